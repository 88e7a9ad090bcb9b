"""Movers in casts by hand, recordings, reports, maps and files: where they are, and under their own names."""

from __future__ import annotations

import json

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import WorldError
from pelagos.messages.motion import ODOMETRY_FIELDS
from pelagos.report.report import render_report
from pelagos.sim.replay import Recording
from pelagos.world.build import build_world, world_config
from pelagos.world.export import export, load, save, save_glb
from pelagos.world.legend import legend
from pelagos.world.preview import look_down, statistics
from pelagos.world.viewpoint import viewpoints

PLATE = {
    "name": "plate", "body": "box", "size_m": 4.0, "material": "gold", "label": "car",
    "path": {"kind": "waypoints", "points_m": [[0, 0, -12], [10, 0, -12]], "speed_mps": 0.5},
}  # fmt: skip
WORLD = {"type": "flat", "depth_m": 30.0, "size_m": [60, 60], "movers": [PLATE]}


@pytest.fixture
def world():
    return build_world(world_config(WORLD))


def simulation(n=1):
    agent = {"vehicle": "remus100", "start": {"position_m": [-20.0, 12.0], "depth_m": 5.0},
             "sensors": {"imu": {"type": "imu", "rate_hz": 100}}}  # fmt: skip
    return pl.Simulation.load({"world": WORLD, "agents": {"auv0": agent}}, n=n)


def test_a_cast_by_hand_sees_movers_where_they_are_now():
    """Without any sensor that sees, nothing else brings the moving scene up to date."""
    sim = simulation()
    for seconds in (2.0, 3.5):
        sim.run(seconds)
        x = 0.5 * sim.time_ns * 1e-9
        hits = sim.world.cast([(x - 1.9, 0.5, 0), (x + 1.9, 0.5, 0), (x - 2.1, 0.5, 0)], (0, 0, -1))
        assert np.allclose(hits.position[:2, 2], -10, atol=1e-3)
        assert hits.position[2, 2] == pytest.approx(-30, abs=1e-3)
        assert np.allclose(hits.velocity[:2], [0.5, 0, 0], atol=1e-6)


def test_a_cast_by_hand_changes_no_reading():
    """The same run with and without casts between its ticks: the same bytes."""
    seen = []
    for looks in (False, True):
        sim = simulation()
        for _ in range(50):
            obs = sim.step()
            if looks:
                sim.world.cast((1, 0, 0), (0, 0, -1))
        seen.append(obs["auv0"]["imu"].data.tobytes())
    assert seen[0] == seen[1]


@pytest.mark.parametrize("n", [1, 2])
def test_recordings_hold_movers_and_what_numbers_mean(tmp_path, n):
    sim = simulation(n)
    sim.run(2.0, record=tmp_path / "a.mcap")
    recording = Recording(tmp_path / "a.mcap")
    channel = recording.channels["/movers/plate/odometry"]
    assert channel.about["label"] == "car"
    t, values = recording.table(channel.topic, ODOMETRY_FIELDS)
    assert t[0] == 0
    assert t[-1] == pytest.approx(2.0)
    assert len(t) == recording.count("/auv0/truth" if n == 1 else "/env1/auv0/truth")
    assert np.allclose(values[:, 3], 0.5 * t, atol=1e-9)  # north is y of ENU
    assert np.allclose(values[:, 4], -12)
    assert np.allclose(values[:, 9:12], [0.5, 0, 0], atol=1e-9)  # bow ahead: along its own x
    names = json.loads(recording.attachments["labels.json"])
    number = channel.about["instance"]
    assert names["instances"][number] == {"name": "plate", "label": 32, "moves": True}
    assert names["labels"]["32"]["name"] == "car"
    hit = sim.world.cast((1.0, 0.0, 0.0), (0, 0, -1))
    assert str(hit.instance[0]) == number
    assert names["materials"][hit.material[0]] == "gold"


def test_a_run_in_two_parts_records_every_tick_once(tmp_path):
    sim = simulation()
    sim.run(0.5)
    sim.run(0.5, record=tmp_path / "b.mcap")
    recording = Recording(tmp_path / "b.mcap")
    assert (recording.times("/movers/plate/odometry") == recording.times("/auv0/truth")).all()


def test_the_report_names_movers(tmp_path):
    sim = simulation()
    sim.run(2.0, record=tmp_path / "a.mcap")
    page = render_report(tmp_path, tmp_path / "a.mcap", sim.world, {}).read_text()
    assert "What moved" in page
    assert "plate" in page


def test_a_paused_world_has_them_as_things(world):
    paused = world.at_time(6.0)
    top, label = look_down(paused, 60)
    rows, columns = np.nonzero(label == 32)
    assert np.ptp(rows) == np.ptp(columns) == 3
    assert top[label == 32] == pytest.approx(-10)
    assert rows.mean() == pytest.approx(29.5 + 3, abs=0.51)  # x = 3 m after 6 s
    hit = paused.cast((3, 0, 0), (0, 0, -1))
    assert paused.materials[hit.material[0]].name == "gold"
    assert (paused.bounds == world.bounds).all()
    assert not paused.movers
    assert [v.name for v in viewpoints(paused)][-1] == "plate"
    assert statistics(paused)["movers"] == statistics(world)["movers"] == {"plate": "box, waypoints"}
    assert legend(paused)["instances"][str(hit.instance[0])] == {"name": "plate", "label": 32, "moves": True}
    assert world.cast((3, 0, 0), (0, 0, -1)).position[0, 2] == pytest.approx(-30)  # the world itself is as it was


def test_saved_worlds_keep_their_movers(tmp_path):
    (tmp_path / "wedge.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
    wedge = {**PLATE, "name": "wedge", "body": "file", "file": str(tmp_path / "wedge.obj")}
    world = build_world(world_config({**WORLD, "movers": [PLATE, wedge]}))
    folder = tmp_path / "moved"
    export(world, tmp_path / "out", t=6.0)
    (tmp_path / "out").rename(folder)
    expected = world.at_time(4.0).geometries
    (tmp_path / "wedge.obj").unlink()  # the export stands alone
    again = load(folder / "world.npz")
    assert [m.name for m in again.movers] == ["plate", "wedge"]
    for a, b in zip(expected, again.at_time(4.0).geometries, strict=True):
        assert a.vertices.tobytes() == b.vertices.tobytes()
    more = {"type": "saved", "path": str(folder / "world.npz"), "movers": [{**PLATE, "name": "other"}]}
    assert [m.name for m in build_world(world_config(more)).movers] == ["plate", "wedge", "other"]
    with pytest.raises(WorldError, match="plate"):
        build_world(world_config({**more, "movers": [PLATE]}))
    save(again, folder / "world.npz")  # onto itself
    assert len(load(folder / "world.npz").movers) == 2


def test_gltf_holds_paused_movers(world, tmp_path):
    import trimesh

    scene = trimesh.load(save_glb(world.at_time(6.0), tmp_path / "w.glb"))
    plate = next(n for n in scene.graph.nodes_geometry if "plate" in n)
    turned = scene.dump(concatenate=False)
    assert len(turned) == 2
    transform, name = scene.graph[plate]
    corners = trimesh.transform_points(scene.geometry[name].vertices, transform)
    assert np.allclose(corners.mean(axis=0), [3, -12, 0], atol=1e-4)  # y up

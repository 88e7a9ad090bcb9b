"""Things on a large ground: where they stand, that rays and hulls meet them, and that pictures and files show them."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

import pelagos as pl
from pelagos.errors import WorldError
from pelagos.world.build import build_world, world_config
from pelagos.world.export import load, save
from pelagos.world.large.picture import pictured
from pelagos.world.preview import draw_map, look_down, statistics
from pelagos.world.viewpoint import viewpoints

WORLD = {
    "type": "large",
    "latitude_deg": 44.0,
    "longitude_deg": 9.0,
    "size_m": [60_000, 60_000],
    "ground": {"kind": "fractal", "seed": 4, "mean_depth_m": 60, "relief_m": 5, "longest_m": 8000},
    "memory_mb": 800,
    "fields": [
        {"centre_m": [20_000, -15_000], "size_m": [300, 300], "objects": [
            {"kind": "boulder", "count": 12, "size_m": [2, 4]},
            {"kind": "wreck_boat", "count": 1, "size_m": 16, "at_m": [[10, -20]]}]},
        {"centre_deg": [44.1, 9.05], "size_m": [100, 100], "objects": [
            {"kind": "manifold", "count": 1, "at_m": [[0, 0]]}]},
    ],
    "things": [{"shape": "box", "at_m": [5, 7, 1.5], "on_ground": True, "size_m": [3, 3, 3], "label": "concrete"}],
}  # fmt: skip


@pytest.fixture(scope="module")
def world():
    return build_world(world_config(WORLD))


def test_things_stand_on_the_ground_where_they_were_put(world):
    names = {g.instance: g.name for g in world.geometries}
    assert sorted(names.values()) == sorted(["seabed", *["boulder"] * 12, "sunken boat", "subsea manifold", "box"])
    for instance in list(names)[1:]:
        points = np.concatenate([g.vertices for g in world.geometries if g.instance == instance])
        middle = (points.min(axis=0) + points.max(axis=0)) / 2
        bed = float(world.height(middle[0], middle[1]))
        assert points[:, 2].min() < bed + 0.2
        assert points[:, 2].max() > bed
    wreck = np.concatenate([g.vertices for g in world.geometries if g.name == "sunken boat"])
    assert np.allclose((wreck.min(axis=0) + wreck.max(axis=0))[:2] / 2, [20_010, -15_020], atol=4)
    manifold = np.concatenate([g.vertices for g in world.geometries if g.name == "subsea manifold"])
    lat, lon = world.origin.to_latlon(*((manifold.min(axis=0) + manifold.max(axis=0))[:2] / 2))
    assert (float(lat), float(lon)) == pytest.approx((44.1, 9.05), abs=2e-5)


@pytest.mark.parametrize("name", ["sunken boat", "subsea manifold", "box"])
def test_rays_hit_things_at_any_distance_from_the_origin(world, name):
    points = np.concatenate([g.vertices for g in world.geometries if g.name == name])
    middle = (points.min(axis=0) + points.max(axis=0)) / 2
    spread = np.random.default_rng(0).uniform(-1, 1, (200, 3)) * np.array([3.0, 3.0, 0.0])
    hits = world.cast(middle + np.array([0.0, 0.0, 50.0]) + spread, (0, 0, -1), 200)
    labels = {g.label for g in world.geometries if g.name == name}
    assert set(hits.label.tolist()) & labels
    assert hits.valid.all()


def test_hulls_come_to_rest_on_things():
    sim = pl.Simulation.load(
        {"world": {**WORLD, "fields": []},
         "agents": {"rov": {"vehicle": "bluerov2_heavy", "start": {"position_m": [5.0, 7.0], "depth_m": 20.0},
                            "control": "pose"}}}
    )  # fmt: skip
    box = next(g for g in sim.world.geometries if g.name == "box")
    top = float(box.vertices[:, 2].max())
    sim.set_state("rov", position=(5, 7, top + 0.5), velocity=(0, 0, -0.4))
    sim.command({"rov": [5.0, 7.0, top - 2.0, 0.0, 0.0, 0.0]})  # it wants to be in the box
    depths = []
    for _ in range(600):
        sim.step()
        depths.append(float(sim.state["rov"].position[0, 2]))
    assert min(depths) < top + 0.45
    assert min(depths) > top - 0.05  # the seabed is 3 m below
    assert bool(np.any(sim.world.near(np.array([[5.0, 7.0, top + 0.2]]), 0.3)))


def test_pictures_and_files_show_ground_and_things(world, tmp_path):
    still = pictured(world)
    assert still.ground is None
    assert still.triangles > 100_000
    x, y = np.array([[20_000], [-15_000]]) + np.random.default_rng(1).uniform(-300, 300, (2, 500))
    hits = still.cast(np.column_stack([x, y, np.zeros(500)]), (0, 0, -1), 200)
    on_bed = hits.label == 4
    assert on_bed.mean() > 0.9
    np.testing.assert_allclose(hits.position[on_bed, 2], world.height(x, y)[on_bed], atol=5e-3)
    top, _ = look_down(still, 80)
    assert np.isfinite(top).all()
    draw_map(still, tmp_path / "map.png", pixels=80)
    views = viewpoints(still)
    assert views[0].exaggeration > 1
    assert "subsea manifold" in [v.name for v in views]
    assert statistics(world)["objects"]["boulder"] == 12
    again = load(save(world, tmp_path / "w.npz"))
    assert again.triangles == still.triangles


@pytest.mark.parametrize(
    ("field", "error", "words"),
    [
        ({"centre_m": [29_950, 0]}, WorldError, r"fields\[0\].*does not lie in the world"),
        ({"centre_deg": [46.0, 9.0]}, WorldError, r"fields\[0\].*does not lie in the world"),
        ({}, ValidationError, "centre_m or as centre_deg"),
        ({"centre_m": [0, 0], "objects": [{"kind": "pipeline"}]}, ValidationError, "digs"),
        ({"centre_m": [0, 0], "objects": [{"kind": "bolder"}]}, ValidationError, "boulder"),
        ({"centre_m": [0, 0], "objects": [{"kind": "cable", "at_m": [[1, 2]]}]}, ValidationError, "leave out at_m"),
        ({"centre_m": [0, 0], "objects": [{"kind": "cable", "heading_deg": 0}]}, ValidationError, "out heading_deg"),
    ],
)
def test_what_cannot_be_is_refused(field, error, words):
    one = {"size_m": [300, 300], "objects": [{"kind": "boulder", "count": 1}], **field}
    with pytest.raises(error, match=words):
        build_world(world_config({**WORLD, "fields": [one]}))


def test_what_finds_no_room_is_said():
    field = {"centre_m": [0, 0], "size_m": [30, 30], "objects": [{"kind": "manifold", "count": 9, "size_m": 14}]}
    notes = build_world(world_config({**WORLD, "fields": [field]})).notes
    assert any(n.startswith("fields[0]: manifold: ") and "of 9 were placed" in n for n in notes)


def test_things_need_room_in_memory():
    field = {"centre_m": [0, 0], "size_m": [2000, 2000], "objects": [{"kind": "kelp", "count": 300, "size_m": 20}]}
    with pytest.raises(WorldError, match="the things on it take"):
        build_world(world_config({**WORLD, "memory_mb": 470, "fields": [field]}))

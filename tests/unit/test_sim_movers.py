"""Scripted movers: paths are functions of time with true velocities; sensors and hulls notice them."""

from __future__ import annotations

import numpy as np
import pytest
from pydantic import ValidationError

import pelagos as pl
from pelagos.errors import InputError
from pelagos.math.so3 import rotate_np
from pelagos.world.build import build_world, world_config
from pelagos.world.path import CirclePath, SwingPath, WanderPath, WaypointPath

POINTS = ((0.0, 0.0, -5.0), (40.0, 10.0, -5.0), (60.0, -20.0, -8.0), (0.0, -30.0, -6.0))
PATHS = [
    CirclePath(centre_m=(3, -2, -7), radius_m=12, speed_mps=1.5, phase_deg=20),
    CirclePath(centre_m=(3, -2, -7), radius_m=12, speed_mps=1.5, clockwise=True),
    WaypointPath(points_m=POINTS, speed_mps=2.0, start_s=3.0),
    WaypointPath(points_m=POINTS, speed_mps=2.0, at_end="loop"),
    SwingPath(at_m=(1, 2, -3), amplitude_deg=25, period_s=6, towards_deg=40),
    WanderPath(at_m=(5, 5, -10), reach_m=(6, 6, 1), period_s=30, seed=2),
]


@pytest.mark.parametrize("path", PATHS, ids=lambda p: p.kind)
def test_velocity_is_the_derivative_of_the_place(path):
    """Central differences over 0.2 ms; joints of a curve's table are left out."""
    h = 1e-4
    for t in np.linspace(0.37, 61.3, 41):
        before, now, after = (path.pose(t + d) for d in (-h, 0.0, h))
        speed = (after.position - before.position) / (2 * h)
        jump = np.abs(after.velocity - before.velocity).max() > 0.05
        assert jump or np.allclose(now.velocity, speed, atol=1e-4)
        assert np.linalg.norm(now.velocity) <= path.fastest_mps + 1e-9
        assert np.linalg.norm(now.attitude) == pytest.approx(1)


@pytest.mark.parametrize("path", PATHS, ids=lambda p: p.kind)
def test_angular_velocity_turns_the_attitude(path):
    h = 1e-4
    arm = np.array([[1.0, 0.5, 0.25]])
    for t in np.linspace(0.37, 61.3, 41):
        before, now, after = (path.pose(t + d) for d in (-h, 0.0, h))
        turned = [rotate_np(p.attitude[None], arm)[0] for p in (before, now, after)]
        speed = (turned[2] - turned[0]) / (2 * h)
        jump = np.abs(after.angular_velocity - before.angular_velocity).max() > 1e-3
        assert jump or np.allclose(np.cross(now.angular_velocity, turned[1]), speed, atol=2e-4)


def test_a_curve_runs_through_its_points_at_its_speed_and_stops():
    path = WaypointPath(points_m=POINTS, speed_mps=2.0)
    places = np.stack([path.pose(t).position for t in np.arange(0, 80, 0.01)])
    for point in POINTS:
        assert np.linalg.norm(places - point, axis=1).min() < 0.02
    assert np.allclose(path.pose(1e4).position, POINTS[-1], atol=1e-12)
    assert not path.pose(1e4).velocity.any()
    assert np.linalg.norm(path.pose(11.0).velocity) == pytest.approx(2.0)


SCENARIO = {
    "world": {
        "type": "flat",
        "depth_m": 30.0,
        "movers": [
            {
                "name": "plate",
                "body": "box",
                "size_m": 4.0,
                "path": {"kind": "waypoints", "points_m": [[0, 0, -12], [0, 0, -16]], "speed_mps": 0.5},
            }
        ],
    },
    "agents": {
        "auv0": {
            "vehicle": "remus100",
            "start": {"position_m": [0.0, 0.0], "depth_m": 5.0},
            "sensors": {"altimeter": {"type": "altimeter", "rate_hz": 10, "noise_m": 0.0}},
        }
    },
}


def test_sensors_see_a_mover_where_it_is_and_how_fast():
    sim = pl.Simulation.load(SCENARIO)
    still = {"position": (0, 0, -5), "attitude": (1, 0, 0, 0), "velocity": (0, 0, 0), "angular_velocity": (0, 0, 0)}
    for _ in range(2):  # a reset brings it back
        sim.reset()
        for _ in range(400):
            sim.set_state("auv0", **still)
            obs = sim.step()
        t = sim.time_ns * 1e-9
        top = -12 - 0.5 * t + 2.0
        assert obs["auv0"]["altimeter"].truth.item() == pytest.approx(-5 - top, abs=0.05)
        hits = sim.world.cast((0.3, 0.2, -5), (0, 0, -1))
        assert hits.position[0, 2] == pytest.approx(top, abs=1e-3)
        assert np.allclose(hits.velocity[0], [0, 0, -0.5], atol=1e-6)


def test_a_mover_pushes_a_hull_that_is_in_its_way():
    ram = {"name": "ram", "body": "box", "size_m": 3.0}
    ram["path"] = {"kind": "waypoints", "points_m": [[0, 3.5, -10], [0, -8, -10]], "speed_mps": 1.0}
    scenario = {
        "world": {"type": "flat", "depth_m": 30.0, "movers": [ram]},
        "agents": {"rov": {"vehicle": "bluerov2_heavy", "start": {"position_m": [0.0, 0.0, -10.0]}}},
    }
    sim = pl.Simulation.load(scenario)
    sim.run(4.5)  # its face is at y = 2 - 4.5 = -2.5
    assert sim.state["rov"].position[0, 1] < -2.3


def test_the_block_length_does_not_matter():
    """A run in one go and one tick at a time meet a mover at the same ticks: the same bytes."""
    whole, ticks = pl.Simulation.load(SCENARIO, n=2), pl.Simulation.load(SCENARIO, n=2)
    whole.run(1.0)
    for _ in range(200):
        obs = ticks.step()
    last = whole.run(0.1).observations["auv0"]["altimeter"]
    for _ in range(20):
        obs = ticks.step()
    assert last.data.tobytes() == obs["auv0"]["altimeter"].data.tobytes()


@pytest.mark.parametrize("body", ["ship", "fish", "chain", "fish_school", "mooring", "wreck_submarine", "sphere"])
def test_every_body_is_closed_and_of_its_size(body):
    mover = {"name": "m", "body": body, "size_m": 20.0, "path": {"kind": "swing", "at_m": [0, 0, -10],
             "amplitude_deg": 10, "period_s": 5}}  # fmt: skip
    world = build_world(world_config({"type": "flat", "movers": [mover]}))
    geometry = world.movers[0].geometry(instance=5, world=world)
    extent = np.ptp(geometry.vertices, axis=0)
    assert 10 < extent.max() < 60
    assert geometry.faces.max() < len(geometry.vertices)
    assert len(geometry.face_materials) == len(geometry.faces)


SWING = {"kind": "swing", "at_m": [0, 0, 0], "amplitude_deg": 5, "period_s": 2}
CIRCLE = {"kind": "circle", "centre_m": [0, 0, 0], "radius_m": -1, "speed_mps": 1}
LINE = {"kind": "waypoints", "points_m": [[0, 0, 0]], "speed_mps": 1}


@pytest.mark.parametrize(
    ("body", "path", "says"),
    [("shipp", SWING, "ship"), ("ship", LINE, "points_m"), ("ship", {"kind": "zigzag"}, "zigzag"),
     ("ship", CIRCLE, "radius_m")],
)  # fmt: skip
def test_bad_movers_are_refused(body, path, says):
    mover = {"name": "m", "body": body, "path": path}
    with pytest.raises((ValidationError, InputError), match=says):
        world_config({"type": "flat", "movers": [mover]})


def test_two_movers_of_one_name_are_refused():
    mover = SCENARIO["world"]["movers"][0]
    with pytest.raises((ValidationError, InputError), match="unique"):
        world_config({"type": "flat", "movers": [mover, mover]})


def test_a_run_in_blocks_reads_a_mover_where_it_is_at_each_reading(tmp_path):
    """A drum that goes away at 2 m/s: a run's record holds the ranges that single ticks give, each 0.1 m further."""
    ranger = {"type": "range_finder", "range_max_m": 30, "azimuth_deg": [0.0], "elevation_deg": [0.0], "rate_hz": 20}
    away = {"kind": "waypoints", "points_m": [[5.0, 0.0, -4.0], [25.0, 0.0, -4.0]], "speed_mps": 2.0}
    scenario = {
        "tick_rate_hz": 100,
        "world": {"type": "flat", "depth_m": 30.0,
                  "movers": [{"name": "drum", "body": "sphere", "size_m": 1.0, "path": away}]},
        "agents": {"rov": {"vehicle": "bluerov2", "start": {"depth_m": 4.0}, "sensors": {"ranger": ranger}}},
    }  # fmt: skip
    ran, stepped = pl.Simulation.load(scenario), pl.Simulation.load(scenario)
    ran.run(seconds=1.0, record=tmp_path / "ran.mcap")
    stepped.reset()
    with stepped.recording(tmp_path / "stepped.mcap"):
        for _ in range(100):
            stepped.step()
    records = (pl.Recording(tmp_path / f"{name}.mcap") for name in ("ran", "stepped"))
    ranges = [[float(r.message.data[0]) for r in record.messages("/rov/ranger")] for record in records]
    assert len(ranges[0]) >= 20
    np.testing.assert_array_equal(ranges[0][-20:], ranges[1][-20:])
    np.testing.assert_allclose(np.diff(ranges[0]), 0.1, atol=0.02)

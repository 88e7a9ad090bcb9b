"""Depth of the world's water under ships in simulations."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl

SHIP = {"type": "kvlcc2", "variant": "shallow"}


def scenario(count=1, vehicle=SHIP, size=20000.0, depth=30.0, **more):
    return {
        "world": {"type": "flat", "depth_m": depth, "size_m": [size, size]}, "tick_rate_hz": 10, **more,
        "agents": {
            f"s{i}": {
                "vehicle": vehicle, "control": "actuators",
                "start": {"position_m": [0.0, 900.0 * i], "heading_deg": 20.0 * i, "speed_mps": 7.0},
            }
            for i in range(count)
        },
    }  # fmt: skip


def gained(given, ticks=1, height=0.0):
    """Velocity FRD after some ticks (3) [m/s], from a height above the mean surface [m]."""
    sim = pl.Simulation.load(given)
    if height:
        sim.set_state("s0", position=[[0.0, 0.0, height]])
    sim.step({"s0": [0.2]}, ticks=ticks)
    return sim.state["s0"].velocity[0] * [1, -1, -1]


def test_the_worlds_depth_is_that_under_the_ship():
    """The first step is that of `Vehicle.accelerations` with the ground 30 m below."""
    vehicle = pl.Vehicle.from_dict(SHIP)
    still, nu = [[0.0]], [[7.0, 0, 0, 0, 0, 0]]
    near, far = (vehicle.accelerations([[0] * 6], nu, still, still, walls=w)[0][0, :3] for w in ([[0, 0, -1, 30]], ()))
    found = (gained(scenario()) - gained(scenario(vehicle="kvlcc2"))) / 0.1
    assert near[2] - far[2] > 0.1  # down
    assert found == pytest.approx(near - far, rel=1e-2, abs=1e-5)


def test_a_tide_deepens_the_water():
    """At high water of a slow tide the ship starts on its surface, 34 m above the ground."""
    tide = scenario(ocean={"tide": [{"period_h": 1e4, "amplitude_m": 4.0}]})
    high, deep, plain = gained(tide, 20, height=4.0), gained(scenario(depth=34.0), 20), gained(scenario(), 20)
    assert high == pytest.approx(deep, rel=1e-5, abs=1e-6)
    assert abs(high[2] - plain[2]) > 1e-3


def test_a_ship_beyond_the_ground_is_in_deep_water():
    """The variant differs by the ray alone: 100 m of ground, and the ship starts outside of it."""
    given = scenario(size=100.0)
    given["agents"]["s0"]["start"]["position_m"] = [500.0, 0.0]
    plain = scenario(size=100.0, vehicle="kvlcc2")
    plain["agents"]["s0"]["start"]["position_m"] = [500.0, 0.0]
    assert gained(given, 10) == pytest.approx(gained(plain, 10), abs=1e-5)


def test_lanes_and_checkpoints_keep_the_bytes():
    both, alone = (pl.Simulation.load(scenario(k)) for k in (2, 1))
    both.step(ticks=30)
    alone.step(ticks=10)
    kept = alone.checkpoint()
    alone.step(ticks=20)
    there = alone.state["s0"].position.copy()
    assert (both.state["s0"].position == there).all()
    alone.restore(kept)
    alone.step(ticks=20)
    assert (alone.state["s0"].position == there).all()
    assert not np.allclose(both.state["s0"].position, both.state["s1"].position)


def test_a_wall_beside_is_no_ground():
    """A quay 40 m to port of the middle of a ship in 100 m of water, which the rays to its sides find."""
    open_water = scenario(vehicle={"type": "kvlcc2", "terms": {"squat": {"type": "squat"}}})
    open_water["world"] = {"type": "built", "depth_m": 100.0, "size_m": [2000, 2000]}
    quay = {**open_water["world"], "things": [{"at_m": [0, 60, 0], "size_m": [300, 40, 40]}]}
    assert gained({**open_water, "world": quay}, 5) == pytest.approx(gained(open_water, 5), rel=1e-9, abs=1e-12)

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
    with pytest.warns(pl.ValidityWarning, match=r"agents\.s0: at x 500, y 0 m there is no ground below, which ends at "
                      r"x -50 and 50, y -50 and 50 m: the water counts as deep there") as told:  # fmt: skip
        found = gained(given, 10)
    assert len(told) == 1
    assert found == pytest.approx(gained(plain, 10), abs=1e-5)


def test_the_ship_that_leaves_the_ground_is_named():
    """Of two alike, the second is 30 m from the edge, to the west, and goes there at 7 m/s."""
    given = scenario(2, size=2000.0)
    given["agents"]["s1"]["start"] |= {"position_m": [0.0, 970.0], "heading_deg": -90.0}
    sim = pl.Simulation.load(given)
    sim.step(ticks=30)
    with pytest.warns(pl.ValidityWarning, match=r"agents\.s1: at x -?0, y 100[0-2] m there is no ground below"):
        sim.step(ticks=30)


def fast(depth, sinkage):
    """A boat of 4.9 m at 6 m/s, whose wave feels the ground of 10 m: F^2 is 0.37 there."""
    squat = {"type": "squat", "sinkage": sinkage, "trim": 0.0}
    given = scenario(vehicle={"type": "wamv", "terms": {"squat": squat}}, depth=depth)
    given["agents"]["s0"]["start"]["speed_mps"] = 6.0
    return given


def test_a_fast_boat_feels_the_ground_beyond_two_lengths():
    """The force goes on by the formula, F^2/sqrt(1 - F^2), on either side of two lengths and at four, with no jump."""
    config = pl.Vehicle.from_catalogue("wamv").config
    length, body = config.length_m, config.body
    volume, found = float(body.displaced[0, 0]) / body.density, []
    depths = [1.99 * length, 2.01 * length, 4.0 * length]
    for depth in depths:
        sim = [pl.Simulation.load(fast(depth, k)) for k in (1.46, 0.0)]
        for one in sim:
            one.step({"s0": [0.0, 0.0]})
        found.append(10 * float(np.subtract(*(one.state["s0"].velocity[0, 2] for one in sim))))
    square = 36.0 / (body.gravity * np.array(depths))
    sinkage = 1.46 * volume / length**2 * square / np.sqrt(1 - square)
    assert np.array(found) / found[0] == pytest.approx(sinkage / sinkage[0], rel=2e-3)
    assert found[0] < -0.05
    assert found[1] / found[0] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize(
    "ship",
    [
        {"type": "kvlcc2", "actuators": {"rudder": {"shallow_water": {"midship": 0.998}}}},
        {"type": "tanker", "added_mass": {"water_depth_m": "world"}},
    ],
)
def test_level_ground_takes_no_momentum(ship):
    """To rounding: the depth under the ship changes with its place alone, and not with its heave."""
    with_it = {**ship}
    if ship["type"] == "tanker":
        with_it["added_mass"] = {**ship["added_mass"], "momentum": True}
    else:
        with_it["actuators"] = {"rudder": {"shallow_water": {"midship": 0.998, "momentum": True}}}
    orders = [0.2] if ship["type"] == "kvlcc2" else [0.2, 1.3]
    ends = []
    for vehicle in (ship, with_it):
        sim = pl.Simulation.load(scenario(vehicle=vehicle))
        sim.set_state("s0", velocity=[[7.0, -0.5, 0.3]])
        sim.step({"s0": orders}, ticks=30)
        ends.append(np.concatenate([sim.state["s0"].velocity[0], sim.state["s0"].angular_velocity[0]]))
    assert ends[1] == pytest.approx(ends[0], rel=1e-9, abs=1e-12)


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

"""Props that fall: as g has it, down to what holds them, with what they come down on pushed aside."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.math.constants import GRAVITY
from pelagos.sim.falling import Falling

H = 0.02
REACH = 0.75


def dropped(height: float, **start: Any) -> tuple[pl.Simulation, Falling]:
    agent = {"vehicle": "bluerov2", "start": {"depth_m": 5.0, **start}}
    scenario = {"world": {"type": "flat", "depth_m": 8.0}, "agents": {"it": agent}}
    sim = pl.Simulation.load(scenario, n=2, seed=1)
    body = sim.spawn(pl.Prop("box", position=(1.5, -2.0, height), size=(0.6, 1.0, 2 * REACH)))
    return sim, Falling(body, REACH, radius=0.5)


def test_a_prop_falls_as_g_has_it_and_lies_on_the_ground() -> None:
    """Speeds come first: after k steps of h it has fallen by g h^2 k (k + 1) / 2."""
    sim, falling = dropped(-3.0, position_m=[20.0, 10.0])
    for k in range(1, 11):
        falling.step(sim, H)
        np.testing.assert_allclose(falling.body.position[:, 2], -3.0 - GRAVITY * H**2 * k * (k + 1) / 2, rtol=1e-6)
        assert not falling.rests
    for _ in range(60):
        falling.step(sim, H)
    np.testing.assert_allclose(falling.body.position, [[1.5, -2.0, -8.0 + REACH]] * 2, atol=1e-3)
    assert not falling.body.velocity.any()
    assert falling.rests


@pytest.mark.parametrize(
    ("where", "pushed"),
    [
        ({"position_m": [1.8, -2.2], "depth_m": 7.2, "heading_deg": 70.0}, True),
        ({"position_m": [1.1, -1.8], "depth_m": 6.9, "heading_deg": -20.0}, True),
        ({"position_m": [2.2, -2.2], "depth_m": 7.2}, False),  # beside it
        ({"position_m": [1.8, -2.2], "depth_m": 6.0}, False),  # above it
    ],
)
def test_what_a_prop_came_down_on_is_pushed_away_from_its_axis(where: dict[str, Any], pushed: bool) -> None:
    """At 3 m/s, whichever way its bow points, once the prop lies."""
    sim, falling = dropped(-7.1, **where)
    while falling.body.velocity.any() or falling.body.position[0, 2] > -7.2:
        falling.step(sim, H)
    state = sim.state["it"]
    apart = state.position[0, :2] - [1.5, -2.0]
    heading = np.radians(where.get("heading_deg", 0.0))
    ahead, left = np.array([np.cos(heading), -np.sin(heading)]), np.array([np.sin(heading), np.cos(heading)])
    out = 3.0 * pushed * apart / np.hypot(*apart)
    np.testing.assert_allclose(state.velocity, [[out @ ahead, out @ left, 0.0]] * 2, atol=1e-6)
    assert falling.rests != pushed


def test_what_is_pushed_in_one_copy_leaves_the_others() -> None:
    """The vehicle of the second copy lies beside it: its controllers go on, to the byte."""
    sims = [dropped(-7.1, position_m=[1.8, -2.2], depth_m=7.2, heading_deg=70.0) for _ in range(2)]
    runs = []
    for (sim, falling), copies in zip(sims, ([0, 1], [1]), strict=True):
        sim.set_mode("it", "velocity")
        sim.set_state("it", position=[2.6, -4.2, -7.2], where=[1])
        if 0 not in copies:
            sim.set_state("it", position=[9.0, -4.2, -7.2], where=[0])
        sim.step({"it": [0.3, 0.1, 0.05, 0.2]}, ticks=20)
        for _ in range(25):
            falling.step(sim, H)
            sim.step()
        runs.append((sim.state["it"], sim.stepper.memory()["runs"]["it"]["vehicle"].reshape(-1, 2)))
    (pushed, whole), (free, alone) = runs
    assert np.abs(pushed.velocity[0] - free.velocity[0]).max() > 0.5
    np.testing.assert_array_equal(whole[:, 1], alone[:, 1])


def test_what_moves_holds_nothing() -> None:
    """Neither a plate on the ground, below the middle of what falls, nor the hull of one of two vehicles."""
    agents = {name: {"vehicle": "bluerov2", "start": {"position_m": [1.5, y], "depth_m": 7.6}}
              for name, y in (("it", -2.0), ("other", 9.0))}  # fmt: skip
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 8.0}, "agents": agents}, n=2, seed=1)
    sim.spawn(pl.Prop("box", position=(1.6, -2.1, -7.9), size=(3.0, 3.0, 0.2)))
    falling = Falling(sim.spawn(pl.Prop("box", position=(1.5, -2.0, -6.6), size=(0.6, 1.0, 2 * REACH))), REACH)
    for _ in range(40):
        falling.step(sim, H)
    np.testing.assert_allclose(falling.body.position, [[1.5, -2.0, -8.0 + REACH]] * 2, atol=1e-3)
    assert falling.rests
    falling.body.move(position=(1.5, -2.0, -7.7))
    falling.step(sim, H)
    np.testing.assert_array_equal(falling.body.position, [[1.5, -2.0, -7.7]] * 2)  # what lies too deep stays there


def test_who_is_below_what_holds_a_prop_is_not_pushed_and_who_is_in_its_axis_goes_north() -> None:
    """A platform 3 m over the ground; each of three vehicles has a place of its own in one of two copies."""
    agents = {name: {"vehicle": "bluerov2", "start": {"position_m": [9.0, y], "depth_m": 4.0, "heading_deg": -90.0}}
              for name, y in (("below", 5.0), ("within", 8.0), ("above", 11.0))}  # fmt: skip
    slab = {"shape": "box", "at_m": [0.0, 0.0, -5.0], "size_m": [4.0, 4.0, 0.2]}
    world = {"type": "flat", "depth_m": 8.0, "size_m": [60, 60], "things": [slab]}
    sim = pl.Simulation.load({"world": world, "agents": agents}, n=2, seed=1)
    falling = Falling(sim.spawn(pl.Prop("box", position=(0.4, -0.2, -4.1), size=(1.0, 1.0, 2 * REACH))), REACH, 0.5)
    places = {"below": [0.5, -0.1, -6.5], "within": [0.4, -0.2, -4.5], "above": [0.5, -0.1, -3.2]}
    for name, place in places.items():
        sim.set_state(name, position=place, velocity=[0.1, 0.2, 0.3], where=[1])
    before = {name: state.velocity.copy() for name, state in sim.state.items()}
    for _ in range(12):
        falling.step(sim, H)
    np.testing.assert_allclose(falling.body.position[:, 2], -4.9 + REACH, atol=1e-3)
    for name in ("below", "above"):
        np.testing.assert_array_equal(sim.state[name].velocity, before[name])
    np.testing.assert_array_equal(sim.state["within"].velocity[0], before["within"][0])
    np.testing.assert_allclose(sim.state["within"].velocity[1], [0.0, -3.0, 0.0], atol=1e-9)  # its bow looks west
    assert not falling.rests

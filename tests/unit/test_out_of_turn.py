"""Readings out of turn, a run that begins at another tick, and a sea with levels and currents of one's own."""

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import CommandError

SENSORS = {"pose": {"type": "pose", "rate_hz": 5}, "depth": {"type": "depth", "rate_hz": 10}}
SCENARIO = {
    "tick_rate_hz": 50,
    "world": {"type": "flat", "depth_m": 40},
    "agents": {
        name: {"vehicle": "hovering_auv", "control": "actuators", "start": {"position_m": place}, "sensors": SENSORS}
        for name, place in (("a", [1.0, -2.0, -6.0]), ("b", [8.0, 5.0, -9.0]))
    },
}


def test_a_reading_out_of_turn_changes_nothing_of_the_run():
    asked, plain = pl.Simulation.load(SCENARIO), pl.Simulation.load(SCENARIO)
    asked.step(ticks=3)
    found = asked.read("a", ["pose"])
    assert set(found) == {"pose"}
    np.testing.assert_allclose(found["pose"].data[0, :3], asked.state["a"].position[0], atol=1e-12)
    asked.step(ticks=7)
    plain.step(ticks=10)
    assert (asked.state["b"].position == plain.state["b"].position).all()
    with pytest.raises(CommandError, match="depth"):
        asked.read("a", ["dept"])


def test_a_run_begins_at_another_tick_and_its_sensors_are_due_by_it():
    sim = pl.Simulation.load(SCENARIO)
    sim.reset(tick=9)
    assert sim.time_ns == 9 * sim.dt_ns
    assert set(sim.step()["a"]) == {"pose", "depth"}  # tick 10
    assert "pose" not in sim.step()["a"]
    with pytest.raises(CommandError, match="tick"):
        sim.reset(tick=-1)


def test_vehicles_of_one_sea_drift_with_currents_of_their_own():
    sim = pl.Simulation.load(SCENARIO)
    sim.ocean.set(current=(0.4, 0.0, 0.0), agent="a")
    sim.ocean.set(current=(0.0, -0.3, 0.0), agent="b")
    before = {n: sim.state[n].position[0].copy() for n in "ab"}
    sim.step(ticks=500)
    moved = {n: sim.state[n].position[0] - before[n] for n in "ab"}
    assert moved["a"][0] > 1.0
    assert abs(moved["a"][1]) < 0.01
    assert moved["b"][1] < -0.7
    assert abs(moved["b"][0]) < 0.01


def test_a_vehicles_own_current_takes_nothing_from_the_others():
    """It ends the scenario's currents for all: that of all is set before; the rest of the sea is nobody's own."""
    sea = {"currents": [{"type": "uniform", "speed_mps": 0.3, "towards_deg": 120}]}
    sim = pl.Simulation.load({**SCENARIO, "ocean": sea})
    with pytest.raises(CommandError, match="set the current of all before that of an agent"):
        sim.ocean.set(current=(0.4, 0.0, 0.0), agent="a")
    with pytest.raises(CommandError, match="with an agent, give its current alone"):
        sim.ocean.set(current=(0.4, 0.0, 0.0), turbidity=2.0, agent="a")
    sim.ocean.set(current=(-0.2, 0.1, 0.0))
    sim.ocean.set(current=(0.4, 0.0, 0.0), agent="a")
    before = {n: sim.state[n].position[0].copy() for n in "ab"}
    sim.step(ticks=500)
    assert (sim.state["a"].position[0] - before["a"])[0] > 1.0
    assert (sim.state["b"].position[0] - before["b"])[0] < -0.3


def test_the_level_of_the_sea_lifts_what_floats():
    boat = {"vehicle": "surface_vessel", "start": {"position_m": [0, 0, 0]}}
    sim = pl.Simulation.load({**SCENARIO, "agents": {"usv": boat}})
    sim.ocean.set(level_m=0.4)
    sim.step(ticks=500)
    lifted = sim.state["usv"].position[0, 2]
    sim.ocean.set(level_m=-0.3)
    sim.step(ticks=500)
    assert abs(lifted - 0.4) < 0.02
    assert abs(sim.state["usv"].position[0, 2] + 0.3) < 0.02

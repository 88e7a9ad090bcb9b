"""What vehicles carry, in simulations: commands by name, missions, batches, checkpoints."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl
from pelagos.errors import CommandError, ScenarioError

CARRIED = {
    "drop_weight": {"type": "releasable", "mass_kg": 3.0, "position_m": [0.0, 0.0, 0.1], "volume_m3": 3.8e-4},
    "bay": {
        "type": "compartment", "size_m": [0.2, 0.1, 0.1], "position_m": [0.4, 0.0, 0.0], "hole_m": [0.4, 0.0, 0.05],
        "orifice_m2": 1e-3, "vent_m": [0.4, 0.0, -0.05], "valve": True, "pump_m3_s": 2e-5,
    },
}  # fmt: skip


def scenario(count=1, **agent):
    return {
        "name": "carried", "duration_s": 20, "world": {"type": "flat", "depth_m": 40.0}, "seed": 3,
        "agents": {
            f"auv{i}": {
                "vehicle": {"type": "remus100", "actuators": CARRIED},
                "start": {"position_m": [0.0, 30.0 * i, -10.0 - i]}, **agent,
            }
            for i in range(count)
        },
    }  # fmt: skip


def at(sim, agent="auv0"):
    return sim.state[agent].actuators[0, -2:].tolist()


def test_every_mode_commands_what_is_carried():
    sim = pl.Simulation.load(scenario())
    names = sim.model.agents["auv0"].vehicle.command_names()
    assert names == ("depth", "heading", "speed", "drop_weight", "bay")
    sim.step({"auv0": [10.0, 0.0, 1.5, 0.0, 0.0]}, ticks=20)
    assert at(sim) == [0.0, 0.0]
    sim.step({"auv0": {"drop_weight": 1.0}}, ticks=5)
    assert at(sim)[0] == 1.0
    assert sim.held_command("auv0")[0].tolist() == [10.0, 0.0, 1.5, 1.0, 0.0]
    sim.step({"auv0": {"bay": 0.001}}, ticks=400)
    assert at(sim) == [1.0, pytest.approx(0.001)]
    with pytest.raises(CommandError, match="drop_weight"):
        sim.step({"auv0": {"drop_weigth": 1.0}})
    with pytest.raises(CommandError, match="finite"):
        sim.step({"auv0": {"bay": np.nan}})
    with pytest.raises(CommandError, match="one number"):
        sim.step({"auv0": {"bay": [1.0, 2.0]}})


def test_a_mission_goes_on_while_a_weight_is_dropped():
    sim = pl.Simulation.load(scenario(mission=[{"type": "waypoints", "points": [[60.0, 0.0]], "depth_m": 10.0}]))
    sim.step(ticks=40)
    sim.step({"auv0": {"drop_weight": 1.0}}, ticks=40)
    assert at(sim)[0] == 1.0
    assert "auv0" in sim.stepper.missions.guidance
    sim.step({"auv0": {"speed": 1.0}}, ticks=1)
    assert "auv0" not in sim.stepper.missions.guidance


def test_lanes_are_as_alone():
    """Two of a kind in one batch, one of which drops its weight, move as two simulations of one do."""
    both, alone = pl.Simulation.load(scenario(2)), pl.Simulation.load(scenario(1))
    for sim in (both, alone):
        sim.step({"auv0": [9.0, 0.2, 1.2, 0.0, 0.001]}, ticks=30)
        sim.step({"auv0": {"drop_weight": 1.0}}, ticks=60)
    assert (both.state["auv0"].position == alone.state["auv0"].position).all()
    assert (both.state["auv0"].actuators == alone.state["auv0"].actuators).all()
    assert at(both, "auv1") == [0.0, 0.0]


def test_checkpoint_holds_what_is_carried(tmp_path):
    sim = pl.Simulation.load(scenario())
    sim.step({"auv0": [9.0, 0.2, 1.2, 1.0, 0.001]}, ticks=50)
    kept = sim.checkpoint()
    sim.step(ticks=50)
    there = sim.state["auv0"].position.copy(), at(sim)
    sim.restore(kept)
    sim.step(ticks=50)
    assert (sim.state["auv0"].position == there[0]).all()
    assert at(sim) == there[1]


def test_names_do_not_clash():
    given = scenario()
    given["agents"]["auv0"]["vehicle"]["actuators"] = {"depth": CARRIED["drop_weight"]}
    with pytest.raises(ScenarioError, match="rename"):
        pl.Simulation.load(given)

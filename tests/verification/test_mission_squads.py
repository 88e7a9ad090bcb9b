"""Vehicles that are guided together do what each does alone, to the byte; so do copies that are at different legs."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.sim.guidance.squad import Squad

CRUISE = [
    {"type": "waypoints", "points": [[14, 2], [16, 14]], "depth_m": 4, "speed_mps": 1.5},
    {"type": "hold", "seconds": 3},
    {"type": "waypoints", "points": [[60, -10]], "depth_m": 5, "speed_mps": 1.6},
    {"type": "orbit", "center": [10, 8], "radius_m": 25, "turns": 0.2, "depth_m": 5},
    {"type": "surface"},
]
HOVER = [
    {"type": "goto", "points": [[1.5, -0.5]], "depth_m": 3.2, "speed_mps": 0.5},
    {"type": "station_keeping", "seconds": 2},
    {"type": "goto", "points": [[0.5, 1.0]], "depth_m": 2.8, "speed_mps": 0.4},
    {"type": "land"},
]
FLEETS = {"remus100": (CRUISE, 60.0, 8.0), "bluerov2_heavy": (HOVER, 26.0, 6.0)}


def swarm(vehicle: str, count: int = 5) -> dict[str, Any]:
    mission, _, depth_m = FLEETS[vehicle]
    start = {"position_m": [0, 0], "depth_m": 3, "heading_deg": 20, "grid": [1, count], "spacing_m": [60, 60]}
    spread = {"start.position_m.0": {"uniform": [-4, 4]}, "start.heading_deg": {"uniform": [-60, 60]}}
    if vehicle == "bluerov2_heavy":
        spread["start.position_m.0"] = {"uniform": [-0.8, 0.8]}
    return {
        "seed": 5, "tick_rate_hz": 20, "world": {"type": "flat", "depth_m": depth_m, "size_m": [900, 900]},
        "ocean": {"currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 70}]},
        "agents": {
            "auv": {
                "count": count, "vehicle": vehicle, "start": start, "mission_from": "start", "mission": mission,
                "distributions": spread,
            }
        },
    }  # fmt: skip


def flown(sim: pl.Simulation, seconds: float) -> tuple[list[np.ndarray], set[tuple[int, ...]]]:
    """Positions and attitudes of all at every second, and the legs that they were at at the same times."""
    seen, legs = [], set()
    for _ in range(int(seconds)):
        sim.step(ticks=20)
        seen += [np.concatenate([s.position, s.attitude], axis=1) for s in sim.state.values()]
        legs.add(tuple(int(g.progress.task[0]) for g in sim.stepper.missions.guidance.values()))
    return seen, legs


@pytest.mark.parametrize("vehicle", FLEETS)
def test_a_squad_does_what_each_of_it_does_alone(vehicle: str, monkeypatch: pytest.MonkeyPatch) -> None:
    called = []
    command = Squad.command
    monkeypatch.setattr(Squad, "command", lambda self, aboard: called.append(len(aboard)) or command(self, aboard))
    together, legs = flown(pl.Simulation.load(swarm(vehicle), n=2), FLEETS[vehicle][1])
    assert set(called) == {10}  # five vehicles in two copies
    assert max(len(set(at)) for at in legs) >= 2  # they were at different legs at once
    assert max(max(at) for at in legs) >= 3
    monkeypatch.setattr(Squad, "in_step", False)
    alone, _ = flown(pl.Simulation.load(swarm(vehicle), n=2), FLEETS[vehicle][1])
    for mine, theirs in zip(together, alone, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_missions_of_other_shapes_are_other_squads() -> None:
    made = swarm("remus100", 4)
    del made["agents"]["auv"]
    one = {"vehicle": "remus100", "mission": CRUISE}
    for i in range(4):
        made["agents"][f"auv{i}"] = one | {"start": {"position_m": [0, 40 * i], "depth_m": 3}}
    made["agents"]["auv2"]["mission"] = [*CRUISE[:1], {"type": "hold", "seconds": 9}, *CRUISE[2:]]
    made["agents"]["auv3"]["mission"] = [{"type": "follow", "agent": "auv0", "offset_m": [-5, 30, 0], "seconds": 60}]
    sim = pl.Simulation.load(made)
    sim.step(ticks=4)
    assert [squad.members for squad in sim.stepper.missions._squads[1]] == [("auv0", "auv1")]
    sim.step({"auv1": [5.0, 0.5, 500.0]})
    sim.step(ticks=4)
    assert not sim.stepper.missions._squads[1]


def test_a_checkpoint_keeps_where_each_stands() -> None:
    sim = pl.Simulation.load(swarm("remus100", 3))
    flown(sim, 9)
    kept = sim.checkpoint()
    ahead, _ = flown(sim, 8)
    sim.restore(kept)
    again, _ = flown(sim, 8)
    for mine, theirs in zip(ahead, again, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_copies_at_different_legs_are_fleets_of_one() -> None:
    made = swarm("remus100", 1)
    auv = made["agents"].pop("auv")
    del auv["count"], auv["start"]["grid"], auv["start"]["spacing_m"], auv["mission_from"], auv["distributions"]
    made["agents"]["auv"] = auv
    made["vary"] = {
        "agents.auv.start.heading_deg": {"uniform": [-120, 120]}, "agents.auv.start.position_m.1": {"uniform": [-9, 9]}
    }  # fmt: skip
    many = pl.Simulation.load(made, n=3)
    whole, at = [], set()
    for _ in range(56):
        many.step(ticks=20)
        whole.append(many.state["auv"].position)
        at.add(tuple(many.stepper.missions.guidance["auv"].progress.task.tolist()))
    assert any(len(set(legs)) == 3 for legs in at)
    for i in range(3):
        alone, _ = flown(pl.Simulation.load(made, environment=i), 56)
        np.testing.assert_array_equal(np.array(whole)[:, i], np.array(alone)[:, 0, :3])

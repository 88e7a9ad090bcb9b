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
    monkeypatch.setattr(Squad, "command", lambda self, *known: called.append(len(known[0])) or command(self, *known))
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


@pytest.mark.slow  # 3 s
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


def formation(**keys: Any) -> dict[str, Any]:
    """Two leaders, and a group that follows one or the other, or the member before, each at a place of its own."""
    leader = {"vehicle": "remus100", "mission": CRUISE}
    behind = {"type": "follow", "seconds": 20}
    group = {
        "count": 5, "vehicle": "remus100", "start": {"position_m": [-20, 5], "depth_m": 3, "spacing_m": [25, 30]},
        "mission": [CRUISE[0], {**behind, "agent": "one", "offset_m": [-9.0, 7.0, 0.5]}, {"type": "surface"}],
        "mission_from": "start", "sensors": {"imu": {"type": "imu", "rate_hz": 20}},
        "distributions": {"mission.1.offset_m.1": {"uniform": [-30, 30]}, "start.heading_deg": {"uniform": [-60, 60]}},
        "overrides": {
            2: {"mission": [CRUISE[0], {**behind, "agent": "two", "offset_m": [8.0, -6.0, -0.7]}, {"type": "surface"}]},
            4: {"mission": [CRUISE[0], {**behind, "agent": "auv[3]", "offset_m": [-9, 3, 0.2]}, {"type": "surface"}]},
        },
        **keys,
    }  # fmt: skip
    return {
        "seed": 3, "tick_rate_hz": 20, "world": {"type": "flat", "depth_m": 9.0, "size_m": [900, 900]},
        "agents": {
            "one": leader | {"start": {"position_m": [0, 0], "depth_m": 3}},
            "two": leader | {"start": {"position_m": [40, -30], "depth_m": 2, "heading_deg": 90}},
            "auv": group,
        },
    }  # fmt: skip


def alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """From here on every agent is guided, and navigates, for itself."""
    monkeypatch.setattr(Squad, "in_step", False)
    monkeypatch.setattr("pelagos.sim.missions.crews_of", lambda *_: ())


def test_followers_are_a_squad_that_does_what_each_does_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    sim = pl.Simulation.load(formation(), n=2)
    together, legs = flown(sim, 46)
    squads = [squad.members for squad in sim.stepper.missions._squads[1]]
    assert squads == [("one", "two"), tuple(f"auv[{i}]" for i in range(5))]
    assert {task for at in legs for task in at[2:]} == {0, 1, 2, 3}
    assert max(len(set(at[2:])) for at in legs) >= 2  # some followed already, others did not
    alone(monkeypatch)
    for mine, theirs in zip(together, flown(pl.Simulation.load(formation(), n=2), 46)[0], strict=True):
        np.testing.assert_array_equal(mine, theirs)


AIDS = {
    "imu": {"type": "imu", "rate_hz": 20, "position_m": [0.2, -0.1, 0.05]},
    "dvl": {"type": "dvl", "rate_hz": 5, "range_max_m": 6.0},
    "depth": {"type": "depth", "rate_hz": 10},
    "gps": {"type": "gps", "rate_hz": 2},
    "mag": {"type": "magnetometer", "rate_hz": 10},
    "usbl": {"type": "usbl", "rate_hz": 5, "interrogate": ["beacon"], "interrogate_s": 1.0},
}
EKF = {"type": "ekf", "beacons": {"beacon": [60.0, -25.0, -4.0]}}


def estimated() -> dict[str, Any]:
    """Five who navigate by filters, one of them by another one, and one by the truth; two begin at the surface."""
    overrides = {
        1: {"start": {"depth_m": 0.2}},
        2: {"navigation": {"type": "ekf", "gate": 9.0}},
        3: {"start": {"depth_m": 0.2}},
        5: {"navigation": "truth"},
    }
    made = formation(count=6, sensors=AIDS, navigation=EKF, mission=CRUISE, overrides=overrides, distributions={
        "start.heading_deg": {"uniform": [-60, 60]}, "start.depth_m": {"uniform": [1.5, 5.5]}
    })  # fmt: skip
    modem = {"modem": {"type": "modem", "rate_hz": 5}}
    made["agents"]["beacon"] = {
        "vehicle": "remus100",
        "start": {"position_m": [60, -25], "depth_m": 4},
        "sensors": modem,
    }
    return made


def known(sim: pl.Simulation) -> list[np.ndarray]:
    """Everything that the filters of all keep, and what they last said."""
    found = [
        v
        for memory in sim.stepper.missions.memory()["navigators"].values()
        for v in (*memory["lanes"].values(), memory["samples"])
    ]
    for solutions in filter(None, sim.stepper.missions.solutions.values()):  # a checkpoint has none
        found += [solutions[-1].position, solutions[-1].attitude, solutions[-1].velocity, solutions[-1].rate]
    return found


def test_a_crew_of_estimators_knows_what_each_would_know_alone(monkeypatch: pytest.MonkeyPatch) -> None:
    """To the byte: copies, who surfaces, who hears no bottom and no beacon, and copies that begin anew."""

    def flight() -> tuple[list[np.ndarray], list[int]]:
        sim = pl.Simulation.load(estimated(), n=2)
        seen, crews = [], []
        for second in range(7):
            sim.step(ticks=10)
            if second == 3:
                sim.reset(where=np.array([False, True]))
            if second == 5:
                kept = sim.checkpoint()
                sim.step(ticks=7)
                sim.restore(kept)
            seen += [np.concatenate([s.position, s.attitude], axis=1) for s in sim.state.values()] + known(sim)
            sim.step(ticks=1)
            crews.append(len(set(sim.stepper.missions._crews[1].values())))
            sim.step(ticks=9)
        return seen, crews

    together, crews = flight()
    assert set(crews) == {1}
    sim = pl.Simulation.load(estimated(), n=2)
    sim.step(ticks=3)
    assert next(iter(sim.stepper.missions._crews[1].values())).members == ("auv[0]", "auv[1]", "auv[3]", "auv[4]")
    alone(monkeypatch)
    other, crews = flight()
    assert set(crews) == {0}
    assert len(together) == len(other)
    for mine, theirs in zip(together, other, strict=True):
        np.testing.assert_array_equal(mine, theirs)


def test_copies_of_estimators_begin_anew_at_ticks_of_guidance() -> None:
    sim = pl.Simulation.load(estimated(), n=2)
    sim.step(ticks=7)
    before = sim.state["auv[0]"].position.copy()
    with pytest.raises(pl.errors.CommandError, match=r"0\.35 s: auv\[0\] navigates by an estimator.*every 0\.1 s"):
        sim.reset(where=np.array([True, False]))
    np.testing.assert_array_equal(sim.state["auv[0]"].position, before)
    sim.step(ticks=1)
    whole = pl.Simulation.load(estimated(), n=2)
    whole.step(ticks=8)
    sim.reset(where=np.array([True, False]))
    sim.step(ticks=40)
    whole.step(ticks=40)
    for name in sim.state:
        np.testing.assert_array_equal(sim.state[name].position[1], whole.state[name].position[1])
        assert name == "beacon" or (sim.state[name].position[0] != whole.state[name].position[0]).any()


@pytest.mark.parametrize("vehicle", ["bluerov2_heavy", "remus100", "wamv"])
def test_copies_begin_anew_while_others_go_on(vehicle: str) -> None:
    """A copy that begins anew does what it did at the first time, eight seconds later; the others' bytes stay."""
    made = swarm("bluerov2_heavy" if vehicle == "wamv" else vehicle, 2)
    if vehicle == "wamv":
        keep = {"type": "station_keeping", "seconds": 5}
        made["agents"]["auv"] |= {"vehicle": "wamv", "mission": [{"type": "goto", "points": [[12, 5]]}, keep]}
        del made["agents"]["auv"]["start"]["depth_m"]
    sim, whole = (pl.Simulation.load(made, n=3) for _ in range(2))
    first = [whole.step(ticks=20) and whole.state["auv"].position for _ in range(16)]
    sim.step(ticks=160)
    sim.reset(where=np.array([True, False, True]))
    again = [sim.step(ticks=20) and sim.state["auv"].position for _ in range(8)]
    for late, early, along in zip(again, first[:8], first[8:], strict=True):
        np.testing.assert_array_equal(late[1], along[1])
        assert late[[0, 2]] == pytest.approx(early[[0, 2]], abs=1e-6)  # times are sums, which differ in their last bits
    assert np.abs(again[-1][0] - first[-1][0]).max() > 0.1

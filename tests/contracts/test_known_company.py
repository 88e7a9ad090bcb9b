"""Numbers of vehicles that have to do with one another: sonars that hear others' pings, modems that wait their turn,
filters and missions of a group, followers, ships that other hulls bump into."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import pelagos as pl
from known import DOUBLE, check

WATER = {
    "currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 70.0, "up_mps": 0.02}],
    "wind": {"speed_mps": 5.0, "from_deg": 200.0},
}
TIGHT = {"beams": 24, "bins": 96, "range_max_m": 25.0, "rate_hz": 5}
LOUD = {"type": "thrusters", "level_db": 165.0}


def loaded(agents: dict[str, Any], n: int = 1, **more: Any) -> pl.Simulation:
    world = {"type": "flat", "depth_m": 14.0}
    return pl.Simulation.load(
        {"seed": 9, "tick_rate_hz": 20, "world": world, "ocean": WATER, "agents": agents, **more}, n=n
    )


def gathered(sim: pl.Simulation, ticks: int) -> dict[str, list[Any]]:
    """Everything that everybody reads."""
    found: dict[str, list[Any]] = {}
    obs = sim.reset()
    for _ in range(ticks):
        for agent, readings in obs.items():
            for sensor, r in readings.items():
                for part, values in {"data": r.data, "valid": r.valid, **r.extras}.items():
                    if values is not None and np.asarray(values).dtype != object:
                        found.setdefault(f"{agent}.{sensor}.{part}", []).append(np.ravel(np.asarray(values)))
        obs = sim.step()
    return {name: [np.concatenate(values)] for name, values in found.items()}


@pytest.mark.parametrize("kind", ["imaging_sonar", "singlebeam", "dvl", "multibeam"])
def test_sonars_that_hear_one_another(kind: str) -> None:
    own = {"imaging_sonar": TIGHT, "multibeam": {"beams": 24, "range_max_m": 30.0}}.get(kind, {"rate_hz": 5})
    sensor = {"type": kind, "position_m": [0.3, 0.1, -0.2], "orientation_deg": [3.0, 4.0, 5.0], **own}
    heard = "others" if kind != "dvl" else "none"
    keys = {"hears": heard} if kind in ("imaging_sonar", "singlebeam") else {}
    agents = {
        f"auv{i}": {
            "vehicle": "bluerov2_heavy", "start": {"position_m": [6.0 * i, 3.5 * i * i], "depth_m": 4.0 + i,
                                                   "heading_deg": 40.0 + 100.0 * i},
            "control": "velocity", "sensors": {"s": {**sensor, **keys}}, "radiated_noise": LOUD,
        }
        for i in range(3)
    }  # fmt: skip
    check("company", f"{kind} that hears others", gathered(loaded(agents), 9))


@pytest.mark.parametrize("mac", ["none", "aloha", "csma", "tdma", "maca"])
def test_modems_that_wait_their_turn(mac: str) -> None:
    modem = {"type": "modem", "rate_hz": 10, "position_m": [0.2, 0.0, 0.4], "mac": mac, "acknowledge": True,
             "bit_rate_bps": 900.0}  # fmt: skip
    agents = {
        f"auv{i}": {
            "vehicle": "remus100",
            "start": {"position_m": [90.0 * i, 40.0 * i * i], "depth_m": 4.0 + i, "heading_deg": 40.0 * i},
            "control": "depth_heading", "command": [5.0, 0.3 * i, 600.0], "sensors": {"m": modem},
        }
        for i in range(3)
    }  # fmt: skip
    sim = loaded(agents)
    came: list[float] = []
    obs = sim.reset()
    for tick in range(240):
        if tick % 40 in (2, 3, 4):
            i = tick % 40 - 2
            sim.send(f"auv{i}", "m", bytes([i, tick % 251, 7]), to=f"auv{(i + 1) % 3}.m" if tick > 60 else "*")
        obs = sim.step()
        for i, readings in enumerate(obs.values()):
            r = readings.get("m")
            if r is not None:
                came += [tick * 1e-2 * (i + 1) * float(v) for v in np.ravel(r.data).astype(float)[:8] if v]
    assert came, mac
    check("company", f"modems by {mac}", {"came": came})


def test_a_group_that_navigates_by_filters() -> None:
    sensors = {
        "imu": {"type": "imu", "rate_hz": 20}, "depth": {"type": "depth", "rate_hz": 10},
        "dvl": {"type": "dvl", "rate_hz": 5, "position_m": [-0.3, 0.05, -0.1], "orientation_deg": [0, 0, 45]},
        "magnetometer": {"type": "magnetometer", "rate_hz": 5}, "gps": {"type": "gps", "rate_hz": 2,
         "position_m": [0.1, 0, 0.2]},
    }  # fmt: skip
    mission = [{"type": "waypoints", "points": [[30.0, -12.0], [18.0, 20.0]], "depth_m": 4.0}]
    group = {
        "count": 3, "vehicle": "remus100", "sensors": sensors, "mission": mission,
        "start": {"position_m": [0, 0], "depth_m": 0.3, "heading_deg": 30, "speed_mps": 1.0, "spacing_m": 12.0},
        "navigation": {"type": "ekf", "start_position_std_m": 2.0, "start_heading_std_deg": 2.0},
    }  # fmt: skip
    sim = loaded({"auv": group}, n=2)
    sim.run(25.0)
    found: dict[str, Any] = {}
    for name in ("auv[0]", "auv[2]"):
        solution, lanes = sim.stepper.missions.solutions[name][-1], sim.stepper.missions.navigators[name].lanes
        place = np.array(sim.state[name].position)
        found[f"{name} way"] = place - place[0]
        found |= {f"{name} {part}": getattr(solution, part) for part in ("position", "velocity", "attitude", "rate")}
        found[f"{name} covariance"] = lanes.covariance
    check("company", "a group by filters", found, DOUBLE)


def test_followers_and_collisions() -> None:
    lead = {
        "vehicle": "bluerov2_heavy", "start": {"position_m": [2.0, 1.0], "depth_m": 4.0},
        "mission": [{"type": "goto", "points": [[14.0, -9.0, -6.0]]}],
    }  # fmt: skip
    tail = {
        "vehicle": "bluerov2_heavy", "start": {"position_m": [-3.0, 2.5], "depth_m": 4.5},
        "mission": [{"type": "follow", "agent": "lead", "seconds": 40.0}],
    }  # fmt: skip
    drift = {"vehicle": "hovering_auv", "control": "actuators"}
    agents = {
        "lead": lead, "tail": tail, "a": {**drift, "start": {"position_m": [30.0, 0.0], "depth_m": 6.0}},
        "b": {**drift, "start": {"position_m": [32.0, 0.4], "depth_m": 6.2, "heading_deg": 140.0}},
    }  # fmt: skip
    sim = loaded(agents, tick_rate_hz=100)
    sim.set_state("a", velocity=(1.1, 0.2, -0.05), angular_velocity=(0.1, -0.2, 0.3))
    sim.set_state("b", velocity=(0.6, -0.1, 0.1))
    sim.run(12.0)
    begin = {"lead": (2, 1, -4), "tail": (-3, 2.5, -4.5), "a": (30, 0, -6), "b": (32, 0.4, -6.2)}
    found = {}
    for name, at in begin.items():
        state = sim.state[name]
        found[f"{name} way"] = np.array(state.position) - at
        found |= {
            f"{name} {part}": np.array(getattr(state, part)) for part in ("velocity", "angular_velocity", "attitude")
        }
    check("company", "followers and collisions", found, DOUBLE)

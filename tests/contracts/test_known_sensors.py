"""Readings of every sensor in a sea with a wall, a mover, wind, a current, layers and a neighbour, off all axes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_every_sensor import NAMES, SMALL

import pelagos as pl
from known import check

SIZES: dict[str, dict[str, Any]] = SMALL | {
    "multibeam": {"beams": 48, "range_max_m": 40.0},
    "imaging_sonar": {"beams": 48, "bins": 96, "range_max_m": 18.0},
}
SURFACED = ("gps", "ais", "radio", "thermal_camera")
LINKED = {"ais": 300, "modem": 120, "optical_modem": 120, "radio": 120, "usbl": 120}
OTHERS = {"usbl": {"type": "modem", "bit_rate_bps": 4000.0}, "optical_modem": {"orientation_deg": [0.0, 2.0, -96.0]}}
OWN = {
    "optical_modem": {"orientation_deg": [3.0, -4.0, 44.0]},
    "usbl": {"interrogate": ["auv1.its"], "interrogate_s": 1.5, "bit_rate_bps": 4000.0},
}


def field(value: float) -> list[dict[str, Any]]:
    return [
        {"type": "profile", "depth_m": [0.0, 3.1, 9.0], "value": [value, 1.3 * value, 0.7 * value]},
        {"type": "gradient", "per_m": 0.011 * value, "towards_deg": 25.0},
    ]


def sea(name: str) -> dict[str, Any]:
    up = name in SURFACED
    height = 1.4 if name in ("ais", "radio") else 0.4
    sensor = {
        "type": name, "rate_hz": 10, "position_m": [0.3, 0.1, height], "orientation_deg": [3.0, -4.0, 5.0],
        **SIZES.get(name, {}), **OWN.get(name, {}),
    }  # fmt: skip
    other = {**sensor, **OTHERS.get(name, {}), "position_m": [0.2, 0.0, 1.2 if up else 0.4]}
    if name == "usbl":
        other = {k: v for k, v in other.items() if not k.startswith("interrogate")}
    start = {"position_m": [4.4, -3.6] if name == "collision" else [0.0, 0.0], "depth_m": 0.0 if up else 3.0}
    return {
        "seed": 11,
        "tick_rate_hz": 20,
        "world": {
            "type": "flat",
            "depth_m": 8.0,
            "things": [{"shape": "box", "at_m": [6.0, -5.0, -6.0], "size_m": [2.0, 1.0, 9.0]}],
            "movers": [{"name": "drum", "body": "cylinder", "size_m": 1.0, "path": {
                "kind": "waypoints", "points_m": [[5.0, -1.0, -3.0], [4.0, -2.0, -3.5]], "speed_mps": 0.5}}],
        },
        "ocean": {
            "temperature_c": field(12.0),
            "salinity": field(30.0),
            "tracers": {"chlorophyll": field(2.0), "oxygen": field(240.0), "turbidity": field(1.5)},
            "currents": [{"type": "uniform", "speed_mps": 0.2, "towards_deg": 70.0}],
            "wind": {"speed_mps": 6.0, "from_deg": 200.0},
            "tide": {"constituent": "M2", "amplitude_m": 0.4, "phase_deg": 50.0},
        },
        "agents": {
            "auv0": {
                "vehicle": "remus100", "start": {**start, "heading_deg": 40.0, "roll_deg": 4.0, "pitch_deg": -3.0},
                "control": "depth_heading", "command": [start["depth_m"] + 1.0, 0.9, 700.0],
                "sensors": {"it": sensor},
                "radiated_noise": {"type": "thrusters", "level_db": 150.0},
            },
            "auv1": {
                "vehicle": "remus100",
                "start": {"position_m": [14.0, 1.0], "depth_m": start["depth_m"] + 0.5, "heading_deg": 80.0},
                "control": "depth_heading", "command": [start["depth_m"] + 1.0, 0.9, 700.0], "sensors": {"its": other},
            },
        },
    }  # fmt: skip


@pytest.mark.parametrize("name", NAMES)
def test_readings(name: str) -> None:
    sim = pl.Simulation.load(sea(name))
    obs, found = sim.reset(), []
    for tick in range(LINKED.get(name, 63 if name == "collision" else 9)):
        found += [r for agent in obs.values() for r in agent.values()]
        if name in LINKED and name != "ais" and tick in (3, 50):
            sender = ("auv1", "its") if name == "usbl" else ("auv0", "it")
            sim.send(*sender, b"of six", to="*")
        obs = sim.step()
    assert found, name
    numbers: dict[str, list[Any]] = {}
    for r in found:
        for part, values in {"data": r.data, "truth": r.truth, "valid": r.valid, **r.extras}.items():
            if values is not None and np.asarray(values).dtype != object:
                numbers.setdefault(part, []).append(np.ravel(np.asarray(values)))
    numbers["t_ns"] = [np.array([r.t_ns for r in found]) * 1e-9]
    check("sensors", name, {part: np.concatenate(values) for part, values in numbers.items()})

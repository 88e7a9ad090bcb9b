"""Filters that navigate by everything that they can: ranges to transponders, a beacon's place, the bottom, depth, the
magnetic field and satellites, with levers and turns; two copies, one of which begins anew in between."""

from __future__ import annotations

from typing import Any

import numpy as np

import pelagos as pl
from known import DOUBLE, check
from pelagos.navigation import measurement
from pelagos.navigation.error_state import SIZE, Lanes

SENSORS: dict[str, Any] = {
    "imu": {"type": "imu", "rate_hz": 20, "position_m": [0.2, -0.1, 0.05], "orientation_deg": [4, -3, 20]},
    "dvl": {"type": "dvl", "rate_hz": 5, "position_m": [-0.3, 0.05, -0.1], "orientation_deg": [0, 0, 45]},
    "depth": {"type": "depth", "rate_hz": 10, "position_m": [0.4, 0.05, 0.1]},
    "gps": {"type": "gps", "rate_hz": 2, "position_m": [0.1, 0, 0.2]},
    "magnetometer": {"type": "magnetometer", "rate_hz": 10, "position_m": [0.6, 0, 0], "orientation_deg": [10, 5, -30]},
    "usbl": {"type": "usbl", "rate_hz": 5, "interrogate": ["dock"], "interrogate_s": 1.0, "position_m": [0.3, 0.1,
    -0.1],
             "orientation_deg": [5, -4, 30]},
    "lbl": {"type": "lbl", "rate_hz": 1, "position_m": [-0.4, 0.1, 0.1], "transponders": {
        "a": {"position_m": [60, 40, -18]}, "b": {"position_m": [-50, 45, -15]}, "c": {"position_m": [10, -70, -17]}}},
}  # fmt: skip


def test_a_filter_with_every_aid() -> None:
    auv = {
        "vehicle": "remus100", "sensors": SENSORS,
        "start": {"position_m": [0, 0], "depth_m": 3.0, "heading_deg": 30, "pitch_deg": -4, "speed_mps": 1.0},
        "mission": [{"type": "waypoints", "points": [[30.0, -12.0], [18.0, 20.0]], "depth_m": 6.0}],
        "navigation": {"type": "ekf", "start_position_std_m": 6.0, "start_velocity_std_mps": 0.2,
                       "start_heading_std_deg": 3.0, "beacons": {"dock": [45.0, -30.0, -14.0]}},
    }  # fmt: skip
    dock = {"vehicle": "hovering_auv", "control": "station_keeping", "start": {"position_m": [45, -30], "depth_m": 14},
            "sensors": {"modem": {"type": "modem", "device": "x150"}}}  # fmt: skip
    scenario = {"seed": 5, "tick_rate_hz": 20, "world": {"type": "flat", "depth_m": 20.0}, "agents": {"a": auv,
        "dock": dock},
                "origin": {"latitude_deg": 44.3, "longitude_deg": 9.2}}  # fmt: skip
    sim = pl.Simulation.load(scenario, n=2)
    sim.reset()
    found: dict[str, Any] = {}
    for moment in ("first", "anew"):
        sim.run(4.5)
        solution, lanes = sim.stepper.missions.solutions["a"][-1], sim.stepper.missions.navigators["a"].lanes
        found |= {f"{moment} {part}": getattr(solution, part) for part in ("position", "velocity", "attitude", "rate")}
        found |= {f"{moment} covariance": lanes.covariance, f"{moment} slow": lanes.slow}
        if moment == "first":
            sim.reset(where=[1])
    check("filters", "every aid", found, DOUBLE)


def test_what_sensors_should_read_and_how_that_depends_on_errors() -> None:
    rng = np.random.default_rng(8)
    attitude = rng.normal(size=(3, 4))
    attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
    lanes = Lanes.at(rng.normal(0, 20, (3, 3)), rng.normal(0, 1, (3, 3)), attitude, rng.uniform(0.1, 1.0, SIZE))
    lanes.slow[:] = rng.normal(0, 0.3, lanes.slow.shape)
    lanes.rate[:] = rng.normal(0, 0.4, (3, 3))
    lever, turn = np.array([0.4, -0.2, 0.3]), np.linalg.qr(rng.normal(size=(3, 3)))[0]
    turn *= np.sign(np.linalg.det(turn))
    three, one, field = rng.normal(0, 5, (3, 3)), rng.normal(20, 5, 3), np.array([2.1e-5, -0.4e-5, -4.2e-5])
    expected = {
        "bottom": measurement.bottom_velocity(lanes, three, lever, turn),
        "satellite": measurement.satellite_position(lanes, three, lever),
        "depth": measurement.depth(lanes, one, lever),
        "magnetic": measurement.magnetic_field(lanes, 1e-5 * three, field, turn),
        "range": measurement.beacon_range(lanes, one, lever, np.array([31.0, -22.0, -17.0])),
        "place": measurement.beacon_place(lanes, three, lever, turn, 4 * three[::-1], np.array([0.7, 1.1, 0.2])),
    }
    found: dict[str, Any] = {}
    for name, (h, innovation) in expected.items():
        found |= {f"{name} by errors": h, f"{name} innovation": innovation}
        noise = 0.3 * np.eye(h.shape[1]) + 0.1 * np.ones((len(h), h.shape[1], h.shape[1]))
        lanes.update(h, innovation, noise, np.array([True, True, False]), 1e9)
        found |= {
            f"{name} {part}": getattr(lanes, part)
            for part in ("position", "velocity", "attitude", "slow", "covariance")
        }
    found["curvature"] = measurement.curvature(lanes, field) * 1e10
    check("filters", "measurements", found, DOUBLE)

"""Swarms: many vehicles in one sea, what a tick of them takes, and how that grows with their number."""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np

import pelagos
from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import BenchError

SIZES: Final = (10, 30, 100, 300, 1000)
TICK_HZ: Final = 200.0
SPACING_M: Final = 20.0
NAVIGATION: Final = {"imu": {"type": "imu", "rate_hz": 100}, "depth": {"type": "depth", "rate_hz": 20}}
DVL: Final = {"dvl": {"type": "dvl", "rate_hz": 5}}
REAL_TIME: Final = Reference("real time at 200 Hz", 1e3 / TICK_HZ)


def fleet(count: int, sensors: dict[str, Any]) -> dict[str, Any]:
    """So many REMUS under depth, heading and speed control over a flat bottom."""
    auv = {
        "count": count,
        "vehicle": "remus100",
        "start": {"position_m": [0.0, 0.0], "depth_m": 10.0, "speed_mps": 1.5, "spacing_m": SPACING_M},
        "control": "depth_heading_speed",
        "command": [10.0, 0.3, 1.5],
        "sensors": sensors,
    }
    return {"tick_rate_hz": TICK_HZ, "world": {"type": "flat", "depth_m": 40.0}, "agents": {"auv": auv}}


def rovs(count: int) -> dict[str, Any]:
    """ROVs 3 m from one another, at rest, with contact among them."""
    rov = {
        "count": count,
        "vehicle": "bluerov2",
        "start": {"position_m": [0.0, 0.0], "depth_m": 10.0, "spacing_m": 3.0},
    }
    return {"tick_rate_hz": TICK_HZ, "world": {"type": "flat", "depth_m": 40.0}, "agents": {"rov": rov}}


def tick_ms(scenario: dict[str, Any], *, seconds: float = 1.0, repeats: int = 3) -> float:
    """Wall-clock time of a tick in a run, the least of several [ms]."""
    sim = pelagos.Simulation.load(scenario)
    sim.run(seconds)
    found = []
    for _ in range(repeats):
        start = time.perf_counter()
        sim.run(seconds)
        found.append((time.perf_counter() - start) / (seconds * TICK_HZ) * 1e3)
    if not all(np.isfinite(state.position).all() for state in sim.state.values()):
        raise BenchError("a position is not finite")
    return min(found)


def swarm_1000_tick_ms() -> Measured:
    """A tick of a thousand, with all three sensors."""
    return Measured(tick_ms(fleet(1000, NAVIGATION | DVL)), detail="1 000 finite positions")


def swarm_1000_load_s() -> Measured:
    """From the scenario to the first tick."""
    start = time.perf_counter()
    sim = pelagos.Simulation.load(fleet(1000, NAVIGATION | DVL))
    sim.step()
    return Measured(time.perf_counter() - start, detail=f"{len(sim.state)} vehicles, one tick")


def swarm_100_contact_tick_ms() -> Measured:
    """A tick of ROVs that may touch one another."""
    return Measured(tick_ms(rovs(100)), detail="100 finite positions")


def swarm_growth() -> Measured:
    """Exponent of the time of a tick against the number of vehicles, by least squares of the logarithms."""
    times = [tick_ms(fleet(count, NAVIGATION | DVL)) for count in SIZES]
    slope = float(np.polyfit(np.log(SIZES), np.log(times), 1)[0])
    return Measured(slope, detail=", ".join(f"{n}: {t:.2f} ms" for n, t in zip(SIZES, times, strict=True)))


CASES: Final = (
    Case("swarm_1000_tick_ms", "1 000 REMUS in one sea with control, IMU, depth and DVL at their rates; one tick",
         swarm_1000_tick_ms, "ms", 5.0, "lower", REAL_TIME),
    Case("swarm_1000_load_s", "the same from the scenario to the end of the first tick",
         swarm_1000_load_s, "s", 5.0, "lower", Reference("no published figure")),
    Case("swarm_100_contact_tick_ms", "100 ROVs 3 m apart over a flat bottom, at rest, contact looked for; one tick",
         swarm_100_contact_tick_ms, "ms", 3.0, "lower", REAL_TIME),
    Case("swarm_growth", "exponent of the time of a tick from 10 to 1 000 vehicles",
         swarm_growth, "1", 1.1, "lower", Reference("linear", 1.0)),
)  # fmt: skip

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
COMPONENTS: Final = 200  # of the sea
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
    """ROVs 3 m from one another in the basin of the harbour, each on a course of its own into others."""
    rov = {
        "count": count,
        "vehicle": "bluerov2",
        "start": {"position_m": [-20.0, -20.0], "depth_m": 3.0, "spacing_m": 3.0},
        "control": "velocity",
        "command": [0.5, 0.0, 0.0, 0.0],
        "distributions": {"start.heading_deg": {"uniform": [-180, 180]}},
    }
    return {"tick_rate_hz": TICK_HZ, "world": {"type": "harbour"}, "agents": {"rov": rov}}


def sonars(count: int) -> dict[str, Any]:
    """ROVs 6 m from one another, each with an imaging sonar that sees those before it."""
    sonar = {"type": "imaging_sonar", "rate_hz": 5, "position_m": [0.3, 0, 0], "beams": 64, "range_max_m": 30}
    rov = {
        "count": count,
        "vehicle": "bluerov2",
        "start": {"position_m": [0.0, 0.0], "depth_m": 10.0, "spacing_m": 6.0},
        "sensors": {"sonar": sonar},
    }
    return {"tick_rate_hz": TICK_HZ, "world": {"type": "flat", "depth_m": 20.0}, "agents": {"rov": rov}}


def boats(count: int) -> dict[str, Any]:
    """WAM-V 12 m from one another in sea state 4."""
    boat = {
        "count": count,
        "vehicle": "wamv",
        "control": "actuators",
        "start": {"position_m": [0.0, 0.0], "depth_m": 0.0, "spacing_m": 12.0},
    }
    waves = {"type": "sea_state", "state": 4, "components_count": COMPONENTS}
    return {
        "tick_rate_hz": 100,
        "world": {"type": "flat", "depth_m": 200.0},
        "ocean": {"waves": waves},
        "agents": {"boat": boat},
    }


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
    """A tick of a thousand, with all three sensors, each reading looked at as one array."""
    sim = pelagos.Simulation.load(fleet(1000, NAVIGATION | DVL))
    ticks, found = round(TICK_HZ), []
    for _ in range(4):
        read: dict[str, int] = {}
        start = time.perf_counter()
        for _ in range(ticks):
            for name, reading in sim.step()["auv"].items():
                if reading.data.shape[:2] != (1, 1000) or not np.isfinite(reading.data[reading.valid]).all():
                    raise BenchError(f"{name} does not read for all, or is not finite")
                read[name] = read.get(name, 0) + 1
        found.append((time.perf_counter() - start) / ticks * 1e3)
    if read != {"imu": 100, "depth": 20, "dvl": 5}:
        raise BenchError(f"readings in a second: {read}")
    return Measured(min(found), detail="1 000 x (100 imu, 20 depth, 5 dvl) readings a second, each looked at")


def swarm_1000_load_s() -> Measured:
    """From the scenario to the first tick."""
    start = time.perf_counter()
    sim = pelagos.Simulation.load(fleet(1000, NAVIGATION | DVL))
    sim.step()
    return Measured(time.perf_counter() - start, detail=f"{len(sim.state)} vehicles, one tick")


def swarm_100_contact_tick_ms() -> Measured:
    """A tick of ROVs that run into one another."""
    sim = pelagos.Simulation.load(rovs(100))
    sim.run(2.0)
    start, touched = time.perf_counter(), 0
    for _ in range(10):
        sim.run(0.1)
        touched += sum(bool(np.any(sim.stepper.contact(name))) for name in sim.state)
    took = (time.perf_counter() - start) / TICK_HZ * 1e3
    if not touched:
        raise BenchError("nothing touches anything")
    return Measured(took, detail=f"{touched / 10:.0f} of 100 touch another at a time")


def swarm_100_sonar_tick_ms() -> Measured:
    """A tick of ROVs that see one another by imaging sonar, on the average over all ticks."""
    sim = pelagos.Simulation.load(sonars(100))
    sim.run(0.4)
    start = time.perf_counter()
    sim.run(1.0)
    took = (time.perf_counter() - start) / TICK_HZ * 1e3
    seen = sim.read("rov[0]")["sonar"].data
    if not np.isfinite(seen).all() or float(np.ptp(seen)) == 0.0:
        raise BenchError("a sonar sees nothing")
    return Measured(took, detail=f"100 pictures of {seen.shape[-2]} x {seen.shape[-1]}, five times a second")


def wamv_500_ss4_rtf() -> Measured:
    """Boats in sea state 4, pressure on the wet hull of each, 100 Hz."""
    sim = pelagos.Simulation.load(boats(500))
    sim.run(0.5)
    before = sim.state["boat"].position[0, :, 2].copy()
    start = time.perf_counter()
    sim.run(2.0)
    took = time.perf_counter() - start
    height = sim.state["boat"].position[0, :, 2]
    if not float(np.abs(height).max()) < 4.0 or not float(np.abs(height - before).min()) > 0.0:
        raise BenchError("the boats do not float on the sea")
    return Measured(2.0 / took, detail=f"{COMPONENTS} components; heights of {float(np.ptp(height)):.1f} m")


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
    Case("swarm_100_contact_tick_ms", "100 ROVs 3 m apart in the harbour that run into one another; one tick",
         swarm_100_contact_tick_ms, "ms", 3.0, "lower", REAL_TIME),
    Case("swarm_100_sonar_tick_ms", "100 ROVs that see one another by imaging sonars of 64 beams, 5 Hz; mean tick",
         swarm_100_sonar_tick_ms, "ms", 25.0, "lower", REAL_TIME),
    Case("wamv_500_ss4_rtf", "500 WAM-V in sea state 4 at 100 Hz, pressure on the wet hull of each",
         wamv_500_ss4_rtf, "x real time", 1.0, "higher", Reference("real time", 1.0)),
    Case("swarm_growth", "exponent of the time of a tick from 10 to 1 000 vehicles",
         swarm_growth, "1", 1.1, "lower", Reference("linear", 1.0)),
)  # fmt: skip

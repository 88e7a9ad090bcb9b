"""Speed of sound channels, of modems and of hydrophones."""

from __future__ import annotations

import time
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from pelagos.acoustics.eigenrays import eigenrays
from pelagos.acoustics.section import Section
from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must
from pelagos.bench.timing import seconds
from pelagos.sensors.comms.link.water_paths import WaterPaths, shift_arrivals
from pelagos.sim.simulation import Simulation

MUNK_DEPTH: Final = np.arange(0.0, 5001.0, 200.0)
NONE: Final = Reference("no published figure")


def munk() -> Section:
    """Munk's profile over 5000 m, 50 Hz."""
    z = 2 * (MUNK_DEPTH - 1300) / 1300
    speed = 1500 * (1 + 0.00737 * (z - 1 + np.exp(-z)))
    return Section(MUNK_DEPTH, speed, np.zeros(1), np.array([5000.0]), sound_speed_ratio=1600 / 1551.91, frequency=50.0)


def channel_munk_100km_ms() -> Measured:
    """All eigenrays of one pair over 100 km; beside BELLHOP's own time for 5001 beams, where it is installed."""
    section = munk()
    ends = np.array([1000.0]), np.array([800.0]), np.array([1e5])
    found = eigenrays([section], *ends)
    must(len(found) >= 10 and abs(found.delay[0] - 66.60) < 0.05, f"ten arrivals from 66.60 s on, not {len(found)}")
    took = seconds(lambda: eigenrays([section], *ends))
    return Measured(1e3 * took, _bellhop_ms(section), f"{len(found)} eigenrays, the first after {found.delay[0]:.4f} s")


def _bellhop_ms(section: Section) -> Reference:
    try:
        import pelagic  # type: ignore[import-untyped]
    except ImportError:
        return Reference("BELLHOP is not installed (package pelagic)")
    lines = [
        "'munk'", "50.0", "1", "'CVF'", "0 0.0 5000.0",
        *(f"{d} {c} /" for d, c in zip(section.depth, section.speed, strict=True)),
        "'A' 0.0", "5000.0 1600.0 0.0 1.0 0.0 0.0 /", "1", "1000.0 /", "1", "800.0 /", "1", "100.0 /", "'A'", "5001",
        "-25 25 /", "0.0 5500 101",
    ]  # fmt: skip
    with TemporaryDirectory() as folder:
        file = Path(folder) / "munk.env"
        file.write_text("\n".join(lines) + "\n")
        took = seconds(lambda: pelagic.bellhop.load(str(file)).run(), at_least_s=0.5, warm_up=1)
    return Reference("BELLHOP (package pelagic), 5001 beams, same run", 1e3 * took)


@cache
def _harbour() -> tuple[WaterPaths, Any]:
    sim = Simulation.load(
        {"tick_rate_hz": 50, "world": {"type": "harbour"},
         "agents": {"a": {"vehicle": "remus100", "start": {"position_m": [-60, 46], "depth_m": 4}}}}
    )  # fmt: skip
    return WaterPaths(sim.model.scene, sim.world, sim.model.ocean, frequency=25e3), sim


def channel_new_link_ms() -> Measured:
    """A link that is traced for the first time, in the harbour: ground by casts, rays, structures in the way."""
    tracer, _ = _harbour()
    a, b, copy = np.array([[-60.0, 46.0, -4.0]]), np.array([[40.0, 20.0, -5.0]]), np.zeros(1, np.int64)
    paths = tracer.trace(a, b, 0.0, copy)
    must(len(paths.arrivals) >= 4, f"at least four paths, not {len(paths.arrivals)}")
    shift = iter(np.linspace(0.0, 5.0, 100_000))

    def once() -> None:
        tracer.trace(a, b + np.array([[next(shift), 0.0, 0.0]]), 0.0, copy)

    return Measured(1e3 * seconds(once), detail=f"{len(paths.arrivals)} paths between places 103 m apart")


def channel_cached_link_us() -> Measured:
    """Delays of a link that was traced before, after both ends have moved a little."""
    tracer, _ = _harbour()
    ends = np.array([[[-60.0, 46.0, -4.0], [40.0, 20.0, -5.0]]])
    paths = tracer.trace(ends[:, 0], ends[:, 1], 0.0, np.zeros(1, np.int64))
    must(len(paths.arrivals) >= 4, f"at least four paths, not {len(paths.arrivals)}")
    new = ends + 0.1

    def many() -> None:
        for _ in range(100):
            shift_arrivals(paths, ends, new)

    start = time.perf_counter()
    took = seconds(many) / 100
    return Measured(
        1e6 * took, detail=f"{len(paths.arrivals)} delays, to first order ({time.perf_counter() - start:.1f} s)"
    )


def swarm(vehicles: int) -> dict[str, Any]:
    """Vehicles on a grid with navigation sensors and modems in TDMA; each tells the others once a frame."""
    side = int(np.ceil(np.sqrt(vehicles)))
    modem = {"type": "modem", "device": "s2cr_18_34", "rate_hz": 2.0, "mac": "tdma", "slots": vehicles, "slot_s": 1.0,
             "guard_s": 0.4, "beacon_s": float(vehicles)}  # fmt: skip
    sensors = {"modem": modem, "imu": {"type": "imu", "rate_hz": 50}, "depth": {"type": "depth", "rate_hz": 10}}
    return {
        "tick_rate_hz": 50,
        "world": {"type": "flat", "depth_m": 60.0, "size_m": [4000.0, 4000.0]},
        "agents": {
            f"auv{k}": {
                "vehicle": "remus100",
                "start": {
                    "position_m": [80.0 * (k % side), 80.0 * (k // side)],
                    "depth_m": 15 + k % 7,
                    "speed_mps": 1.0,
                },
                "control": "depth_heading",
                "command": [15.0 + k % 7, 0.0, 800.0],
                "sensors": sensors,
            }
            for k in range(vehicles)
        },
    }


def _swarm_rtf(vehicles: int, seconds_simulated: float) -> Measured:
    sim = Simulation.load(swarm(vehicles))
    sim.run(3.0)
    heard: list[Any] = []
    for name in sim.model.agents:
        sim.subscribe(f"{name}.modem", lambda reading: heard.extend(reading.packets))
    result = sim.run(seconds_simulated)
    must(len(heard) >= 0.5 * seconds_simulated * (vehicles - 1), f"packets heard by most, not {len(heard)}")
    return Measured(result.real_time_factor, detail=f"{len(heard)} packets received in {seconds_simulated:g} s")


def modem_swarm_20_rtf() -> Measured:
    """Twenty vehicles."""
    return _swarm_rtf(20, 20.0)


def modem_swarm_100_rtf() -> Measured:
    """A hundred vehicles."""
    return _swarm_rtf(100, 8.0)


def hydrophone_4ch_96khz_rtf() -> Measured:
    """Four elements at 96 kHz with one pinger."""
    elements = [[0.0, 0, 0], [0.02, 0, 0], [0, 0.02, 0], [0, 0, 0.02]]
    hydrophone = {"type": "hydrophone", "elements_m": elements, "pingers": {"p": {"position_m": [60.0, 20.0, -20.0]}}}
    sim = Simulation.load(
        {"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 40.0},
         "agents": {"a": {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 10},
                          "sensors": {"hydrophone": hydrophone}}}}
    )  # fmt: skip
    sim.run(1.0)
    result = sim.run(5.0)
    reading = result.observations["a"]["hydrophone"]
    must(
        reading.data.shape == (1, 4, 9600) and float(np.abs(reading.data).max()) > 0, "4 x 9600 samples that are not 0"
    )
    return Measured(result.real_time_factor, detail="4 x 480 000 samples")


CASES: Final = (
    Case("channel_munk_100km_ms", "all eigenrays of one pair over 100 km of Munk's profile",
         channel_munk_100km_ms, "ms", 50.0, "lower", NONE),
    Case("channel_new_link_ms", "a new link in the harbour: bottom by casts, rays, structures in the way",
         channel_new_link_ms, "ms", 20.0, "lower", NONE),
    Case("channel_cached_link_us", "the same link again, its ends a little moved",
         channel_cached_link_us, "us", 50.0, "lower", NONE),
    Case("modem_swarm_20_rtf", "20 vehicles with modems in TDMA, IMU and depth; simulated over wall-clock time",
         modem_swarm_20_rtf, "x real time", 20.0, "higher", NONE),
    Case("modem_swarm_100_rtf", "100 vehicles with modems in TDMA, IMU and depth; simulated over wall-clock time",
         modem_swarm_100_rtf, "x real time", 1.0, "higher", NONE),
    Case("hydrophone_4ch_96khz_rtf", "four hydrophones at 96 kHz with a pinger; simulated over wall-clock time",
         hydrophone_4ch_96khz_rtf, "x real time", 5.0, "higher", NONE),
)  # fmt: skip

"""Large worlds: rays beside those of a small one, and the cost of a transit of 100 km through a streamed one."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from functools import cache
from typing import Any, Final

import numpy as np
import yaml

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.cases.worlds import WORLD
from pelagos.bench.check import BenchError, example, must
from pelagos.bench.timing import seconds
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.sensors.sonar.singlebeam import Singlebeam, SinglebeamConfig
from pelagos.sim.memory import peak_memory_mb
from pelagos.world.build import build_world, world_config
from pelagos.world.world import World

ALTITUDE_M: Final = 8.0
TRANSIT: Final = "transit_100km.yaml"
NONE: Final = Reference("no published figure")


@cache
def _transited() -> dict[str, Any]:
    """The transit in a fresh process."""
    done = subprocess.run(
        [sys.executable, "-m", "pelagos.bench.cases.large_worlds"], capture_output=True, text=True, check=False
    )
    if done.returncode != 0:
        raise BenchError(f"ended with code {done.returncode}: {(done.stderr.strip() or 'no message').splitlines()[-1]}")
    found: dict[str, Any] = json.loads(done.stdout.splitlines()[-1])
    return found


@cache
def _world(name: str) -> World:
    return build_world(world_config(WORLD if name == "2 km" else {"type": "harbour"}))


def _ping_s(name: str, kind: str) -> float:
    """Time of a ping at the same height above the ground [s]."""
    world = _world(name)
    context = SensorContext(
        path="auv0.sonar",
        seed=0,
        dt_ns=5_000_000,
        scene=world.scene(),
        world=world,
        ocean=build_ocean(OceanConfig(), world),
        own_body=np.full(1, NO_BODY, np.uint32),
    )
    sensor: Any = (
        Multibeam(MultibeamConfig(), context) if kind == "multibeam" else Singlebeam(SinglebeamConfig(), context)
    )
    x, y = (0.0, 0.0) if name == "2 km" else (-40.0, 30.0)
    z = float(world.height(x, y)) + ALTITUDE_M
    step = iter(range(1_000_000))

    def ping() -> Any:
        k = next(step)
        return sensor.sense(lanes([k], dt_ns=5_000_000, position=np.array([[x + 0.01 * k, y, z]]))).data

    first = np.asarray(ping())
    must(bool(np.isfinite(first).any()) and float(np.nanstd(first)) > 0, f"{kind} sees nothing")
    return seconds(ping)


def _ratio(kind: str) -> Measured:
    small = _ping_s("harbour", kind)
    large = _ping_s("2 km", kind)
    reference = Reference("the same sonar in the small harbour, same run", 1.0)
    return Measured(large / small, reference, f"{1e3 * large:.3g} ms a ping, {1e3 * small:.3g} ms in the harbour")


def multibeam_2km_x() -> Measured:
    """A ping of a multibeam in 8 million triangles over one in the harbour."""
    return _ratio("multibeam")


def singlebeam_2km_x() -> Measured:
    """A ping of a single beam in 8 million triangles over one in the harbour."""
    return _ratio("singlebeam")


def _transit() -> dict[str, Any]:
    """Follow the transit block by block; the axis of every beam must meet the ground."""
    from pelagos.sim.simulation import Simulation

    sim = Simulation.load(example(TRANSIT))
    sim.reset()
    last = round(float(sim.scenario.duration_s or 0.0) * 1e9) // sim.dt_ns
    beams = lost = silent = 0
    begun, start = sim.state["ship"].position[0], time.perf_counter()
    while sim.stepper.tick < last:
        for sampled in sim.stepper.advance(last):
            if sampled.model.name == "multibeam":
                read = sampled.measurement
                beams += read.truth.size
                lost += int((~np.isfinite(read.truth)).sum())
                silent += int((~np.isfinite(read.data)).sum())
    took = time.perf_counter() - start
    way = float(np.linalg.norm(sim.state["ship"].position[0] - begun))
    must(lost == 0, f"the rays of {lost} of {beams} beams met nothing")
    must(way > 99_000.0, f"the ship went {way:.0f} m only")
    return {
        "memory_mb": peak_memory_mb(),
        "rtf": last * sim.dt_ns * 1e-9 / took,
        "detail": f"{way / 1e3:.1f} km; all of {beams} beams met the ground, {silent} too faint to detect",
    }


def transit_100km_mb() -> Measured:
    """Peak memory of a transit of 100 km."""
    found = _transited()
    limit = yaml.safe_load(example(TRANSIT).read_text(encoding="utf-8"))["world"]["memory_mb"]
    reference = Reference("the scenario's memory_mb", float(limit))
    return Measured(found["memory_mb"], reference, found["detail"])


def transit_100km_rtf() -> Measured:
    """Real-time factor of the same transit."""
    found = _transited()
    return Measured(found["rtf"], Reference("real time", 1.0), found["detail"])


CASES: Final = (
    Case("multibeam_2km_x", "a multibeam ping over 8 M triangles, over one in the small harbour",
         multibeam_2km_x, "x", 1.5, "lower", NONE),
    Case("singlebeam_2km_x", "a single-beam ping over 8 M triangles, over one in the small harbour",
         singlebeam_2km_x, "x", 1.5, "lower", NONE),
    Case("transit_100km_mb", "peak memory of a ship with a multibeam on 100 km through a world of 100 km at 10 m",
         transit_100km_mb, "MB", 1024.0, "lower", NONE),
    Case("transit_100km_rtf", "the same transit; simulated over wall-clock time",
         transit_100km_rtf, "x real time", 50.0, "higher", NONE),
)  # fmt: skip


if __name__ == "__main__":
    print(json.dumps(_transit()))

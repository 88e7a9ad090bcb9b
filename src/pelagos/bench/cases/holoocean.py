"""HoloOcean's interface: what it adds to a tick, and its own published cases."""

from __future__ import annotations

import time
from typing import Any, Final

import numpy as np

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.check import must
from pelagos.bench.timing import seconds_in_turns
from pelagos.compat import holoocean
from pelagos.compat.holoocean import packagemanager

TICKS: Final = 50
COMMAND: Final = np.array([1.0, 2, 3, 4, 0, 0, 0, 0])


def step_overhead_ms() -> Measured:
    """Time of a step beyond the native step with the same sensors, scenario SimpleUnderwater-Hovering."""
    env = holoocean.make("SimpleUnderwater-Hovering", seed=1)
    sim = env.pelagos

    def through_the_interface() -> None:
        for _ in range(TICKS):
            env.step(COMMAND)

    def native() -> None:
        for _ in range(TICKS):
            sim.step()

    whole, own = (1e3 * s / TICKS for s in seconds_in_turns(through_the_interface, native))
    state = env.step(COMMAND)
    must("PoseSensor" in state and np.isfinite(state["PoseSensor"]).all(), "a pose at every tick")
    return Measured(whole - own, Reference("the native tick with the same sensors", own), f"{whole:.3f} ms in all")


def _fan(sensor: dict[str, Any], tps: int) -> dict[str, Any]:
    agent = {
        "agent_name": "auv0", "agent_type": "HoveringAUV", "control_scheme": 0, "location": [-5, 0, -10],
        "rotation": [0, 0, 180], "sensors": [sensor],
    }  # fmt: skip
    return {"name": "case", "world": "Dam", "package_name": "Ocean", "ticks_per_sec": tps, "agents": [agent]}


def singlebeam_tick_ms() -> Measured:
    """A tick with a single-beam sonar that pings at every tick, before the dam."""
    config = {"OpeningAngle": 30, "RangeMin": 0.5, "RangeMax": 23, "RangeBins": 200}
    env = holoocean.make(scenario_cfg=_fan({"sensor_type": "SinglebeamSonar", "configuration": config}, 30), seed=1)
    (took,) = seconds_in_turns(lambda: env.tick())
    must(float(env.tick()["SinglebeamSonar"].max()) > 0, "an echo")
    return Measured(1e3 * took, detail="200 bins, 30 pings a second")


def dam_hovering_fps() -> Measured:
    """Pictures a second of 512 x 512 with all navigation sensors, at 30 ticks a second."""
    scenario = packagemanager.get_scenario("Dam-HoveringCamera")
    agent = scenario["agents"][0]
    agent["sensors"] = [s for s in agent["sensors"] if s.get("sensor_name") != "RightCamera"]
    scenario["ticks_per_sec"] = 30
    for sensor in agent["sensors"]:
        rate = 30.0 if sensor["sensor_type"] == "RGBCamera" else min(float(sensor.get("Hz") or 30), 30.0)
        sensor["Hz"] = 30.0 / round(30.0 / rate)
    env = holoocean.make(scenario_cfg=scenario, seed=1)
    (took,) = seconds_in_turns(lambda: env.tick())
    picture = env.tick()["LeftCamera"]
    must(picture.shape == (512, 512, 4) and picture[..., :3].std() > 1, "a picture with something in it")
    return Measured(1 / took, detail="one picture a tick")


def make_s() -> Measured:
    """Longest `make` of a shipped scenario of each world, the second time in a process."""
    longest, name = 0.0, ""
    for scenario in ("Dam-HoveringImagingSonar", "OpenWater-TorpedoSidescanSonar", "PierHarbor-HoveringCamera",
                     "SimpleUnderwater-Hovering", "Rooms-DataGen"):  # fmt: skip
        holoocean.make(scenario, seed=1)
        start = time.perf_counter()
        holoocean.make(scenario, seed=1)
        took = time.perf_counter() - start
        if took > longest:
            longest, name = took, scenario
    return Measured(longest, detail=name)


CASES: Final = (
    Case("holoocean_step_overhead_ms", "HoloOcean's step over the native step, six navigation sensors",
         step_overhead_ms, "ms", 0.1, "lower", Reference("the native tick with the same sensors")),
    Case("holoocean_singlebeam_tick_ms", "HoloOcean's single beam before the dam: a whole tick", singlebeam_tick_ms,
         "ms", 0.5, "lower", Reference("HoloOcean single beam by ray casting, gaming GPU (arXiv 2510.06160)", 12.0)),
    Case("holoocean_dam_hovering_fps", "HoloOcean's Dam-Hovering with a camera of 512 x 512 and navigation sensors",
         dam_hovering_fps, "Hz", 29.0, "higher", Reference("HoloOcean, Dam-Hovering on a GPU", 29.0)),
    Case("holoocean_make_s", "HoloOcean's make of a shipped scenario, warm", make_s, "s", 5.0, "lower",
         Reference("no published figure")),
)  # fmt: skip

"""What every sensor of the registry must do, checked the day it is added."""

from __future__ import annotations

import inspect
import re

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.config import registry
from pelagos.config.described import descriptions
from pelagos.messages.encoders import encoder
from pelagos.messages.encoding import Site
from pelagos.sensors.sensor import SensorConfig

_CAST = re.compile(r"call void %rd\d+\(ptr %u\d+_in_0")  # a call into Embree
NAMES = sorted(registry.entries("sensor", plugins=False))
NOTHING_TO_CITE = {  # no model
    "pose", "velocity", "tracer", "instance_camera", "normal_camera", "collision", "range_finder",
}  # fmt: skip
SMALL = {  # images as small as they may be: these tests are about rules, not about pictures
    "camera": {"width_px": 32, "height_px": 24},
    "depth_camera": {"width_px": 32, "height_px": 24},
    "semantic_camera": {"width_px": 32, "height_px": 24},
    "instance_camera": {"width_px": 32, "height_px": 24},
    "normal_camera": {"width_px": 32, "height_px": 24},
    "optical_flow_camera": {"width_px": 32, "height_px": 24},
    "event_camera": {"width_px": 32, "height_px": 24},
    "thermal_camera": {"width_px": 32, "height_px": 24},
    "profiling_sonar": {"range_max_m": 40.0},
    "multibeam": {"beams": 32},
    "imaging_sonar": {"beams": 32, "bins": 64},
    "tracer": {"tracer": "oxygen"},
    "lbl": {"transponders": {"a": {"position_m": [40.0, 20.0, -6.0]}, "b": {"position_m": [-30.0, 50.0, -7.0]}}},
    "range_bearing": {"targets": {"a": {"position_m": [40.0, 20.0, -6.0]}, "b": {"position_m": [-30.0, 50.0, -7.0]}}},
    "hydrophone": {
        "sample_rate_hz": 2000.0,
        "pingers": {"p": {"position_m": [40.0, 20.0, -6.0], "frequency_hz": 900.0}},
    },
}


def scenario(name: str) -> dict[str, object]:
    return {
        "seed": 11,
        "world": {"type": "flat", "depth_m": 8.0},
        "ocean": {"tracers": {"chlorophyll": 2.0, "oxygen": 240.0, "turbidity": 1.5}},
        "agents": {
            "auv0": {
                "vehicle": "remus100",
                "start": {"position_m": [0.0, 0.0], "depth_m": 0.0 if name == "gps" else 3.0, "heading_deg": 40.0},
                "control": "depth_heading",
                "command": [0.0 if name == "gps" else 4.0, 0.9, 700.0],
                "sensors": {
                    "it": {"type": name, "rate_hz": 10, "position_m": [0.3, 0.0, 0.3], **SMALL.get(name, {})},
                },
            }
        },
    }


def readings(sim: pl.Simulation, count: int = 4) -> list[pl.Reading]:
    found, obs = [], sim.reset()
    for _ in range(20 * count):
        found += [obs["auv0"]["it"]] if "it" in obs["auv0"] else []
        obs = sim.step()
    return found


def assert_same(one: pl.Reading, other: pl.Reading) -> None:
    assert one.t_ns == other.t_ns
    for mine, theirs in ((one.data, other.data), (one.truth, other.truth), (one.valid, other.valid)):
        assert mine.tobytes() == theirs.tobytes()
    assert one.extras.keys() == other.extras.keys()
    for extra, values in one.extras.items():
        assert values.tobytes() == other.extras[extra].tobytes(), extra


def counted(sim: pl.Simulation) -> tuple[int, int]:
    """Kernels of one reading, and places in their code where rays are cast, by Dr.Jit's history of kernels."""
    sensor = sim.model.agents["auv0"].sensors["it"].sensor
    sim.reset()
    for _ in range(20):
        sim.step()  # everything is recorded by now
    history: list[dict[str, object]] = []
    sense = sensor.sense

    def watched(motion):
        dr.kernel_history_clear()
        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            found = sense(motion)
            history[:] = dr.kernel_history()
        return found

    sensor.sense = watched
    try:
        for _ in range(20):
            sim.step()
    finally:
        sensor.sense = sense
    casts = [len(_CAST.findall(k["ir"].getvalue())) for k in history if "ir" in k]
    return len(history), sum(casts)


@pytest.fixture(scope="module", params=NAMES)
def sensor(request) -> tuple[str, pl.Simulation, list[pl.Reading]]:
    sim = pl.Simulation.load(scenario(request.param), n=3)
    return request.param, sim, readings(sim)


def test_readings_have_a_fleet_axis_a_time_and_a_frame(sensor):
    _, sim, found = sensor
    assert len(found) == 4
    for k, reading in enumerate(found):
        assert reading.t_ns == k * 100_000_000
        assert reading.frame == "auv0/it"
        assert reading.valid.shape == (3,)
        assert len(reading.data) == len(reading.truth) == 3
        for name, values in reading.extras.items():
            assert isinstance(values, np.ndarray), name
    assert sim.n == 3


def test_copies_alone_in_a_fleet_and_repeated_are_the_same_bytes(sensor):
    name, _, found = sensor
    again = readings(pl.Simulation.load(scenario(name), n=3))
    alone = readings(pl.Simulation.load(scenario(name), environment=2))
    for reading, repeat, single in zip(found, again, alone, strict=True):
        assert reading.data.tobytes() == repeat.data.tobytes()
        assert reading.data[2].tobytes() == single.data[0].tobytes()
        assert reading.truth[2].tobytes() == single.truth[0].tobytes()
        for extra in reading.extras:
            assert extra in single.extras


def test_a_second_reset_gives_the_same_readings(sensor):
    """A sensor keeps nothing from one run to the next."""
    _, sim, found = sensor
    for reading, again in zip(found, readings(sim), strict=True):
        assert_same(reading, again)


def test_blocks_of_ticks_read_the_same_as_single_ticks(sensor):
    """A sensor keeps nothing from one reading to the next either: `run` asks it in blocks, `step` a tick at a time."""
    _, sim, found = sensor
    sim.reset()
    in_blocks = sim.run(seconds=0.3).observations["auv0"]["it"]
    assert_same(found[3], in_blocks)


def test_a_reading_takes_no_more_kernels_and_casts_than_its_class_declares(sensor):
    """Hits that are not evaluated before they are gathered, or results that are not packed, show here first."""
    name, sim, _ = sensor
    if jit.device != "cpu":
        pytest.skip("kernels are counted by their LLVM code")
    cls = registry.find("sensor", name).load()
    kernels, casts = counted(sim)
    assert kernels <= cls.KERNELS, f"{name} takes {kernels} kernels a reading, {cls.KERNELS} are declared"
    assert casts <= cls.CASTS, f"{name} casts rays in {casts} places a reading, {cls.CASTS} are declared"


def test_truth_does_not_depend_on_the_seed(sensor):
    name, _, found = sensor
    if name == "event_camera":  # how far each pixel is towards its next event is drawn: a state, not a noise
        return
    other = readings(pl.Simulation.load(scenario(name), n=3, seed=12))
    for reading, another in zip(found, other, strict=True):
        assert np.array_equal(reading.truth, another.truth, equal_nan=reading.truth.dtype.kind == "f")


def test_it_says_what_it_is(sensor):
    name, _, _ = sensor
    cls = registry.find("sensor", name).load()
    assert cls.TITLE
    assert "\n" not in cls.TITLE
    assert bool(cls.SOURCES) != (name in NOTHING_TO_CITE)
    assert all(isinstance(s, str) and s for s in cls.SOURCES)
    assert len(f"{inspect.getmodule(cls).__doc__}{cls.__doc__}") > 100  # what it is, and what a reading holds
    assert issubclass(cls.Config, SensorConfig)
    for field in cls.Config.model_fields:
        assert descriptions(cls.Config).get(field) or field == "type", f"{name}.{field} has no docstring"


def test_it_has_messages_of_its_own(sensor):
    name, sim, found = sensor
    config = sim.model.agents["auv0"].sensors["it"].config
    encoding = encoder(config, Site("auv0/it", 45.0, 12.0))
    data = encoding.encode(found[-1], 0)
    assert data
    assert any(part is not None for part in data), name


def test_ray_sensors_explain_themselves(sensor):
    name, sim, _ = sensor
    model = sim.model.agents["auv0"].sensors["it"]
    if not model.sees:
        return
    assert "explain" in dict(inspect.getmembers(type(model.sensor))), name

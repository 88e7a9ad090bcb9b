"""Readings are finite, or their class says that they may lack values."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.config import registry
from pelagos.errors import SimulationError
from pelagos.sensors.sensor import Measurement

MAY_LACK = {  # without an echo, a hit or an answer
    "adcp", "depth_camera", "lbl", "lidar", "multibeam", "optical_flow_camera", "profiling_sonar", "range_bearing",
    "range_finder", "semantic_lidar",
}  # fmt: skip
SCENARIO = {
    "world": {"type": "flat", "depth_m": 30},
    "agents": {
        name: {
            "vehicle": "remus100",
            "start": {"position_m": [x, 3.0, -9.0]},
            "sensors": {"imu": {"type": "imu", "rate_hz": 50}, "depth": {"type": "depth", "rate_hz": 10}},
        }
        for name, x in (("auv0", 0.0), ("auv1", 40.0))
    },
}


def test_classes_that_may_lack_values_are_those_that_are_known() -> None:
    names = registry.entries("sensor", plugins=False)
    found = {name for name in names if getattr(registry.find("sensor", name).load(), "MAY_LACK", False)}
    assert found == MAY_LACK


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf])
def test_a_number_that_is_not_finite_stops_the_run(value: float, monkeypatch: pytest.MonkeyPatch) -> None:
    sim = pl.Simulation.load(SCENARIO, n=3)
    sensor = registry.find("sensor", "depth").load()
    honest: Any = sensor.sense

    def spoiled(self: Any, motion: Any) -> Measurement:
        m = honest(self, motion)
        data = np.array(m.data)
        late = (np.array(motion.t_ns) >= 300_000_000) & (np.array(motion.copy) == 2)
        data[late] = value
        return replace(m, data=data, truth=m.truth)

    monkeypatch.setattr(sensor, "sense", spoiled)
    with pytest.raises(SimulationError, match=r"auv0\.depth \(type depth, copy 2\) .* t = 0\.300 s"):
        sim.step(ticks=100)


def test_lanes_without_reading_may_hold_anything(monkeypatch: pytest.MonkeyPatch) -> None:
    sim = pl.Simulation.load(SCENARIO, n=2)
    sensor = registry.find("sensor", "depth").load()
    honest: Any = sensor.sense

    def silent(self: Any, motion: Any) -> Measurement:
        m = honest(self, motion)
        return replace(m, data=np.full_like(m.data, np.nan), truth=m.truth, valid=np.zeros(len(m.data), dtype=bool))

    monkeypatch.setattr(sensor, "sense", silent)
    sim.step(ticks=100)

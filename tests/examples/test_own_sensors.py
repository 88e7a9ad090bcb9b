"""The three doors for a sensor of one's own: their examples run, and keep the rules that built-in sensors keep."""

from __future__ import annotations

import runpy
from pathlib import Path

import numpy as np
import pytest

from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext

EXAMPLES = Path(__file__).parents[2] / "examples"
DOORS = {
    "sensor_numpy.py": ("Plumb", r"^\[1[56]\.\d+.*\] for \[16\. 16\."),
    "sensor_rays.py": ("Alarm", r"m for 12\.4\d\d m, echo after 16\.\d+ ms"),
    "sensor_drjit.py": ("TurnRate", r"^mean 0\.(300|299|301)\d* rad/s, standard deviation 0\.0(099|10[01])"),
}


@pytest.mark.parametrize("name", DOORS)
def test_it_runs_and_reads_what_it_should(name: str, capsys: pytest.CaptureFixture[str]) -> None:
    import re

    runpy.run_path(str(EXAMPLES / name), run_name="__main__")
    said = capsys.readouterr().out
    assert re.search(DOORS[name][1], said), said


@pytest.mark.parametrize("name", DOORS)
def test_it_reads_the_same_in_blocks_and_one_by_one(name: str) -> None:
    made = runpy.run_path(str(EXAMPLES / name))
    cls = made[DOORS[name][0]]
    sensor = cls(cls.Config(), SensorContext.alone("a.b", copies=2, seed=3))
    place = {"position": (3.0, -2.0, -4.0), "angular_velocity": (0.1, -0.2, 0.3), "environments": (0, 1)}
    block = sensor.sense(lanes(range(3), dt_ns=10_000_000, **place))
    single = [sensor.sense(lanes([k], dt_ns=10_000_000, **place)) for k in range(3)]
    assert block.data.tobytes() == np.concatenate([one.data for one in single]).tobytes()
    assert block.truth.tobytes() == np.concatenate([one.truth for one in single]).tobytes()

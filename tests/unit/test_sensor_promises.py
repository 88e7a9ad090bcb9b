"""Truth that is computed when somebody looks at it."""

from __future__ import annotations

import copy
import dataclasses
import pickle
from typing import Any

import numpy as np
import pytest

from pelagos.bench.cases.sonar import context, motion
from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Measurement, Reading
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sim.sampled import Sampled


class Counted:
    """Computes an array, and counts how often."""

    def __init__(self, values: Any) -> None:
        self.values, self.calls = np.asarray(values, dtype=float), 0

    def __call__(self) -> Any:
        self.calls += 1
        return self.values


def measured(counted: Counted) -> Measurement:
    return Measurement(counted.values + 1.0, promised(counted))


def reading(measurement: Measurement, lanes: slice) -> Reading:
    return measurement.reading(lanes, np.ones(1, dtype=bool), 0, "auv0/it")


def test_a_promise_is_kept_once_and_only_when_somebody_looks() -> None:
    counted = Counted([1.0, 2.0])
    found = measured(counted)
    first, second = (reading(found, slice(k, k + 1)) for k in range(2))
    assert counted.calls == 0
    assert second.truth.tolist() == [2.0]
    assert first.truth.tolist() == [1.0]
    assert found.truth is found.truth
    assert counted.calls == 1


def test_blocks_are_joined_without_looking() -> None:
    parts = [Counted([1.0]), Counted([2.0])]
    model: Any = dataclasses.make_dataclass("Model", [("period", int)])(1)
    sampled = [Sampled(("auv0",), model, range(k, k + 1), measured(part)) for k, part in enumerate(parts)]
    joined = Sampled.join(sampled).measurement
    assert [part.calls for part in parts] == [0, 0]
    assert joined.truth.tolist() == [1.0, 2.0]


def test_a_reading_is_pickled_and_copied_with_its_truth() -> None:
    found = reading(measured(Counted([3.0])), slice(0, 1))
    assert pickle.loads(pickle.dumps(found)).truth.tolist() == [3.0]
    assert copy.deepcopy(found).truth.tolist() == [3.0]
    with pytest.raises(dataclasses.FrozenInstanceError):
        found.truth = np.zeros(1)  # type: ignore[misc]


@pytest.mark.parametrize("options", [{}, {"multipath": "surface_and_bottom", "volume_scattering_db": -60.0}])
def test_later_pings_leave_the_truth_of_earlier_ones(options: dict[str, Any]) -> None:
    config = ImagingSonarConfig(
        beams=16, rays_per_beam=64, bins=127, range_max_m=30.0, orientation_deg=(0, 20, 0), **options
    )
    sonar = ImagingSonar(config, context())
    at_once = [sonar.sense(motion(k)).truth.copy() for k in (0, 300)]
    pings = [sonar.sense(motion(k)) for k in (0, 300)]
    for ping, expected in zip(pings, at_once, strict=True):
        assert ping.truth.tobytes() == expected.tobytes()
    assert not np.array_equal(at_once[0], at_once[1])

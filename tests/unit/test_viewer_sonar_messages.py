"""Recorded pings as people see them: the same picture as of the reading itself."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pelagos.config import registry
from pelagos.drawing.sample import sample_of
from pelagos.messages.encoders import encoder
from pelagos.messages.encoding import Site
from pelagos.sensors.sensor import Reading
from pelagos.sim.replay import Recorded
from pelagos.viewer.recorded import WANTED, sample_from


@pytest.mark.parametrize("kind", ["sidescan", "singlebeam", "mechanical_scanning_sonar"])
def test_a_recorded_ping_is_drawn_as_the_reading_is(kind: str) -> None:
    config = registry.find("sensor", kind).config.model_validate({"type": kind, "bins": 16})
    shape = (1, 2, 16) if kind == "sidescan" else (1, 16)
    data = np.linspace(0.05, 0.95, int(np.prod(shape)), dtype=np.float32).reshape(shape)
    extras: dict[str, Any] = {"altitude": np.array([7.5]), "angle": np.array([-0.75])}
    reading = Reading(data, data, 5_000_000, "a/s", np.ones(1, bool), extras)
    encoding = encoder(config, Site("a/s", 0.0, 0.0))
    (topic,) = [t for t in encoding.topics if f"/{t.suffix}".endswith(WANTED[kind])]
    raw = bytes(encoding.encode(reading, 0)[encoding.topics.index(topic)] or b"")
    found = sample_from(config, "s", Recorded(f"/a/s/{topic.suffix}", 5_000_000, topic.type, raw))
    seen = sample_of(config, reading)
    assert found is not None
    if kind == "mechanical_scanning_sonar":
        assert found.sector is not None
        assert seen.sector is not None
        np.testing.assert_array_equal(found.sector[0], seen.sector[0])
        assert found.sector[1] == pytest.approx(seen.sector[1]) == pytest.approx(-0.75)
    else:
        assert found.line is not None
        np.testing.assert_array_equal(found.line, seen.line)


SMALL = {
    "imu": 6, "magnetometer": 3, "gps": 3, "depth": 0, "pose": 7, "velocity": 3, "dvl": 3, "altimeter": 0, "ctd": 3,
    "sound_velocity": 0, "fluorometer": 0, "oxygen": 0, "turbidity": 0, "tracer": 0, "current_meter": 3, "collision": 1,
}  # fmt: skip
"""Numbers of a reading by sensor type; 0: one, without an axis."""


@pytest.mark.parametrize("kind", SMALL)
def test_a_recorded_reading_has_the_numbers_of_the_reading_itself(kind: str) -> None:
    """A recording's panels write what a live view's do, in the same words."""
    needed = {"tracer": {"tracer": "dye"}}.get(kind, {})
    config = registry.find("sensor", kind).config.model_validate({"type": kind, **needed})
    values = np.array([-0.75, 0.5, 1.25, 0.5, -0.5, 0.5, -0.5])  # the last four a unit quaternion
    data = values[None, : SMALL[kind]] if SMALL[kind] else values[:1]
    extras: dict[str, Any] = {
        "salinity": np.array([35.5]), "sound_speed": np.array([1495.0]), "altitude": np.array([7.5]),
        "ranges": np.array([[8.0, 8.5, 9.0, 9.5]]), "beam_valid": np.ones((1, 4), bool), "sigma": np.full((1, 4), 0.01),
        "beam_velocity": np.full((1, 4), -0.25), "force": np.array([[3.0, -4.0, 0.5]]),
        "moment": np.array([[1.0, -2.0, 0.25]]), "snr": np.full((1, 4), 20.0),
    }  # fmt: skip
    if kind == "collision":
        data = np.array([[True]])
    reading = Reading(data, data, 5_000_000, "a/s", np.ones(1, bool), extras)
    encoding = encoder(config, Site("a/s", 0.0, 0.0))
    wanted = WANTED.get(kind, ("",))
    number = next(i for i, t in enumerate(encoding.topics) if f"/{t.suffix}".endswith(wanted))
    topic, raw = encoding.topics[number], bytes(encoding.encode(reading, 0)[number] or b"")
    found = sample_from(config, "s", Recorded(f"/a/s/{topic.suffix}", 5_000_000, topic.type, raw))
    assert found is not None
    seen = sample_of(config, reading).numbers
    assert list(found.numbers) == list(seen)
    if kind == "pose":  # q and -q are one attitude
        turned = [found.numbers[f"q {c}"] for c in "wxyz"], [seen[f"q {c}"] for c in "wxyz"]
        assert abs(np.dot(*turned)) == pytest.approx(1.0)
        found.numbers.update({k: v for k, v in seen.items() if k.startswith("q ")})  # type: ignore[attr-defined]
    assert found.numbers == pytest.approx(seen)

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

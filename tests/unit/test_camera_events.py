"""Counts of an event camera against its rule, one number at a time; and pixels whose thresholds differ."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from test_camera_special import ahead, context, plates

from pelagos import jit
from pelagos.sensors.camera import event_camera
from pelagos.sensors.camera.event_camera import EventCamera, EventCameraConfig, event_count
from pelagos.sensors.camera.picture.pixel_order import Tiling, image_rows, pixels

NAMES = ("data", "truth", "change", "phase")


@pytest.mark.parametrize(("refractory", "most"), [(0.0, 32767), (1e-7, 32767), (0.013, 3), (0.004, 12)])
def test_a_pixel_sends_one_event_a_threshold_unless_it_rests(refractory: float, most: int) -> None:
    """At 20 Hz a rest of 13 ms lets 3 whole events through, and of 4 ms 12."""
    config = EventCameraConfig(rate_hz=20.0, refractory_s=refractory)
    rng = np.random.default_rng(6)
    change, phase = rng.normal(0, 1.5, 400).round(3), rng.uniform(0, 1, 400)
    threshold = rng.uniform(0.05, 0.7, 400)
    change[:2] = 9e6, -9e6
    found = np.array(event_count(jit.Float(change), jit.Float(phase), jit.Float(threshold), config))
    for c, p, t, n in zip(change, phase, threshold, found, strict=True):
        whole = math.floor(abs(c) / t + p)
        if abs(abs(c) / t + p - round(abs(c) / t + p)) > 1e-4:
            assert n == math.copysign(min(whole, most), c), (c, p, t)
    assert np.abs(found).max() == most


def test_pixels_tell_light_now_from_light_before_by_thresholds_of_their_own(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of light that grows by e^0.01 a column over 2 cd/m^2, with the darkest of 3: log ((L + 3) / (2 + 3)). Thresholds
    are 0.2 +- 0.15, none below a tenth of 0.2, the same at another time, when phases are others."""
    width, height = 97, 70
    config = EventCameraConfig(
        background_hz=2.0, threshold_mismatch=0.15, threshold=0.2, rate_hz=10.0, refractory_s=0.0,
        darkest_cd_m2=3.0, width_px=width, height_px=height,
    )  # fmt: skip
    bare = SimpleNamespace(arguments=lambda *_: (), ripple=lambda _: None)  # light comes from below
    monkeypatch.setattr(event_camera, "Surroundings", lambda _: bare)
    camera = EventCamera(config, context(plates()))
    asked: list[float] = []
    monkeypatch.setattr(
        event_camera, "scenery_of", lambda *given: (asked.append(given[-1]), SimpleNamespace(level=None))[1]
    )
    monkeypatch.setattr(event_camera, "light_sources", lambda *_: [])
    monkeypatch.setattr(event_camera, "sight_lines", lambda *_: None)
    monkeypatch.setattr(event_camera, "radiance_along", lambda *_, **__: (asked[-1], None))
    monkeypatch.setattr(
        event_camera, "pixel_light",
        lambda delay, where, *_: jit.Array3f(2 * dr.exp(0.01 * jit.Float(where.column)) if delay == 0 else 2.0),
    )  # fmt: skip

    def sensed(tick: int) -> dict[str, Any]:
        motion = ahead()
        motion.tick = motion.tick + tick
        own: dict[str, Any] = {}
        caster, given = camera._view._context.scene.caster, camera._arguments(motion)
        found = camera._kernel(caster, *given, trace=lambda name, values, _: own.update({name: values}))
        dr.eval(found, own)
        seen = {name: camera._view.images(v, np.float64)[0] for name, v in zip(NAMES, found, strict=True)}
        return seen | {"own": np.array(own["threshold"])}

    one, later = sensed(0), sensed(7)
    assert asked[:2] == [0.0, pytest.approx(-0.1)]
    change = np.log((2 * np.exp(0.01 * np.arange(width)) + 3) / 5)
    np.testing.assert_allclose(one["change"], np.tile(change, (height, 1)), atol=1e-5)
    own = one["own"]
    assert own.min() == pytest.approx(0.02)
    assert (own < 0.0201).mean() == pytest.approx(0.115, abs=0.02)  # of a normal law, below -1.2 deviations
    above = own[own > 0.2]
    assert np.sqrt(np.mean((above - 0.2) ** 2)) == pytest.approx(0.15, rel=0.04)
    assert np.array_equal(later["own"], own)
    where = pixels(Tiling(width, height), 1)
    own = np.array(image_rows(jit.Float(own), Tiling(width, height), where, 1)).reshape(height, width)
    assert len(np.unique(own[own > 0.021])) > 0.95 * (own > 0.021).sum()  # no two pixels share one
    for seen in (one, later):
        assert np.array_equal(seen["truth"], np.floor(change / 0.2 + seen["phase"]))
        extra = seen["data"] - np.floor(seen["change"] / own + seen["phase"])
        assert set(np.unique(extra)) <= {0.0, 1.0}
        assert extra.mean() == pytest.approx(0.2, abs=4 * 0.4 / np.sqrt(extra.size))
        assert seen["phase"].mean() == pytest.approx(0.5, abs=4 * 0.29 / np.sqrt(extra.size))
    assert np.abs(one["phase"] - later["phase"]).min() > 0

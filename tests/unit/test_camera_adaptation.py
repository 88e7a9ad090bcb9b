"""An automatic exposure that takes its time, against the rule that it states."""

from __future__ import annotations

from dataclasses import replace

import drjit as dr
import numpy as np
import pytest
from test_camera_picture import camera, context, looking_down

from pelagos import jit
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.exposure_lag import _LONGEST, _MOMENTS


def diving(height: float, speed: float):
    """Nose down, going forward, that is down."""
    motion = looking_down(height=height)
    return replace(motion, velocity=jit.Array3f64(*(dr.opaque(jit.Float64, v) for v in (speed, 0.0, 0.0))))


def stops(config: dict, height: float, speed: float, ground: float = -60.0) -> float:
    """What the exposure lets in [stops]."""
    found = camera(context(z=ground), shutter_s=10.0, ripple=0.0, **config).sense(diving(height, speed))
    return float(np.log2(found.extras["exposure_s"][0] * found.extras["iso"][0]))


@pytest.mark.parametrize(("speed", "up", "down"), [(2.0, 0.4, 0.05), (-2.0, 0.02, 0.3), (2.0, 60.0, 50.0)])
def test_the_meter_follows_at_its_rate(speed: float, up: float, down: float) -> None:
    """Darker or brighter by more a second than the meter follows, it lags by the difference; else by nothing."""
    rate = min(up, down)
    step = min(8.0 / rate, _LONGEST) / _MOMENTS
    moments = np.arange(_MOMENTS, -1, -1) * step
    wanted = [stops({}, -30.0 + speed * t, 0.0) for t in moments]  # stops let in: the darker, the more
    follows = wanted[0]
    for now in wanted[1:]:
        follows += float(np.clip(now - follows, -up * step, down * step))  # more is let in of a darker scene
    keys = {"exposure_speed_up_ev_per_s": up, "exposure_speed_down_ev_per_s": down}
    found = stops(keys, -30.0, speed)
    # one ray a tile, with open water around, stands for the frame: 14 m over pale ground that is off by 0.17 stops
    assert found == pytest.approx(follows, abs=0.19)
    if rate < 1:
        assert abs(found - wanted[-1]) > 0.3
    else:
        assert found == pytest.approx(wanted[-1], abs=1e-3)


@pytest.mark.parametrize(
    ("height", "speed", "up", "down"), [(-12.0, -12.0, 1.25, 2.0), (-85.0, 12.0, 2.0, 1.25), (-12.0, -12.0, 1.25, None)]
)
def test_a_scene_that_always_changes_faster_is_followed_at_the_rate(height, speed, up, down) -> None:
    """Over open water, 12 m/s up or down change it by 1.7 stops a second, the meter by 1.25: in 6.4 s by 8 stops."""
    seconds, keys = 8.0 / 1.25, {"exposure_speed_up_ev_per_s": up, "exposure_speed_down_ev_per_s": down}
    before, now = (stops({}, height + speed * t, 0.0, ground=-200.0) for t in (seconds, 0.0))
    assert abs(now - before) > 10.0
    followed = 8.0 if speed > 0 else -8.0
    assert stops(keys, height, speed, ground=-200.0) == pytest.approx(before + followed, abs=0.02)


def test_one_way_only() -> None:
    slow_to_darken = {"exposure_speed_down_ev_per_s": 0.05}
    assert stops(slow_to_darken, -30.0, -2.0) == pytest.approx(stops({}, -30.0, 0.0), abs=1e-3)  # it grows brighter
    assert stops(slow_to_darken, -30.0, 2.0) < stops({}, -30.0, 0.0) - 0.3


def test_only_an_automatic_exposure_adapts() -> None:
    assert not CameraConfig(exposure="manual", exposure_speed_up_ev_per_s=1.0).adapts

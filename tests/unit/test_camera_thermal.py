"""What a thermal camera takes the temperatures along its rays for, and the sun on what it sees."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_camera_special import ahead, context, half

from pelagos import jit
from pelagos.sensors.camera.picture.sea_crossing import Crossing
from pelagos.sensors.camera.thermal_camera import ThermalCamera, ThermalCameraConfig, apparent, sky_power


def fourth(celsius: Any) -> Any:
    return ((np.asarray(celsius) + 273.15) / 100) ** 4


def test_the_sky_is_warmer_towards_the_horizon() -> None:
    """A mixture of powers, with e^-(rise / 0.35) of the air's."""
    config = ThermalCameraConfig(air_c=11.0, sky_c=-40.0)
    rise = np.array([0.0, 0.2, 0.7, 1.0])
    warm = np.exp(-rise / 0.35)
    expected = (1 - warm) * fourth(-40.0) + warm * fourth(11.0)
    assert np.array(sky_power(jit.Float(rise), config)) == pytest.approx(expected, rel=1e-5)


def test_the_nearest_of_sea_and_solids_shows_through_the_air() -> None:
    """Sea, solids and sky, up and down, near and at the end of the reach, from both sides of the surface."""
    config = ThermalCameraConfig(air_c=18.0, sky_c=-30.0, attenuation_per_km=4.0, max_range_m=300.0)
    rise = np.array([-0.3, -0.3, 0.4, 0.4, -0.2, -0.05, 0.5, -0.6])
    hit = np.array([50.0, 10.0, 120.0, np.inf, np.inf, np.inf, 3.0, np.inf])
    sea_way = np.array([30.0, 30.0, np.inf, np.inf, 250.0, 310.0, 7.0, 20.0])
    under = np.array([False] * 6 + [True] * 2)
    solid = np.array([40.0, 35.0, -5.0, 0.0, 0.0, 0.0, 60.0, 0.0])
    sea = np.array([6.0, 7.0, 8.0, 9.0, 10.0, 11.0, 12.0, 13.0])
    rays: Any = SimpleNamespace(direction=jit.Array3f(0.0, 0.0, jit.Float(rise)), max_range=jit.Float(300.0))
    hits: Any = SimpleNamespace(valid=jit.Bool(np.isfinite(hit)), t=jit.Float(hit))
    crossing = Crossing(jit.Bool(under), jit.Float(sea_way))
    found = np.array(apparent(rays, hits, jit.Float(solid), jit.Float(sea), crossing, config))

    def mirrored(cosine: float) -> float:
        within = math.asin(math.sqrt(1 - cosine**2) / 1.22)
        outside = math.acos(cosine)
        s = math.sin(outside - within) / math.sin(outside + within)
        p = math.tan(outside - within) / math.tan(outside + within)
        return 0.5 * (s * s + p * p)

    def sky(r: float) -> float:
        warm = math.exp(-r / 0.35)
        return float((1 - warm) * fourth(-30.0) + warm * fourth(18.0))

    for k in range(8):
        if under[k]:
            assert found[k] == pytest.approx(sea[k] + 273.15)
            continue
        if sea_way[k] < min(hit[k], 300.0):
            share, way = mirrored(-rise[k]), sea_way[k]
            power = (1 - share) * fourth(sea[k]) + share * sky(-rise[k])
        elif np.isfinite(hit[k]):
            power, way = 0.95 * fourth(solid[k]) + 0.05 * sky(0.5), hit[k]
        else:
            power, way = sky(abs(rise[k])), 0.0
        left = math.exp(-4.0 * way / 1000)
        expected = 100 * (left * power + (1 - left) * fourth(18.0)) ** 0.25
        assert found[k] == pytest.approx(expected, abs=0.02), k


def test_what_stands_in_the_shade_has_the_airs_temperature() -> None:
    """The sun is 34 degrees high behind the camera: a plate 3 m before a wall keeps it off the wall's middle."""
    keys: dict[str, Any] = {"noise_k": 0.0, "attenuation_per_km": 0.0, "width_px": 64, "height_px": 64}
    wall = half(1, -8.0, 8.0, 0.5, 9.0, 6.0)
    roof = half(0, -8.0, 8.0, 3.6, 9.0, 3.0)
    seen = [
        ThermalCamera(ThermalCameraConfig(**keys), context(things, sun=0.6)).sense(ahead(height=2.0)).truth[0]
        for things in ([wall], [wall, roof])
    ]
    free, shaded = (picture[30, 32] for picture in seen)  # 2.2 m high: its light comes over x = 3 at 4.2 m
    facing = math.cos(0.6)
    assert free > shaded + 15 * facing
    assert shaded == pytest.approx(15.0, abs=2.0)
    assert seen[1][38, 32] == pytest.approx(seen[0][38, 32], abs=0.01)  # 0.8 m high: the light passes below the plate

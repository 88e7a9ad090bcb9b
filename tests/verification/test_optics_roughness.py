"""Roughness of the sea by the wind: Cox and Munk's slopes, shared among waves that are drawn and that are not."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.surface_wind import surface_wind, wave_slope
from pelagos.optics.caustics import Ripple, unseen_slope, waves_at
from pelagos.optics.interface import fresnel
from pelagos.optics.roughness import glitter, tilt_towards_eye
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.raycast.rays import NO_BODY
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.surroundings import Surroundings
from pelagos.sensors.sensor import SensorContext
from pelagos.world.build import build_world
from pelagos.world.generate.flat import FlatConfig


def ripple_of(**ocean: Any) -> Ripple:
    """Short waves that a camera has by default."""
    world = build_world(FlatConfig(type="flat"))
    made = build_ocean(OceanConfig.model_validate(ocean), seed=3)
    context = SensorContext("a.camera", 1, 5_000_000, world.scene(1), world, made, np.full(1, NO_BODY, np.uint32))
    return Surroundings(context).ripple(CameraConfig())


@pytest.mark.parametrize(("wind", "waves"), [(1.0, None), (5.0, (0.35, 2.6)), (12.0, (1.6, 5.5))])
def test_all_slopes_together_are_cox_and_munks(wind: float, waves: tuple[float, float] | None):
    """0.003 + 0.00512 U, and 0.008 + 0.00156 U of what a slick of oil leaves, by hand from their paper: the ocean's own
    waves, ripples of 0.3 to 4 m, and finer waves.
    """
    every = 0.003 + 0.00512 * wind
    under_oil = min(0.008 + 0.00156 * wind, every)
    ocean: dict[str, Any] = {"wind": {"speed_mps": wind}}
    if waves is not None:
        ocean["waves"] = {"type": "jonswap", "significant_height_m": waves[0], "peak_period_s": waves[1]}
    sea = ripple_of(**ocean)
    assert sea.mean_square_slope + sea.longer + sea.finer == pytest.approx(every, rel=1e-6)
    assert sea.mean_square_slope + sea.longer == pytest.approx(under_oil, rel=1e-6)
    drawn = waves_at(sea, jit.Float64([0.0]), jit.Array3f(0, 0.6, 0.8), 1)
    near, far = (float(np.array(unseen_slope(drawn, jit.Float(d)))[0]) for d in (0.0, 1e5))
    assert near == pytest.approx(sea.finer, abs=1e-6)
    assert far == pytest.approx(every, rel=1e-4)
    x, y = (np.array(s) for s in (drawn.slope_x, drawn.slope_y))
    assert (x**2 + y**2).mean() == pytest.approx(sea.mean_square_slope, rel=0.02)  # waves that share a number add up


def test_without_wind_it_is_that_of_the_waves():
    """A wind sea of 1.6 m has some wind; swell has none, and a calm is left with Cox and Munk's 0.003."""
    sea = {"type": "jonswap", "significant_height_m": 1.6, "peak_period_s": 5.5}
    wind, _ = surface_wind(build_ocean(OceanConfig.model_validate({"waves": sea})))
    assert 5 < wind < 12
    calm = ripple_of()
    assert calm.mean_square_slope == pytest.approx(0.003)
    assert calm.finer == 0
    swell = build_ocean(OceanConfig.model_validate({"waves": {"type": "regular", "height_m": 1, "period_s": 12}}))
    assert surface_wind(swell)[0] == 0
    k = (2 * math.pi / 12) ** 2 / 9.81
    assert wave_slope(swell, 3.0) == pytest.approx(0.5 * (0.5 * k) ** 2, rel=0.01)
    assert wave_slope(swell, 300.0) == 0


def test_the_wind_gives_the_ripples_their_direction():
    """From 220 degrees, towards north-east: 40 degrees, -40 from north to west; 28 waves within 80 degrees of it."""
    sea = ripple_of(wind={"speed_mps": 6, "from_deg": 220})
    angle = np.angle(np.sum(np.exp(1j * np.arctan2(sea.j, sea.i))))
    assert math.degrees(angle) == pytest.approx(-40, abs=10)


@pytest.mark.parametrize("rise_deg", [1.0, 5.0, 20.0, 60.0])
@pytest.mark.parametrize("variance", [0.004, 0.05])
def test_the_slope_that_is_seen_leans_to_the_eye(variance: float, rise_deg: float):
    """Mean of s max(tan e + s, 0) over that of max(tan e + s, 0), s normal, by quadrature."""
    rise, deviation = math.tan(math.radians(rise_deg)), math.sqrt(variance / 2)
    s = np.linspace(-8, 8, 40_001) * deviation
    weight = np.exp(-0.5 * (s / deviation) ** 2) * np.maximum(rise + s, 0)
    expected = np.sum(s * weight) / np.sum(weight)
    found = float(np.array(tilt_towards_eye(jit.Float(variance), jit.Float(rise)))[0])
    assert found == pytest.approx(expected, rel=1e-3, abs=1e-6)


@pytest.mark.parametrize("elevation_deg", [30.0, 50.0, 80.0])
def test_glitter_holds_what_a_smooth_sea_mirrors(elevation_deg: float):
    """Integral of L |cos| over all directions to the eye = F cos(sun) E, within 3 %: slopes of 0.004 change the mean of
    F, and of the area that is shown, by the second order, most for a low sun."""
    high = math.radians(elevation_deg)
    towards = jit.Array3f(math.cos(high), 0, math.sin(high))
    up, side = np.meshgrid((np.arange(600) + 0.5) / 600, (np.arange(1200) + 0.5) * (2 * math.pi / 1200))
    level = np.sqrt(1 - up**2)
    eye = (level * np.cos(side), level * np.sin(side), up)  # from the surface
    direction = jit.Array3f(*(jit.Float(-v.ravel()) for v in eye))
    seen = np.array(glitter(jit.Float(0.004), jit.Array2f(0), direction, towards))
    whole = np.sum(seen * up.ravel()) * (1 / 600) * (2 * math.pi / 1200)
    mirror = float(np.array(fresnel(jit.Float(math.sin(high)), jit.Float(REFRACTIVE_INDEX)))[0])
    assert whole == pytest.approx(mirror * math.sin(high), rel=0.03)


def test_glitter_is_where_the_sea_slopes_to_mirror_the_sun():
    """Brightest near the mirror's direction, dark away from the sun and by night."""
    sun, d = jit.Array3f(0.6, 0, 0.8), jit.Array3f(jit.Float([0.6, 0.8, 0.0]), 0, jit.Float([-0.8, -0.6, -1.0]))
    eye = jit.Array3f(-d.x, d.y, d.z)  # looks towards -x, away from the sun, and towards it
    away, towards = (np.array(glitter(jit.Float(0.01), jit.Array2f(0), v, sun)) for v in (eye, d))
    assert towards[0] > 3 * towards[1] > 0
    assert towards[0] > 100 * away[0]
    night = np.array(glitter(jit.Float(0.01), jit.Array2f(0), d, jit.Array3f(0.9, 0, -0.1)))
    assert (night == 0).all()
    assert dr.all(jit.Float(towards) < 100)

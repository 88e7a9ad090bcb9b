"""What a camera sees light in, ray by ray."""

from __future__ import annotations

import math
from dataclasses import fields
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.atmosphere import Air
from pelagos.optics.light_field import Fall, LightField, Local
from pelagos.optics.water import WaterArrays
from pelagos.sensors.camera.picture.scenery import (
    Scenery,
    behind_air,
    by_ray,
    depth_at,
    depth_of_starts,
    sea_from_above,
)

LANE = np.array([2, 0, 1, 2, 2])


def spectrum(k):
    """Three colours of three images."""
    return jit.Array3f(*(k * np.array([[0.11], [0.23], [0.37]]) + [0.0, 0.01, 0.03]))


def test_each_ray_has_the_water_of_its_own_image():
    """Every rate of three images' waters, none like another: a ray of lane k reads entry k of each."""
    numbers = iter(range(1, 40))
    fall = lambda: Fall(spectrum(next(numbers)), spectrum(next(numbers)))
    same = {k: jit.Float([1.0]) for k in ("towards_sun", "below", "beam", "irradiance", "radiance", "calm", "source")}
    own = {k: spectrum(next(numbers)) for k in ("loss", "fading", "decay")}
    local = Local(fall(), fall(), fall(), *(spectrum(next(numbers)) for _ in range(3)))
    field = LightField(**same, **own, blur=jit.Float([0.1, 0.4, 0.2]), local=local)
    water = WaterArrays(*(spectrum(next(numbers)) for _ in fields(WaterArrays)))
    scenery = Scenery(
        tables=None, looks=None, water=water, light=None, field=field, air=None, waves=None, level=None,
        tide=jit.Float([0.3, -0.7, 0.9]), depth=None, t=None,
    )  # fmt: skip
    seen = by_ray(scenery, jit.UInt32(LANE))

    def check(found, given):
        np.testing.assert_array_equal(np.array(found), np.array(given)[..., LANE])

    check(seen.tide, scenery.tide)
    for name in ("loss", "fading", "decay", "blur"):
        check(getattr(seen.field, name), getattr(field, name))
    for name in ("decay", "loss", "fading"):
        for part in ("excess", "clear"):
            check(getattr(getattr(seen.field.local, name), part), getattr(getattr(local, name), part))
    for name in ("irradiance", "source", "radiance"):
        check(getattr(seen.field.local, name), getattr(local, name))
    for f in fields(WaterArrays):
        check(getattr(seen.water, f.name), getattr(water, f.name))
    assert all(getattr(seen.field, k) is same[k] for k in same)


def test_air_fades_what_is_behind_it_to_its_own_light():
    """Fog and rain together, along the way; of the sea 6 % of what a white plane would send."""
    light: Any = SimpleNamespace(
        sun=jit.Array3f(5e4, 6e4, 7e4), sky=jit.Array3f(1e4, 2e4, 3e4), towards_sun=jit.Array3f(0.6, 0.0, 0.8)
    )
    air = Air(jit.Float(0.01), jit.Float(0.003), None)
    scenery: Any = SimpleNamespace(air=air, light=light)
    white = (0.8 * np.array([5e4, 6e4, 7e4]) + [1e4, 2e4, 3e4]) / math.pi
    seen = behind_air(scenery, jit.Array3f(100.0, 9e4, 2e4), jit.Float(70.0))
    left = math.exp(-0.013 * 70.0)
    assert np.array(seen).ravel() == pytest.approx(white + left * (np.array([100.0, 9e4, 2e4]) - white), rel=1e-5)
    assert np.array(sea_from_above(scenery)).ravel() == pytest.approx(0.06 * white, rel=1e-5)
    clear: Any = SimpleNamespace(air=None, light=light)
    assert np.array(behind_air(clear, jit.Array3f(1.0, 2.0, 3.0), jit.Float(70.0))).ravel().tolist() == [1, 2, 3]


def test_depths_count_from_the_sea_over_each_camera():
    """A ray's start from the surface over its own camera, a place from the mean level that the tide makes."""
    scenery: Any = SimpleNamespace(
        waves=SimpleNamespace(swell=None), level=jit.Float([0.5, -0.25, 1.5]), tide=jit.Float([0.3, 0.1, 0.2])
    )
    rays: Any = SimpleNamespace(origin=jit.Array3f64(0.0, 0.0, jit.Float64([-4.0, 1.0, -2.0, 3.0])))
    found = depth_of_starts(scenery, rays, jit.UInt32([2, 0, 1, 2]))
    assert np.array(found).tolist() == [5.5, -0.5, 1.75, -1.5]
    place = jit.Array3f64(9.0, 8.0, jit.Float64([-1.0, 2.0, 0.0]))
    assert np.array(depth_at(scenery, place)) == pytest.approx([1.3, -1.9, 0.2])
    scenery.tide = None
    assert np.array(depth_at(scenery, place)).tolist() == [1.0, -2.0, 0.0]

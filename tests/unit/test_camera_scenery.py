"""What a camera sees light in, ray by ray."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from pelagos import jit
from pelagos.optics.light_field import Fall, LightField, Local
from pelagos.optics.water import WaterArrays
from pelagos.sensors.camera.picture.scenery import Scenery, by_ray

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

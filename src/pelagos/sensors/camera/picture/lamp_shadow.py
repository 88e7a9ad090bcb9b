"""Shadows in a lamp's cone: how much of its light comes to the water along a line of sight, past what stands around.

Asked along one line in every square of four by four pixels, once in each of four parts of equal angle seen from the
lamp, and smoothed over three by three squares, which ask at nine places of the parts.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.lamp import SHADE_PARTS, Beam, seen_from
from pelagos.optics.light_source import LightSource
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Rays
from pelagos.sensors.camera.picture.camera_rays import Frame
from pelagos.sensors.camera.picture.lamp_light import lamp_reaches
from pelagos.sensors.camera.picture.light_shafts import mean_3x3, shafts_at
from pelagos.sensors.camera.picture.pixel_blocks import square_pixels, stratum
from pelagos.sensors.camera.picture.pixel_order import Pixels
from pelagos.sensors.camera.picture.scenery import Scenery, depth_at
from pelagos.sensors.camera.picture.surroundings import light_sources

if TYPE_CHECKING:
    from pelagos.sensors.camera.picture.surroundings import LitViewConfig


def with_shadows(
    lamps: list[LightSource], caster: Caster, scenery: Scenery, frame: Frame[LitViewConfig], where: Pixels
) -> list[LightSource]:
    """The same lamps, by the rays of `where`, with shadows in their cones; lasers as they are."""
    if not any(isinstance(lamp, Beam) for lamp in lamps):
        return lamps
    tiling = frame.tiling
    along, x, y = square_pixels(tiling, frame.images, lanes=SHADE_PARTS)
    rays = frame.rays(along, scenery.level)
    reach = dr.minimum(caster.cast(rays).t, rays.max_range)
    part = dr.arange(jit.UInt32, dr.width(reach)) % SHADE_PARTS
    share = (jit.Float(part) + stratum(x, y)) / SHADE_PARTS
    found = [
        _free(caster, scenery, rays, reach, share, lamp) if isinstance(lamp, Beam) else None
        for lamp in light_sources(frame.config, frame.motion, along.image)
    ]
    dr.eval(found)
    made: list[LightSource] = []
    for lamp, free in zip(lamps, found, strict=True):
        if isinstance(lamp, Beam):
            lamp = replace(lamp, shade=shafts_at(mean_3x3(free, tiling), tiling, where))
        made.append(lamp)
    return made


def _free(caster: Caster, scenery: Scenery, rays: Rays, reach: Array, share: Array, lamp: Beam) -> Array:
    """`Float`: 1 where the lamp's light comes to the place at that share of the angle, 0 where something stands before
    it."""
    _, place, distance = seen_from(lamp, rays.direction, reach, share)
    start = rays.origin + jit.Array3f64(place)
    towards = (lamp.position - place) / dr.maximum(distance, 1e-6)
    lit = (-dr.dot(lamp.axis, towards) > lamp.outer) & (depth_at(scenery, start) > 0)
    return dr.select(lit & ~lamp_reaches(caster, scenery, rays, start, towards, distance, lit), jit.Float(0), 1)

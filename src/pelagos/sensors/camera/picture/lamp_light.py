"""Light of the vehicle's lamps and lasers on surfaces, with shadows, and in the water before them."""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.laser_beam import LaserBeam
from pelagos.optics.light_source import LightSource, glow, light_at, loss_of
from pelagos.optics.sight_line import SightLines
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.camera.picture.scenery import Scenery, depth_at

_START: Final = 2e-3  # [m] off surfaces
_SHORT: Final = 0.05  # [m] that shadow rays end before a lamp: its own housing casts none


def lamps_on_surface(
    caster: Caster, scenery: Scenery, rays: Rays, hits: Hits, normal: Array, lamps: list[LightSource],
    footprint: Array,
) -> Array:  # fmt: skip
    """Irradiance of lamps and lasers on the surfaces hit, `Array3f` [lx].

    Args:
        caster, scenery, rays: see `radiance.radiance_along`.
        hits: of surfaces.
        normal: of them, with their texture, `Array3f`.
        lamps: by ray.
        footprint: width of a pixel there [m].
    """
    total = jit.Array3f(0)
    seen = jit.Array3f(hits.position - rays.origin)
    wet = depth_at(scenery, hits.position) > 0
    for lamp in lamps:
        loss = dr.select(wet, loss_of(lamp, scenery.water), 0)
        across, towards, distance = light_at(lamp, loss, seen, footprint)
        facing = dr.maximum(dr.dot(normal, towards), 0)
        lit = (facing > 0) & (dr.dot(hits.normal, towards) > 0) & (dr.max(across) > 0)
        start = hits.position + jit.Array3f64(hits.normal) * _START
        free = lamp_reaches(caster, scenery, rays, start, towards, distance, lit)
        total += dr.select(free, across * facing, 0)
    return total


def lamps_in_water(
    caster: Caster, scenery: Scenery, rays: Rays, reach: Array, lamps: list[LightSource], pixel_angle: float,
    lines: SightLines | None = None,
) -> Array:  # fmt: skip
    """Radiance that the water sends back from the beams, `Array3f` [cd/m^2]; `reach` of the rays in water [m].

    `lines` of sight where the water differs along them. A laser's beam ends where it meets something; shadows in a
    lamp's cone are `lamp_shade`'s.
    """
    total = jit.Array3f(0)
    for lamp in lamps:
        seen, place = glow(lamp, scenery.water, rays.direction, reach, pixel_angle, lines)
        if place is not None and isinstance(lamp, LaserBeam):
            back = lamp.position - place
            distance = dr.norm(back)
            start = rays.origin + jit.Array3f64(place)
            lit = dr.max(seen) > 0
            free = lamp_reaches(caster, scenery, rays, start, back / dr.maximum(distance, 1e-6), distance, lit)
            seen = dr.select(free, seen, 0)
        total += dr.select(reach > 0, seen, 0)
    return total


def lamp_reaches(
    caster: Caster, scenery: Scenery, rays: Rays, start: Array, towards: Array, distance: Array, asked: Array
) -> Array:
    """`Bool`: nothing but the vehicle that carries it stands between a place and a lamp, where `asked`."""
    reach = dr.select(asked, dr.maximum(distance - _SHORT, 0), 0)
    shadow = Rays(start, towards, reach, rays.copy, rays.own, rays.drift)
    return asked & ~caster.occluded(shadow, past_own=True)

"""Crossing of the sea's surface by rays of label cameras and laser scanners: that of the ocean's waves and tide."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.swell import elevation_at, swell_around
from pelagos.optics.wave_surface import way_to_surface
from pelagos.raycast.rays import Rays

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean


@jit.struct
class Crossing:
    """By ray, a Dr.Jit struct.

    Attributes:
        under: `Bool`, the ray starts in the water.
        way: `Float`, to the surface [m]; very long where the ray does not come through it.
    """

    under: Array
    way: Array


def uneven_sea(ocean: Ocean) -> Any:
    """The ocean, to be handed to `sea_crossing`, where its surface is not always z = 0; else None."""
    return None if ocean.waves is None and ocean.tide is None else ocean


def level_over(ocean: Ocean, position: Array, t_ns: Array, copy: Array) -> Array:
    """Height of the sea over sensors, `Float` by lane [m]; arguments as of `sea_crossing`."""
    level = jit.Float(ocean.elevation(position.x, position.y, jit.Float64(t_ns) * 1e-9, copy))
    level = level + dr.zeros(jit.Float, dr.width(t_ns))
    dr.eval(level)
    return level


def sea_crossing(rays: Rays, lane: Array, ocean: Ocean, position: Array, t_ns: Array, copy: Array) -> Crossing:
    """Crossing of rays with the sea.

    Args:
        rays: in the world.
        lane: `UInt32`, image or sample of each ray.
        ocean: see `uneven_sea`.
        position: `Array3f64` of the sensors by lane, world [m].
        t_ns: `UInt64` by lane [ns].
        copy: `UInt32`, of the fleet, that each sensor is in.
    """
    height, rise = jit.Float(rays.origin.z), rays.direction.z
    if ocean is not None:
        t = jit.Float64(t_ns) * 1e-9
        if ocean.waves is not None:
            swell = swell_around(ocean.elevation, position, t, dr.width(t_ns), copy=copy)
            x = jit.Float(rays.origin.x - dr.gather(jit.Float64, swell.corner_x, lane))
            y = jit.Float(rays.origin.y - dr.gather(jit.Float64, swell.corner_y, lane))
            under = height < elevation_at(swell, x, y, lane)
            return Crossing(under, way_to_surface(swell, rays.origin, rays.direction, lane))
        height -= dr.gather(jit.Float, level_over(ocean, position, t_ns, copy), lane)
    under = height < 0
    t_sea = -height / dr.select(dr.abs(rise) < 1e-6, 1e-6, rise)
    return Crossing(under, dr.select((under == (rise > 0)) & (t_sea >= 0), t_sea, dr.inf))

"""The realtime view: what light comes along each camera ray, from the nearest surface and from the water before it.

One pass of rays finds surfaces, one pass of shadow rays finds the sun. Everything else is closed form: pure functions
of `pelagos.optics` on the hits. Distances and directions are in world axes relative to the camera, single precision.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.caustics import Waves, focusing, slope
from pelagos.optics.interface import fresnel, reflect, refract, surface_normal
from pelagos.optics.lamp import Beam, lamp_backscatter, lamp_beam_at, lamp_illuminance
from pelagos.optics.snow import ALBEDO, flakes
from pelagos.optics.sunlight import LightArrays, light_at_depth, scattered_daylight, sky_radiance
from pelagos.optics.texture import Looks, surface_look
from pelagos.optics.transport import near_transmission, sharp_transmission, total_transmission, veil_length
from pelagos.optics.water import REFRACTIVE_INDEX, WaterArrays
from pelagos.raycast.caster import cast, occluded
from pelagos.raycast.rays import Hits, Rays
from pelagos.raycast.scene import Tables

_SHADOW_START = 2e-3  # [m] off the surface
_SHADOW_REACH = 200.0  # [m]
_FAR = 1e4  # [m]


@dataclass
class Scenery:
    """All that light depends on besides the rays, a Dr.Jit struct handed to frozen functions.

    Attributes:
        tables: of the ray-tracing scene.
        looks: by material row.
        water: its optics.
        light: sun and sky.
        waves: of the moments of the lanes.
    """

    tables: Tables
    looks: Looks
    water: WaterArrays
    light: LightArrays
    waves: Waves


@dataclass
class Radiance:
    """Light along the rays, a Dr.Jit struct of `Array3f` [cd/m^2].

    Attributes:
        sharp: from the surface, straight to the pixel.
        near: from the surface, scattered by a few degrees on the way: belongs to the pixel's neighbourhood.
        far: from the surface, scattered forward by more.
        veil: from the water itself.
    """

    sharp: Array
    near: Array
    far: Array
    veil: Array


def look(
    static: Any,
    moving: Any,
    scenery: Scenery,
    rays: Rays,
    lane: Array,
    lamps: list[Beam],
    pixel_angle: float,
    openness: Array | None = None,
    snow: float = 0.0,
) -> tuple[Radiance, Hits]:
    """Radiance along rays through water or air.

    Args:
        static, moving: the two scenes, see `cast`.
        scenery: see `Scenery`.
        rays: from the camera.
        lane: `UInt32`, row of `scenery.waves` of each ray.
        lamps: by ray, positions relative to the camera.
        pixel_angle: angle between neighbouring pixels [rad].
        openness: by ray, see `ambient.openness`; None for open water.
        snow: flakes of marine snow in a cubic metre.
    """
    opened = jit.Array3f(1) if openness is None else openness
    d = rays.direction
    height = jit.Float(rays.origin.z)
    under = height < 0
    hits = cast(static, moving, scenery.tables, rays, smooth=True)
    to_surface = dr.select(under == (d.z > 0), -height / dr.select(dr.abs(d.z) < 1e-6, 1e-6, d.z), _FAR)
    solid = hits.valid & (hits.t < to_surface)
    reach = dr.select(solid, hits.t, dr.minimum(to_surface, rays.max_range))
    from_surface = _surface_light(static, moving, scenery, rays, hits, solid, lane, lamps, pixel_angle, opened.x)
    beyond = dr.select(under, *_through_surface(scenery, rays, reach, lane))
    sky_seen = dr.select(under, d.z > 0, True) & ~solid & ((reach < rays.max_range) | ~under)
    radiance = dr.select(solid, from_surface, dr.select(sky_seen, beyond, 0))
    wet = dr.select(under, reach, 0)
    sharp, near, total = (f(scenery.water, wet) for f in (sharp_transmission, near_transmission, total_transmission))
    veil = dr.select(under, _veil(scenery, -height, d, wet, opened.y, opened.z), 0)
    for lamp in lamps:
        veil += dr.select(under, lamp_backscatter(lamp, scenery.water, d, wet), 0)
    if snow > 0:
        cover, distance = flakes(jit.Array3f(rays.origin), d, wet, snow, pixel_angle)
        flake = _flake_light(scenery, lamps, -height, d * distance) * sharp_transmission(scenery.water, distance)
        return Radiance(
            dr.lerp(radiance * sharp, flake, cover),
            radiance * (near - sharp) * (1 - cover),
            radiance * dr.maximum(total - near, 0) * (1 - cover),
            dr.lerp(veil, veil * dr.minimum(distance / dr.maximum(wet, 1e-3), 1), cover),
        ), hits
    return Radiance(radiance * sharp, radiance * (near - sharp), radiance * dr.maximum(total - near, 0), veil), hits


def _surface_light(
    static: Any, moving: Any, scenery: Scenery, rays: Rays, hits: Hits, solid: Array, lane: Array,
    lamps: list[Beam], pixel_angle: float, opened: Array,
) -> Array:  # fmt: skip
    """Radiance of the hit surfaces themselves: matt, lit by beam, diffuse light from above and below, and lamps."""
    depth = -jit.Float(hits.position.z)
    facing = dr.maximum(-dr.dot(hits.shading_normal, rays.direction), 0.15)
    footprint = hits.t * pixel_angle / facing
    x, y = jit.Float(hits.position.x), jit.Float(hits.position.y)
    albedo, normal = surface_look(
        scenery.looks, hits.material, jit.Array3f(x, y, -depth), hits.shading_normal, footprint, solid
    )
    here = light_at_depth(scenery.light, scenery.water, depth)
    towards = here.towards_sun
    facing_sun = dr.maximum(dr.dot(normal, towards), 0)
    lit = solid & (facing_sun > 0) & (dr.dot(hits.normal, towards) > 0)
    start = hits.position + jit.Array3f64(hits.normal) * _SHADOW_START
    shadow = Rays(start, towards, dr.select(lit, _SHADOW_REACH, 0), rays.copy, rays.own)
    dark = occluded(static, moving, scenery.tables, shadow)
    pattern = focusing(scenery.waves, x, y, dr.maximum(depth, 0), towards, lane)
    pattern = dr.lerp(1, pattern, here.sharpness)
    beam = here.beam * dr.select(lit & ~dark, facing_sun * pattern, 0)
    above = 0.5 + 0.5 * normal.z
    total = beam + here.diffuse * above * opened + here.upwelling * (1 - above)
    seen = rays.direction * hits.t
    for lamp in lamps:
        total += lamp_illuminance(lamp, scenery.water, seen, normal)
    return albedo * total / math.pi


def _flake_light(scenery: Scenery, lamps: list[Beam], depth: Array, seen: Array) -> Array:
    """Radiance of a pale flake at `seen`, relative to the camera: daylight from above and around, and the lamps."""
    here = light_at_depth(scenery.light, scenery.water, depth)
    total = 0.5 * (here.beam + here.diffuse + here.upwelling)
    for lamp in lamps:
        total += lamp_beam_at(lamp, scenery.water.absorption + scenery.water.backscatter, seen)[0]
    return total * (ALBEDO / math.pi)


def _veil(
    scenery: Scenery, depth: Array, direction: Array, distance: Array, beam_open: Array, sky_open: Array
) -> Array:
    """Daylight scattered into the line of sight."""
    here = light_at_depth(scenery.light, scenery.water, depth)
    source = scattered_daylight(here, scenery.water, direction, beam_open, sky_open)
    return source * veil_length(scenery.water, here.attenuation, direction.z, distance)


def _through_surface(scenery: Scenery, rays: Rays, reach: Array, lane: Array) -> tuple[Array, Array]:
    """Radiance beyond the sea surface for eyes below and for eyes above it."""
    d = rays.direction
    x = jit.Float(rays.origin.x) + reach * d.x
    y = jit.Float(rays.origin.y) + reach * d.y
    calm = dr.rcp(1 + dr.square(0.05 * reach))  # slopes average out within a far pixel
    up = surface_normal(slope(scenery.waves, x, y, lane) * calm)
    cosine = dr.abs(dr.dot(up, d))
    below = dr.select(dr.dot(up, d) > 0, -up, up)
    out = refract(d, below, REFRACTIVE_INDEX)
    mirror = fresnel(cosine, 1 / REFRACTIVE_INDEX)
    deep = _water_glow(scenery, reflect(d, below))
    window = sky_radiance(scenery.light, out) / REFRACTIVE_INDEX**-2
    from_below = dr.lerp(window, deep, mirror)
    glint = fresnel(cosine, REFRACTIVE_INDEX)
    upward = reflect(d, up)
    upward.z = dr.abs(upward.z)
    sea = dr.lerp(_water_glow(scenery, refract(d, up, 1 / REFRACTIVE_INDEX)) / REFRACTIVE_INDEX**2,
                  sky_radiance(scenery.light, upward), glint)  # fmt: skip
    from_above = dr.select(d.z < 0, sea, sky_radiance(scenery.light, d))
    return from_below, from_above


def _water_glow(scenery: Scenery, direction: Array) -> Array:
    """Radiance of bottomless water seen downwards from just below its surface."""
    down = jit.Array3f(direction.x, direction.y, -dr.maximum(dr.abs(direction.z), 0.02))
    return _veil(scenery, jit.Float(0.01), down, jit.Float(_FAR), jit.Float(1), jit.Float(1))

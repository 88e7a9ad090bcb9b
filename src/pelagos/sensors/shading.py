"""The realtime view: what light comes along each camera ray, from the nearest surface and from the water before it.

One pass of rays finds surfaces, a second follows those that meet the sea surface to what is behind it or mirrored in
it, and a pass of shadow rays finds the sun. Everything else is closed form: pure functions of `pelagos.optics` on the
hits. Distances and directions are in world axes relative to the camera, single precision.
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
from pelagos.optics.sunlight import (
    Entering,
    LightArrays,
    LightAtDepth,
    light_at_depth,
    scattered_daylight,
    sky_radiance,
)
from pelagos.optics.texture import Looks, surface_look
from pelagos.optics.transport import near_transmission, sharp_transmission, total_transmission, veil_length
from pelagos.optics.water import REFRACTIVE_INDEX, WaterArrays
from pelagos.optics.wave_surface import way_to_surface
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
        sun: what of them enters the water.
        waves: of the moments of the lanes.
        level: `Float`, height of the sea surface over each camera [m].
        at_eye: light in the water at each camera's depth.
        at_surface: light just below the surface.
    """

    tables: Tables
    looks: Looks
    water: WaterArrays
    light: LightArrays
    sun: Entering
    waves: Waves
    level: Array
    at_eye: LightAtDepth
    at_surface: LightAtDepth


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
    height = jit.Float(rays.origin.z) - dr.gather(jit.Float, scenery.level, lane)
    under = height < 0
    first = cast(static, moving, scenery.tables, rays, smooth=True)
    to_sea = dr.select(under == (d.z > 0), -height / dr.select(dr.abs(d.z) < 1e-6, 1e-6, d.z), _FAR)
    if scenery.waves.swell is not None:
        to_sea = way_to_surface(scenery.waves.swell, rays.origin, d, lane)
    meets_sea = (to_sea < first.t) & ((to_sea < rays.max_range) | ~under) & (to_sea < _FAR) & (rays.max_range > 0)
    behind = _behind_the_sea(static, moving, scenery, rays, to_sea, under, meets_sea, first, lane)
    hits = behind.hits
    own_light = _surface_light(static, moving, scenery, rays, behind, lane, lamps, pixel_angle, opened.x)
    sky_seen = ~under & ~meets_sea & ~hits.valid
    own_light = dr.if_stmt(
        (own_light,), sky_seen, lambda _: sky_radiance(scenery.light, d), lambda own_light: own_light, mode="symbolic"
    )
    radiance = own_light * behind.weight + behind.added
    wet = dr.select(under, dr.minimum(dr.select(meets_sea, to_sea, first.t), rays.max_range), 0)
    sharp, near, total = (f(scenery.water, wet) for f in (sharp_transmission, near_transmission, total_transmission))
    here = _at_eye(scenery, lane)
    veil = dr.select(under, _veil(scenery, here, d, wet, opened.y, opened.z), 0)
    for lamp in lamps:
        veil += dr.select(under, lamp_backscatter(lamp, scenery.water, d, wet), 0)
    if snow > 0:
        cover, distance = flakes(jit.Array3f(rays.origin), d, wet, snow, pixel_angle)
        flake = _flake_light(scenery, lamps, here, d * distance) * sharp_transmission(scenery.water, distance)
        return Radiance(
            dr.lerp(radiance * sharp, flake, cover),
            radiance * (near - sharp) * (1 - cover),
            radiance * dr.maximum(total - near, 0) * (1 - cover),
            dr.lerp(veil, veil * dr.minimum(distance / dr.maximum(wet, 1e-3), 1), cover),
        ), first
    return Radiance(radiance * sharp, radiance * (near - sharp), radiance * dr.maximum(total - near, 0), veil), first


@dataclass
class _Behind:
    """What a ray finds in the end, straight or by way of the sea surface, a Dr.Jit struct.

    Attributes:
        hits: of the last stretch.
        way: `Float`, length of all stretches to them [m].
        direction: `Array3f`, of the last stretch.
        weight: `Array3f`, share of their light that arrives at the first stretch's end.
        added: `Array3f`, what else arrives there: sky, mirrored or refracted, and light of the water [cd/m^2].
    """

    hits: Hits
    way: Array
    direction: Array
    weight: Array
    added: Array


def _behind_the_sea(
    static: Any, moving: Any, scenery: Scenery, rays: Rays, to_sea: Array, under: Array, meets_sea: Array, first: Hits,
    lane: Array,
) -> _Behind:  # fmt: skip
    """Follow rays that meet the sea surface along its stronger branch, refracted or mirrored.

    The other branch sees open sky or open water. From below, the light in Snell's window grows by n^2.
    """
    d = rays.direction
    spread = dr.select(under, REFRACTIVE_INDEX**2, REFRACTIVE_INDEX**-2)

    def bent(_: Array) -> tuple[Array, Array, Array, Array, Array]:
        """Start and direction of the stronger branch, whether it is in the water, its share; the other's light."""
        place = rays.origin + jit.Array3f64(d) * jit.Float64(to_sea)
        calm = dr.rcp(1 + dr.square(0.05 * to_sea))  # slopes average out within a far pixel
        up = surface_normal(slope(scenery.waves, jit.Float(place.x), jit.Float(place.y), lane) * calm)
        normal = dr.select(under, -up, up)
        cosine = dr.maximum(-dr.dot(normal, d), 1e-3)
        mirror = fresnel(cosine, dr.select(under, 1 / REFRACTIVE_INDEX, REFRACTIVE_INDEX))
        out = refract(d, normal, dr.select(under, REFRACTIVE_INDEX, 1 / REFRACTIVE_INDEX))
        back = reflect(d, normal)
        into_air, into_water = dr.select(under, out, back), dr.select(under, back, out)
        into_air = dr.normalize(jit.Array3f(into_air.x, into_air.y, dr.maximum(into_air.z, 1e-3)))
        into_water = dr.normalize(jit.Array3f(into_water.x, into_water.y, dr.minimum(into_water.z, -0.02)))
        mirrored = mirror > dr.select(under, 0.9, 0.4)
        wet = mirrored == under
        refracted = (1 - mirror) * spread
        of_air, of_water = dr.select(under, refracted, mirror), dr.select(under, mirror, refracted)
        deep = _veil(scenery, scenery.at_surface, into_water, jit.Float(_FAR), jit.Float(1), jit.Float(1))
        start = jit.Array3f64(place.x, place.y, place.z + dr.select(wet, -_SHADOW_START, _SHADOW_START))
        other = dr.select(wet, of_air * sky_radiance(scenery.light, into_air), of_water * deep)
        return start, dr.select(wet, into_water, into_air), wet, dr.select(wet, of_water, of_air), other

    def straight(_: Array) -> tuple[Array, Array, Array, Array, Array]:
        # copies: the result is written into what a branch returns
        return jit.Array3f64(rays.origin), jit.Array3f(d), jit.Bool(False), jit.Float(1), jit.Array3f(0)

    start, direction, wet, share, other = dr.if_stmt((meets_sea,), meets_sea, bent, straight, mode="symbolic")
    # With flat normals, and outside of the branch: Dr.Jit 1.5 may write the same function twice into a kernel that
    # interpolates normals in two places, which LLVM refuses ("invalid redefinition of function").
    reach = dr.select(meets_sea, rays.max_range, 0)
    second = cast(static, moving, scenery.tables, Rays(start, direction, reach, rays.copy, rays.own))
    length = dr.select(second.valid, second.t, _FAR)
    sky = dr.select(second.valid, 0, sky_radiance(scenery.light, direction))
    down = jit.Array3f(direction.x, direction.y, dr.minimum(direction.z, 0))
    veil = _veil(scenery, scenery.at_surface, down, length, jit.Float(1), jit.Float(1))
    kept = dr.select(wet, total_transmission(scenery.water, length), 1)
    weight = dr.select(meets_sea, share * kept, 1)
    added = dr.select(meets_sea, other + share * dr.select(wet, veil, sky), 0)
    way = dr.select(meets_sea, to_sea + second.t, first.t)
    return _Behind(dr.select(meets_sea, second, first), way, direction, weight, added)


def _surface_light(
    static: Any, moving: Any, scenery: Scenery, rays: Rays, behind: _Behind, lane: Array, lamps: list[Beam],
    pixel_angle: float, opened: Array,
) -> Array:  # fmt: skip
    """Radiance of the hit surfaces themselves: matt, lit by beam, diffuse light from above and below, and lamps."""

    def lit_surface(hits: Hits) -> Array:
        depth = -jit.Float(hits.position.z)
        facing = dr.maximum(-dr.dot(hits.shading_normal, behind.direction), 0.15)
        footprint = behind.way * pixel_angle / facing
        x, y = jit.Float(hits.position.x), jit.Float(hits.position.y)
        albedo, normal = surface_look(
            scenery.looks, hits.material, hits.place, hits.shading_normal, footprint, hits.valid
        )
        here = light_at_depth(scenery.sun, depth)
        towards = here.towards_sun
        facing_sun = dr.maximum(dr.dot(normal, towards), 0)
        lit = hits.valid & (facing_sun > 0) & (dr.dot(hits.normal, towards) > 0)
        start = hits.position + jit.Array3f64(hits.normal) * _SHADOW_START
        shadow = Rays(start, towards, dr.select(lit, _SHADOW_REACH, 0), rays.copy, rays.own)
        dark = occluded(static, moving, scenery.tables, shadow, coherent=True)
        pattern = focusing(scenery.waves, x, y, dr.maximum(depth, 0), towards, lane)
        pattern = dr.lerp(1, pattern, here.sharpness)
        beam = here.beam * dr.select(lit & ~dark, facing_sun * pattern, 0)
        above = 0.5 + 0.5 * normal.z
        total = beam + here.diffuse * above * opened + here.upwelling * (1 - above)
        seen = jit.Array3f(hits.position - rays.origin)
        for lamp in lamps:
            total += lamp_illuminance(lamp, scenery.water, seen, normal)
        return albedo * total / math.pi

    hits = behind.hits
    return dr.if_stmt((hits,), hits.valid, lit_surface, lambda _: jit.Array3f(0), mode="symbolic")


def _at_eye(scenery: Scenery, lane: Array) -> LightAtDepth:
    """Light in the water at the cameras, by ray."""
    here = scenery.at_eye
    beam, diffuse, upwelling, sharpness = (
        dr.gather(type(v), v, lane) for v in (here.beam, here.diffuse, here.upwelling, here.sharpness)
    )
    return LightAtDepth(scenery.sun.towards_sun_below, beam, diffuse, upwelling, sharpness)


def _flake_light(scenery: Scenery, lamps: list[Beam], here: LightAtDepth, seen: Array) -> Array:
    """Radiance of a pale flake at `seen`, relative to the camera: daylight from above and around, and the lamps."""
    total = 0.5 * (here.beam + here.diffuse + here.upwelling)
    for lamp in lamps:
        total += lamp_beam_at(lamp, scenery.water.absorption + scenery.water.backscatter, seen)[0]
    return total * (ALBEDO / math.pi)


def _veil(
    scenery: Scenery, here: LightAtDepth, direction: Array, distance: Array, beam_open: Array, sky_open: Array
) -> Array:
    """Daylight scattered into the line of sight that starts in the light `here`."""
    source = scattered_daylight(here, scenery.sun, scenery.water, direction, beam_open, sky_open)
    return source * veil_length(scenery.water, scenery.sun.attenuation, direction.z, distance)

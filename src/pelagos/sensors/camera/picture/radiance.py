"""The realtime view: what light comes along each camera ray, from the nearest surface and from the water before it.

One pass of rays finds surfaces, a second follows those that meet the sea surface to what is behind it or mirrored in
it, and a pass of shadow rays finds the sun. Everything else is closed form: pure functions of `pelagos.optics` on the
hits. Distances and directions are in world axes relative to the camera, single precision.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TypeAlias

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.caustics import focusing, slope, unseen_slope
from pelagos.optics.foam import foam_cover, foam_radiance
from pelagos.optics.interface import fresnel, reflect, refract, surface_normal
from pelagos.optics.light_field import (
    aureole,
    beam_at,
    beam_veil,
    diffuse_irradiance,
    diffuse_radiance,
    diffuse_source,
    pattern_left,
    seen_through,
    surface_radiance,
)
from pelagos.optics.light_shafts import shaft_gain
from pelagos.optics.light_source import LightSource, light_at, loss_of
from pelagos.optics.light_tables import CRITICAL_COSINE
from pelagos.optics.roughness import glitter, leaning
from pelagos.optics.sight_line import Sight, SightLines, sight_at
from pelagos.optics.snow import ALBEDO, flakes
from pelagos.optics.texture import surface_look
from pelagos.optics.transport import near_transmission, path_length, sharp_transmission
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.optics.wave_surface import way_to_surface
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.camera.picture.lamp_light import lamps_in_water, lamps_on_surface
from pelagos.sensors.camera.picture.scenery import (
    FAR,
    Scenery,
    behind_air,
    by_ray,
    depth_at,
    depth_of_starts,
    fog_radiance,
    sea_from_above,
    sky_in_air,
)

_SHADOW_START = 2e-3  # [m] off the surface
_OPAQUE = 6.0  # optical depth that leaves less than a step of 8 bits: water hides what is farther off
_SHADOW_REACH = 200.0  # [m]


@jit.struct
class Ambience:
    """Diffuse light around what is seen, a Dr.Jit struct of `Array3f`; see `ambient`.

    Attributes:
        surface_open: share of the open sea's diffuse light that reaches the surfaces seen.
        surface_sent: irradiance that they get from other surfaces instead [lx].
        source: what a metre of water at the camera sends on of diffuse light [cd/m^2 per m].
        rate: at which that falls along the line of sight [1/m].
        sent: light of surfaces that the water turns into the line of sight [cd/m^2].
        beam_open: `Float`, share of the water that the sun's beam reaches.
        shafts: `Array4f`, see `light_shafts`; None under a sea without ripples.
    """

    surface_open: Array
    surface_sent: Array
    source: Array
    rate: Array
    sent: Array
    beam_open: Array
    shafts: Array | None = None


@dataclass
class Radiance:
    """Light along the rays, a Dr.Jit struct of `Array3f` [cd/m^2].

    Attributes:
        sharp: from the surface, straight to the pixel.
        near: from the surface, scattered by a few degrees on the way: belongs to the pixel's neighbourhood.
        far: from the surface, scattered forward by some more.
        veil: from the water itself.
    """

    sharp: Array
    near: Array
    far: Array
    veil: Array


def radiance_along(
    caster: Caster, scenery: Scenery, rays: Rays, lane: Array, lamps: list[LightSource], pixel_angle: float,
    around: Ambience | None = None, snow: float = 0.0, lines: SightLines | None = None,
) -> tuple[Radiance, Hits]:  # fmt: skip
    """Radiance along rays through water or air.

    Args:
        caster: the world, see `Caster`.
        scenery: see `Scenery`.
        rays: from the camera.
        lane: `UInt32`, row of `scenery.waves` of each ray.
        lamps: by ray, positions relative to the camera.
        pixel_angle: angle between neighbouring pixels [rad].
        around: by ray; None for the open sea.
        snow: flakes of marine snow in a cubic metre.
        lines: of sight, around each ray; None where the water is the same everywhere.
    """
    scenery = by_ray(scenery, lane)
    depth = depth_of_starts(scenery, rays, lane)
    around = _open_sea(scenery, rays.direction, depth) if around is None else around
    d = rays.direction
    under = depth > 0
    first = caster.cast(rays, smooth=True)
    to_sea = dr.select(under == (d.z > 0), depth / dr.select(dr.abs(d.z) < 1e-6, 1e-6, d.z), FAR)
    if scenery.waves.swell is not None:
        to_sea = way_to_surface(scenery.waves.swell, rays.origin, d, lane)
    meets_sea = (to_sea < first.t) & ((to_sea < rays.max_range) | ~under) & (to_sea < FAR) & (rays.max_range > 0)
    behind = _behind_the_sea(caster, scenery, rays, to_sea, under, meets_sea, first, lane, pixel_angle)
    hits = behind.hits
    wet = dr.select(under, dr.minimum(dr.select(meets_sea, to_sea, first.t), rays.max_range), 0)
    beyond, sight = scenery, None
    if lines is not None:
        sight = sight_at(lines, scenery.field, scenery.water, d, around.rate, wet)
        field = seen_through(scenery.field, scenery.water, sight.water, depth)
        beyond = replace(scenery, water=sight.water, field=field)
    own_light = _surface_light(caster, beyond, rays, behind, lane, lamps, pixel_angle, around)
    sky_seen = ~under & ~meets_sea & ~hits.valid
    own_light = dr.if_stmt(
        (own_light,), sky_seen, lambda _: sky_in_air(scenery, d), lambda own_light: own_light, mode="symbolic"
    )
    radiance = own_light * behind.weight + behind.added
    if scenery.air is not None:
        dry = dr.select(sky_seen | under, 0, dr.select(meets_sea, to_sea, first.t))
        radiance = behind_air(scenery, radiance, dry)
    sharp, near, far = _transmissions(beyond, wet, meets_sea & (d.z > CRITICAL_COSINE))
    veil = dr.select(under, _veil(beyond, around, d, depth, wet, sight), 0)
    if lamps:
        veil += lamps_in_water(caster, scenery, rays, wet, lamps, pixel_angle, lines)
    seen = Radiance(radiance * sharp, radiance * dr.maximum(near - sharp, 0), radiance * far, veil)
    if snow <= 0:
        return seen, first
    cover, distance = flakes(jit.Array3f(rays.origin), d, wet, snow, pixel_angle)
    flake = _flake_light(beyond, lamps, depth, d * distance, pixel_angle)
    flake *= sharp_transmission(beyond.water, distance)
    return _behind_flakes(seen, flake, cover, dr.minimum(distance / dr.maximum(wet, 1e-3), 1)), first


def _transmissions(scenery: Scenery, wet: Array, window: Array) -> tuple[Array, Array, Array]:
    """Shares of a surface's light: straight through the water, with that scattered by a few degrees, and the rest.

    The veil holds the sky's own light that is scattered by a few degrees: in its `window` only surfaces' comes on top.
    """
    sharp, near = sharp_transmission(scenery.water, wet), near_transmission(scenery.water, wet)
    arriving = dr.exp(-dr.select(window, scenery.field.fading, scenery.field.loss) * wet)
    near = dr.minimum(near, arriving)
    return sharp, near, arriving - near


def _behind_flakes(seen: Radiance, flake: Array, cover: Array, before: Array) -> Radiance:
    """Light where flakes cover a share of the view, with a share of the water `before` them."""
    return Radiance(
        dr.lerp(seen.sharp, flake, cover),
        seen.near * (1 - cover),
        seen.far * (1 - cover),
        dr.lerp(seen.veil, seen.veil * before, cover),
    )


@dataclass
class _Behind:
    """Last finding of a ray, straight or by way of the sea surface, a Dr.Jit struct.

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
    caster: Caster, scenery: Scenery, rays: Rays, to_sea: Array, under: Array, meets_sea: Array, first: Hits,
    lane: Array, pixel_angle: float,
) -> _Behind:  # fmt: skip
    """Follow rays that meet the sea surface along its stronger branch, refracted or mirrored.

    The other branch sees open sky or open water. From below, the light in Snell's window grows by n^2.
    """
    d = rays.direction

    def bent(_: Array) -> _Branch:
        return _branch_at(scenery, rays, to_sea, under, lane, pixel_angle)

    def straight(_: Array) -> _Branch:
        # copies: the result is written into what a branch returns
        return jit.Array3f64(rays.origin), jit.Array3f(d), jit.Bool(False), jit.Float(1), jit.Array3f(0)

    start, direction, wet, share, other = dr.if_stmt((meets_sea,), meets_sea, bent, straight, mode="symbolic")
    # With flat normals, and outside of the branch: Dr.Jit 1.5 may write the same function twice into a kernel that
    # interpolates normals in two places, which LLVM refuses ("invalid redefinition of function").
    seen = dr.select(wet, _OPAQUE / dr.min(scenery.field.loss) - dr.select(under, to_sea, 0), FAR)
    reach = dr.select(meets_sea, dr.clip(seen, 0, rays.max_range), 0)
    second = caster.cast(Rays(start, direction, reach, rays.copy, rays.own))
    length = dr.select(second.valid, second.t, FAR)
    sky = dr.if_stmt(
        (direction,), meets_sea & ~wet & ~second.valid, lambda d: sky_in_air(scenery, d), lambda _: jit.Array3f(0),
        mode="symbolic",
    )  # fmt: skip
    down = jit.Array3f(direction.x, direction.y, dr.minimum(direction.z, 0))
    veil = dr.if_stmt(
        (down, length),
        meets_sea & wet,
        lambda down, length: _water_below(scenery, down, length),
        lambda down, length: jit.Array3f(0),
        mode="symbolic",
    )
    kept = dr.select(wet, dr.exp(-scenery.field.loss * length), 1)
    if scenery.air is not None:
        clear = dr.exp(-(scenery.air.fog + scenery.air.rain) * length)
        kept *= dr.select(wet, 1, clear)
        sky = dr.select(second.valid, fog_radiance(scenery) * (1 - clear), sky)
    weight = dr.select(meets_sea, share * kept, 1)
    added = dr.select(meets_sea, other + share * dr.select(wet, veil, sky), 0)
    way = dr.select(meets_sea, to_sea + second.t, first.t)
    return _Behind(dr.select(meets_sea, second, first), way, direction, weight, added)


_Branch: TypeAlias = tuple[Array, Array, Array, Array, Array]


def _branch_at(scenery: Scenery, rays: Rays, to_sea: Array, under: Array, lane: Array, pixel_angle: float) -> _Branch:
    """Branches of rays at the sea surface: start and direction of the stronger branch, whether it is in the water,
    and its share; the other branch's light, with the sun's glitter.
    """
    d = rays.direction
    spread = dr.select(under, REFRACTIVE_INDEX**2, REFRACTIVE_INDEX**-2)
    place = rays.origin + jit.Array3f64(d) * jit.Float64(to_sea)
    x, y = jit.Float(place.x), jit.Float(place.y)
    drawn, rough = slope(scenery.waves, x, y, lane, to_sea), unseen_slope(scenery.waves, to_sea)
    lean = leaning(rough, drawn, d)
    up = surface_normal(dr.select(under, drawn, lean))
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
    start = jit.Array3f64(place.x, place.y, place.z + dr.select(wet, -_SHADOW_START, _SHADOW_START))
    other = dr.if_stmt(
        (into_air, into_water, of_air, of_water),
        wet,
        lambda into_air, into_water, of_air, of_water: of_air * sky_in_air(scenery, into_air),
        lambda into_air, into_water, of_air, of_water: of_water * _water_below(scenery, into_water, jit.Float(FAR)),
        mode="symbolic",
    )
    glint = glitter(rough, drawn, d, scenery.field.towards_sun)
    other += dr.select(under, 0, glint) * scenery.light.sun
    share = dr.select(wet, of_water, of_air)
    if scenery.waves.swell is not None:
        footprint = to_sea * pixel_angle / dr.maximum(dr.abs(d.z), 0.05)
        foam = foam_cover(scenery.waves.swell, x, y, lane, footprint)
        share, other = share * (1 - foam), dr.lerp(other, foam_radiance(scenery.light, under), foam)
    return start, dr.select(wet, into_water, into_air), wet, share, other


def _surface_light(
    caster: Caster, scenery: Scenery, rays: Rays, behind: _Behind, lane: Array, lamps: list[LightSource],
    pixel_angle: float, around: Ambience,
) -> Array:  # fmt: skip
    """Radiance of the hit surfaces themselves: matt, lit by beam, diffuse light from above and below, and lamps."""

    def lit_surface(hits: Hits) -> Array:
        depth = depth_at(scenery, hits.position)
        facing = dr.maximum(-dr.dot(hits.shading_normal, behind.direction), 0.15)
        footprint = behind.way * pixel_angle / facing
        x, y = jit.Float(hits.position.x), jit.Float(hits.position.y)
        albedo, normal = surface_look(
            scenery.looks, hits.material, hits.place, hits.shading_normal, footprint, hits.valid
        )
        wet, below = depth > 0, dr.maximum(depth, 0)
        towards = dr.select(wet, scenery.field.below, scenery.field.towards_sun)
        facing_sun = dr.maximum(dr.dot(normal, towards), 0)
        lit = hits.valid & (facing_sun > 0) & (dr.dot(hits.normal, towards) > 0)
        start = hits.position + jit.Array3f64(hits.normal) * _SHADOW_START
        shadow = Rays(start, towards, dr.select(lit, _SHADOW_REACH, 0), rays.copy, rays.own, rays.drift)
        dark = caster.occluded(shadow, coherent=True)
        pattern = focusing(scenery.waves, x, y, below, towards, lane)
        pattern = dr.lerp(1, pattern, pattern_left(scenery.field, below))
        beam = dr.select(wet, beam_at(scenery.field, below) * pattern, scenery.light.sun)
        diffuse = dr.select(wet, diffuse_irradiance(scenery.field, below, normal), _in_air(scenery, normal.z))
        total = beam * dr.select(lit & ~dark, facing_sun, 0)
        total += diffuse * around.surface_open + around.surface_sent
        if lamps:
            width = behind.way * pixel_angle
            total += lamps_on_surface(caster, scenery, rays, hits, normal, lamps, width)
        return albedo * total / math.pi

    hits = behind.hits
    return dr.if_stmt((hits,), hits.valid, lit_surface, lambda _: jit.Array3f(0), mode="symbolic")


def _in_air(scenery: Scenery, rise: Array) -> Array:
    """Irradiance of sky and sea on surfaces above the water [lx]."""
    above = 0.5 + 0.5 * rise
    return scenery.light.sky * above + math.pi * sea_from_above(scenery) * (1 - above)


def _flake_light(scenery: Scenery, lamps: list[LightSource], depth: Array, seen: Array, pixel_angle: float) -> Array:
    """Radiance of a pale flake at `seen`, relative to the camera: daylight from above and around, and the lamps."""
    field = scenery.field
    below = dr.maximum(depth - seen.z, 0)
    up = jit.Array3f(0, 0, 1)
    total = 0.5 * (beam_at(field, below) + diffuse_irradiance(field, below, up) + diffuse_irradiance(field, below, -up))
    for lamp in lamps:
        total += light_at(lamp, loss_of(lamp, scenery.water), seen, dr.norm(seen) * pixel_angle)[0]
    return total * (ALBEDO / math.pi)


def _veil(
    scenery: Scenery, around: Ambience, direction: Array, depth: Array, distance: Array, sight: Sight | None
) -> Array:
    """Daylight that the water turns into the line of sight."""
    field, water = scenery.field, scenery.water
    if sight is None:
        beam = beam_veil(field, water, depth, direction, distance)
        diffuse = path_length(around.rate, distance)
    else:
        beam, diffuse = beam_at(field, depth) * sight.beam, sight.diffuse
    beam += aureole(field, water, depth, direction, distance)
    if around.shafts is not None:
        beam *= shaft_gain(around.shafts, distance)
    return beam * around.beam_open + around.source * diffuse + around.sent


def _water_below(scenery: Scenery, direction: Array, distance: Array) -> Array:
    """Daylight that the water sends up along a ray that starts at the sea surface."""
    field = scenery.field
    far = dr.maximum(-direction.z * distance, 0)
    diffuse = surface_radiance(field, direction)
    diffuse -= dr.exp(-field.loss * distance) * diffuse_radiance(field, far, direction)
    return dr.maximum(diffuse, 0) + beam_veil(field, scenery.water, jit.Float(0), direction, distance)


def _open_sea(scenery: Scenery, direction: Array, depth: Array) -> Ambience:
    """Radiance of a sea in which nothing stands; for level or downward views."""
    field, none = scenery.field, jit.Array3f(0)
    below = dr.maximum(depth, 0)
    source = diffuse_source(field, below, direction)
    return Ambience(jit.Array3f(1), none, source, open_sea_rate(scenery, direction, depth), none, jit.Float(1))


def open_sea_rate(scenery: Scenery, direction: Array, depth: Array) -> Array:
    """Rate at which the source of diffuse light falls along lines of sight where nothing stands, `Array3f` [1/m]."""
    below = dr.maximum(depth, 0)
    source = diffuse_source(scenery.field, below, direction)
    return source / dr.maximum(diffuse_radiance(scenery.field, below, direction), 1e-12)

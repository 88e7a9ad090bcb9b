"""The reference view: light followed backwards from the pixel through every scattering and reflection, by chance.

It shares surfaces, materials, water and light with the realtime view (`shading`), and none of its short cuts: it
solves the radiative transfer equation for the inherent properties alone (absorption, scattering, phase functions), so
that downward attenuation, veil, glow and light between surfaces come out instead of going in. The sea surface is flat
for refraction, at the tide's level; the pattern of the waves modulates light that comes straight from the sun, as in
the realtime view.

Estimator: path tracing with next-event estimation to the sun (along its refracted direction) and the lamps, distances
sampled for a random channel and weighted by the mean over channels (spectral multiple importance sampling, A. Wilkie
et al. 2014, doi 10.1111/cgf.12419).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import philox, uniform32
from pelagos.optics.caustics import focusing
from pelagos.optics.directions import about, off_matt
from pelagos.optics.interface import fresnel, refract, sun_below_surface
from pelagos.optics.light_source import LightSource, light_at
from pelagos.optics.phase import henyey_greenstein, sample_henyey_greenstein, water_molecules
from pelagos.optics.texture import surface_look
from pelagos.optics.water import MEAN_COSINE, REFRACTIVE_INDEX, WaterArrays
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.camera.picture.scenery import Scenery, behind_air, by_ray, depth_at, sky_in_air
from pelagos.sensors.noise import Key, lane_stream

BOUNCES: Final = 48
_START: Final = 2e-3  # [m] off surfaces
_FAR: Final = 1e4  # [m]
_REACH: Final = 200.0  # [m] of shadow rays


@dataclass
class Path:
    """The state of one path, a Dr.Jit struct.

    Attributes:
        light: `Array3f`, gathered so far [cd/m^2].
        weight: `Array3f`.
        origin: `Array3f64`, world [m].
        direction: `Array3f`.
        travelled: `Float`, from the pixel, for the size of detail [m].
        straight: `Bool`, nothing but the sea surface has turned it: it may end in the glare around the sun, which
            otherwise counts as the sun's own light.
        alive: `Bool`.
        bounce: `UInt32`.
    """

    light: Array
    weight: Array
    origin: Array
    direction: Array
    travelled: Array
    straight: Array
    alive: Array
    bounce: Array


def path_traced(
    caster: Caster, scenery: Scenery, rays: Rays, lane: Array, lamps: list[LightSource], pixel_angle: float,
    counter: tuple[Array, Array, Array, Array], key: Key,
) -> Array:  # fmt: skip
    """Radiance along rays by one random path each, `Array3f` [cd/m^2].

    Args:
        caster, scenery, rays, lane, lamps, pixel_angle: see `radiance.radiance_along`.
        counter: of the random numbers: pixel, environment, tick, sample.
        key: random stream.
    """
    scenery = by_ray(scenery, lane)
    width = dr.width(rays.max_range)
    start = Path(
        light=dr.zeros(jit.Array3f, width),
        weight=dr.full(jit.Array3f, 1, width),
        origin=jit.Array3f64(rays.origin),
        direction=jit.Array3f(rays.direction),
        travelled=dr.zeros(jit.Float, width),
        straight=dr.full(jit.Bool, True, width),
        alive=rays.max_range > 0,
        bounce=dr.zeros(jit.UInt32, width),
    )

    def extend(path: Path) -> tuple[Path]:
        draws = _draws(counter, path.bounce, key)
        return (_extended(caster, scenery, rays, lane, lamps, pixel_angle, path, draws),)

    return dr.while_loop((start,), lambda p: p.alive & (p.bounce < BOUNCES), extend, mode="symbolic")[0].light


def _draws(counter: tuple[Array, Array, Array, Array], bounce: Array, key: Key) -> list[Array]:
    pixel, environment, tick, number = counter
    stream, environment = lane_stream(key, environment)
    words = [philox((pixel, environment, tick, (number * BOUNCES + bounce) * 4 + k), stream) for k in (1, 2)]
    return [uniform32(w) for four in words for w in four]


def _extended(
    caster: Caster, scenery: Scenery, rays: Rays, lane: Array, lamps: list[LightSource], pixel_angle: float,
    path: Path, u: list[Array],
) -> Path:  # fmt: skip
    """One step: a free flight, what ends it, its light from sun and lamps, and where the path goes on."""
    ray = Rays(path.origin, path.direction, rays.max_range, rays.copy, rays.own, rays.drift)
    hits = caster.cast(ray, smooth=True, coherent=False)
    flight = _flight(scenery, path, hits, u)
    weight = path.weight * flight.weight
    light = path.light
    if scenery.air is not None:  # fog on the way through air; what it scatters comes as its own light
        dry = (depth_at(scenery, path.origin) <= 0) & (flight.solid | flight.surface)
        light += dr.select(dry, weight * behind_air(scenery, jit.Array3f(0), flight.way), 0)
        weight *= dr.select(dry, dr.exp(-(scenery.air.fog + scenery.air.rain) * flight.way), 1)
    facing = dr.maximum(-dr.dot(hits.shading_normal, path.direction), 0.15)
    detail = (path.travelled + flight.way) * pixel_angle / facing
    albedo, normal = surface_look(scenery.looks, hits.material, hits.place, hits.shading_normal, detail, flight.solid)
    start = flight.place + jit.Array3f64(dr.select(flight.solid, hits.normal, 0)) * _START
    event = flight.scatters | flight.solid

    def lit(towards: Array, reach: Array, arriving: Array, *, own: bool = False) -> Array:
        """Light that comes from a direction and leaves along the path, if nothing stands before it."""
        ray = Rays(start, towards, dr.select(event, reach, 0), rays.copy, rays.own, rays.drift)
        free = ~caster.occluded(ray, past_own=own)
        turned = _phase(scenery.water, dr.dot(towards, path.direction))
        matt = albedo * (dr.maximum(dr.dot(normal, towards), 0) / math.pi)
        matt = dr.select(dr.dot(hits.normal, towards) > 0, matt, 0)
        return dr.select(event & free, weight * arriving * dr.select(flight.scatters, turned, matt), 0)

    towards, beam = _sunbeam(scenery, flight.place, lane)
    light += lit(towards, jit.Float(_REACH), beam)
    for lamp in lamps:
        place = jit.Array3f(flight.place - rays.origin)
        loss = dr.select(depth_at(scenery, flight.place) > 0, scenery.water.attenuation, 0)
        arriving, to_lamp, distance = light_at(lamp, loss, place, (path.travelled + flight.way) * pixel_angle)
        light += lit(to_lamp, distance - 0.05, arriving, own=True)
    sea = _sea_surface(scenery, path, flight, u[2])
    light += weight * sea.light
    scattered, ratio = _scattered(scenery.water, path.direction, u[3], u[4], u[5])
    matt = off_matt(normal, u[4], u[5])
    matt += 2 * dr.maximum(-dr.dot(matt, hits.normal), 0) * hits.normal  # bumps send no light into the ground
    weight = weight * sea.weight * dr.select(flight.scatters, ratio, dr.select(flight.solid, albedo, 1))
    survival = dr.clip(2 * dr.max(weight), 0.05, 1)
    alive = path.alive & (event | sea.goes_on) & (u[6] < survival) & (dr.max(weight) > 0)
    return Path(
        light=light,
        weight=weight / survival,
        origin=dr.select(flight.surface, sea.origin, start),
        direction=dr.select(flight.scatters, scattered, dr.select(flight.solid, matt, sea.direction)),
        travelled=path.travelled + flight.way,
        straight=path.straight & ~event,
        alive=alive,
        bounce=path.bounce + 1,
    )


@dataclass
class _Flight:
    """A free flight and its end: in the water, on a solid, at the sea surface, or nowhere. A Dr.Jit struct."""

    way: Array
    place: Array
    weight: Array
    scatters: Array
    solid: Array
    surface: Array


def _flight(scenery: Scenery, path: Path, hits: Hits, u: list[Array]) -> _Flight:
    water, depth, rise = scenery.water, depth_at(scenery, path.origin), path.direction.z
    wet = depth > 0
    to_sea = dr.select(wet == (rise > 0), depth / dr.select(dr.abs(rise) < 1e-6, 1e-6, rise), _FAR)
    to_sea = dr.maximum(to_sea, 0)
    end = dr.minimum(dr.select(hits.valid, hits.t, _FAR), to_sea)
    c = dr.select(wet, water.attenuation, 0)
    picked = dr.select(u[0] < 1 / 3, c.x, dr.select(u[0] < 2 / 3, c.y, c.z))
    free = dr.select(wet, -dr.log(u[1]) / dr.maximum(picked, 1e-9), dr.inf)
    scatters = path.alive & (free < end)
    way = dr.minimum(free, end)
    through = dr.exp(-c * way)
    chance = dr.select(scatters, dr.mean(c * through), dr.mean(through))
    solid = path.alive & ~scatters & hits.valid & (hits.t <= to_sea)
    return _Flight(
        way=way,
        place=path.origin + jit.Array3f64(path.direction) * jit.Float64(way),
        weight=through * dr.select(scatters, water.scattering, 1) / dr.maximum(chance, 1e-20),
        scatters=scatters,
        solid=solid,
        surface=path.alive & ~scatters & ~solid & (to_sea < _FAR),
    )


def _sunbeam(scenery: Scenery, place: Array, lane: Array) -> tuple[Array, Array]:
    """Direction to the sun, and irradiance across its beam that no water has scattered yet [lx]."""
    towards = scenery.light.towards_sun
    depth = depth_at(scenery, place)
    wet = depth > 0
    below = sun_below_surface(towards)
    high = dr.maximum(towards.z, 0)
    through = (1 - fresnel(high, REFRACTIVE_INDEX)) * high / below.z
    pattern = focusing(scenery.waves, jit.Float(place.x), jit.Float(place.y), dr.maximum(depth, 0), below, lane)
    wet_beam = (
        scenery.light.sun * through * pattern * dr.exp(-scenery.water.attenuation * dr.maximum(depth, 0) / below.z)
    )
    return dr.select(wet, below, towards), dr.select(high > 0, dr.select(wet, wet_beam, scenery.light.sun), 0)


@dataclass
class _Sea:
    """Sea surface as a path meets it, and the sky of one that meets nothing. A Dr.Jit struct."""

    light: Array
    weight: Array
    origin: Array
    direction: Array
    goes_on: Array


def _sea_surface(scenery: Scenery, path: Path, flight: _Flight, u: Array) -> _Sea:
    """Reflected or refracted by chance, as Fresnel's law says; from below, refracted paths end in the sky."""
    wet = depth_at(scenery, path.origin) > 0
    d = path.direction
    up = jit.Array3f(0, 0, dr.select(wet, -1.0, 1.0))
    out = refract(d, up, dr.select(wet, REFRACTIVE_INDEX, 1 / REFRACTIVE_INDEX))
    mirrored = u < fresnel(dr.abs(d.z), dr.select(wet, 1 / REFRACTIVE_INDEX, REFRACTIVE_INDEX))
    crossed = flight.surface & ~mirrored
    lost = path.alive & ~flight.scatters & ~flight.solid & ~flight.surface
    sky = sky_in_air(scenery, dr.select(crossed, out, d), glare=dr.select(path.straight, 1.0, 0.0))
    n2 = REFRACTIVE_INDEX**2
    goes_below = wet == mirrored
    level = 0 if scenery.tide is None else scenery.tide
    return _Sea(
        light=dr.select(crossed & wet, sky * n2, dr.select(lost & ~wet, sky, 0)),
        weight=dr.select(crossed & ~wet, 1 / n2, 1),
        origin=jit.Array3f64(flight.place.x, flight.place.y, level + dr.select(goes_below, -1e-4, 1e-4)),
        direction=dr.select(mirrored, jit.Array3f(d.x, d.y, -d.z), out),
        goes_on=flight.surface & (mirrored | ~wet),
    )


def _phase(water: WaterArrays, cosine: Array) -> Array:
    """Phase function of the water with its particles, by channel [1/sr]."""
    molecules = water.water_scattering * water_molecules(cosine)
    particles = water.particle_scattering * henyey_greenstein(cosine, MEAN_COSINE)
    return (molecules + particles) / water.scattering


def _scattered(water: WaterArrays, direction: Array, pick: Array, u: Array, v: Array) -> tuple[Array, Array]:
    """A new direction by the phase function of green, and the other channels' weight for it."""
    share = water.particle_scattering.y / water.scattering.y
    cosine = dr.select(pick < share, sample_henyey_greenstein(u, MEAN_COSINE), 2 * u - 1)
    drawn = share * henyey_greenstein(cosine, MEAN_COSINE) + (1 - share) / (4 * math.pi)
    return about(direction, cosine, v), _phase(water, cosine) / drawn

"""Diffuse light among piers, walls and hulls: how much of the open sea's light they keep away, and what they send
instead.

A few rays in every block of the picture gather light, once at the surface that they see and once in the water before
it, from one direction each: what `light_field` says of the open sea, or, where something stands there, the water up to
it and its own light. Means over neighbouring blocks are taken of both, as what was kept over what the open sea gives,
and as what was added: light that has been scattered has no sharp shadows. The rays' directions depend on the pixel
alone, so that a still picture stays still.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import philox, uniform32
from pelagos.optics.directions import about, off_matt
from pelagos.optics.light_field import (
    beam_at,
    beam_veil,
    calm_radiance,
    diffuse_irradiance,
    diffuse_radiance,
    diffuse_source,
    turned_phase,
    window_radiance,
)
from pelagos.optics.light_tables import CRITICAL_COSINE
from pelagos.optics.phase import sample_turning
from pelagos.optics.texture import mean_albedo, mean_facing
from pelagos.optics.transport import fitted_rate, path_length
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.camera.picture.camera_rays import Frame, ViewConfig
from pelagos.sensors.camera.picture.pixel_order import TILE, Pixels, Tiling, lane_at, smooth_tiles, tent, tiles_at
from pelagos.sensors.camera.picture.pixel_samples import ROOT
from pelagos.sensors.camera.picture.radiance import Ambience
from pelagos.sensors.camera.picture.scenery import Scenery, by_ray, depth_at, sea_from_above, sky_in_air

_AT_SURFACE: Final = 14  # probes in a block of 32 x 32 pixels
_IN_WATER: Final = 12  # likewise; of another number, so that both are followed at a time
_REACH: Final = 60.0  # [m]
_SHADOW_REACH: Final = 200.0  # [m]
_STEPS: Final = 4
_KEY: Final = (0x0004, 0x0004)
_START: Final = 0.02  # [m] off surfaces
_GROWTH: Final = 1.5  # of diffuse light towards the surface, over its mean K; assumed
_SHALLOW: Final = 0.02  # least depth of a camera [m]
_FAR: Final = 1e4  # [m]


def ambience(caster: Caster, scenery: Scenery, frame: Frame[ViewConfig], *, beside: Any = None) -> list[Array]:
    """By block, packed for `ambience_at`; see `Ambience`. `beside` is worked out at the same time, on free cores."""
    tiling, images = frame.tiling, frame.images
    coarse = _blocks(tiling)
    source, rate, rise = _towards(scenery, frame)
    dr.eval(source, rate, rise)

    def probes(number: int) -> _Probes:
        where = _probes(tiling, images, number)
        rays = frame.rays(where, scenery.level)
        return _Probes(where, rays, caster.cast(rays), _draws(where, tiling, number))

    surface = _at_surface(caster, scenery, probes(_AT_SURFACE))
    water = _before_it(caster, scenery, probes(_IN_WATER), source, rate)
    dr.eval(surface, water, beside)
    a, b, *sent_there = _block_means(surface, _AT_SURFACE, coarse, images)
    d, e, *sent_here, v, g = _block_means(water, _IN_WATER, coarse, images)
    # of the sky that is seen in its window, what only goes on nearly straight is not kept away by what stands aside
    turned = dr.lerp(1, dr.minimum(d / dr.maximum(v, 1e-12), 1), dr.clip((rise - 0.6) * 8, 0, 1))
    made = Ambience(
        surface_open=b / dr.maximum(a, 1e-12),
        surface_sent=_sent(*sent_there),
        source=source * (1 - (1 - e / dr.maximum(d, 1e-12)) * turned),
        rate=rate,
        sent=_sent(*sent_here),
        beam_open=g.x,
    )
    packed = _packed(made)
    dr.eval(packed)
    return packed


def _sent(lit: Array, table: Array, open_sea: Array, arrives: Array) -> Array:
    """Light of solids, `Array3f`: of the sun's beam, and of as much of what the open sea would give them as arrives.

    The tables say how much the open sea gives: walks find a fifth more, as they take scattering by less than 24 degrees
    for none, and see the glow around the sun in the sky, which the tables have in the beam.
    """
    return lit + table * dr.minimum(arrives / dr.maximum(open_sea, 1e-12), 2)


def _block_means(values: list[Array], number: int, coarse: Tiling, images: int) -> list[Array]:
    """Smooth means of `Array3f`s over the `number` probes of each block; all components are summed in one go."""
    parts = [c for v in values for c in v]
    blocks = images * coarse.tiles
    side_by_side = dr.ravel(jit.ArrayXf(parts), order="C")  # in one kernel
    sums = dr.block_sum(side_by_side, number)
    dr.eval(sums)

    def mean(k: int) -> Array:
        def of_block(block: Array) -> Array:
            return jit.Array3f(*(dr.gather(jit.Float, sums, block + (3 * k + c) * blocks) for c in range(3)))

        return tent(of_block, coarse, images) / number

    means = [mean(k) for k in range(len(values))]
    dr.eval(means)
    return [smooth_tiles(m, coarse, images) for m in means]


@dataclass
class _Probes:
    """Rays of a few pixels of each block, what they hit, and five numbers 0 .. 1 for each."""

    where: Pixels
    rays: Rays
    hits: Hits
    u: list[Array]


def _at_surface(caster: Caster, scenery: Scenery, probes: _Probes) -> list[Array]:
    """Irradiance of the surfaces seen: from the open sea, what of it arrives, and what `_sent` asks for; `Array3f` each
    [lx]."""
    rays, hits, u = probes.rays, probes.hits, probes.u
    scenery = by_ray(scenery, probes.where.image)
    start = hits.position + jit.Array3f64(hits.normal) * _START
    up, whole = off_matt(hits.normal, u[0], u[1]), jit.Array3f(math.pi)
    found = _gathered(caster, scenery, rays, start, up, whole, hits.valid, (probes.where.ray, 0))
    dry = _above_water(caster, scenery, rays, start, up, hits.valid & (depth_at(scenery, start) <= 0))
    return [*(w + d for w, d in zip(found, dry, strict=False)), *found[len(dry) :]]


def _above_water(caster: Caster, scenery: Scenery, rays: Rays, start: Array, up: Array, wanted: Array) -> list[Array]:
    """The first three of surfaces above the water, from one direction: sky or sea, or what stands before it, which has
    half of that light itself (assumed)."""
    reach = dr.select(wanted, jit.Float(_REACH), 0)
    met = caster.cast(Rays(start, up, reach, rays.copy, rays.own), coherent=False)
    light = dr.select(up.z > 0, sky_in_air(scenery, up, glare=0.0), sea_from_above(scenery))
    light = dr.select(wanted, math.pi * light, 0)
    sent = 0.5 * light * mean_albedo(scenery.looks, met.material, met.valid)
    return [light, dr.select(met.valid, 0, light), dr.select(met.valid, sent, 0)]


def _before_it(
    caster: Caster, scenery: Scenery, probes: _Probes, source: Array, rate: Array
) -> list[Array]:  # fmt: skip
    """Light that the water before the surfaces turns into the line of sight [cd/m^2].

    From the open sea, what of it arrives, and what `_sent` asks for, by way of one place by chance as light from there
    arrives; then the open sea's as `source` and `rate` of the block have it, and whether the sun's beam is at that
    place.
    """
    rays, hits, u = probes.rays, probes.hits, probes.u
    scenery = by_ray(scenery, probes.where.image)
    water, field = scenery.water, scenery.field
    reach = dr.minimum(hits.t, rays.max_range)
    loss = field.loss.y
    span = 1 - dr.exp(-loss * reach)
    along = -dr.log(1 - u[2] * span) / loss
    place = rays.origin + jit.Array3f64(rays.direction) * jit.Float64(along)
    wet = probes.where.active & (depth_at(scenery, place) > 0) & (depth_at(scenery, rays.origin) > 0)
    asked = dr.select(wet, jit.Float(_SHADOW_REACH), 0)
    sunlit = ~caster.occluded(Rays(place, field.below, asked, rays.copy, rays.own))
    turned = about(rays.direction, sample_turning(u[3]), u[4])
    turning = water.turning * dr.exp((loss - field.loss) * along) * (span / loss)
    found = _gathered(caster, scenery, rays, place, turned, turning, wet, (probes.where.ray, 1))
    block = dr.arange(jit.UInt32, dr.width(wet)) // _IN_WATER
    whole = dr.gather(jit.Array3f, source, block) * path_length(dr.gather(jit.Array3f, rate, block), reach)
    return [*found, dr.select(wet, whole, 0), jit.Array3f(dr.select(sunlit, 1, 0), 0, 0)]


@jit.struct
class _Walk:
    """A random walk backwards from an eye, through the open sea until something stands in its way, and on from there.

    Attributes:
        place, direction: where it is, and where it goes on to.
        weight: `Array3f`.
        met: `UInt32`, how many solids have stood in its way.
        open_sea, arrives: `Array3f`, light of the open sea, and what of it arrives [cd/m^2].
        lit: `Array3f`, light of solids that the sun's beam is on [cd/m^2].
        table: `Array3f`, that of the first solid in the open sea, by the tables [cd/m^2].
        there: `Array3f`, the same as the walk finds it [cd/m^2].
        sent: `Array3f`, what of that arrives, by way of the first solid and more [cd/m^2].
        alive: `Bool`.
        step: `UInt32`.
    """

    place: Array
    direction: Array
    weight: Array
    met: Array
    open_sea: Array
    arrives: Array
    lit: Array
    table: Array
    there: Array
    sent: Array
    alive: Array
    step: Array


def _gathered(
    caster: Caster, scenery: Scenery, rays: Rays, place: Array, direction: Array, weight: Array,
    wanted: Array, key: tuple[Array, int],
) -> list[Array]:  # fmt: skip
    """Light from a direction, times `weight`: of the open sea; what of it arrives; and what `_sent` asks for; `Array3f`
    each."""
    width = dr.width(wanted)
    none = [dr.zeros(jit.Array3f, width) for _ in range(6)]
    start = _Walk(
        place=jit.Array3f64(place),
        direction=jit.Array3f(direction),
        weight=jit.Array3f(weight),
        met=dr.zeros(jit.UInt32, width),
        open_sea=none[0],
        arrives=none[1],
        lit=none[2],
        table=none[3],
        there=none[4],
        sent=none[5],
        alive=jit.Bool(wanted & (depth_at(scenery, place) > 0)),
        step=dr.zeros(jit.UInt32, width),
    )

    def step(walk: _Walk) -> tuple[_Walk]:
        return (_stepped(caster, scenery, rays, walk, key),)

    walk = dr.while_loop((start,), lambda w: w.alive & (w.step < _STEPS), step, mode="symbolic")[0]
    field, depth = scenery.field, dr.maximum(depth_at(scenery, walk.place), 0)
    last = _open_sea(scenery, walk.place, walk.direction)
    last = walk.weight * (last + window_radiance(field, scenery.light, depth, walk.direction))
    last = dr.select(walk.alive, last, 0)
    first, once = (dr.select(walk.met == k, last, 0) for k in (0, 1))
    sent = walk.sent + last - first
    return [walk.open_sea + first, walk.arrives + first, walk.lit, walk.table, walk.there + once, sent]


def _open_sea(scenery: Scenery, place: Array, direction: Array) -> Array:
    """Light of the water from a direction where nothing stands, `Array3f` [cd/m^2]."""
    field = scenery.field
    depth = dr.maximum(depth_at(scenery, place), 0)
    light = calm_radiance(field, depth, direction)
    return light + beam_veil(field, scenery.water, depth, direction, _to_sea(depth, direction))


def _to_sea(depth: Array, direction: Array) -> Array:
    return dr.select(direction.z > 1e-4, depth / dr.maximum(direction.z, 1e-4), _FAR)


def _stepped(caster: Caster, scenery: Scenery, rays: Rays, walk: _Walk, key: tuple[Array, int]) -> _Walk:
    """A free flight to a place where light is scattered, to the surface of the sea, or to a solid."""
    field, water = scenery.field, scenery.water
    u = [uniform32(w) for w in philox((key[0], walk.step, jit.UInt32(2 + key[1]), jit.UInt32(0)), _KEY)]
    d, mean_loss = walk.direction, field.loss.y
    depth = dr.maximum(depth_at(scenery, walk.place), 0)
    to_sea = _to_sea(depth, d)
    flight = -dr.log(1 - u[0]) / mean_loss
    free_way = dr.minimum(flight, to_sea)
    reach = dr.minimum(dr.select(d.z > CRITICAL_COSINE, to_sea, free_way), _REACH)  # the sky itself is always asked for
    reach = dr.select(walk.alive, reach, 0)
    hits = caster.cast(Rays(walk.place, d, reach, rays.copy, rays.own), coherent=False)
    solid = walk.alive & hits.valid & (hits.t < free_way)
    at_sea = ~solid & (flight > to_sea)
    way = dr.select(solid, hits.t, free_way)
    on = walk.place + jit.Array3f64(d) * jit.Float64(way)
    on.z = dr.select(at_sea, (0 if scenery.tide is None else scenery.tide) - 1e-3, on.z)
    on += jit.Array3f64(dr.select(solid, hits.normal, 0)) * _START
    asks = dr.select(walk.alive & ~at_sea, jit.Float(_SHADOW_REACH), 0)
    sunlit = ~caster.occluded(Rays(on, field.below, asks, rays.copy, rays.own))

    kept = walk.weight * dr.exp(-(field.loss - mean_loss) * way)
    albedo = mean_albedo(scenery.looks, hits.material, solid)
    matt = albedo * (mean_facing(scenery.looks, hits.material, solid) / math.pi)
    matt *= dr.maximum(dr.dot(hits.normal, field.below), 0)
    turned = turned_phase(field, water, d) / mean_loss
    beam = kept * beam_at(field, dr.maximum(depth_at(scenery, on), 0)) * dr.select(solid, matt, turned)
    sky = dr.select(walk.alive, walk.weight * window_radiance(field, scenery.light, depth, d), 0)
    here = dr.select(walk.alive & ~at_sea, beam, 0)
    sunny = dr.select(sunlit, here, 0)
    seen = dr.select(solid, 0, sunny) + dr.select(hits.valid, 0, sky)
    of_sea = sky + dr.select(solid, kept * _open_sea(scenery, on, d), here)
    first = walk.met == 0
    given = diffuse_irradiance(field, dr.maximum(depth_at(scenery, on), 0), hits.normal)
    given = kept * albedo * given / math.pi
    onward = dr.select(solid, off_matt(hits.normal, u[1], u[2]), about(d, sample_turning(u[1]), u[2]))
    return _Walk(
        place=on,
        direction=dr.select(at_sea, jit.Array3f(d.x, d.y, -d.z), onward),
        weight=kept * dr.select(at_sea, 1, dr.select(solid, albedo, water.turning / mean_loss)),
        met=walk.met + dr.select(solid, jit.UInt32(1), 0),
        open_sea=walk.open_sea + dr.select(first, of_sea, 0),
        arrives=walk.arrives + dr.select(first, seen, 0),
        lit=walk.lit + dr.select(solid, sunny, 0),
        table=walk.table + dr.select(first & solid, given, 0),
        there=walk.there + dr.select(walk.met == 1, of_sea, 0),
        sent=walk.sent + dr.select(first, 0, seen),
        alive=walk.alive & (~at_sea | (d.z < CRITICAL_COSINE)) & (depth_at(scenery, on) > 0),
        step=walk.step + 1,
    )


def ambience_at(blocks: list[Array], tiling: Tiling, where: Pixels) -> Ambience:
    """Interpolated to every lane from what `ambience` gives."""
    coarse = _blocks(tiling)
    column, row = 0.5 * jit.Float(where.column) - 0.25, 0.5 * jit.Float(where.row) - 0.25
    p, q, r, s = (tiles_at(v, coarse, where.image, column, row, jit.Array4f) for v in blocks)
    return Ambience(p.xyz, q.xyz, r.xyz, s.xyz, jit.Array3f(p.w, q.w, r.w), s.w)


def _packed(a: Ambience) -> list[Array]:
    """Sixteen values of a block as four packets, so that four loads fetch them."""
    last = (a.sent.x, a.sent.y, a.sent.z, a.beam_open)
    packets = zip((a.surface_open, a.surface_sent, a.source, a.rate), last, strict=True)
    return [dr.ravel(jit.Array4f(v.x, v.y, v.z, w)) for v, w in packets]


def _towards(scenery: Scenery, frame: Frame[ViewConfig]) -> tuple[Array, Array, Array]:
    """Towards each block: diffuse light's source at the camera, the rate at which it falls along the way, d_z."""
    where = _middles(frame.tiling, frame.images)
    rays = frame.rays(where, scenery.level)
    field, d = by_ray(scenery, where.image).field, rays.direction
    depth = dr.maximum(dr.gather(jit.Float, scenery.depth, where.image), _SHALLOW)
    to_sea = _to_sea(depth, d)
    source = diffuse_source(field, depth, d)
    whole = diffuse_radiance(field, depth, d)
    whole -= dr.exp(-field.loss * to_sea) * diffuse_radiance(field, jit.Float(0), d)
    rate = fitted_rate(dr.maximum(whole, 1e-3 * source / field.loss), source, to_sea)
    # near the surface it hardly follows from the whole: not far from what light makes that falls with the depth
    rise = _GROWTH * field.decay
    low, high = field.loss - rise * dr.maximum(d.z, 0), _GROWTH * field.loss + rise * dr.maximum(-d.z, 0)
    return source, dr.clip(rate, low, high), d.z


def _draws(where: Pixels, tiling: Tiling, number: int) -> list[Array]:
    """Five numbers 0 .. 1 for each probe: even over a block (M. Roberts's R-sequence), shifted at random from block to
    block."""
    lane = dr.arange(jit.UInt32, dr.width(where.ray))
    place, block = lane % number, lane // number % _blocks(tiling).tiles
    words = [w for k in (0, 1) for w in philox((block, jit.UInt32(k), jit.UInt32(0), jit.UInt32(0)), _KEY)]
    steps = [jit.UInt32(int(ROOT ** -(d + 1) * 2**32)) for d in range(5)]
    return [uniform32(words[d] + place * steps[d]) for d in range(5)]


def _blocks(tiling: Tiling) -> Tiling:
    """Blocks of 32 pixels each way: tiles of a picture of half the size."""
    return Tiling(-(-tiling.width // 2), -(-tiling.height // 2))


def _probes(tiling: Tiling, images: int, number: int) -> Pixels:
    """A few pixels of each block, no two in a row or column."""
    lane = dr.arange(jit.UInt32, images * _blocks(tiling).tiles * number)
    place = lane % number
    return _chosen(tiling, lane // number, place * 32 // number, (place * 10 + 5) % 32)


def _middles(tiling: Tiling, images: int) -> Pixels:
    """The pixel in the middle of each block."""
    return _chosen(tiling, dr.arange(jit.UInt32, images * _blocks(tiling).tiles), jit.UInt32(15), jit.UInt32(15))


def _chosen(tiling: Tiling, block_of_all: Array, right: Array, down: Array) -> Pixels:
    """A pixel of each block of all images; beyond the picture's edge, the edge's."""
    blocks = _blocks(tiling)
    image = block_of_all // blocks.tiles
    block = block_of_all - image * blocks.tiles
    column = dr.minimum(block % blocks.across * (2 * TILE) + right, tiling.width - 1)
    row = dr.minimum(block // blocks.across * (2 * TILE) + down, tiling.height - 1)
    ray = lane_at(tiling, jit.UInt32(0), column, row)
    return Pixels(image, ray, column, row, dr.full(jit.Bool, True, dr.width(ray)))

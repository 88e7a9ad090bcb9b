"""How open the water is: how much daylight reaches surfaces and the water before them past piers, walls and hulls.

A few rays in every tile of the picture find out, and their mean is smoothed over neighbouring tiles: light that has
been scattered has no sharp shadows. The rays' directions depend on the pixel alone, so that a still picture stays
still.
"""

from __future__ import annotations

import math
from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import philox, uniform32
from pelagos.optics.interface import sun_below_surface
from pelagos.raycast.caster import cast, occluded
from pelagos.raycast.rays import Rays
from pelagos.sensors.pixels import TILE, Pixels, Tiling, inner_place, smooth_tiles
from pelagos.sensors.sensor import Kinematics
from pelagos.sensors.shading import Scenery
from pelagos.sensors.view import Lens, ViewConfig, view_rays

_PROBES: Final = 8  # in a tile, one in every 32 pixels
_SPREAD: Final = 0.75  # of the directions that diffuse light comes from, about the zenith; assumed
_REACH: Final = 60.0  # [m]
_ROOT: Final = 1.2207440846057596  # of x^4 = x + 1: three dimensions
_START: Final = 0.02  # [m] off surfaces


def openness(
    static: Any, moving: Any, scenery: Scenery, lens: Lens, motion: Kinematics, own: Array, config: ViewConfig,
    tiling: Tiling,
) -> Array:  # fmt: skip
    """By tile, `Array3f` 0 .. 1: diffuse light on surfaces, sunbeams in the water, sky light in the water."""
    images = dr.width(motion.tick)
    where = _probes(tiling, images)
    rays = view_rays(lens, where, motion, own, config)
    hits = cast(static, moving, scenery.tables, rays)
    draws = _draws(where)
    angle, radius = 2 * math.pi * draws[0], _SPREAD * dr.sqrt(draws[1])
    s, c = dr.sincos(angle)
    upwards = dr.normalize(jit.Array3f(radius * c, radius * s, 1))
    water = scenery.water
    loss = water.absorption.y + water.turning.y
    start = hits.position + jit.Array3f64(hits.normal) * _START
    above = cast(static, moving, scenery.tables, Rays(start, upwards, _reach(hits.valid), rays.copy, rays.own))
    on_surface = dr.select(hits.valid & above.valid, 1 - dr.exp(-loss * above.t), 1)
    reach = dr.minimum(hits.t, rays.max_range)
    along = -dr.log(1 - draws[2] * (1 - dr.exp(-loss * reach))) / loss
    middle = rays.origin + jit.Array3f64(rays.direction) * jit.Float64(along)
    wet = where.active & (middle.z < 0)
    towards = sun_below_surface(scenery.light.towards_sun)
    sunlit = ~occluded(static, moving, scenery.tables, Rays(middle, towards, _reach(wet), rays.copy, rays.own))
    above = cast(static, moving, scenery.tables, Rays(middle, upwards, _reach(wet), rays.copy, rays.own))
    in_water = dr.select(above.valid, 1 - dr.exp(-loss * above.t), 1)
    found = jit.Array3f(on_surface, dr.select(sunlit, 1, 0), in_water)
    dr.eval(found)  # once: each sum over tiles would cast the rays again
    count = dr.maximum(dr.block_sum(dr.select(where.active, jit.Float(1), 0), _PROBES), 1)
    means = dr.block_sum(dr.select(where.active, found, 0), _PROBES) / count
    return smooth_tiles(smooth_tiles(means, tiling, images), tiling, images)


def _draws(where: Pixels) -> list[Array]:
    """Three numbers 0 .. 1 for each probe: even over a tile (M. Roberts's R-sequence in three dimensions), shifted at
    random from tile to tile."""
    tile, number = where.ray // (TILE * TILE), where.ray % (TILE * TILE) // (TILE * TILE // _PROBES)
    words = philox((tile, jit.UInt32(0), jit.UInt32(0), jit.UInt32(0)), (0x0A3B, 0x1E57))
    draws = []
    for d in range(3):
        value = uniform32(words[d]) + (jit.Float(number) + 0.5) * _ROOT ** -(d + 1)
        draws.append(value - dr.floor(value))
    return draws


def _reach(wanted: Array) -> Array:
    return dr.select(wanted, jit.Float(_REACH), 0)


def _probes(tiling: Tiling, images: int) -> Pixels:
    """Every eighth pixel of each tile, another column in each row."""
    lane = dr.arange(jit.UInt32, images * tiling.tiles * _PROBES)
    tile_of_all, number = lane // _PROBES, lane % _PROBES
    image = tile_of_all // tiling.tiles
    tile = tile_of_all - image * tiling.tiles
    inner = number * (TILE * TILE // _PROBES) + (number * 5) % (TILE * TILE // _PROBES)
    inner_column, inner_row = inner_place(inner)
    column, row = tile % tiling.across * TILE + inner_column, tile // tiling.across * TILE + inner_row
    active = (column < tiling.width) & (row < tiling.height)
    return Pixels(image, tile * (TILE * TILE) + inner, column, row, active)

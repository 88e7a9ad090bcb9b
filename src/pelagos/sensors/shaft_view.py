"""Shafts of light in a picture: one line of sight in every square of four by four pixels, and between them."""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.light_shafts import shafts
from pelagos.sensors.pixels import Pixels, Tiling, lane_at
from pelagos.sensors.scenery import Scenery, by_ray
from pelagos.sensors.sensor import Kinematics
from pelagos.sensors.view import Lens, ViewConfig, view_rays

_SQUARE: Final = 4  # [px]


def shaft_squares(
    scenery: Scenery, lens: Lens, motion: Kinematics, own: Array, config: ViewConfig, tiling: Tiling
) -> Array:
    """What `shafts` gives for each square of all images, `Array4f`, row by row; not worked out yet."""
    across, down = _size(tiling)
    square = dr.arange(jit.UInt32, dr.width(motion.tick) * across * down)
    image, inner = square // (across * down), square % (across * down)
    column = dr.minimum(inner % across * _SQUARE + 1, tiling.width - 1)
    row = dr.minimum(inner // across * _SQUARE + 1, tiling.height - 1)
    lane = lane_at(tiling, jit.UInt32(0), column, row)
    where = Pixels(image, lane, column, row, dr.full(jit.Bool, True, dr.width(square)))
    rays = view_rays(lens, where, motion, own, config, scenery.level)
    depth = dr.gather(jit.Float, scenery.depth, image)
    stratum = (inner % across % 3 + 3 * (inner // across % 3)) * 4 % 9  # nine neighbours start in nine places
    jitter = (jit.Float(stratum) + 0.5) / 9
    place = jit.Array2f(jit.Float(rays.origin.x), jit.Float(rays.origin.y))
    field = by_ray(scenery, image).field
    return shafts(scenery.waves, field, place, depth, rays.direction, image, jitter)


def smoothed(values: Array, tiling: Tiling) -> Array:
    """Means over three by three squares, repeating the edge; `Float`, four values side by side."""
    across, down = _size(tiling)
    square = dr.arange(jit.UInt32, dr.width(values))
    packed = dr.ravel(values)
    first = square // (across * down) * (across * down)
    inner = square - first
    x, y = jit.Int32(inner % across), jit.Int32(inner // across)
    total = jit.Array4f(0)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            at = dr.clip(y + b, 0, down - 1) * across + dr.clip(x + a, 0, across - 1)
            total += dr.gather(jit.Array4f, packed, first + jit.UInt32(at))
    smooth = dr.ravel(total / 9)
    dr.eval(smooth)
    return smooth


def shafts_at(squares: Array, tiling: Tiling, where: Pixels) -> Array:
    """Between the squares, for every lane, `Array4f`; beyond the edge, that of the edge."""
    across, down = _size(tiling)
    x = dr.clip((jit.Float(where.column) - 1) / _SQUARE, 0, across - 1)
    y = dr.clip((jit.Float(where.row) - 1) / _SQUARE, 0, down - 1)
    i, j = jit.UInt32(x), jit.UInt32(y)
    a, b = x - jit.Float(i), y - jit.Float(j)
    i1, j1 = dr.minimum(i + 1, across - 1), dr.minimum(j + 1, down - 1)
    base = where.image * (across * down)

    def at(column: Array, row: Array) -> Array:
        return dr.gather(jit.Array4f, squares, base + row * across + column)

    return dr.lerp(dr.lerp(at(i, j), at(i1, j), a), dr.lerp(at(i, j1), at(i1, j1), a), b)


def _size(tiling: Tiling) -> tuple[int, int]:
    return -(-tiling.width // _SQUARE), -(-tiling.height // _SQUARE)

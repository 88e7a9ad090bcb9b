"""One line of sight in every square of four by four pixels, and places between: for what is smooth in a picture."""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.camera.picture.pixel_order import Pixels, Tiling, lane_at

_SIDE: Final = 4  # [px]


def size(tiling: Tiling) -> tuple[int, int]:
    """Squares across a picture, and down."""
    return -(-tiling.width // _SIDE), -(-tiling.height // _SIDE)


def square_pixels(tiling: Tiling, images: int, *, lanes: int = 1) -> tuple[Pixels, Array, Array]:
    """A pixel in each square of all images, row by row, in so many neighbouring `lanes`; column and row of the
    square."""
    across, down = size(tiling)
    square = dr.arange(jit.UInt32, images * across * down * lanes) // lanes
    image, inner = square // (across * down), square % (across * down)
    x, y = inner % across, inner // across
    column = dr.minimum(x * _SIDE + 1, tiling.width - 1)
    row = dr.minimum(y * _SIDE + 1, tiling.height - 1)
    lane = lane_at(tiling, jit.UInt32(0), column, row)
    return Pixels(image, lane, column, row, dr.full(jit.Bool, True, dr.width(square))), x, y


def stratum(x: Array, y: Array) -> Array:
    """Place in a stretch for a square, 0 .. 1: nine neighbours in nine places; `x`, `y` column and row of it."""
    return (jit.Float((x % 3 + 3 * (y % 3)) * 4 % 9) + 0.5) / 9


def around(tiling: Tiling, where: Pixels) -> tuple[list[Array], Array, Array]:
    """The four squares around each lane, row by row, and the place between them, rightwards and down, 0 .. 1.

    Beyond the edge, those of the edge.
    """
    across, down = size(tiling)
    x = dr.clip((jit.Float(where.column) - 1) / _SIDE, 0, across - 1)
    y = dr.clip((jit.Float(where.row) - 1) / _SIDE, 0, down - 1)
    i, j = jit.UInt32(x), jit.UInt32(y)
    i1, j1 = dr.minimum(i + 1, across - 1), dr.minimum(j + 1, down - 1)
    base = where.image * (across * down)
    corners = [base + b * across + a for b in (j, j1) for a in (i, i1)]
    return corners, x - jit.Float(i), y - jit.Float(j)

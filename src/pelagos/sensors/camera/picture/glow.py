"""Glow around what is seen: light that the water scattered forward on its way, spread over the picture by angle.

Light turned by theta at the share s of its way arrives theta (1 - s) from where it began: of scattering anywhere along
the way a third of theta's mean square is left, half of it in each direction of the picture. Between 1 and 24 degrees
the share of scattering by less than theta grows with log theta (see `optics.transport`), which gives the spreads.

The picture is spread in blocks of pixels where it is wide; block, kernel and interpolation add up to the spread asked
for, so that a view has the same glow at any number of pixels.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.camera.picture.pixel_order import SQUARE, TILE, Pixels, Tiling, lane_at, pixels_at


def _spread_rad(least_deg: float, most_deg: float) -> float:
    """Standard deviation along a row of light turned by between two angles, at equal shares of their logarithm."""
    mean_square = 0.5 * (most_deg**2 - least_deg**2) / math.log(most_deg / least_deg)
    return math.radians(math.sqrt(mean_square / 3 / 2))


NEAR_RAD: Final = _spread_rad(1.0, 5.0)
FAR_RAD: Final = _spread_rad(5.0, 24.0)  # by more, it counts as light of the water
_BLOCKS: Final = (TILE, SQUARE, 2, 1)  # edges of blocks [px]; all but those of 2 are side by side in the order of lanes
_BLUR: Final = 1 / 12 + 1 / 6  # variance of a block's mean and of interpolation between blocks [edges^2]
_LEAST: Final = 1.0  # variance of the kernel that blocks leave [edges^2]: it does not show their grid
_TAILS: Final = 3.0  # standard deviations that the kernel reaches


def glow(near: Array, far: Array, where: Pixels, tiling: Tiling, pixel_angle: float) -> Array:
    """Light at the pixels `Array3f` of what the water scattered by a few degrees (`near`) and by some more (`far`).

    Args:
        near, far: `Array3f` by lane, evaluated, where they would be seen without it [cd/m^2].
        where: lanes.
        tiling: their order.
        pixel_angle: angle between neighbouring pixels [rad].
    """
    return spread(near, NEAR_RAD / pixel_angle, where, tiling) + spread(far, FAR_RAD / pixel_angle, where, tiling)


def spread(light: Array, width: float, where: Pixels, tiling: Tiling) -> Array:
    """Light under a bell of standard deviation `width` [px] in both directions, `Array3f`; the edge goes on outside."""
    edge = next(e for e in _BLOCKS if e == 1 or width**2 >= (_BLUR + _LEAST) * e**2)
    deviation = math.sqrt((width / edge) ** 2 - (_BLUR if edge > 1 else 0.0))
    means = _means(light, where, edge)
    for right, down in ((1, 0), (0, 1)):
        means = _bell(means, deviation, tiling, edge, right, down)
        dr.eval(means)
    return means if edge == 1 else _between(means, tiling, where, edge)


def _means(light: Array, where: Pixels, edge: int) -> Array:
    """Over the active lanes of each block, `Array3f`; 0 in blocks outside the picture."""
    if edge == 1:
        return light
    parts = [jit.Float(1), *light]
    kept = dr.ravel(jit.ArrayXf([dr.select(where.active, part, 0) for part in parts]), order="C")  # one kernel, one sum
    lanes, blocks = dr.width(where.active), dr.width(where.active) // (edge * edge)
    block = dr.arange(jit.UInt32, blocks)
    if edge < SQUARE:
        dr.eval(kept)
        first = _first_lane(block, edge)
        inside = [row * SQUARE + column for row in range(edge) for column in range(edge)]
        sums = [sum(dr.gather(jit.Float, kept, first + k * lanes + i) for i in inside) for k in range(len(parts))]
    else:
        summed = dr.block_sum(kept, edge * edge)
        dr.eval(summed)
        sums = [dr.gather(jit.Float, summed, block + k * blocks) for k in range(len(parts))]
    return jit.Array3f(sums[1:]) / dr.maximum(sums[0], 1)


def _bell(means: Array, deviation: float, tiling: Tiling, edge: int, right: int, down: int) -> Array:
    """One pass over blocks, along rows or columns."""
    across, rows = -(-tiling.width // edge), -(-tiling.height // edge)
    reach = min(math.ceil(_TAILS * deviation), max(across, rows))
    fall = -0.5 / deviation**2
    whole = sum(math.exp(fall * k * k) for k in range(-reach, reach + 1))
    image, column, row = _places(dr.width(means), tiling, edge)

    def add(k: Array, total: Array) -> tuple[Array, Array]:
        x, y = dr.clip(column + right * k, 0, across - 1), dr.clip(row + down * k, 0, rows - 1)
        weight = dr.exp(fall * jit.Float(k * k)) / whole
        return k + 1, total + weight * dr.gather(jit.Array3f, means, _block(tiling, image, x, y, edge))

    start = (jit.Int32(-reach), dr.zeros(jit.Array3f, dr.width(means)))
    return dr.while_loop(start, lambda k, _: k <= reach, add, mode="symbolic")[1]


def _places(blocks: int, tiling: Tiling, edge: int) -> tuple[Array, Array, Array]:
    """Image `UInt32`, column and row `Int32` of each block."""
    first = pixels_at(tiling, _first_lane(dr.arange(jit.UInt32, blocks), edge))
    return first.image, jit.Int32(first.column // edge), jit.Int32(first.row // edge)


def _first_lane(block: Array, edge: int) -> Array:
    """`UInt32` lane of the upper left pixel of a block."""
    if edge >= SQUARE or edge == 1:
        return block * (edge * edge)
    across = SQUARE // edge
    square, within = block // (across * across), block % (across * across)
    return square * (SQUARE * SQUARE) + edge * (within // across * SQUARE + within % across)


def _block(tiling: Tiling, image: Array, column: Array, row: Array, edge: int) -> Array:
    """`UInt32` number of the block at (column, row) [blocks]."""
    column, row = jit.UInt32(column), jit.UInt32(row)
    lane = lane_at(tiling, image, column * edge, row * edge)
    if edge >= SQUARE or edge == 1:
        return lane // (edge * edge)
    across = SQUARE // edge
    return lane // (SQUARE * SQUARE) * (across * across) + row % across * across + column % across


def _between(means: Array, tiling: Tiling, where: Pixels, edge: int) -> Array:
    """Interpolated to every lane."""
    across, rows = -(-tiling.width // edge), -(-tiling.height // edge)
    x = dr.clip((jit.Float(where.column) + 0.5) / edge - 0.5, 0, across - 1)
    y = dr.clip((jit.Float(where.row) + 0.5) / edge - 0.5, 0, rows - 1)
    i, j = jit.UInt32(x), jit.UInt32(y)
    i1, j1 = dr.minimum(i + 1, across - 1), dr.minimum(j + 1, rows - 1)
    a, b = x - jit.Float(i), y - jit.Float(j)

    def at(column: Array, row: Array) -> Array:
        return dr.gather(jit.Array3f, means, _block(tiling, where.image, column, row, edge))

    return dr.lerp(dr.lerp(at(i, j), at(i1, j), a), dr.lerp(at(i, j1), at(i1, j1), a), b)

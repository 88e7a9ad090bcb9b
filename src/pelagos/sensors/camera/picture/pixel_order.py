"""The order of an image's rays: square tiles, so that neighbouring lanes look at neighbouring places.

Rays of one tile hit the same triangles, which the ray caster likes, and their sums are the coarse image that glow
and metering need. A lane is (image, tile, square of 4 x 4 in the tile, row, column); images whose size is no multiple
of a tile have idle lanes at their edge.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array

TILE: Final = 16  # pixels, each way
SQUARE: Final = 4  # of a tile's squares


@dataclass(frozen=True)
class Tiling:
    """Size of an image [px] and its tiles."""

    width: int
    height: int

    @property
    def across(self) -> int:
        """Tiles in a row."""
        return -(-self.width // TILE)

    @property
    def down(self) -> int:
        """Rows of tiles."""
        return -(-self.height // TILE)

    @property
    def tiles(self) -> int:
        """Tiles of an image."""
        return self.across * self.down

    @property
    def lanes(self) -> int:
        """Rays of an image, idle ones included."""
        return self.tiles * TILE * TILE

    def arrange(self, values: NDArray[np.float64]) -> NDArray[np.float32]:
        """`(height, width, ...)` -> `(lanes, ...)`; idle lanes repeat the edge."""
        rows, columns = self._places()
        return np.asarray(
            values[np.minimum(rows, self.height - 1), np.minimum(columns, self.width - 1)], dtype=np.float32
        )

    def _places(self) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        k = np.arange(self.lanes)
        tile, (column, row) = k // TILE**2, inner_place(k % TILE**2)
        return tile // self.across * TILE + row, tile % self.across * TILE + column


def inner_place(inner: Any) -> tuple[Any, Any]:
    """Column and row within a tile of its lane `inner`: squares of 4 x 4, which a caster of 16 rays at a time likes."""
    square, within = inner // 16, inner % 16
    return square % 4 * 4 + within % 4, square // 4 * 4 + within // 4


@jit.struct
class Pixels:
    """Pixel to which each lane of `images` images belongs, a Dr.Jit struct.

    Attributes:
        image: `UInt32`, which image.
        ray: `UInt32`, lane within its image.
        column, row: `UInt32` [px].
        active: `Bool`, not idle.
    """

    image: Array
    ray: Array
    column: Array
    row: Array
    active: Array


def pixels(tiling: Tiling, images: int) -> Pixels:
    """The lanes of `images` images."""
    return pixels_at(tiling, dr.arange(jit.UInt32, images * tiling.lanes))


def pixels_at(tiling: Tiling, lane: Array) -> Pixels:
    """Some of the lanes of images."""
    image = lane // tiling.lanes
    ray = lane - image * tiling.lanes
    tile, inner = ray // (TILE * TILE), ray % (TILE * TILE)
    inner_column, inner_row = inner_place(inner)
    column, row = tile % tiling.across * TILE + inner_column, tile // tiling.across * TILE + inner_row
    return Pixels(image, ray, column, row, (column < tiling.width) & (row < tiling.height))


def tile_means(values: list[Array], active: Array) -> list[Array]:
    """Means over the active lanes of each tile, `(images * tiles,)` each, `Array3f`; summed in fixed order."""
    parts = [jit.Float(1), *(c for v in values for c in v)]
    kept = dr.ravel(jit.ArrayXf([dr.select(active, part, 0) for part in parts]), order="C")  # one kernel, one sum
    sums = dr.block_sum(kept, TILE * TILE)
    dr.eval(sums)
    tiles = dr.width(active) // (TILE * TILE)
    tile = dr.arange(jit.UInt32, tiles)
    number, *means = (dr.gather(jit.Float, sums, tile + k * tiles) for k in range(len(parts)))
    return [jit.Array3f(means[k : k + 3]) / number for k in range(0, len(means), 3)]


def tile_sizes(tiling: Tiling, images: int) -> Array:
    """Pixels of each tile, idle lanes left out, `Float` `(images * tiles,)`."""
    tile = dr.arange(jit.UInt32, images * tiling.tiles) % tiling.tiles
    across = dr.minimum(tiling.width - tile % tiling.across * TILE, TILE)
    return jit.Float(across * dr.minimum(tiling.height - tile // tiling.across * TILE, TILE))


def image_means(values: Array, active: Array, tiling: Tiling) -> Array:
    """Mean over each image, `(images,)`."""
    tile_sums = dr.block_sum(dr.select(active, values, 0), TILE * TILE)
    return dr.block_sum(tile_sums, tiling.tiles) / (tiling.width * tiling.height)


def smooth_tiles(means: Array, tiling: Tiling, images: int) -> Array:
    """`Array3f` of tiles under a 3 x 3 tent, repeating the edge."""
    return tent(lambda tile: dr.gather(jit.Array3f, means, tile), tiling, images)


def tent(means: Callable[[Array], Array], tiling: Tiling, images: int) -> Array:
    """The same of what `means` gives for the number of a tile."""
    tile = dr.arange(jit.UInt32, images * tiling.tiles)
    image, inner = tile // tiling.tiles, tile % tiling.tiles
    x, y = jit.Int32(inner % tiling.across), jit.Int32(inner // tiling.across)
    total = jit.Array3f(0)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            cx, cy = dr.clip(x + a, 0, tiling.across - 1), dr.clip(y + b, 0, tiling.down - 1)
            source = image * tiling.tiles + jit.UInt32(cy * tiling.across + cx)
            total += (2 - abs(a)) * (2 - abs(b)) / 16 * means(source)
    return total


def between_tiles(means: Array, tiling: Tiling, where: Pixels) -> Array:
    """`Array3f` by tile, interpolated to every lane."""
    return tiles_at(means, tiling, where.image, jit.Float(where.column), jit.Float(where.row))


def tiles_at(means: Array, tiling: Tiling, image: Array, column: Array, row: Array, kind: Any = None) -> Array:
    """`Array3f` by tile, interpolated at any place (column, row) [px] of `image`; beyond the edge, that of the edge.

    With `kind` an array of that type, from one whose components lie side by side.
    """
    kind = kind or jit.Array3f
    x, y = (column + 0.5) / TILE - 0.5, (row + 0.5) / TILE - 0.5
    x, y = dr.clip(x, 0, tiling.across - 1), dr.clip(y, 0, tiling.down - 1)
    i, j = jit.UInt32(x), jit.UInt32(y)
    a, b = x - jit.Float(i), y - jit.Float(j)
    i1, j1 = dr.minimum(i + 1, tiling.across - 1), dr.minimum(j + 1, tiling.down - 1)
    base = image * tiling.tiles

    def at(tile_column: Array, tile_row: Array) -> Array:
        return dr.gather(kind, means, base + tile_row * tiling.across + tile_column)

    return dr.lerp(dr.lerp(at(i, j), at(i1, j), a), dr.lerp(at(i, j1), at(i1, j1), a), b)


def lane_at(tiling: Tiling, image: Array, column: Array, row: Array) -> Array:
    """`UInt32` lane of a pixel, the inverse of `pixels`."""
    tile = row // TILE * tiling.across + column // TILE
    x, y = column % TILE, row % TILE
    inner = (y // 4 * 4 + x // 4) * 16 + y % 4 * 4 + x % 4
    return image * tiling.lanes + tile * (TILE * TILE) + inner


def pixel_values_at(values: Array, tiling: Tiling, image: Array, column: Array, row: Array) -> Array:
    """`Float` by lane, interpolated at any place (column, row) [px]; beyond the edge, that of the edge."""
    x, y = dr.clip(column, 0, tiling.width - 1), dr.clip(row, 0, tiling.height - 1)
    i, j = jit.UInt32(x), jit.UInt32(y)
    a, b = x - jit.Float(i), y - jit.Float(j)
    i1, j1 = dr.minimum(i + 1, tiling.width - 1), dr.minimum(j + 1, tiling.height - 1)

    def at(c: Array, r: Array) -> Array:
        return dr.gather(jit.Float, values, lane_at(tiling, image, c, r))

    return dr.lerp(dr.lerp(at(i, j), at(i1, j), a), dr.lerp(at(i, j1), at(i1, j1), a), b)


def image_rows(values: Array, tiling: Tiling, where: Pixels, images: int) -> Array:
    """Lanes back to `(images, height, width)` flattened, `values` of any type."""
    out = dr.empty(type(values), images * tiling.width * tiling.height)  # all are written
    index = (where.image * tiling.height + where.row) * tiling.width + where.column
    dr.scatter(out, values, index, where.active)
    return out

"""Choice of tiles in a scene: fine ones near the places that are looked from, coarse ones elsewhere.

A tile of level l has `CELLS` x `CELLS` cells of the ground's spacing times 2^l. It is split in four where a place is
nearer than `reach[l]` times its edge (the larger of the distances along x and along y). Two tiles that touch differ by
one level at most: a tile that was not split lies at least reach[l] edges off; the mother of a tile two levels finer
lies within reach[l-1] half edges, is half an edge wide, and reach[l] >= (reach[l-1] + 1) / 2.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world.large.ground import Inset, LargeGround

CELLS: Final = 16
TRIANGLES: Final = 2 * CELLS * CELLS
_FAR: Final = 3.0  # reach of the levels that are far from the finest


@dataclass(frozen=True)
class Tiles:
    """Tiles of a level each.

    Attributes:
        level, i, j: `(t,)` int64; the tile covers nodes i CELLS .. (i + 1) CELLS of its level along x, and so along y.
    """

    level: NDArray[np.int64]
    i: NDArray[np.int64]
    j: NDArray[np.int64]

    def __len__(self) -> int:
        return len(self.level)


def top_level(ground: LargeGround) -> int:
    """The level at which one tile covers everything."""
    return max(0, int(np.ceil(np.log2(max(ground.cells) / CELLS) - 1e-9)))


def reaches(ground: LargeGround, detail: float) -> dict[int, float]:
    """For each level that can be split, the distance in edges within which it is; `detail` >= 1 at the finest."""
    found = {}
    for level in range(ground.finest + 1, top_level(ground) + 1):
        best = min(_FAR, detail)
        for first in {inset.level + 1 for inset in ground.insets} | {1}:
            if level >= first:
                best = max(best, 1 + (detail - 1) / 2.0 ** (level - first))
        found[level] = best
    return found


def leaves(ground: LargeGround, places: NDArray[np.float64], reach: Mapping[int, float]) -> Tiles:
    """The tiles for places `(f, 2)` [m], ordered by level and index."""
    at_level, at_i, at_j = [], [], []
    i, j = np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int64)
    for level in range(top_level(ground), ground.finest - 1, -1):
        edge = ground.spacing_at(level) * CELLS
        x = ground.x0 + i.astype(np.float64) * edge
        y = ground.y0 + j.astype(np.float64) * edge
        inside = (x < ground.x1) & (y < ground.y1)
        i, j, x, y = i[inside], j[inside], x[inside], y[inside]
        split = _near(x, y, edge, places, reach[level] * edge) if level in reach else np.zeros(len(i), dtype=bool)
        if level <= 0:
            split &= _beside(x, y, edge, [n for n in ground.insets if n.level < level])
        at_level.append(np.full(int((~split).sum()), level, dtype=np.int64))
        at_i.append(i[~split])
        at_j.append(j[~split])
        i = (2 * i[split][:, None] + np.array([0, 0, 1, 1])).ravel()
        j = (2 * j[split][:, None] + np.array([0, 1, 0, 1])).ravel()
    level_, i_, j_ = (np.concatenate(a) for a in (at_level, at_i, at_j))
    order = np.lexsort((j_, i_, level_))
    return Tiles(level_[order], i_[order], j_[order])


def _near(
    x: NDArray[np.float64], y: NDArray[np.float64], edge: float, places: NDArray[np.float64], limit: float
) -> NDArray[np.bool_]:
    middle = edge / 2
    near = np.zeros(len(x), dtype=bool)
    for px, py in places.tolist():
        away = np.maximum(np.abs(x + middle - px), np.abs(y + middle - py)) - middle
        near |= away < limit
    return near


def _beside(x: NDArray[np.float64], y: NDArray[np.float64], edge: float, insets: Sequence[Inset]) -> NDArray[np.bool_]:
    """Tiles nearer than their own edge to an inset: so that tiles that touch differ by one level there too."""
    near = np.zeros(len(x), dtype=bool)
    for inset in insets:
        low, high = inset.low, inset.high
        dx = np.maximum(low[0] - (x + edge), x - high[0])
        dy = np.maximum(low[1] - (y + edge), y - high[1])
        near |= np.maximum(dx, dy) < edge
    return near


def coarser_sides(tiles: Tiles) -> NDArray[np.int64]:
    """`(t,)` bits: 1, 2, 4, 8 where the neighbour at lower x, higher x, lower y, higher y is one level coarser."""
    known = {(int(a), int(b), int(c)) for a, b, c in zip(tiles.level, tiles.i, tiles.j, strict=True)}
    bits = np.zeros(len(tiles), dtype=np.int64)
    for row, (level, i, j) in enumerate(zip(tiles.level.tolist(), tiles.i.tolist(), tiles.j.tolist(), strict=True)):
        for bit, (di, dj) in enumerate(((-1, 0), (1, 0), (0, -1), (0, 1))):
            # a neighbour within the same mother is as fine or finer: only an outer side can border a coarser tile
            a, b = i + di, j + dj
            if (a >> 1, b >> 1) != (i >> 1, j >> 1) and (level + 1, a >> 1, b >> 1) in known:
                bits[row] |= 1 << bit
    return bits

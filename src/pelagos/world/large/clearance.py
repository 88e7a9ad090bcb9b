"""Clearance over a ground too large for one map: blocks of cells, filled when they are asked for."""

from __future__ import annotations

import math
from collections import OrderedDict
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world.large.ground import LargeGround

_BLOCK: Final = 8  # cells along the edge of a block, of the finest level in it
_BLOCKS: Final = 16  # blocks along the edge of what is looked at in one go
_KEPT: Final = 256


class GroundClearance:
    """Highest ground in each block of cells; conservative, as it takes every node of the block and of its rim."""

    def __init__(self, ground: LargeGround) -> None:
        self._ground = ground
        self._known: OrderedDict[tuple[int, int, int], NDArray[np.float64]] = OrderedDict()

    def near(self, position: NDArray[np.float64], margin: float | NDArray[np.float64]) -> NDArray[np.bool_]:
        """`(n,)`: whether the ground may be within `margin` [m] of positions `(n, 3)`; False is certain.

        What is not finite counts as near.
        """
        margins = np.broadcast_to(margin, (len(position),)).tolist()
        rows = zip(position.tolist(), margins, strict=True)
        return np.array([self._near(x, y, z, m) for (x, y, z), m in rows], dtype=bool)

    def _near(self, x: float, y: float, z: float, margin: float) -> bool:
        if not math.isfinite(x + y + z + margin):
            return True
        g = self._ground
        low = (max(x - margin, g.x0), max(y - margin, g.y0))
        high = (min(x + margin, g.x1), min(y + margin, g.y1))
        if low[0] > high[0] or low[1] > high[1]:
            return False
        # in an inset all of its detail counts; a sphere that is larger than its blocks asks the same of more of them
        levels = [n.level for n in g.insets if _overlap(n.low, n.high, low, high)]
        level = min(levels, default=0)
        edge = g.spacing_at(level) * _BLOCK
        i0, i1 = int((low[0] - g.x0) // edge), int((high[0] - g.x0) // edge)
        j0, j1 = int((low[1] - g.y0) // edge), int((high[1] - g.y0) // edge)
        if (i1 - i0) > 4 * _BLOCKS or (j1 - j0) > 4 * _BLOCKS:
            return True  # too wide to be worth it
        limit = z - margin
        for a in range(i0 // _BLOCKS, i1 // _BLOCKS + 1):
            for b in range(j0 // _BLOCKS, j1 // _BLOCKS + 1):
                tops = self._tops(level, a, b)
                rows = slice(max(i0 - a * _BLOCKS, 0), i1 - a * _BLOCKS + 1)
                columns = slice(max(j0 - b * _BLOCKS, 0), j1 - b * _BLOCKS + 1)
                if (tops[rows, columns] >= limit).any():
                    return True
        return False

    def _tops(self, level: int, a: int, b: int) -> NDArray[np.float64]:
        key = (level, a, b)
        found = self._known.get(key)
        if found is None:
            along = np.arange(_BLOCK * _BLOCKS + 1)
            i, j = np.broadcast_arrays((a * along[-1] + along)[:, None], (b * along[-1] + along)[None, :])
            z = self._ground.nodes(level, i, j)
            z = np.maximum(np.maximum(z[:-1, :-1], z[1:, :-1]), np.maximum(z[:-1, 1:], z[1:, 1:]))
            found = z.reshape(_BLOCKS, _BLOCK, _BLOCKS, _BLOCK).max(axis=(1, 3))
            self._known[key] = found
            if len(self._known) > _KEPT:
                self._known.popitem(last=False)
        self._known.move_to_end(key)
        return found


def _overlap(
    a_low: tuple[float, float], a_high: tuple[float, float], b_low: tuple[float, float], b_high: tuple[float, float]
) -> bool:
    return all(a_low[k] <= b_high[k] and b_low[k] <= a_high[k] for k in range(2))

"""The ground with its level of detail: nested square grids about a place, each twice as coarse as the one within."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

CELLS: Final = 64
"""Along the side of each grid; a multiple of 8, so that every grid leaves out the one within."""

Heights = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


@dataclass(frozen=True)
class Patch:
    """One grid, without the hole that the finer one fills.

    Attributes:
        level: 0 is the finest.
        corner: of its lowest cell, in cells of this level.
        vertices: `(v, 3)` [m].
        faces: `(f, 3)`.
    """

    level: int
    corner: tuple[int, int]
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]


@dataclass(frozen=True)
class NestedGrids:
    """Cuts a height field into patches.

    Attributes:
        height: of the ground at x, y [m]; NaN where there is none.
        bounds: `(2, 2)` lowest and highest x, y [m].
        cell_m: of the finest level [m].
    """

    height: Heights
    bounds: NDArray[np.float64]
    cell_m: float

    @property
    def levels(self) -> int:
        """As many as it takes to cover the world from any place in it."""
        size = float((self.bounds[1] - self.bounds[0]).max())
        return max(1, int(np.ceil(np.log2(max(2.0 * size / (CELLS * self.cell_m), 1.0)))) + 1)

    def corners(self, x: float, y: float) -> list[tuple[int, int]]:
        """Of every level about a place, in cells of each: a level moves by an eighth of its side."""
        found = []
        for level in range(self.levels):
            step = self.cell_m * 2**level
            snap = CELLS // 8
            cx, cy = (int(np.floor(v / step / snap + 0.5)) * snap - CELLS // 2 for v in (x, y))
            found.append((cx, cy))
        return found

    def patches(self, x: float, y: float, known: dict[int, tuple[object, ...]] | None = None) -> Iterator[Patch]:
        """The patches about a place; those that `known` has already are left out, and it is brought up to date."""
        kept = {} if known is None else known
        corners = self.corners(x, y)
        for level, corner in enumerate(corners):
            hole = None
            if level:
                inner = corners[level - 1]
                hole = (inner[0] // 2 - corner[0], inner[1] // 2 - corner[1])
            if kept.get(level) == (corner, hole):
                continue
            kept[level] = (corner, hole)
            yield self._patch(level, corner, hole)

    def _patch(self, level: int, corner: tuple[int, int], hole: tuple[int, int] | None) -> Patch:
        step = self.cell_m * 2**level
        index = np.arange(CELLS + 1)
        x, y = np.meshgrid((corner[0] + index) * step, (corner[1] + index) * step, indexing="ij")
        low, high = self.bounds
        inside = np.clip(x, low[0], high[0]), np.clip(y, low[1], high[1])
        z = np.asarray(self.height(*inside), dtype=np.float64)
        for along, edge in (
            (inside[1][0], z[0]), (inside[1][-1], z[-1]), (inside[0][:, 0], z[:, 0]), (inside[0][:, -1], z[:, -1])
        ):  # fmt: skip
            _stitch(along, edge)
        cells = np.ones((CELLS, CELLS), dtype=bool)
        corners = [z[:-1, :-1], z[1:, :-1], z[:-1, 1:], z[1:, 1:]]
        for c in corners:
            cells &= np.isfinite(c)
        x, y = inside
        cells &= (x[1:, :-1] > x[:-1, :-1]) & (y[:-1, 1:] > y[:-1, :-1])
        if hole is not None:
            i, j = hole
            half = CELLS // 2
            cells[max(i, 0) : max(i + half, 0), max(j, 0) : max(j + half, 0)] = False
        a = np.arange((CELLS + 1) ** 2, dtype=np.uint32).reshape(CELLS + 1, CELLS + 1)
        p, q, r, s = (v[cells] for v in (a[:-1, :-1], a[1:, :-1], a[1:, 1:], a[:-1, 1:]))
        faces = np.concatenate([np.stack([p, q, r], -1), np.stack([p, r, s], -1)])
        vertices = np.stack([x, y, np.nan_to_num(z)], axis=-1).reshape(-1, 3)
        used, places = np.unique(faces, return_inverse=True)
        return Patch(level, corner, vertices[used].astype(np.float32), places.reshape(-1, 3).astype(np.uint32))


def _stitch(along: NDArray[np.float64], z: NDArray[np.float64]) -> None:
    """Put every second node of an edge on the line of its neighbours, which the coarser grid around has there."""
    length = along[2::2] - along[:-2:2]
    part = np.divide(along[1:-1:2] - along[:-2:2], length, out=np.zeros_like(length), where=length > 0)
    z[1:-1:2] = z[:-2:2] + part * (z[2::2] - z[:-2:2])

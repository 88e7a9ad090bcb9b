"""Where nothing can be near: a coarse map of the highest thing in each cell, asked before any ray is cast."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.raycast.geometry import Geometry, PlacedGeometry

_MAX_CELLS: Final = 1024  # along either side
_CHUNK: Final = 1 << 18  # faces at a time: memory stays small
_SMALL: Final = 3  # cells that a face may span in the vectorised pass


class Clearance:
    """Highest z of anything static above each cell; conservative: it takes the bounding box of every triangle, or of a
    whole copy of a model.

    Attributes:
        cell: edge of a cell [m].
        top: `(cx, cy)` float64 [m]; -inf over cells with nothing.
        x0, y0: lower corner [m].
    """

    def __init__(self, geometries: Sequence[Geometry], *, cell: float = 4.0) -> None:
        solid = [g for g in geometries if len(g.faces)]
        corners = np.array([g.extent for g in solid]) if solid else np.zeros((1, 2, 3))
        low, high = corners[:, 0, :2].min(axis=0), corners[:, 1, :2].max(axis=0)
        self.cell = max(cell, float((high - low).max()) / (_MAX_CELLS - 1))
        self.x0, self.y0 = float(low[0]), float(low[1])
        shape = (int((high - low)[0] // self.cell) + 1, int((high - low)[1] // self.cell) + 1)
        self.top: NDArray[np.float64] = np.full(shape, -np.inf)
        for g, extent in zip(solid, corners, strict=False):
            if isinstance(g, PlacedGeometry):  # thousands of small things: the box around each of them is near enough
                first, last = (((c[:2] - low) // self.cell).astype(np.int32)[None] for c in extent)
                self._fill(first, last, extent[1, 2:])
                continue
            vertices = g.vertices
            cells = ((vertices[:, :2] - low) // self.cell).astype(np.int32)
            for start in range(0, len(g.faces), _CHUNK):
                faces = g.faces[start : start + _CHUNK]
                corners = cells[faces]  # (f, 3, 2)
                self._fill(corners.min(axis=1), corners.max(axis=1), vertices[:, 2][faces].max(axis=1))

    def _fill(self, first: NDArray[np.int32], last: NDArray[np.int32], top: NDArray[np.float64]) -> None:
        ny = self.top.shape[1]
        span = last - first
        small = (span < _SMALL).all(axis=1)
        flat = self.top.reshape(-1)
        for dx in range(_SMALL):
            for dy in range(_SMALL):
                here = small & (span[:, 0] >= dx) & (span[:, 1] >= dy)
                if here.any():
                    np.maximum.at(flat, (first[here, 0] + dx) * ny + first[here, 1] + dy, top[here])
        for (i0, j0), (i1, j1), z in zip(
            first[~small].tolist(), last[~small].tolist(), top[~small].tolist(), strict=True
        ):
            block = self.top[i0 : i1 + 1, j0 : j1 + 1]
            np.maximum(block, z, out=block)

    def near(self, position: NDArray[np.float64], margin: float) -> NDArray[np.bool_]:
        """`(n,)`: whether anything static may be within `margin` [m] of positions `(n, 3)`; False is certain."""
        if len(position) == 1:
            x, y, z = position[0].tolist()
            return np.array([self._near(x, y, z, margin)])
        low = np.floor((position[:, :2] - [self.x0, self.y0] - margin) / self.cell)
        high = np.floor((position[:, :2] - [self.x0, self.y0] + margin) / self.cell)
        reach = int((high - low).max(initial=0)) + 1
        limit = position[:, 2] - margin
        found = np.zeros(len(position), dtype=bool)
        for dx in range(reach):
            for dy in range(reach):
                i = np.minimum(low[:, 0] + dx, high[:, 0])
                j = np.minimum(low[:, 1] + dy, high[:, 1])
                on = (i >= 0) & (j >= 0) & (i < self.top.shape[0]) & (j < self.top.shape[1])
                cell = self.top[np.where(on, i, 0).astype(np.intp), np.where(on, j, 0).astype(np.intp)]
                found |= on & (cell >= limit)
        return found

    def _near(self, x: float, y: float, z: float, margin: float) -> bool:
        nx, ny = self.top.shape
        i0, i1 = int((x - margin - self.x0) // self.cell), int((x + margin - self.x0) // self.cell)
        j0, j1 = int((y - margin - self.y0) // self.cell), int((y + margin - self.y0) // self.cell)
        if i1 < 0 or j1 < 0 or i0 >= nx or j0 >= ny:
            return False
        block = self.top[max(i0, 0) : i1 + 1, max(j0, 0) : j1 + 1]
        return bool(block.max() >= z - margin)

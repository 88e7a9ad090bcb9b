"""Clearance map: the highest thing in each coarse cell, asked before any ray is cast."""

from __future__ import annotations

import math
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
        self._levels: dict[int, NDArray[np.float64]] = {}
        self._windows: list[NDArray[np.float64]] = [self.top]
        for g, extent in zip(solid, corners, strict=False):
            if isinstance(g, PlacedGeometry):  # thousands of small things: the box around each of them is near enough
                first, last = (((c[:2] - low) // self.cell).astype(np.int32)[None] for c in extent)
                self._fill(first, last, extent[1, 2:])
                continue
            vertices = g.vertices
            cells = ((vertices[:, :2] - low) // self.cell).astype(np.int32)
            for start in range(0, len(g.faces), _CHUNK):
                faces = g.faces[start : start + _CHUNK].T  # (3, f): three columns are soon compared, rows of three not
                at, height = cells[faces], vertices[:, 2][faces]
                self._fill(at.min(axis=0), at.max(axis=0), height.max(axis=0))

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

    def near(self, position: NDArray[np.float64], margin: float | NDArray[np.float64]) -> NDArray[np.bool_]:
        """`(n,)`: whether anything static may be within `margin` [m] of positions `(n, 3)`; False is certain.

        Of many positions, each looks at the highest thing around it in one of a few maps, whose reach is a power of two
        of cells: the time does not depend on the margin. Those that are near by that look again, at the cells that they
        reach and no others. What is not finite counts as near.
        """
        if len(position) == 1:
            x, y, z = position[0].tolist()
            return np.array([self._near(x, y, z, float(np.ravel(margin)[0]))])
        margins = np.broadcast_to(np.asarray(margin, dtype=np.float64), (len(position),))
        found = self._may_be_near(position, margins)
        again = np.flatnonzero(found)
        if len(again):
            again = again[np.isfinite(position[again]).all(axis=1) & np.isfinite(margins[again])]
            found[again] = self._highest_in(position[again], margins[again]) >= position[again, 2] - margins[again]
        return found

    def _highest_in(self, position: NDArray[np.float64], margins: NDArray[np.float64]) -> NDArray[np.float64]:
        """`(m,)` the highest thing in the cells within a margin of each position, by its coordinates; of the whole map,
        where that is wider.

        A rectangle that is at most one cell longer than wide is covered by four squares whose edge is a power of two.
        """
        at = (position[:, :2] - [self.x0, self.y0])[:, None] + margins[:, None, None] * np.array([[-1.0], [1.0]])
        first, last = np.floor(at / self.cell).transpose(1, 0, 2)  # (m, 2) cells
        span = (last - first).min(axis=1) + 1.0
        level = np.floor(np.log2(span)).astype(np.int64)
        highest = np.full(len(position), self.top.max())
        for k in np.unique(level):
            if 1 << int(k) > max(self.top.shape):
                continue
            edge, here = 1 << int(k), level == k
            windows = self._window(int(k))
            low, high = first[here], last[here] - (edge - 1)
            corners = [(a[:, 0], b[:, 1]) for a in (low, high) for b in (low, high)]
            highest[here] = np.max([_at(windows, i + (edge - 1), j + (edge - 1)) for i, j in corners], axis=0)
        return highest

    def _window(self, level: int) -> NDArray[np.float64]:
        """The highest thing in each square of 2^level cells that has a cell of `top`."""
        while len(self._windows) <= level:
            step = 1 << (len(self._windows) - 1)
            self._windows.append(_joined(_joined(self._windows[-1], step).T, step).T)
        return self._windows[level]

    def _may_be_near(self, position: NDArray[np.float64], margins: NDArray[np.float64]) -> NDArray[np.bool_]:
        reach = margins / self.cell
        widest = float(reach.max())
        if math.isfinite(widest + float(position.sum())) and widest < 2.0 * float(reach.mean()) + 1.0:
            highest = self._around(position, max(math.ceil(math.log2(max(widest, 1.0))), 0))
            return np.asarray(highest >= position[:, 2] - margins)
        level = np.where(reach > 1.0, np.ceil(np.log2(np.maximum(reach, 1.0))), 0.0)
        finite = np.isfinite(position).all(axis=1) & np.isfinite(level)
        found = ~finite
        for k in np.unique(level[finite]):
            here = finite & (level == k)
            highest = self._around(position[here], int(min(k, 64)))
            found[here] = highest >= position[here, 2] - margins[here]
        return found

    def _around(self, position: NDArray[np.float64], level: int) -> NDArray[np.float64]:
        """`(m,)` the highest thing within 2^level cells of each position, or of the whole map where that is wider."""
        reach = 1 << level
        if reach >= max(self.top.shape):
            return np.full(len(position), self.top.max())
        widened = self._widened(level)
        i, j = np.floor((position[:, :2] - [self.x0, self.y0]) / self.cell).T + reach
        return _at(widened, i, j)

    def _widened(self, level: int) -> NDArray[np.float64]:
        """The map of the highest thing within 2^level cells, which begins and ends so many cells beyond `top`."""
        if level not in self._levels:
            step = 1 if level == 0 else 1 << (level - 1)
            before = self.top if level == 0 else self._widened(level - 1)
            across = _highest(before, step, centre=level == 0)
            self._levels[level] = _highest(across.T, step, centre=level == 0).T
        return self._levels[level]

    def _near(self, x: float, y: float, z: float, margin: float) -> bool:
        if not math.isfinite(x + y + z + margin):
            return True
        nx, ny = self.top.shape
        i0, i1 = int((x - margin - self.x0) // self.cell), int((x + margin - self.x0) // self.cell)
        j0, j1 = int((y - margin - self.y0) // self.cell), int((y + margin - self.y0) // self.cell)
        if i1 < 0 or j1 < 0 or i0 >= nx or j0 >= ny:
            return False
        block = self.top[max(i0, 0) : i1 + 1, max(j0, 0) : j1 + 1]
        return bool(block.max() >= z - margin)


def _at(values: NDArray[np.float64], i: NDArray[np.float64], j: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values of a map at whole numbers; -inf beyond its edge."""
    on = (i >= 0) & (j >= 0) & (i < values.shape[0]) & (j < values.shape[1])
    at = np.where(on, i, 0).astype(np.intp), np.where(on, j, 0).astype(np.intp)
    return np.where(on, values[at], -np.inf)


def _joined(values: NDArray[np.float64], step: int) -> NDArray[np.float64]:
    """The higher of each row and that `step` further on; rows that begin before the first are `step` more."""
    made = np.full((len(values) + step, values.shape[1]), -np.inf)
    made[step:] = values
    np.maximum(made[: len(values)], values, out=made[: len(values)])
    return made


def _highest(values: NDArray[np.float64], step: int, *, centre: bool) -> NDArray[np.float64]:
    """The highest of the values `step` rows before and after, and of the row itself where `centre`; `step` rows more
    at both ends."""
    made = np.full((len(values) + 2 * step, values.shape[1]), -np.inf)
    made[: len(values)] = values
    np.maximum(made[2 * step :], values, out=made[2 * step :])
    if centre:
        np.maximum(made[step:-step], values, out=made[step:-step])
    return made

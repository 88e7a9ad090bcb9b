"""Ground of any size: one grid of heights for the whole, finer grids where they are wanted."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.world.generate.relief import smoothstep
from pelagos.world.large.source import Source
from pelagos.world.terrain import HeightField


@dataclass(frozen=True)
class Inset:
    """A rectangle with ground of its own.

    Attributes:
        low, high: corners (x, y) [m], on nodes of the ground's coarse grid.
        level: its spacing is the ground's times 2^level; negative.
        source: heights, or what is added to the ground around it.
        adds: the source is added to the heights below it.
        blend_m: width of the rim on which it fades into the ground around it [m].
        material: row of the ground's materials.
    """

    low: tuple[float, float]
    high: tuple[float, float]
    level: int
    source: Source
    adds: bool
    blend_m: float
    material: int = 0

    def holds(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.bool_]:
        """Mask of the places that lie in it, its edge included."""
        return (x >= self.low[0]) & (x <= self.high[0]) & (y >= self.low[1]) & (y <= self.high[1])

    def mixed(self, z: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heights with this inset laid over `z` at flat places `(k,)`."""
        here = self.holds(x, y)
        if not here.any():
            return z
        u, v = x[here], y[here]
        rim = np.minimum(np.minimum(u - self.low[0], self.high[0] - u), np.minimum(v - self.low[1], self.high[1] - v))
        weight = smoothstep(rim, 0.0, self.blend_m)
        own = self.source.heights(u, v)
        out = z.copy()
        below = z[here]
        out[here] = below + weight * (own if self.adds else np.where(np.isnan(own), 0.0, own - below))
        return out


@dataclass(frozen=True)
class LargeGround:
    """Ground of a large world; which part of it stands in a scene is `Stream`'s business.

    Attributes:
        x0, y0: place of node (0, 0) [m].
        cells: number of cells along x and y.
        spacing: of the coarse grid [m].
        source: its heights.
        insets: from the coarsest to the finest: the later lies on top.
        materials: rows of the world's table: the ground's own, then those of insets.
        label, instance: of all of it.
        triangles: that a scene may hold at most.
        reach: how far full resolution shall go around a vehicle [m]; as far as the triangles allow where infinite.
    """

    x0: float
    y0: float
    cells: tuple[int, int]
    spacing: float
    source: Source
    insets: Sequence[Inset]
    materials: tuple[int, ...]
    label: int
    instance: int
    triangles: int
    reach: float = np.inf

    @property
    def x1(self) -> float:
        """End along x [m]."""
        return self.x0 + self.cells[0] * self.spacing

    @property
    def y1(self) -> float:
        """End along y [m]."""
        return self.y0 + self.cells[1] * self.spacing

    @cached_property
    def finest(self) -> int:
        """The lowest level of any inset, or 0."""
        return min((i.level for i in self.insets), default=0)

    def spacing_at(self, level: int) -> float:
        """Between nodes of a level [m]."""
        return float(self.spacing * 2.0**level)

    def nodes(self, level: int, i: NDArray[np.int64], j: NDArray[np.int64]) -> NDArray[np.float64]:
        """Heights [m] at nodes of a level's grid, of equal shape; nodes outside stand on the edge."""
        shape, step = i.shape, self.spacing_at(level)
        x = np.clip(self.x0 + i.ravel() * step, self.x0, self.x1)
        y = np.clip(self.y0 + j.ravel() * step, self.y0, self.y1)
        z = self._coarse(x, y) if level < 0 else self.source.heights(x, y)
        for inset in self.insets:
            z = inset.mixed(z, x, y)
        return z.reshape(shape)

    def surface(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Height [m] of the ground's finest triangles at places of equal shape [m]; NaN outside."""
        return self._at_finest(x, y, flat=True)

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """As `surface`, bilinear between nodes."""
        return self._at_finest(x, y, flat=False)

    def level_at(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.int64]:
        """The finest level that there is at each place."""
        level = np.zeros(np.shape(x), dtype=np.int64)
        for inset in self.insets:
            level = np.where(inset.holds(x, y), np.minimum(level, inset.level), level)
        return level

    def _at_finest(self, x: ArrayLike, y: ArrayLike, *, flat: bool) -> NDArray[np.float64]:
        u, v = np.broadcast_arrays(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        shape, u, v = u.shape, u.ravel(), v.ravel()
        slack = 1e-9 * (1 + max(self.cells)) * self.spacing
        inside = (u >= self.x0 - slack) & (u <= self.x1 + slack) & (v >= self.y0 - slack) & (v <= self.y1 + slack)
        out = np.full(u.shape, np.nan)
        levels = self.level_at(u, v)
        for level in np.unique(levels[inside]).tolist():
            here = inside & (levels == level)
            out[here] = self._on_level(level, u[here], v[here], flat=flat)
        return out.reshape(shape)

    def _on_level(
        self, level: int, x: NDArray[np.float64], y: NDArray[np.float64], *, flat: bool
    ) -> NDArray[np.float64]:
        step = self.spacing_at(level)
        i, j = _snap((x - self.x0) / step), _snap((y - self.y0) / step)
        a = np.clip(np.floor(i), 0, round(self.cells[0] * 2.0**-level) - 1).astype(np.int64)
        b = np.clip(np.floor(j), 0, round(self.cells[1] * 2.0**-level) - 1).astype(np.int64)
        z00, z10, z01, z11 = self.nodes(level, a + np.array([[0], [1], [0], [1]]), b + np.array([[0], [0], [1], [1]]))
        p, q = np.clip(i - a, 0, 1), np.clip(j - b, 0, 1)
        if not flat:
            return np.asarray((z00 * (1 - p) + z10 * p) * (1 - q) + (z01 * (1 - p) + z11 * p) * q)
        more, less = np.maximum(p, q), np.minimum(p, q)
        return np.asarray(z00 * (1 - more) + np.where(p >= q, z10, z01) * (more - less) + z11 * less)

    def _coarse(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
        """Heights of the coarse grid's triangles, each of its nodes asked for once."""
        i, j = _snap((x - self.x0) / self.spacing), _snap((y - self.y0) / self.spacing)
        a = np.clip(np.floor(i), 0, self.cells[0] - 1).astype(np.int64)
        b = np.clip(np.floor(j), 0, self.cells[1] - 1).astype(np.int64)
        wide = self.cells[1] + 1
        keys = np.stack([a * wide + b, (a + 1) * wide + b, a * wide + b + 1, (a + 1) * wide + b + 1])
        known, where = np.unique(keys, return_inverse=True)
        at = known // wide, known % wide
        z = self.source.heights(self.x0 + at[0] * self.spacing, self.y0 + at[1] * self.spacing)
        z00, z10, z01, z11 = z[where.reshape(keys.shape)]
        p, q = i - a, j - b
        more, less = np.maximum(p, q), np.minimum(p, q)
        return np.asarray(z00 * (1 - more) + np.where(p >= q, z10, z01) * (more - less) + z11 * less)


@dataclass(frozen=True)
class Overview(HeightField):
    """The whole ground on a coarse grid, for maps; heights are asked of the ground itself.

    Attributes:
        ground: whose overview this is.
    """

    ground: LargeGround | None = None

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """See `LargeGround.height`."""
        assert self.ground is not None
        return self.ground.height(x, y)

    def surface(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """See `LargeGround.surface`."""
        assert self.ground is not None
        return self.ground.surface(x, y)


def _snap(index: NDArray[np.float64]) -> NDArray[np.float64]:
    """A place on a node must not fall beside it by rounding."""
    near = np.rint(index)
    return np.where(np.abs(index - near) < 1e-9 * (1 + np.abs(near)), near, index)

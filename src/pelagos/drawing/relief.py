"""The ground in a rectangle, seen from above: heights, what stands on it, and its shaded colours."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from matplotlib.colors import LightSource, Normalize
from numpy.typing import NDArray

from pelagos.drawing.colours import DEPTHS

PIXELS: Final = 520
"""Of a map's longer side."""
_STRUCTURE_M: Final = 0.4  # what stands this far above the ground is drawn as a structure
_STRUCTURE: Final = (0.30, 0.33, 0.36)


@dataclass(frozen=True)
class Relief:
    """The ground in a rectangle.

    Attributes:
        east, north: `(w,)`, `(h,)` [m].
        height: `(h, w)` [m]; NaN where there is no ground.
        structure: `(h, w)` bool: something stands on or above the ground there.
    """

    east: NDArray[np.float64]
    north: NDArray[np.float64]
    height: NDArray[np.float64]
    structure: NDArray[np.bool_]

    @property
    def extent(self) -> tuple[float, float, float, float]:
        """For `imshow`."""
        return float(self.east[0]), float(self.east[-1]), float(self.north[0]), float(self.north[-1])


def relief(world: Any, low: NDArray[np.float64], high: NDArray[np.float64], *, pixels: int = PIXELS) -> Relief:
    """The ground between two corners (x, y) NWU [m], and what stands on it, looked at from above."""
    step = float((high - low).max()) / pixels
    north = np.arange(low[0], high[0] + step / 2, step)
    east = np.arange(-high[1], -low[1] + step / 2, step)
    x, y = np.meshgrid(north, -east, indexing="ij")
    height = np.asarray(world.height(x, y))
    smooth = np.asarray(world.terrain.height(x, y)) if getattr(world, "terrain", None) is not None else height
    structure = np.zeros(height.shape, dtype=bool)
    if np.isfinite(height).any():
        above = float(np.asarray(world.bounds)[1, 2]) + 10.0
        origins = np.stack([x.ravel(), y.ravel(), np.full(x.size, above)], axis=-1)
        hits = world.cast(origins, np.array([0.0, 0.0, -1.0]), max_range=above - float(np.nanmin(height)) + 10.0)
        top = np.where(np.isfinite(hits.t), hits.position[:, 2], np.nan).reshape(height.shape)
        structure = np.nan_to_num(top - height) > _STRUCTURE_M
    return Relief(east, north, smooth, structure)


def depth_norm(height: NDArray[np.float64]) -> Normalize:
    """Colours for all but the outermost half per cent of heights [m]."""
    finite = height[np.isfinite(height)]
    if len(finite) == 0:
        return Normalize(-1.0, 0.0)
    low, high = (float(v) for v in np.percentile(finite, [0.5, 99.5]))
    return Normalize(low, min(max(high, low + 0.5), max(0.0, low + 0.5)))


def shaded(ground: Relief, norm: Normalize) -> NDArray[np.float64]:
    """`(h, w, 3)` colours 0 .. 1, the southernmost row first: depths, lit from the north-west; structures dark grey."""
    dx = abs(float(ground.east[1] - ground.east[0]))
    shade = LightSource(azdeg=315, altdeg=45)
    finite = np.isfinite(ground.height)
    filled = np.where(finite, ground.height, np.nanmean(ground.height) if finite.any() else 0.0)
    span = max(float(np.nanmax(filled) - np.nanmin(filled)), 1e-3)
    exaggeration = 0.12 * (ground.east[-1] - ground.east[0]) / span
    colours = DEPTHS(norm(filled))[..., :3]
    picture = shade.shade_rgb(colours, filled, blend_mode="soft", vert_exag=max(exaggeration, 1.0), dx=dx, dy=dx)
    picture = np.clip(0.15 + 0.85 * picture, 0, 1)
    picture[~finite] = 1.0
    picture[ground.structure] = _STRUCTURE
    return np.asarray(picture, dtype=np.float64)

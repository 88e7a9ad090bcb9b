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
_STEEPNESS: Final = 0.12  # of the whole relief over the width of a map, as it is lit
_FLAT: Final = 1e-6  # a ground whose cosines differ by less has no relief to show
_SUN: Final = LightSource(azdeg=315, altdeg=45)


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


@dataclass(frozen=True)
class Tone:
    """Colours and light of a ground; maps of one tone fit on one another, however near each is.

    Attributes:
        norm: heights [m] to colours.
        exaggeration: of heights, in the light.
        dark, bright: cosines between ground and light that are black and white.
    """

    norm: Normalize
    exaggeration: float
    dark: float
    bright: float


def tone_of(ground: Relief, norm: Normalize) -> Tone:
    """The tone in which a ground shows all its relief."""
    filled = _filled(ground)
    span = max(float(filled.max() - filled.min()), 1e-3)
    exaggeration = max(_STEEPNESS * (ground.east[-1] - ground.east[0]) / span, 1.0)
    lit = _lit(ground, filled, exaggeration)
    dark, bright = float(lit.min()), float(lit.max())
    return Tone(norm, exaggeration, *((dark, bright) if bright - dark > _FLAT else (0.0, 1.0)))


def shaded(ground: Relief, tone: Tone) -> NDArray[np.float64]:
    """`(h, w, 3)` colours 0 .. 1, the southernmost row first: depths, lit from the north-west; structures dark grey."""
    filled = _filled(ground)
    light = np.clip((_lit(ground, filled, tone.exaggeration) - tone.dark) / (tone.bright - tone.dark), 0, 1)
    picture = _SUN.blend_soft_light(DEPTHS(tone.norm(filled))[..., :3], light[..., None])
    picture = np.clip(0.15 + 0.85 * picture, 0, 1)
    picture[~np.isfinite(ground.height)] = 1.0
    picture[ground.structure] = _STRUCTURE
    return np.asarray(picture, dtype=np.float64)


def _filled(ground: Relief) -> NDArray[np.float64]:
    """Heights with their mean where there is no ground."""
    finite = np.isfinite(ground.height)
    return np.where(finite, ground.height, np.nanmean(ground.height) if finite.any() else 0.0)


def _lit(ground: Relief, height: NDArray[np.float64], exaggeration: float) -> NDArray[np.float64]:
    """Cosine between the ground's normal and the way to the light."""
    to_north, to_east = np.gradient(exaggeration * height, ground.north, ground.east)
    east, north, up = _SUN.direction
    return np.asarray((up - to_east * east - to_north * north) / np.sqrt(1 + to_east**2 + to_north**2))

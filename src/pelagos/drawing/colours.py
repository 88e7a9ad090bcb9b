"""Colour maps: even to the eye, and readable without seeing red and green apart."""

from __future__ import annotations

from typing import Final

import numpy as np
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap
from numpy.typing import ArrayLike, NDArray

DEPTHS: Final = LinearSegmentedColormap.from_list(
    "depths", ["#0b1f4b", "#11467f", "#1f78a8", "#45a5b5", "#8ccbb5", "#cfe6bd", "#f6f3cf"]
)
"""Deep to shallow."""
DIFFERENCE: Final = LinearSegmentedColormap.from_list(
    "difference", ["#2166ac", "#92c5de", "#f7f7f7", "#f4a582", "#b2182b"]
)
INTENSITY: Final = colormaps["viridis"]
HEAT: Final = colormaps["inferno"]


def painted(values: ArrayLike, low: float, high: float, colours: object = INTENSITY) -> NDArray[np.uint8]:
    """`(..., 3)` colours of values between `low` and `high`; black where a value is not finite."""
    v = np.asarray(values, dtype=np.float64)
    finite = np.isfinite(v)
    span = high - low if high > low else 1.0
    level = np.clip(np.where(finite, (v - low) / span, 0.0), 0.0, 1.0)
    table = np.asarray(colours(np.arange(256)))[:, :3]  # type: ignore[operator]
    out = np.round(255 * table).astype(np.uint8)[np.round(255 * level).astype(np.uint8)]
    out[~finite] = 0
    return np.asarray(out, dtype=np.uint8)


def display(albedo: ArrayLike) -> NDArray[np.float64]:
    """sRGB 0 .. 1 of linear reflectances `(..., 3)` as a screen shows them (IEC 61966-2-1)."""
    v = np.clip(np.asarray(albedo, dtype=np.float64), 0.0, 1.0)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)

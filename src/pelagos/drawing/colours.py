"""Colour maps: even to the eye, and readable without seeing red and green apart."""

from __future__ import annotations

from typing import Final

import numpy as np
from cmap import Colormap
from matplotlib import colormaps
from matplotlib.colors import LinearSegmentedColormap, to_hex
from numpy.typing import ArrayLike, NDArray

_SHADES: Final = 9


def cmocean(name: str, *, last: float = 1.0) -> LinearSegmentedColormap:
    """A map of cmocean (K. Thyng et al., Oceanography 29(3), 2016, doi:10.5670/oceanog.2016.66), up to a part of it.

    The package `cmap` has its numbers; `cmocean` itself warns with matplotlib 3.11.
    """
    table = Colormap(f"cmocean:{name}")(np.linspace(0.0, last, 256))
    return LinearSegmentedColormap.from_list(name, table)


DEPTHS: Final = cmocean("deep", last=0.86).reversed()
"""Deep to shallow, without the darkest part, which is black under shading."""
DIFFERENCE: Final = cmocean("balance")
INTENSITY: Final = colormaps["viridis"]
HEAT: Final = colormaps["inferno"]


def painted(values: ArrayLike, low: float, high: float, colours: object = INTENSITY) -> NDArray[np.uint8]:
    """`(..., 3)` colours of values between `low` and `high`; black where a value is not finite."""
    v = np.array(values, dtype=np.float64)
    lost = ~np.isfinite(v)
    v[lost] = low
    v -= low
    v /= high - low if high > low else 1.0
    np.clip(v, 0.0, 1.0, out=v)
    v *= 255
    level = np.round(v, out=v).astype(np.intp)
    level[lost] = 256
    table = np.zeros((257, 3), dtype=np.uint8)  # the last is black
    table[:256] = np.round(255 * np.asarray(colours(np.arange(256)))[:, :3])  # type: ignore[operator]
    return np.asarray(table.take(level, axis=0))


def display(albedo: ArrayLike) -> NDArray[np.float64]:
    """sRGB 0 .. 1 of linear reflectances `(..., 3)` as a screen shows them (IEC 61966-2-1)."""
    v = np.clip(np.asarray(albedo, dtype=np.float64), 0.0, 1.0)
    return np.where(v <= 0.0031308, 12.92 * v, 1.055 * v ** (1 / 2.4) - 0.055)


def shades(colours: LinearSegmentedColormap) -> list[str]:
    """A few colours of a map from low to high, "#rrggbb", for a bar of the page."""
    return [to_hex(c) for c in colours(np.linspace(0.0, 1.0, _SHADES))]

"""Polar sonar images as the eye wants them: range upwards from the sonar, beams as they lie."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def fan_image(
    polar: NDArray[np.floating], azimuth: NDArray[np.floating], ranges: NDArray[np.floating], *, height: int = 480,
    outside: float = np.nan,
) -> NDArray[np.float32]:  # fmt: skip
    """Resample a polar image `(beams, bins)` to a fan `(height, width)`, bilinearly.

    The sonar stands at the middle of the bottom edge and looks up; left is left. Pixels are
    square, max(range)/height [m].

    Args:
        polar: image by beam and range bin.
        azimuth: `(beams,)` [rad], positive to the left, evenly spaced, in either order.
        ranges: `(bins,)` middle of the bins [m], evenly spaced.
        height: pixels from the sonar to the far edge.
        outside: value of pixels outside of the sector.
    """
    beams, bins = polar.shape
    bin_width = float(ranges[1] - ranges[0]) if bins > 1 else float(ranges[0])
    far = float(ranges[-1]) + 0.5 * bin_width
    step = float(azimuth[1] - azimuth[0]) if beams > 1 else 1.0
    widest = min(float(np.max(np.abs(azimuth))) + 0.5 * abs(step), np.pi / 2)
    half = max(int(np.ceil(height * np.sin(widest))), 1)
    x = (height - 0.5 - np.arange(height))[:, None] * (far / height)  # ahead [m]
    y = (half - 0.5 - np.arange(2 * half))[None, :] * (far / height)  # to the left [m]
    r, a = np.hypot(x, y), np.arctan2(y, x)
    beam = (a - float(azimuth[0])) / step
    bin_ = (r - float(ranges[0])) / bin_width
    inside = (beam > -0.5) & (beam < beams - 0.5) & (bin_ > -0.5) & (bin_ < bins - 0.5)
    fan = bilinear(np.asarray(polar, dtype=np.float32), beam, bin_)
    return np.where(inside, fan, np.float32(outside))


def bilinear(
    image: NDArray[np.float32], row: NDArray[np.floating], column: NDArray[np.floating]
) -> NDArray[np.float32]:
    """Values of `image` at fractional places, clamped to its edges."""
    rows, columns = image.shape
    row, column = np.clip(row, 0, rows - 1), np.clip(column, 0, columns - 1)
    r0 = np.minimum(row.astype(np.intp), max(rows - 2, 0))
    c0 = np.minimum(column.astype(np.intp), max(columns - 2, 0))
    r1, c1 = np.minimum(r0 + 1, rows - 1), np.minimum(c0 + 1, columns - 1)
    fr, fc = (row - r0).astype(np.float32), (column - c0).astype(np.float32)
    top = image[r0, c0] * (1 - fc) + image[r0, c1] * fc
    bottom = image[r1, c0] * (1 - fc) + image[r1, c1] * fc
    return np.asarray(top * (1 - fr) + bottom * fr, dtype=np.float32)

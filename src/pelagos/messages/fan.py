"""Sonar images as a viewer wants them: a fan in shades of copper, quickly."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

HEIGHT: Final = 320  # pixels from the sonar to the far edge


class FanPreview:
    """Turns polar images `(beams, bins)` uint8 into fans `(height, width, 3)` uint8, bilinearly; right is right.

    Args:
        azimuth: `(beams,)` [rad], positive to the left, evenly spaced.
        first_m, last_m: near edge of the first bin and far edge of the last [m].
        bins: range bins.
        height: pixels from the sonar to the far edge.
    """

    def __init__(
        self, azimuth: NDArray[np.float64], first_m: float, last_m: float, bins: int, *, height: int = HEIGHT
    ) -> None:
        from scipy.sparse import csr_array  # a tenth of the time that all imports take

        beams = len(azimuth)
        step = float(azimuth[1] - azimuth[0]) if beams > 1 else 1.0
        widest = min(float(np.abs(azimuth).max()) + 0.5 * abs(step), np.pi / 2)
        half = max(int(np.ceil(height * np.sin(widest))), 8)
        ahead = (height - 0.5 - np.arange(height))[:, None] * (last_m / height)
        left = (half - 0.5 - np.arange(2 * half))[None, :] * (last_m / height)
        beam = (np.arctan2(left, ahead) - float(azimuth[0])) / step
        place = (np.hypot(ahead, left) - first_m) / (last_m - first_m) * bins - 0.5
        self._shape = beam.shape
        inside = (beam > -0.5) & (beam < beams - 0.5) & (place > -0.5) & (place < bins - 0.5)
        b = np.clip(beam[inside], 0, beams - 1)
        r = np.clip(place[inside], 0, bins - 1)
        b0, r0 = np.minimum(b.astype(np.int32), max(beams - 2, 0)), np.minimum(r.astype(np.int32), max(bins - 2, 0))
        b1, r1 = np.minimum(b0 + 1, beams - 1), np.minimum(r0 + 1, bins - 1)
        fb, fr = (b - b0).astype(np.float32), (r - r0).astype(np.float32)
        cells = np.stack([b0 * bins + r0, b0 * bins + r1, b1 * bins + r0, b1 * bins + r1], axis=-1)
        weights = np.stack([(1 - fb) * (1 - fr), (1 - fb) * fr, fb * (1 - fr), fb * fr], axis=-1)
        first = np.zeros(self._shape[0] * self._shape[1] + 1, dtype=np.int32)  # pixels outside have no weights
        np.cumsum(4 * inside.ravel(), out=first[1:])
        self._pixels = csr_array((weights.ravel(), cells.ravel(), first), shape=(len(first) - 1, beams * bins))
        self._colours = copper()

    def __call__(self, polar: NDArray[np.uint8]) -> NDArray[np.uint8]:
        """The fan of one image."""
        level = self._pixels @ polar.ravel().astype(np.float32)
        level += np.float32(0.5)
        return np.asarray(self._colours.take(level.astype(np.uint8), axis=0).reshape(*self._shape, 3))


def copper() -> NDArray[np.uint8]:
    """`(256, 3)` colours from black through copper to near white; level 0 is black."""
    x = np.linspace(0.0, 1.0, 256)
    red = np.clip(1.35 * x, 0, 1)
    green = np.clip(0.78 * x + 0.22 * x**4, 0, 1)
    blue = np.clip(0.42 * x + 0.45 * x**5, 0, 1)
    return np.asarray(np.round(255 * np.stack([red, green, blue], axis=-1)), dtype=np.uint8)

"""Dispersion relation of surface waves. NumPy; run once."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pelagos.math.constants import GRAVITY

Values = NDArray[np.float64]


def wavenumber(omega: Values, depth: float | None) -> Values:
    """k [1/m] of waves of angular frequency omega [rad/s] in water of `depth` [m] (None: deep), omega^2 = g k tanh(k
    h).
    """
    deep = omega**2 / GRAVITY
    if depth is None:
        return deep
    x0 = np.maximum(deep * depth, 1e-300)
    x = x0 / np.sqrt(np.tanh(x0))
    for _ in range(30):  # Newton, quadratic from a start within 5 %
        th = np.tanh(x)
        x = np.maximum(x - (x * th - x0) / (th + x * (1 - th * th)), 1e-150)
    return np.asarray(x / depth)

"""Wave spectra S(f) [m^2/Hz] of the surface elevation, and the dispersion relation. NumPy; run once, when the sea is
made.

Sources: K. Hasselmann et al., Ergaenzungsheft zur Deutschen Hydrographischen Zeitschrift A8(12), 1973 (JONSWAP);
DNV-RP-C205 (2021), Section 3.5 (its form by significant height and peak period). Heights fix the energy: shapes are
scaled numerically.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from pelagos.math.constants import GRAVITY


def jonswap(f: NDArray[np.float64], height: float, period: float, gamma: float = 3.3) -> NDArray[np.float64]:
    """JONSWAP spectrum of significant height [m] and peak period [s] at frequencies f [Hz]; gamma 1 is
    Pierson-Moskowitz.
    """
    grid = np.linspace(0.2 / period, 60.0 / period, 60_000)
    shape = _jonswap_shape(grid, period, gamma)
    tail = period**-4 * grid[-1] ** -4 / 4  # shape ~ Tp^-4 f^-5 beyond the grid
    m0 = float(np.trapezoid(shape, grid)) + tail
    scaled: NDArray[np.float64] = (height / 4) ** 2 / m0 * _jonswap_shape(f, period, gamma)
    return scaled


def _jonswap_shape(f: NDArray[np.float64], period: float, gamma: float) -> NDArray[np.float64]:
    fp = 1 / period
    with np.errstate(over="ignore", under="ignore", divide="ignore"):
        sigma = np.where(f <= fp, 0.07, 0.09)
        peak = np.exp(-0.5 * ((f - fp) / (sigma * fp)) ** 2)
        shape = period**-4 * f**-5.0 * np.exp(-1.25 * (fp / f) ** 4) * gamma**peak
    return np.where(f > 0, shape, 0.0)


def wavenumber(omega: NDArray[np.float64], depth: float | None) -> NDArray[np.float64]:
    """k [1/m] of waves of angular frequency omega [rad/s] in water of `depth` [m] (None: deep), omega^2 = g k tanh(k
    h).
    """
    deep = omega**2 / GRAVITY
    if depth is None:
        return deep
    x0 = deep * depth
    x = x0 / np.sqrt(np.tanh(np.maximum(x0, 1e-300)))
    for _ in range(30):  # Newton; quadratic from a start within 5 %
        th = np.tanh(x)
        x = np.maximum(x - (x * th - x0) / (th + x * (1 - th * th)), 1e-12)
    return np.asarray(x / depth)

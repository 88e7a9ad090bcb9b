"""Wave spectra S(f) [m^2/Hz] of the surface's elevation, and spreading. NumPy; run once.

Where a significant height is given it fixes the energy: shapes are scaled numerically, not by the usual closed forms,
which are up to 2 % off.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.constants import GRAVITY
from pelagos.math.dispersion import wavenumber

Values = NDArray[np.float64]

SEA_STATES: Final[dict[int, tuple[float, float]]] = {
    0: (0.0, 1.0), 1: (0.05, 2.0), 2: (0.3, 7.5), 3: (0.88, 7.5), 4: (1.88, 8.8), 5: (3.25, 9.7), 6: (5.0, 12.4),
    7: (7.5, 15.0), 8: (11.5, 16.4), 9: (14.0, 20.0),
}  # fmt: skip
"""Significant height [m] and most probable peak period [s] by sea state, North Atlantic, annual: NATO STANAG 4194, as
in O. M. Faltinsen, Sea Loads on Ships and Offshore Structures (1990), Table 2.2. The period of state 1 and the height
of 9, "over 14 m", are assumed."""


def pierson_moskowitz(f: Values, wind: float) -> Values:
    """Fully developed sea for the wind speed 19.5 m above the surface [m/s].

    W. J. Pierson and L. Moskowitz, J. Geophys. Res. 69:5181 (1964), doi 10.1029/JZ069i024p05181: alpha 0.0081, beta
    0.74.
    """
    omega = 2 * math.pi * np.maximum(f, 1e-9)
    with np.errstate(under="ignore"):
        return 2 * math.pi * 0.0081 * GRAVITY**2 / omega**5 * np.exp(-0.74 * (GRAVITY / (wind * omega)) ** 4)


def pierson_moskowitz_peak(wind: float) -> float:
    """Peak period [s] of `pierson_moskowitz`."""
    return float(2 * math.pi * wind / (0.8 * 0.74) ** 0.25 / GRAVITY)


def jonswap(f: Values, height: float, period: float, gamma: float = 3.3) -> Values:
    """JONSWAP of significant height [m] and peak period [s]; gamma 1 has the Pierson-Moskowitz shape.

    K. Hasselmann et al., Ergaenzungsheft zur Deutschen Hydrographischen Zeitschrift A8(12), 1973.
    """
    return _of_height(lambda x: _jonswap_shape(x, gamma), f, height, period)


def tma(f: Values, height: float, period: float, gamma: float, depth: float) -> Values:
    """JONSWAP in water of `depth` [m], scaled to the height that is given.

    E. Bouws et al., J. Geophys. Res. 90:975 (1985), doi 10.1029/JC090iC01p00975; the factor after S. A.
    Kitaigorodskii et al., J. Phys. Oceanogr. 5:410 (1975).
    """

    def shape(x: Values) -> Values:
        kh = wavenumber(2 * math.pi * np.maximum(x, 1e-9) / period, depth) * depth
        factor = np.tanh(kh) ** 2 / (1 + 2 * kh / np.sinh(np.minimum(2 * kh, 700.0)))
        return _jonswap_shape(x, gamma) * factor

    return _of_height(shape, f, height, period)


def ochi_hubble(f: Values, height: float, period: float, sharpness: float) -> Values:
    """One peak of M. K. Ochi and E. N. Hubble, "Six-parameter wave spectra", Proc. 15th Coastal Eng. Conf. (1976), p.
    301.

    sharpness: lambda; 1 is Pierson-Moskowitz, swell is 3 or more.
    """
    c = sharpness + 0.25
    x = np.maximum(f, 1e-9) * period
    with np.errstate(under="ignore", over="ignore"):
        shape = c**sharpness / math.gamma(sharpness) * x ** -(4 * sharpness + 1) * np.exp(-c * x**-4.0)
    return np.asarray(height**2 / 4 * period * shape)


@dataclass(frozen=True)
class Peak:
    """One system of a double-peaked sea: significant height [m], peak period [s], peak enhancement."""

    height: float
    period: float
    gamma: float


def torsethaugen_peaks(height: float, period: float) -> tuple[Peak, Peak]:
    """Primary and secondary system of a North Sea spectrum of significant height [m] and peak period [s].

    Shorter periods than that of the fully developed sea (6.6 Hs^(1/3), a fetch of 370 km) are mostly wind sea, longer
    ones mostly swell. K. Torsethaugen and S. Haver, "Simplified double peak spectral model for ocean waves", Proc. 14th
    ISOPE (2004), Vol. III, p. 76, Table 1; fitted to heights up to 11 m and periods up to 20 s.
    """
    developed = 6.6 * height ** (1 / 3)
    steepness = 2 * math.pi / GRAVITY
    if period <= developed:
        shortest = 2.0 * math.sqrt(height)
        e = (developed - period) / (developed - shortest) if developed > shortest else 0.0
        share = 0.7 + 0.3 * math.exp(-((e / 0.5) ** 2))
        gamma = 35.0 * (steepness * share * height / period**2) ** (6 / 7)
        second = Peak(math.sqrt(1 - share**2) * height, developed + 2.0, 1.0)
    else:
        e = (period - developed) / max(25.0 - developed, 1e-9)
        share = 0.6 + 0.4 * math.exp(-((e / 0.3) ** 2))
        gamma = 35.0 * (steepness * height / developed**2) ** (6 / 7) * (1 + 6.0 * e)
        rest = math.sqrt(1 - share**2) * height
        second = Peak(rest, 6.6 * rest ** (1 / 3), 1.0)
    return Peak(share * height, period, max(gamma, 1.0)), second


def torsethaugen(f: Values, height: float, period: float) -> Values:
    """Swell and wind sea of the North Sea in one spectrum, see `torsethaugen_peaks`; the tail falls as f^-4."""
    total = np.zeros_like(np.asarray(f, dtype=np.float64))
    for peak in torsethaugen_peaks(height, period):
        if peak.height > 1e-9 * height:
            total += _of_height(partial(_slow_tail_shape, gamma=peak.gamma), f, peak.height, peak.period)
    return total


def _slow_tail_shape(x: Values, gamma: float) -> Values:
    """Over x = f / fp: x^-4 exp(-x^-4), with JONSWAP's enhancement."""
    with np.errstate(over="ignore", under="ignore", divide="ignore", invalid="ignore"):
        sigma = np.where(x <= 1, 0.07, 0.09)
        shape = x**-4.0 * np.exp(-(x**-4.0)) * gamma ** np.exp(-0.5 * ((x - 1) / sigma) ** 2)
    return np.where(x > 0, shape, 0.0)


def _of_height(shape: Callable[[Values], Values], f: Values, height: float, period: float) -> Values:
    """A shape over f / fp, scaled to a significant height."""
    from scipy.integrate import trapezoid

    x = np.concatenate([np.linspace(0.2, 4.0, 40_001), np.geomspace(4.0, 400.0, 4_001)[1:]])
    m0 = float(trapezoid(shape(x), x)) / period
    return np.asarray((height / 4) ** 2 / m0 * shape(f * period))


def _jonswap_shape(x: Values, gamma: float) -> Values:
    """Over x = f / fp."""
    with np.errstate(over="ignore", under="ignore", divide="ignore", invalid="ignore"):
        sigma = np.where(x <= 1, 0.07, 0.09)
        shape = x**-5.0 * np.exp(-1.25 * x**-4.0) * gamma ** np.exp(-0.5 * ((x - 1) / sigma) ** 2)
    return np.where(x > 0, shape, 0.0)


def cos2s(angle: Values, exponent: float) -> Values:
    """Spreading cos^2s(angle / 2), normalised to an integral of 1 over the circle [1/rad].

    M. S. Longuet-Higgins, D. E. Cartwright and N. D. Smith, in Ocean Wave Spectra (1963), p. 111.
    """
    factor = math.exp(math.lgamma(exponent + 1) - math.lgamma(exponent + 0.5)) / (2 * math.sqrt(math.pi))
    return np.asarray(factor * np.abs(np.cos(angle / 2)) ** (2 * exponent))

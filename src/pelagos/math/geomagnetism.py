"""The Earth's main magnetic field: the International Geomagnetic Reference Field, 14th generation, epoch 2025.0.

Coefficients: IAGA Working Group V-MOD, IGRF-14 (2024), doi 10.5281/zenodo.14012302. Equations: P. Alken et al., Earth
Planets Space 73:49 (2021), doi 10.1186/s40623-020-01288-x, equation 1. The crust adds some 100 nT, a steel quay far
more.
"""

from __future__ import annotations

import math
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.geodesy import WGS84_A, WGS84_F

RADIUS_M: Final = 6_371_200.0  # reference sphere of the coefficients

_G: Final = (  # nT, row n = 1 .. 13, column m = 0 .. n
    (-29350.0, -1410.3),
    (-2556.2, 2950.9, 1648.7),
    (1360.9, -2404.2, 1243.8, 453.4),
    (894.7, 799.6, 55.8, -281.1, 12.0),
    (-232.9, 369.0, 187.2, -138.7, -141.9, 20.9),
    (64.3, 63.8, 76.7, -115.7, -40.9, 14.9, -60.8),
    (79.6, -76.9, -8.8, 59.3, 15.8, 2.5, -11.2, 14.3),
    (23.1, 10.9, -17.5, 2.0, -21.8, 16.9, 14.9, -16.8, 1.0),
    (4.7, 8.0, 3.0, -0.2, -2.5, -13.1, 2.4, 8.6, -8.7, -12.8),
    (-1.3, -6.4, 0.2, 2.0, -1.0, -0.5, -0.9, 1.5, 0.9, -2.6, -3.9),
    (3.0, -1.4, -2.5, 2.4, -0.6, 0.0, -0.6, -0.1, 1.1, -1.0, -0.1, 2.6),
    (-2.0, -0.1, 0.4, 1.2, -1.2, 0.6, 0.5, 0.5, -0.1, -0.5, -0.2, -1.2, -0.7),
    (0.2, -0.9, 0.6, 0.7, -0.2, 0.5, 0.1, 0.7, 0.0, 0.3, 0.2, 0.4, -0.5, -0.4),
)
_H: Final = (
    (0.0, 4545.5),
    (0.0, -3133.6, -814.2),
    (0.0, -56.9, 237.6, -549.6),
    (0.0, 278.6, -134.0, 212.0, -375.4),
    (0.0, 45.3, 220.0, -122.9, 42.9, 106.2),
    (0.0, -18.4, 16.8, 48.9, -59.8, 10.9, 72.8),
    (0.0, -48.9, -14.4, -1.0, 23.5, -7.4, -25.1, -2.2),
    (0.0, 7.2, -12.6, 11.5, -9.7, 12.7, 0.7, -5.2, 3.9),
    (0.0, -24.8, 12.1, 8.3, -3.4, -5.3, 7.2, -0.6, 0.8, 9.8),
    (0.0, 3.3, 0.1, 2.5, 5.4, -9.0, 0.4, -4.2, -3.8, 0.9, -9.0),
    (0.0, 0.0, 2.8, -0.6, 0.1, 0.5, -0.3, -1.2, -1.7, -2.9, -1.8, -2.3),
    (0.0, -1.2, 0.6, 1.0, -1.5, 0.0, 0.6, -0.2, 0.8, 0.1, -0.9, 0.1, 0.2),
    (0.0, -0.9, 0.7, 1.2, -0.3, -1.3, -0.1, 0.2, -0.2, 0.5, 0.6, -0.6, -0.3, -0.5),
)


def earth_field(
    latitude_deg: float, longitude_deg: float, *, height_m: float = 0.0, degree: int = 13
) -> NDArray[np.float64]:
    """Magnetic flux density at a place, `(3,)` NWU [T].

    Args:
        latitude_deg, longitude_deg: geodetic, WGS 84 [deg].
        height_m: above the ellipsoid [m].
        degree: highest degree of the harmonics; 1 is the tilted dipole.
    """
    latitude = math.radians(min(max(latitude_deg, -89.999999), 89.999999))
    r, geocentric = _geocentric(latitude, height_m)
    theta, phi = math.pi / 2 - geocentric, math.radians(longitude_deg)
    s, c = math.sin(theta), math.cos(theta)
    p = _schmidt(s, c, degree)
    radial = colatitudinal = eastward = 0.0
    for n in range(1, degree + 1):
        scale = (RADIUS_M / r) ** (n + 2)
        for m in range(n + 1):
            g, h = _G[n - 1][m], _H[n - 1][m]
            wave = g * math.cos(m * phi) + h * math.sin(m * phi)
            slope = (n * c * p[n, m] - math.sqrt(n * n - m * m) * p[n - 1, m]) / s  # d p / d theta
            radial += scale * (n + 1) * wave * p[n, m]
            colatitudinal -= scale * wave * slope
            eastward += scale * m * (g * math.sin(m * phi) - h * math.cos(m * phi)) * p[n, m] / s
    tilt = latitude - geocentric
    north = -colatitudinal * math.cos(tilt) - radial * math.sin(tilt)
    up = radial * math.cos(tilt) - colatitudinal * math.sin(tilt)
    return 1e-9 * np.array([north, -eastward, up])


def _geocentric(latitude: float, height: float) -> tuple[float, float]:
    """Distance from the centre [m] and geocentric latitude [rad]."""
    e2 = WGS84_F * (2 - WGS84_F)
    normal = WGS84_A / math.sqrt(1 - e2 * math.sin(latitude) ** 2)
    out = (normal + height) * math.cos(latitude)
    up = (normal * (1 - e2) + height) * math.sin(latitude)
    return math.hypot(out, up), math.atan2(up, out)


def _schmidt(s: float, c: float, degree: int) -> NDArray[np.float64]:
    """Schmidt semi-normalised Legendre functions of cos(theta), `(degree + 1, degree + 1)`; zero where m > n."""
    p = np.zeros((degree + 1, degree + 1))
    p[0, 0] = 1.0
    for n in range(1, degree + 1):
        p[n, n] = s * p[n - 1, n - 1] * (1.0 if n == 1 else math.sqrt(1 - 0.5 / n))
        for m in range(n):
            before = math.sqrt((n - 1) ** 2 - m * m) * p[n - 2, m] if m < n - 1 else 0.0
            p[n, m] = ((2 * n - 1) * c * p[n - 1, m] - before) / math.sqrt(n * n - m * m)
    return p

"""Between latitude and longitude on WGS 84 and the world's own metres (x north, y west, z up), without any library.

The map is the transverse Mercator projection about the origin, scale 1 there: on it z stays the height above the sea
however far one goes, which a plane that touches the ellipsoid cannot do (79 m in 31 km). Distances are true to
(d / 9000 km)^2 / 2 at distance d [km] east or west of the origin: 0.8 mm in 1 km at 11 km, 6 cm in 1 km at 100 km.

Source: C. F. F. Karney, "Transverse Mercator with an accuracy of a few nanometers", J. Geodesy 85 (2011) 475-485,
doi 10.1007/s00190-011-0445-3: Kruger's series to sixth order (Eqs. 35 and 36), conformal latitude (Eqs. 7-9, 19-21).
Valid within 35 degrees of longitude from the origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

WGS84_A: Final = 6378137.0
"""Equatorial radius [m]."""
WGS84_F: Final = 1 / 298.257223563
"""Flattening."""

_N: Final = WGS84_F / (2 - WGS84_F)
_E2: Final = WGS84_F * (2 - WGS84_F)
_E: Final = float(np.sqrt(_E2))
_A1: Final = WGS84_A / (1 + _N) * (1 + _N**2 / 4 + _N**4 / 64 + _N**6 / 256)  # Eq. 14


def _series(rows: tuple[tuple[float, ...], ...]) -> tuple[float, ...]:
    """Coefficients of sin 2j: row j holds the factors of n^j, n^(j+1), ..."""
    return tuple(sum(c * _N ** (j + k) for k, c in enumerate(row)) for j, row in enumerate(rows, start=1))


_ALPHA: Final = _series((
    (1 / 2, -2 / 3, 5 / 16, 41 / 180, -127 / 288, 7891 / 37800),
    (13 / 48, -3 / 5, 557 / 1440, 281 / 630, -1983433 / 1935360),
    (61 / 240, -103 / 140, 15061 / 26880, 167603 / 181440),
    (49561 / 161280, -179 / 168, 6601661 / 7257600),
    (34729 / 80640, -3418889 / 1995840),
    (212378941 / 319334400,),
))  # fmt: skip
_BETA: Final = _series((
    (1 / 2, -2 / 3, 37 / 96, -1 / 360, -81 / 512, 96199 / 604800),
    (1 / 48, 1 / 15, -437 / 1440, 46 / 105, -1118711 / 3870720),
    (17 / 480, -37 / 840, -209 / 4480, 5569 / 90720),
    (4397 / 161280, -11 / 504, -830251 / 7257600),
    (4583 / 161280, -108847 / 3991680),
    (20648693 / 638668800,),
))  # fmt: skip


@dataclass(frozen=True)
class GeoOrigin:
    """Place of the world's origin on Earth.

    Attributes:
        latitude: WGS 84 [deg], north positive, -90 .. 90.
        longitude: WGS 84 [deg], east positive, -180 .. 180.
    """

    latitude: float
    longitude: float

    def to_geodetic(self, position: NDArray[np.float64]) -> NDArray[np.float64]:
        """World NWU `(..., 3)` [m] -> (latitude [deg], longitude [deg], height above the mean sea surface [m])."""
        lat, lon = self.to_latlon(position[..., 0], position[..., 1])
        return np.stack([lat, lon, np.broadcast_to(position[..., 2], lat.shape)], axis=-1)

    def to_nwu(self, geodetic: NDArray[np.float64]) -> NDArray[np.float64]:
        """(latitude [deg], longitude [deg], height [m]) `(..., 3)` -> world NWU `(..., 3)` [m]."""
        x, y = self.to_xy(geodetic[..., 0], geodetic[..., 1])
        return np.stack([x, y, np.broadcast_to(geodetic[..., 2], x.shape)], axis=-1)

    def to_latlon(self, x: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """World x north, y west [m] -> (latitude, longitude) [deg]."""
        xi = np.asarray(x, dtype=np.float64) / _A1 + _meridian(self.latitude)
        eta = -np.asarray(y, dtype=np.float64) / _A1
        z = xi + 1j * eta
        w = z - sum(b * np.sin(2 * j * z) for j, b in enumerate(_BETA, start=1))  # Eq. 11 in complex form
        xi_, eta_ = w.real, w.imag
        conformal = np.sin(xi_) / np.hypot(np.sinh(eta_), np.cos(xi_))  # Eq. 18
        longitude = np.arctan2(np.sinh(eta_), np.cos(xi_))
        latitude = np.degrees(np.arctan(_tan_from_conformal(conformal)))
        return latitude, _wrap(np.degrees(longitude) + self.longitude)

    def to_xy(self, latitude: ArrayLike, longitude: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(latitude, longitude) [deg] -> world x north, y west [m]."""
        tau = np.tan(np.radians(np.asarray(latitude, dtype=np.float64)))
        away = np.radians(_wrap(np.asarray(longitude, dtype=np.float64) - self.longitude))
        conformal = _conformal_tan(tau)
        xi_ = np.arctan2(conformal, np.cos(away))  # Eq. 10
        eta_ = np.arcsinh(np.sin(away) / np.hypot(conformal, np.cos(away)))
        w = xi_ + 1j * eta_
        z = w + sum(a * np.sin(2 * j * w) for j, a in enumerate(_ALPHA, start=1))
        return (z.real - _meridian(self.latitude)) * _A1, -z.imag * _A1


def _wrap(degrees: NDArray[np.float64]) -> NDArray[np.float64]:
    wrapped: NDArray[np.float64] = (degrees + 180) % 360 - 180
    return wrapped


def _conformal_tan(tau: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tangent of the conformal latitude from that of the latitude (Eqs. 7-9)."""
    sigma = np.sinh(_E * np.arctanh(_E * tau / np.sqrt(1 + tau**2)))
    found: NDArray[np.float64] = tau * np.sqrt(1 + sigma**2) - sigma * np.sqrt(1 + tau**2)
    return found


def _tan_from_conformal(conformal: NDArray[np.float64]) -> NDArray[np.float64]:
    """Tangent of the latitude from that of the conformal latitude, by Newton's method (Eqs. 19-21)."""
    tau = conformal / (1 - _E2)
    for _ in range(4):  # converges to rounding in three
        now = _conformal_tan(tau)
        step = (conformal - now) / np.sqrt(1 + now**2) * (1 + (1 - _E2) * tau**2) / ((1 - _E2) * np.sqrt(1 + tau**2))
        tau = tau + step
    return tau


def _meridian(latitude: float) -> float:
    """Northing of a latitude on the central meridian, in units of the rectifying radius."""
    xi = float(np.arctan(_conformal_tan(np.tan(np.radians(np.float64(latitude))))))
    return xi + sum(a * float(np.sin(2 * j * xi)) for j, a in enumerate(_ALPHA, start=1))

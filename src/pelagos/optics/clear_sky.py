"""The clear sky: sunlight scattered by air, haze and ozone's blue, from noon to the end of twilight.

Sunlight comes down through spherical shells of air molecules, aerosol and ozone; what a direction of view scatters
towards the eye is summed along it, once exactly and all further times by the isotropic second order and its geometric
series (S. Hillaire, Computer Graphics Forum 39(4):13, 2020, doi 10.1111/cgf.14050, Section 5.5). NumPy, float64, by
channel; radiance is over the sun's irradiance above the atmosphere.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache, lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.optics.water import CHANNELS_NM

Numbers = NDArray[np.float64]

ROWS: Final = 32  # of elevation; sin(elevation) = (row / (ROWS - 1))^2
COLUMNS: Final = 25  # of azimuth from the sun's, 0 to 180 deg

_EARTH: Final = 6360e3  # radius [m]
_TOP: Final = 80e3  # of the air [m]
_MOLECULES_M: Final = 8.0e3  # scale height [m]
_AEROSOL_M: Final = 1.2e3  # of haze over the sea [m]; assumed
_AEROSOL: Final = 0.12  # vertical optical thickness at 550 nm, clear maritime air; assumed
_AEROSOL_KEPT: Final = 0.96  # of what aerosol takes, it scatters; assumed
_AEROSOL_G: Final = 0.76  # mean cosine of that; assumed
_OZONE: Final = (0.0412, 0.0212, 0.0031)  # vertical optical thickness of 300 DU in red, green, blue: the Chappuis band,
# 5.1, 2.6 and 0.4e-21 cm^2 (A. Serdyuchenko et al., Atmos. Meas. Tech. 7:625, 2014, doi 10.5194/amt-7-625-2014)
_OZONE_M: Final = (25e3, 15e3)  # middle of its layer, and where it ends above and below [m]
_SEA: Final = 0.06  # albedo of the ground
# sine of 1.5 deg, below which the sky is as there: haze in perfect layers would show as a bright line; assumed
_HORIZON: Final = 0.026
_GLOW_EDGE: Final = 0.64  # cosine of the angle from the sun at which its glow ends
_HEIGHTS: Final = 18
_SUNS: Final = 40
_STEPS: Final = 32
_LOW_SUN: Final = 0.1  # sine of its elevation below which the earth's shadow is followed closely


@dataclass(frozen=True, eq=False)
class ClearSky:
    """Light that reaches the sea under one height of the sun, over the irradiance above the atmosphere, by channel.

    Attributes:
        beam: `(3,)`, the sun's own, across its beam; 0 where it has set.
        radiance: `(ROWS, COLUMNS, 3)` [1/sr].
        irradiance: `(3,)` of the whole sky on level ground.
        glow: part of the radiance that is haze's glow within 50 deg of the sun.
        glow_share: `(3,)`, its share of the irradiance.
    """

    beam: Numbers
    radiance: Numbers
    irradiance: Numbers
    glow: Numbers
    glow_share: Numbers

    @property
    def pattern(self) -> Numbers:
        """Radiance over its mean, weighted by the cosine: `(ROWS, COLUMNS, 3)`."""
        return self.radiance * (math.pi / self.irradiance)

    def around(self, up: Numbers, glow: float) -> Numbers:
        """Mean of the pattern all round at sines of elevation `(k,)`, with a share of the glow: `(k, 3)`."""
        pattern = (self.radiance - (1 - glow) * self.glow) * (math.pi / self.irradiance)
        mean = 0.5 * (pattern[:, 1:] + pattern[:, :-1]).mean(axis=1)
        rows = np.arange(ROWS)
        return np.stack([np.interp(np.sqrt(up) * (ROWS - 1), rows, mean[:, c]) for c in range(3)], axis=-1)


def clear_sky(elevation: float) -> ClearSky:
    """The sky for a height of the sun [rad]; down to 12 deg below the horizon, where it stays as it is then."""
    return _solved(round(elevation, 9))  # the same one for an angle and for what is left of it after sine and arcsine


@lru_cache(maxsize=64)
def _solved(elevation: float) -> ClearSky:
    low = math.radians(-12)
    sine = math.sin(max(elevation, low))
    up = (np.arange(ROWS) / (ROWS - 1)) ** 2
    seen = np.maximum(up, _HORIZON)
    side = np.linspace(0, math.pi, COLUMNS)
    toward = np.sqrt(1 - seen**2)[:, None] * np.cos(side) * math.sqrt(1 - sine * sine) + seen[:, None] * sine
    ups = np.broadcast_to(seen[:, None], toward.shape)
    radiance, glow = _gathered(np.zeros_like(ups), ups, np.full_like(ups, sine), toward, scattered_again())
    weight = _weights(up, side)
    irradiance, shining = (np.einsum("rs,rsc->c", weight, v) for v in (radiance, glow))
    beam = _transmittance(np.zeros(1), np.array([sine]))[0] if elevation > 0 else np.zeros(3)
    return ClearSky(beam, radiance, irradiance, glow, shining / irradiance)


def _weights(up: Numbers, side: Numbers) -> Numbers:
    """Of rows and columns in an integral of radiance times sine over the upper half: trapezoids."""
    square = up * up
    rows = np.zeros_like(up)
    rows[:-1] += 0.25 * np.diff(square)
    rows[1:] += 0.25 * np.diff(square)
    columns = np.full_like(side, 2 * math.pi / (len(side) - 1))
    columns[[0, -1]] *= 0.5
    return np.asarray(rows[:, None] * columns)


def _extinction(height: Numbers) -> tuple[Numbers, Numbers, Numbers]:
    """Scattering by molecules and by aerosol, and all that is lost [1/m], `(..., 3)` at heights [m]."""
    um = np.array([nm for nm, _ in CHANNELS_NM.values()]) / 1000
    rayleigh = 0.00864 * um ** -(3.916 + 0.074 * um + 0.05 / um)  # A. T. Young 1980, of the whole air
    z = np.maximum(height, 0)[..., None]
    molecules = rayleigh / _MOLECULES_M * np.exp(-z / _MOLECULES_M)
    aerosol = _AEROSOL * (um / 0.55) ** -1.0 / _AEROSOL_M * np.exp(-z / _AEROSOL_M)
    middle, half = _OZONE_M
    ozone = np.array(_OZONE) / half * np.maximum(1 - np.abs(z - middle) / half, 0)
    return molecules, _AEROSOL_KEPT * aerosol, molecules + aerosol + ozone


def _way(height: Numbers, up: Numbers) -> tuple[Numbers, NDArray[np.bool_]]:
    """Way [m] from a height in a direction of sine `up` to the top or to the ground, and whether it is the ground."""
    r = _EARTH + height
    to_top = -r * up + np.sqrt(np.maximum(r * r * (up * up - 1) + (_EARTH + _TOP) ** 2, 0))
    inside = r * r * (up * up - 1) + _EARTH**2
    ground = (up < 0) & (inside >= 0) & (height > 0)
    to_ground = -r * up - np.sqrt(np.maximum(inside, 0))
    return np.where(ground, to_ground, to_top), ground


def _along(height: Numbers, up: Numbers, way: Numbers) -> tuple[Numbers, Numbers]:
    """Height [m], and sine over the horizon there, after a way [m] from a height in a direction."""
    r = _EARTH + height
    there = np.sqrt(r * r + way * way + 2 * r * way * up)
    return there - _EARTH, np.clip((r * up + way) / there, -1, 1)


def _places(way: Numbers, steps: int) -> tuple[Numbers, Numbers]:
    """Middles of the steps of a way and their lengths, `(..., steps)`: short ones first, where air is thick."""
    edge = np.linspace(0, 1, steps + 1) ** 2
    return way[..., None] * 0.5 * (edge[1:] + edge[:-1]), way[..., None] * np.diff(edge)


def _transmittance(height: Numbers, up: Numbers) -> Numbers:
    """Share of light left that comes from a direction out of space, `(..., 3)`; 0 where the earth is in the way."""
    way, ground = _way(height, up)
    at, step = _places(way, _STEPS)
    z, _ = _along(height[..., None], up[..., None], at)
    lost = (_extinction(z)[2] * step[..., None]).sum(axis=-2)
    return np.asarray(np.where((ground | ((height <= 0) & (up < 0)))[..., None], 0.0, np.exp(-lost)))


@cache
def _sunlight() -> Numbers:
    """`_transmittance` by height and by the sun's sine, `(_HEIGHTS, _SUNS, 3)`; see `_looked_up`."""
    z, u = np.meshgrid(_table_heights(), _table_suns(), indexing="ij")
    return _transmittance(z, u)


def _table_heights() -> Numbers:
    return np.asarray(_TOP * (np.arange(_HEIGHTS) / (_HEIGHTS - 1)) ** 2)


def _table_suns() -> Numbers:
    """Denser at the horizon."""
    x = np.linspace(-1, 1, _SUNS)
    return np.asarray(np.sign(x) * np.abs(x) ** 2.2)


def _looked_up(table: Numbers, height: Numbers, sun: Numbers) -> Numbers:
    """Of a table `(_HEIGHTS, _SUNS, 3)`, between its nodes."""
    row = np.sqrt(np.clip(height / _TOP, 0, 1)) * (_HEIGHTS - 1)
    x = np.sign(sun) * np.abs(sun) ** (1 / 2.2)
    column = (x + 1) / 2 * (_SUNS - 1)
    i = np.minimum(row.astype(int), _HEIGHTS - 2)
    j = np.minimum(column.astype(int), _SUNS - 2)
    a, b = (row - i)[..., None], (column - j)[..., None]
    low = table[i, j] * (1 - b) + table[i, j + 1] * b
    return np.asarray(low * (1 - a) + (table[i + 1, j] * (1 - b) + table[i + 1, j + 1] * b) * a)


def _gathered(height: Numbers, up: Numbers, sun: Numbers, toward: Numbers, again: Numbers | None) -> Numbers:
    """Radiance from directions `up` at heights: what air sends on once, and `again`.

    Args:
        height: [m].
        up: sine over the horizon.
        sun: sine of the sun's elevation there.
        toward: cosine of the angle between direction and sun.
        again: see `scattered_again`; None: light scattered once, by an even phase function.

    Returns:
        `(..., 3)`; with `again` `(2, ..., 3)`: all, and the part of it that is haze's glow around the sun.
    """
    way, _ = _way(height, up)
    at, step = _places(way, _STEPS)
    z, _ = _along(height[..., None], up[..., None], at)
    # the sun stands higher or lower over another place
    there = ((_EARTH + height)[..., None] * sun[..., None] + at * toward[..., None]) / (_EARTH + z)
    there = np.clip(there, -1, 1)
    molecules, aerosol, lost = _extinction(z)
    depth = np.cumsum(lost * step[..., None], axis=-2)
    inside = -np.expm1(-lost * step[..., None]) / np.maximum(lost, 1e-12)  # metres' worth of each step
    left = np.exp(-(depth - lost * step[..., None])) * inside
    sets = again is not None and float(np.min(sun)) < _LOW_SUN
    light = _transmittance(z, there) if sets else _looked_up(_sunlight(), z, there)
    if again is None:
        return np.asarray(((molecules + aerosol) * light * left).sum(axis=-2) / (4 * math.pi))
    by_molecules = 3 / (16 * math.pi) * (1 + toward**2)
    once = molecules * by_molecules[..., None, None] + aerosol * _by_aerosol(toward)[..., None, None]
    source = once * light + (molecules + aerosol) * _looked_up(again, z, there)
    forward = np.maximum(_by_aerosol(toward) - float(_by_aerosol(np.array(_GLOW_EDGE))), 0)
    glow = (aerosol * light * left).sum(axis=-2) * forward[..., None]
    return np.stack([(source * left).sum(axis=-2), glow])


def _by_aerosol(cosine: Numbers) -> Numbers:
    """Henyey and Greenstein's phase function [1/sr]."""
    g = _AEROSOL_G
    return np.asarray((1 - g * g) / (4 * math.pi) / (1 + g * g - 2 * g * cosine) ** 1.5)


@cache
def scattered_again() -> Numbers:
    """Mean radiance of light scattered twice and more, `(_HEIGHTS, _SUNS, 3)` [1/sr], by height and the sun's sine.

    The second order over 1 - f, where f is the share of light that is sent out evenly at a place and comes back to it.
    """
    z, sun = (v.ravel() for v in np.meshgrid(_table_heights(), _table_suns(), indexing="ij"))
    up, weight = np.polynomial.legendre.leggauss(8)
    side = (np.arange(4) + 0.5) * math.pi / 4
    second, back = np.zeros((len(z), 3)), np.zeros((len(z), 3))
    for u, w in zip(up, weight, strict=True):
        ups = np.full_like(z, u)
        way, ground = _way(z, ups)
        for s in side:
            toward = np.sqrt(1 - u * u) * np.sqrt(1 - sun * sun) * math.cos(s) + u * sun
            share = w / 2 / len(side)
            once = _gathered(z, ups, sun, toward, None)
            second += share * (once + _off_the_sea(z, ups, sun, toward, way, ground))
        back += w / 2 * _coming_back(z, ups, way)
    table = second / (1 - back)
    return np.asarray(table.reshape(_HEIGHTS, _SUNS, 3))


def _coming_back(height: Numbers, up: Numbers, way: Numbers) -> Numbers:
    """Share of evenly sent light that is scattered along a direction."""
    at, step = _places(way, _STEPS)
    z, _ = _along(height[..., None], up[..., None], at)
    molecules, aerosol, lost = _extinction(z)
    depth = np.cumsum(lost * step[..., None], axis=-2) - 0.5 * lost * step[..., None]
    return np.asarray(((molecules + aerosol) * np.exp(-depth) * step[..., None]).sum(axis=-2))


def _off_the_sea(
    height: Numbers, up: Numbers, sun: Numbers, toward: Numbers, way: Numbers, ground: NDArray[np.bool_]
) -> Numbers:
    """Radiance of the sunlit sea at the end of a way."""
    there = np.clip(((_EARTH + height) * sun + way * toward) / _EARTH, -1, 1)
    at, step = _places(way, _STEPS)
    z, _ = _along(height[..., None], up[..., None], at)
    left = np.exp(-(_extinction(z)[2] * step[..., None]).sum(axis=-2))
    lit = _looked_up(_sunlight(), np.zeros_like(height), there) * np.maximum(there, 0)[..., None]
    return np.asarray(np.where(ground[..., None], _SEA / math.pi * lit * left, 0.0))

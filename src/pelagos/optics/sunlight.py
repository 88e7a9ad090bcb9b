"""Light above the sea: the sun's beam and the sky's diffuse light.

Units are photometric: lux for irradiance, cd/m^2 for radiance, in each channel, with white daylight (sun 45 degrees
    high) as (1, 1, 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cache
from typing import Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.phase import henyey_greenstein
from pelagos.optics.water import CHANNELS_NM, Triple

_EXTRATERRESTRIAL_LUX: Final = 133_800.0  # solar illuminance constant
_AEROSOL: Final = 0.12  # vertical optical thickness at 550 nm, clear maritime air; assumed
SKY_TINT: Final = (0.75, 0.95, 1.25)  # of the clear sky overhead, red, green, blue; assumed


@dataclass(frozen=True)
class Daylight:
    """Sun and sky, plain numbers.

    Attributes:
        towards_sun: unit vector, world NWU.
        sun: irradiance across the beam at sea level [lx].
        sky: irradiance of the whole sky on a horizontal surface [lx].
        cover: share of the sky's light that comes from clouds and fog.
    """

    towards_sun: Triple
    sun: Triple
    sky: Triple
    cover: float = 0.0

    def arrays(self) -> LightArrays:
        """The same as Dr.Jit arrays, for frozen functions."""
        towards, sun, sky = (jit.Array3f(*v) for v in (self.towards_sun, self.sun, self.sky))
        light = LightArrays(towards, sun, sky, jit.Float(self.cover))
        dr.make_opaque(light)
        return light


@jit.struct
class LightArrays:
    """`Daylight` as a Dr.Jit struct of `Array3f`; `cover` is a `Float` (1)."""

    towards_sun: Array
    sun: Array
    sky: Array
    cover: Array


def daylight(elevation: float, azimuth: float = 0.0, *, cloud: float = 0.0) -> Daylight:
    """Sun and sky for a height of the sun.

    Direct: Beer's law through Rayleigh (A. T. Young 1980) and aerosol thickness over the relative air mass of F.
        Kasten and
    A. T. Young 1989 (doi 10.1364/AO.28.004735). Diffuse: half of what molecules take from the beam, and most of what
    aerosol takes, comes down (first order). Cloud hides the beam and leaves 30 % of all light under overcast (F.
    Kasten and G. Czeplak 1980).

    Args:
        elevation: of the sun over the horizon [rad]; below the horizon only twilight of the sky is left.
        azimuth: direction of the sun from north, counter-clockwise (NWU) [rad].
        cloud: share of the sky that is covered, 0 .. 1.
    """
    direct, sky = _clear(elevation)
    reference = sum(_white()) / 3
    balance = [reference / w for w in _white()]
    total = [d * max(math.sin(elevation), 0) + s for d, s in zip(direct, sky, strict=True)]
    dimmed = 1 - 0.7 * cloud**3.4
    open_sky = (1 - cloud) * dimmed
    grey = [dimmed * t - open_sky * d * max(math.sin(elevation), 0) for t, d in zip(total, direct, strict=True)]
    c = math.cos(elevation)
    towards = (c * math.cos(azimuth), c * math.sin(azimuth), math.sin(elevation))
    return Daylight(
        towards_sun=towards,
        sun=_times([open_sky * d for d in direct], balance),
        sky=_times(grey, balance),
        cover=cloud,
    )


def _clear(elevation: float) -> tuple[list[float], list[float]]:
    """Beam and diffuse horizontal irradiance without clouds [lx]."""
    degrees = math.degrees(elevation)
    high = max(degrees, 0.0)
    mass = 1 / (math.sin(math.radians(high)) + 0.50572 * (high + 6.07995) ** -1.6364)
    direct, sky = [], []
    for nm, _ in CHANNELS_NM.values():
        um = nm / 1000
        rayleigh = 0.00864 * um ** -(3.916 + 0.074 * um + 0.05 / um)
        aerosol = _AEROSOL * (um / 0.55) ** -1.0
        beam = _EXTRATERRESTRIAL_LUX * math.exp(-mass * (rayleigh + aerosol))
        above = max(math.sin(elevation), 0.0)
        lost = 0.5 * (1 - math.exp(-mass * rayleigh)) + 0.75 * math.exp(-mass * rayleigh) * (
            1 - math.exp(-mass * aerosol)
        )
        twilight = 400.0 * math.exp(min(degrees, 0.0) * 0.75)  # [lx], after the sun has set; about a factor 2 a degree
        direct.append(beam if degrees > 0 else 0.0)
        sky.append(_EXTRATERRESTRIAL_LUX * lost * above + twilight)
    return direct, sky


def _white() -> list[float]:
    direct, sky = _clear(math.radians(45))
    return [d * math.sin(math.radians(45)) + s for d, s in zip(direct, sky, strict=True)]


def _times(a: list[float], b: list[float]) -> Triple:
    r, g, bl = (float(x) for x in np.multiply(a, b))
    return r, g, bl


def sky_pattern(up: Array, tint: float, cover: Array) -> Array:
    """Radiance of the sky at an elevation of sine `up` over its mean, weighted by the cosine.

    Clear: tinted overhead, pale at the horizon; assumed. Covered: three times as bright overhead as at the horizon,
    (1 + 2 sin) / 3 (P. Moon and D. E. Spencer, Illum. Eng. 37:707, 1942; CIE S 011:2003).
    """
    clear = _clear_shape(up, tint) / _clear_mean(tint)
    return clear + cover * ((1 + 2 * up) * (3 / 7) - clear)


def _clear_shape(up: Array, tint: float) -> Array:
    horizon = dr.exp(-6 * up)
    return tint * (1 - 0.2 * up) * (1 - 0.6 * horizon) + 0.95 * horizon


@cache
def _clear_mean(tint: float) -> float:
    steps = [(k + 0.5) / 400 for k in range(400)]
    return sum(float(_clear_shape(u, tint)) * 2 * u for u in steps) / 400


def sky_radiance(light: LightArrays, direction: Array, *, glare: Array = 1.0) -> Array:
    """Radiance of the sky above water [cd/m^2]: brighter to the horizon and around the sun, never below the horizon.

    Args:
        light: see `Daylight`.
        direction: unit vector away from the eye.
        glare: share of the sun's own light that is let in, spread over its aureole.
    """
    up = dr.clip(direction.z, 0, 1)
    shape = jit.Array3f(*(sky_pattern(up, tint, light.cover) for tint in SKY_TINT))
    base = light.sky / math.pi * shape
    near_sun = dr.clip(dr.dot(direction, light.towards_sun), -1, 1)
    aureole = 0.02 * henyey_greenstein(near_sun, 0.9) + 0.012 * henyey_greenstein(near_sun, 0.985)
    return base + glare * light.sun * aureole

"""Light above the sea: the sun's beam and the sky's diffuse light.

Units are photometric: lux for irradiance, cd/m^2 for radiance, in each channel, with white daylight (sun 45 degrees
    high) as (1, 1, 1).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.clear_sky import COLUMNS, ROWS, clear_sky
from pelagos.optics.phase import henyey_greenstein
from pelagos.optics.water import Triple

_EXTRATERRESTRIAL_LUX: Final = 133_800.0  # solar illuminance constant
_LOW_SUN: Final = 0.15  # sine of its elevation below which its glow is part of the sky rather than of the beam


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
        table = np.zeros((ROWS * COLUMNS, 4), dtype=np.float32)
        table[:, :3] = clear_sky(math.asin(self.towards_sun[2])).pattern.reshape(-1, 3)
        light = LightArrays(towards, sun, sky, jit.Float(self.cover), jit.Float(table.ravel()))
        jit.align(light)
        return light


@jit.struct
class LightArrays:
    """`Daylight` as a Dr.Jit struct of `Array3f`; `cover` is a `Float` (1), `pattern` a `Float` table of the clear sky,
    see `ClearSky`, with four values a direction."""

    towards_sun: Array
    sun: Array
    sky: Array
    cover: Array
    pattern: Array


def daylight(elevation: float, azimuth: float = 0.0, *, cloud: float = 0.0) -> Daylight:
    """Sun and sky for a height of the sun.

    Without clouds as `clear_sky` has it. Cloud hides the beam and leaves 30 % of all light under overcast (F. Kasten
    and G. Czeplak 1980).

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
    sky = clear_sky(elevation)
    return (_EXTRATERRESTRIAL_LUX * sky.beam).tolist(), (_EXTRATERRESTRIAL_LUX * sky.irradiance).tolist()


def _white() -> list[float]:
    direct, sky = _clear(math.radians(45))
    return [d * math.sin(math.radians(45)) + s for d, s in zip(direct, sky, strict=True)]


def _times(a: list[float], b: list[float]) -> Triple:
    r, g, bl = (float(x) for x in np.multiply(a, b))
    return r, g, bl


def overcast_pattern(up: Array) -> Array:
    """Radiance of a covered sky at an elevation of sine `up` over its mean, weighted by the cosine.

    Three times as bright overhead as at the horizon, (1 + 2 sin) / 3 (P. Moon and D. E. Spencer, Illum. Eng. 37:707,
    1942; CIE S 011:2003).
    """
    return (1 + 2 * up) * (3 / 7)


def beam_and_mean_sky(light: Daylight, up: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Sun and sky where the sky has to be the same all round: haze's glow counts with the beam, unless the sun is low.

    Returns:
        `(3,)` across the beam [lx]; `(k, 3)` radiance at sines of elevation `up` [cd/m^2].
    """
    clear = clear_sky(math.asin(light.towards_sun[2]))
    high = max(light.towards_sun[2], 0.0)
    moved = min(high / _LOW_SUN, 1.0)
    pattern = clear.around(up, 1 - moved)
    pattern = pattern + light.cover * (overcast_pattern(up)[:, None] - pattern)
    sky = np.array(light.sky)
    glow = (1 - light.cover) * moved * clear.glow_share * sky
    return np.add(light.sun, glow / max(high, _LOW_SUN)), sky / math.pi * pattern


def sky_radiance(light: LightArrays, direction: Array, *, glare: Array = 1.0) -> Array:
    """Radiance of the sky above water, `Array3f` [cd/m^2]; below the horizon that at the horizon.

    Args:
        light: see `Daylight`.
        direction: unit vector away from the eye.
        glare: share of the sun's own light that is let in, spread over its corona.
    """
    up = dr.clip(direction.z, 0, 1)
    clear = _pattern_at(light, direction, up)
    base = light.sky / math.pi * (clear + light.cover * (overcast_pattern(up) - clear))
    near_sun = dr.clip(dr.dot(direction, light.towards_sun), -1, 1)
    return base + glare * light.sun * (0.012 * henyey_greenstein(near_sun, 0.985))


def _pattern_at(light: LightArrays, direction: Array, up: Array) -> Array:
    """`ClearSky.pattern` in a direction, by linear interpolation."""
    sun = light.towards_sun
    across = dr.rsqrt(dr.maximum((1 - up * up) * (1 - sun.z * sun.z), 1e-8))
    cosine = dr.clip((direction.x * sun.x + direction.y * sun.y) * across, -1, 1)
    row, side = dr.sqrt(up) * (ROWS - 1), dr.acos(cosine) * ((COLUMNS - 1) / math.pi)
    i, j = dr.minimum(jit.UInt32(row), ROWS - 2), dr.minimum(jit.UInt32(side), COLUMNS - 2)
    a, b = row - jit.Float(i), side - jit.Float(j)
    at = i * COLUMNS + j
    corner = [dr.gather(jit.Array4f, light.pattern, at + k) for k in (0, 1, COLUMNS, COLUMNS + 1)]
    return dr.lerp(dr.lerp(corner[0], corner[1], b), dr.lerp(corner[2], corner[3], b), a).xyz

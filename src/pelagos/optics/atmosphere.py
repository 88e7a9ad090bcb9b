"""Air that is not clear: fog and rain between the eye and what it sees.

Fog takes light from a line of sight and sends that of the sky and the sun into it; seen through enough of it,
everything is as bright as the fog itself (H. Koschmieder, Beitr. Phys. freien Atmos. 12:33, 1924). Visibility is the
meteorological optical range: the way over which 5 % of a beam are left (WMO-No. 8, Volume I, Chapter 9).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.sunlight import Daylight

LAYER_M: Final = 120.0  # height of a fog bank over the sea [m]; assumed
RAIN_LAYER_M: Final = 2000.0  # height from which rain falls [m]; assumed
_LEFT: Final = 0.05  # of a beam at the visibility
_KEPT: Final = 0.8  # of the light that fog takes from the sun's beam, arrives below it all the same; assumed
_RAIN_DB_KM: Final = (1.076, 0.67)  # ITU-R P.1814 (2007), Section 4.3, the coefficients of Carbonneau


@jit.struct
class Air:
    """Air over the sea: a Dr.Jit struct of `Float` (1).

    Attributes:
        fog, rain: extinction [1/m].
        drops: rate of rainfall [mm/h], None without rain.
    """

    fog: Array
    rain: Array
    drops: Array | None


@dataclass(frozen=True)
class Weather:
    """Weather of the sky, plain numbers.

    Attributes:
        cloud: share of the sky that is covered.
        visibility: over the sea [m].
        rain: [mm/h].
    """

    cloud: float = 0.0
    visibility: float = math.inf
    rain: float = 0.0

    @property
    def clear(self) -> bool:
        """Neither fog nor rain stands between the eye and what it sees."""
        return math.isinf(self.visibility) and self.rain == 0

    def air(self) -> Air:
        """The same as Dr.Jit arrays, for frozen functions."""
        fog, rain, drops = (dr.opaque(jit.Float, v) for v in (self.fog, rain_extinction(self.rain), self.rain))
        return Air(fog, rain, drops if self.rain > 0 else None)

    @property
    def fog(self) -> float:
        """Extinction [1/m], see `fog_extinction`."""
        return fog_extinction(self.visibility)


def fog_extinction(visibility: float, wavelength_nm: float = 550.0) -> float:
    """Extinction [1/m] of fog through which one sees `visibility` [m] far; infinite is clear.

    By wavelength as (lambda / 550 nm)^-q, and q falls to none in thick fog (I. I. Kim, B. McArthur and E. Korevaar,
    Proc. SPIE 4214:26, 2001, doi 10.1117/12.417512).
    """
    km = visibility / 1000
    if km > 6:
        q = 1.6 if km > 50 else 1.3
    elif km > 1:
        q = 0.16 * km + 0.34
    else:
        q = max(km - 0.5, 0.0)
    return -math.log(_LEFT) / visibility * math.pow(wavelength_nm / 550.0, -q)


def rain_extinction(rate: float) -> float:
    """Extinction [1/m] of light in rain of `rate` [mm/h]: k R^a dB/km (ITU-R P.1814)."""
    k, a = _RAIN_DB_KM
    return k * math.pow(rate, a) * math.log(10.0) / 10.0 / 1000.0


def under_weather(light: Daylight, weather: Weather) -> Daylight:
    """Sun and sky below fog and rain: what they take from the sun's beam, the sky gives back but for a part."""
    rise = max(light.towards_sun[2], 0.05)
    depth = fog_extinction(weather.visibility) * LAYER_M + rain_extinction(weather.rain) * RAIN_LAYER_M
    kept = math.exp(-depth / rise)
    lost = [s * (1 - kept) * max(light.towards_sun[2], 0.0) for s in light.sun]
    red, green, blue = (kept * s for s in light.sun)
    sky = [s + _KEPT * x for s, x in zip(light.sky, lost, strict=True)]
    through = math.exp(-depth)  # straight up
    return replace(light, sun=(red, green, blue), sky=(sky[0], sky[1], sky[2]), cover=1 - (1 - light.cover) * through)


def way_to_sky(air: Air, rise: Array) -> Array:
    """Optical thickness of the air to the sky in a direction whose sine over the horizon is `rise`."""
    up = dr.maximum(rise, 1e-3)
    return air.fog * (LAYER_M / up) + air.rain * dr.minimum(RAIN_LAYER_M / up, 20_000.0)


def airlight(sun: Array, sky: Array, towards_sun: Array) -> Array:
    """Radiance of thick fog [cd/m^2]: it sends on what falls on it, evenly; arguments as in `LightArrays`."""
    return (sun * dr.maximum(towards_sun.z, 0.0) + sky) * (1.0 / math.pi)


def through_air(light: Array, thickness: Array, fog: Array) -> Array:
    """Radiance `light` behind air of an optical thickness, in which the fog's own radiance is `fog`."""
    return dr.lerp(fog, light, dr.exp(-thickness))

"""Light above the sea: the sun's beam, the sky's diffuse light, and how much of both arrives at a depth.

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
from pelagos.optics.interface import DIFFUSE_TRANSMITTANCE, fresnel, sun_below_surface
from pelagos.optics.phase import henyey_greenstein
from pelagos.optics.water import (
    CHANNELS_NM,
    FORWARD_PEAK,
    MEAN_COSINE,
    REFRACTIVE_INDEX,
    SCALED_COSINE,
    Triple,
    WaterArrays,
)

_EXTRATERRESTRIAL_LUX: Final = 133_800.0  # solar illuminance constant
_AEROSOL: Final = 0.12  # vertical optical thickness at 550 nm, clear maritime air; assumed
_MOLECULES: Final = 0.0796  # [1/sr], nearly isotropic: 1 / (4 pi)
_SKY_SPREAD: Final = 0.8  # mean cosine of diffuse light under water about the zenith; assumed
_AGAIN: Final = 1.4
_SKY_WAY: Final = 1.197  # D0 of a uniform sky, Gordon 1989
_SKY_TINT: Final = (0.75, 0.95, 1.25)  # of the clear sky overhead, red, green, blue; assumed
UPWELLING_FLOOR: Final = 0.06  # irradiance from below over irradiance from above where the water adds nothing; assumed


@dataclass(frozen=True)
class Daylight:
    """Sun and sky, plain numbers.

    Attributes:
        towards_sun: unit vector, world NWU.
        sun: irradiance across the beam at sea level [lx].
        sky: irradiance of the whole sky on a horizontal surface [lx].
    """

    towards_sun: Triple
    sun: Triple
    sky: Triple

    def arrays(self) -> LightArrays:
        """The same as Dr.Jit arrays, for frozen functions."""
        light = LightArrays(*(jit.Array3f(*v) for v in (self.towards_sun, self.sun, self.sky)))
        dr.make_opaque(light)
        return light


@dataclass
class LightArrays:
    """`Daylight` as a Dr.Jit struct of `Array3f`."""

    towards_sun: Array
    sun: Array
    sky: Array


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


def _sky_shape(up: Array, tint: float) -> Array:
    """How bright the sky is at an elevation of sine `up`: tinted overhead, pale at the horizon; assumed."""
    horizon = dr.exp(-6 * up)
    return tint * (1 - 0.2 * up) * (1 - 0.6 * horizon) + 0.95 * horizon


@cache
def _sky_mean(tint: float) -> float:
    """Mean of `_sky_shape` over a horizontal surface's hemisphere, weighted by the cosine."""
    steps = [(k + 0.5) / 400 for k in range(400)]
    return sum(float(_sky_shape(u, tint)) * 2 * u for u in steps) / 400


@jit.struct
class LightAtDepth:
    """Light in the water at one depth, a Dr.Jit struct.

    Attributes:
        towards_sun: `Array3f`, direction that the beam comes from, in the water.
        beam: `Array3f`, irradiance across what is still a beam [lx].
        diffuse: `Array3f`, irradiance on a horizontal surface of the light that no longer is [lx].
        upwelling: `Array3f`, irradiance from below on a horizontal surface [lx].
        sharpness: `Float`, 0 .. 1: how much of the pattern of the waves is left in the beam.
    """

    towards_sun: Array
    beam: Array
    diffuse: Array
    upwelling: Array
    sharpness: Array


@jit.struct
class Entering:
    """What of daylight is the same at every place of a frame, a Dr.Jit struct: `entering` works it out once.

    Attributes:
        towards_sun: `Array3f`, direction of the sun in air.
        towards_sun_below: `Array3f`, the same in the water.
        beam, sky: `Array3f`, irradiance on a horizontal surface just below the sea surface [lx].
        beam_above, sky_above: `Array3f`, the same above it.
        attenuation: `Array3f`, of irradiance from above against depth [1/m].
        unbeaming: `Array3f`, rate at which the beam becomes diffuse, against depth [1/m].
        reflectance: `Array3f`, irradiance from below over irradiance from above.
        again: `Array3f`, gain of light that is scattered more than once.
        blur: `Float`, rate at which the waves' pattern is lost, against depth [1/m].
    """

    towards_sun: Array
    towards_sun_below: Array
    beam: Array
    sky: Array
    beam_above: Array
    sky_above: Array
    attenuation: Array
    unbeaming: Array
    reflectance: Array
    again: Array
    blur: Array


def entering(light: LightArrays, water: WaterArrays) -> Entering:
    """Daylight that enters the water, and how fast it falls with depth.

    A beam forgets its direction over the transport length 1 / (b_w + b_p (1 - g)); the fine pattern of the waves is
    lost over a quarter of the scattering length's inverse (scattering by a few degrees; assumed).
    """
    below = sun_below_surface(light.towards_sun)
    high = dr.maximum(light.towards_sun.z, 0)
    beam_above = light.sun * high
    beam = beam_above * (1 - fresnel(high, REFRACTIVE_INDEX))
    sky = light.sky * DIFFUSE_TRANSMITTANCE
    albedo = water.turning / (water.absorption + water.turning)
    return Entering(
        towards_sun=light.towards_sun,
        towards_sun_below=below,
        beam=beam,
        sky=sky,
        beam_above=beam_above,
        sky_above=light.sky,
        attenuation=water.downwelling * obliqueness(water, beam, sky, below.z),
        unbeaming=(water.water_scattering + (1 - MEAN_COSINE) * water.particle_scattering) / below.z,
        # 0.33 b_b / (a + b_b): H. R. Gordon et al. 1975
        reflectance=UPWELLING_FLOOR + 0.33 * water.backscatter / (water.absorption + water.backscatter),
        again=dr.rcp(1 - dr.power(albedo, _AGAIN)),
        blur=0.25 * water.particle_scattering.y,
    )


def light_at_depth(sun: Entering, depth: Array) -> LightAtDepth:
    """What a depth gets of sun and sky: Ed(z) = Ed(0) exp(-Kd D0 z), split into beam and diffuse light.

    Args:
        sun: see `Entering`.
        depth: below the surface [m]; above it everything is as in air.
    """
    below = dr.maximum(depth, 0)
    wet = depth > 0
    plane = dr.select(wet, sun.beam, sun.beam_above)
    total = (plane + dr.select(wet, sun.sky, sun.sky_above)) * dr.exp(-sun.attenuation * below)
    share = plane * dr.exp(-(sun.attenuation + sun.unbeaming) * below)
    towards = dr.select(wet, sun.towards_sun_below, sun.towards_sun)
    return LightAtDepth(
        towards_sun=towards,
        beam=share / dr.maximum(towards.z, 1e-3),
        diffuse=total - share,
        upwelling=total * sun.reflectance,
        sharpness=dr.select(wet, dr.exp(-sun.blur * below), 0),
    )


def obliqueness(water: WaterArrays, beam: Array, sky: Array, mu: Array) -> Array:
    """How much faster daylight falls with depth than light from the zenith would, `Array3f`.

    In clear water D0, the mean way over the depth (H. R. Gordon, Limnol. Oceanogr. 34:1389, 1989, doi
    10.4319/lo.1989.34.8.1389); scattering evens the directions out, sqrt((a + G(m) b) / (a + G(1) b)) / m with m = 1
    / D0 and G(m) = 0.425 m - 0.190 (J. T. O. Kirk 1984, equation 14). Jerlov's types are taken to state attenuation
    from the zenith.

    Args:
        water: its optics.
        beam, sky: irradiance on a horizontal surface below the sea surface, `Array3f`.
        mu: cosine of the refracted sun's angle to the zenith.
    """
    d0 = (beam / mu + _SKY_WAY * sky) / dr.maximum(beam + sky, 1e-12)
    oblique = 0.425 / d0 - 0.190
    a, b = water.absorption, water.scattering
    return d0 * dr.sqrt((a + oblique * b) / (a + (0.425 - 0.190) * b))


def scattered_daylight(
    here: LightAtDepth, sun: Entering, water: WaterArrays, direction: Array, beam_open: Array, sky_open: Array
) -> Array:
    """Radiance that a metre of water sends towards the eye from sun and sky, `Array3f` [cd/m^2 per m].

    Scattered once in the scaled medium (`WaterArrays.turning`), where the forward peak counts as not scattered at
    all. Light scattered again adds 1 / (1 - w^1.4) with the scaled medium's single scattering albedo w, a fit to path
    tracing in types I, 1C and 3C (gains 1.0, 1.2 and 1.9).
    Light from below is left out: what comes from surfaces and is scattered forward counts as their image (`transport`).

    Args:
        here: light at that place.
        sun: see `Entering`.
        water: its optics.
        direction: of sight, away from the eye.
        beam_open, sky_open: share of beam and diffuse light that nothing keeps off.
    """
    to_sun = dr.dot(direction, here.towards_sun)
    particles = (1 - FORWARD_PEAK) * water.particle_scattering
    beam = water.water_scattering * _MOLECULES + particles * henyey_greenstein(to_sun, SCALED_COSINE)
    sky = water.water_scattering * _MOLECULES + particles * henyey_greenstein(direction.z, SCALED_COSINE * _SKY_SPREAD)
    return (here.beam * beam * beam_open + 1.2 * here.diffuse * sky * sky_open) * sun.again


def sky_radiance(light: LightArrays, direction: Array, *, glare: float = 1.0) -> Array:
    """Radiance of the sky above water [cd/m^2]: brighter to the horizon and around the sun, never below the horizon.

    Args:
        light: see `Daylight`.
        direction: unit vector away from the eye.
        glare: share of the sun's own light that is let in, spread over its aureole.
    """
    up = dr.clip(direction.z, 0, 1)
    shape = jit.Array3f(*(_sky_shape(up, tint) / _sky_mean(tint) for tint in _SKY_TINT))
    base = light.sky / math.pi * shape
    near_sun = dr.clip(dr.dot(direction, light.towards_sun), -1, 1)
    aureole = 0.02 * henyey_greenstein(near_sun, 0.9) + 0.012 * henyey_greenstein(near_sun, 0.985)
    return base + glare * light.sun * aureole

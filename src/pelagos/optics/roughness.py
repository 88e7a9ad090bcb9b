"""Roughness of the sea by the wind, and the effect of waves too short or too far off to be drawn on its reflection.

C. Cox and W. Munk, J. Opt. Soc. Am. 44:838 (1954), doi 10.1364/JOSA.44.000838, photographed the sun's glitter: slopes
are nearly normal with a mean square, up- and crosswind together, of 0.003 + 0.00512 U, and of 0.008 + 0.00156 U under
a slick of oil, which stills all waves shorter than some 0.3 m. The difference is those waves'.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.interface import fresnel
from pelagos.optics.water import REFRACTIVE_INDEX

_LEAST: Final = 3e-4  # mean square slope that the glitter is spread over in a pixel: the sun's disc alone has 1e-5


def mean_square_slope(wind: float) -> float:
    """Of all waves at a wind [m/s] 12.5 m up, both directions together; measured up to 14 m/s."""
    return 0.003 + 0.00512 * wind


def long_mean_square_slope(wind: float) -> float:
    """Of waves over 0.3 m alone; no more than all."""
    return min(0.008 + 0.00156 * wind, mean_square_slope(wind))


def tilt_towards_eye(variance: Array, rise: Array) -> Array:
    """Mean slope towards the eye of what an eye sees of a rough surface, `Float`: near the horizon it sees the fronts
    of waves and not their backs.

    A facet of slope s, normal with the variance v in that direction, shows with the weight max(tan e + s, 0); waves
    that hide others are left out.

    Args:
        variance: mean square slope, both directions together.
        rise: tan e, of the line to the eye over the surface.
    """
    return 0.5 * variance * _front(variance, rise) / _shown(variance, rise)


def glitter(variance: Array, slope: Array, direction: Array, towards_sun: Array) -> Array:
    """Radiance of the sun's mirror image in a rough surface over the irradiance of its beam, `Float` [1/sr].

    p(z) F / (4 A cos^4 b) for the slope z and tilt b of facets that mirror the sun to the eye (Cox and Munk 1954), with
    the area A that the surface shows to the eye over its level area, as `tilt_towards_eye` has it.

    Args:
        variance: mean square slope around `slope`, both directions together.
        slope: `Array2f` of the surface that is drawn.
        direction: unit, from the eye to the surface, downwards.
        towards_sun: unit.
    """
    v = dr.maximum(variance, _LEAST)
    facet = dr.normalize(towards_sun - direction)
    up = dr.maximum(facet.z, 0.05)
    x, y = -facet.x / up - slope.x, -facet.y / up - slope.y
    density = dr.exp(-(x * x + y * y) / v) / (math.pi * v)
    level = dr.sqrt(dr.maximum(1 - direction.z * direction.z, 1e-6))
    area = level * _shown(v, _rise(slope, direction, level))
    mirror = fresnel(dr.clip(-dr.dot(facet, direction), 0, 1), jit.Float(REFRACTIVE_INDEX))
    seen = density * mirror / (4 * area * dr.square(dr.square(up)))
    return dr.select((facet.z > 0.05) & (towards_sun.z > 0), seen, 0)


def leaning(variance: Array, slope: Array, direction: Array) -> Array:
    """`slope` `Array2f` with `tilt_towards_eye` of the waves on it; see `glitter`."""
    level = dr.sqrt(dr.maximum(1 - direction.z * direction.z, 1e-6))
    more = tilt_towards_eye(variance, _rise(slope, direction, level)) / level
    return jit.Array2f(slope.x + more * direction.x, slope.y + more * direction.y)


def _rise(slope: Array, direction: Array, level: Array) -> Array:
    """Tangent of the angle of the line of sight over a surface that slopes; not below the horizon of a level one."""
    return dr.maximum((-direction.z + slope.x * direction.x + slope.y * direction.y) / level, 0)


def _shown(variance: Array, rise: Array) -> Array:
    """Mean of max(tan e + s, 0)."""
    deviation = dr.sqrt(dr.maximum(0.5 * variance, 1e-8))
    u = rise / deviation
    return rise * _front(variance, rise) + deviation * dr.exp(-0.5 * u * u) * (1 / math.sqrt(2 * math.pi))


def _front(variance: Array, rise: Array) -> Array:
    """Share of facets that face the eye."""
    return 0.5 + 0.5 * dr.erf(rise * dr.rsqrt(dr.maximum(variance, 2e-8)))

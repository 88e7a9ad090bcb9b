"""Phase functions: how scattered light spreads over angle [1/sr], each integrating to 1 over the sphere."""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos.jit import Array
from pelagos.optics.water import FORWARD_PEAK, MEAN_COSINE

_RAYLEIGH_RATIO: Final = 0.835  # (1 - d)/(1 + d) with depolarisation d = 0.09 of water, A. Morel 1974


def henyey_greenstein(cosine: Array, g: Array) -> Array:
    """(1 - g^2) / (4 pi (1 + g^2 - 2 g cos)^1.5) [1/sr]. L. Henyey and J. Greenstein 1941, doi 10.1086/144246.

    Two of them, one after the other, are one with the product of their g: light spread by g1 and scattered by g2.
    """
    q = 1 + g * g - 2 * g * cosine
    return (1 - g * g) / (4 * math.pi) * dr.rcp(q * dr.sqrt(q))


def sample_henyey_greenstein(u: Array, g: float) -> Array:
    """Cosine of the angle by the inverse of the cumulative function, for u uniform in 0 .. 1."""
    s = (1 - g * g) / (1 - g + 2 * g * u)
    return dr.clip((1 + g * g - s * s) / (2 * g), -1, 1)


def turning_phase(cosine: Array) -> Array:
    """Of what particles scatter by more than a few degrees, the share 1 - FORWARD_PEAK of all [1/sr]: Henyey and
    Greenstein's phase function, level within `PEAK_EDGE`."""
    return henyey_greenstein(dr.minimum(cosine, PEAK_EDGE), MEAN_COSINE)


def sample_turning(u: Array) -> Array:
    """Cosine of the angle of light so scattered, for u uniform in 0 .. 1."""
    share = u * (1 - FORWARD_PEAK)
    level = PEAK_EDGE + (share - _TAIL) * ((1 - PEAK_EDGE) / (1 - FORWARD_PEAK - _TAIL))
    return dr.select(share < _TAIL, sample_henyey_greenstein(dr.minimum(share, _TAIL), MEAN_COSINE), level)


def henyey_greenstein_backward(g: float) -> float:
    """Share of the light scattered by more than 90 degrees."""
    return (1 - g) / (2 * g) * ((1 + g) / math.sqrt(1 + g * g) - 1)


def water_molecules(cosine: Array) -> Array:
    """Phase function of pure sea water, 0.06225 (1 + 0.835 cos^2) [1/sr] (A. Morel 1974)."""
    return (1 + _RAYLEIGH_RATIO * cosine * cosine) * (3 / (4 * math.pi * (3 + _RAYLEIGH_RATIO)))


def _tail(cosine: float) -> float:
    """Share of the particles' scattering at angles with a lower cosine."""
    g = MEAN_COSINE
    return (1 - g * g) / (2 * g) * (1 / math.sqrt(1 + g * g - 2 * g * cosine) - 1 / (1 + g))


def _edge() -> float:
    """The cosine within which the phase function must be level for its rest to hold the share FORWARD_PEAK."""
    g, low, high = MEAN_COSINE, 0.0, 1.0
    for _ in range(60):
        middle = 0.5 * (low + high)
        level = (1 - g * g) / 2 / (1 + g * g - 2 * g * middle) ** 1.5 * (1 - middle)
        low, high = (middle, high) if _tail(middle) + level < 1 - FORWARD_PEAK else (low, middle)
    return low


PEAK_EDGE: Final = _edge()
_TAIL: Final = _tail(PEAK_EDGE)

"""Phase functions: how scattered light spreads over angle [1/sr], each integrating to 1 over the sphere."""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos.jit import Array

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


def henyey_greenstein_backward(g: float) -> float:
    """Share of the light scattered by more than 90 degrees."""
    return (1 - g) / (2 * g) * ((1 + g) / math.sqrt(1 + g * g) - 1)


def water_molecules(cosine: Array) -> Array:
    """Phase function of pure sea water, 0.06225 (1 + 0.835 cos^2) [1/sr] (A. Morel 1974)."""
    return (1 + _RAYLEIGH_RATIO * cosine * cosine) * (3 / (4 * math.pi * (3 + _RAYLEIGH_RATIO)))

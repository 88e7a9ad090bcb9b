"""Whitecaps as a camera sees them: patches of matt white, torn into lace, on the sea and from below it."""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.sunlight import LightArrays
from pelagos.optics.swell import Swell, whiteness_at
from pelagos.optics.texture import value_noise

ALBEDO: Final = 0.5  # of fresh foam: P. Koepke, Appl. Opt. 23:1816 (1984)
THROUGH: Final = 0.25  # share of the light above that comes out below it; assumed
_PATCH_M: Final = 2.6  # size of patches
_LACE_M: Final = (0.55, 0.16)  # of the meshes of the lace, coarse and fine
_BEND_M: Final = 0.25  # by which they are bent
_MEAN_LACE: Final = -0.086  # of a thread, on average
_THIN: Final = 1.05  # what whiteness, lace and patches must add up to
_WHITEST: Final = 0.55  # whiteness from which foam grows no denser
_SHARP: Final = 0.45  # from water to foam


def foam_cover(swell: Swell, x: Array, y: Array, lane: Array, footprint: Array) -> Array:
    """Share of a place that is foam, `Float` 0 to 1.

    Args:
        swell: grids, see `Swell.foam`.
        x, y: world [m], `Float`.
        lane: `UInt32`, row of `swell`.
        footprint: width of a pixel on the surface [m]; finer lace is left out.
    """
    white = whiteness_at(swell, x, y, lane)
    if swell.foam is None:
        return white

    def torn(white: Array) -> Array:
        patch, bend = value_noise(jit.Array3f(x / _PATCH_M, y / _PATCH_M, 0.3))
        total = 1.7 * dr.minimum(white, _WHITEST) + 0.7 * patch - _THIN
        u, v = 0.8 * x + 0.6 * y + _BEND_M * bend.y, 0.8 * y - 0.6 * x + _BEND_M * bend.x  # meshes run every way
        for number, size in enumerate(_LACE_M):  # threads where the noise changes sign, holes between them
            kept = dr.clip(1.6 - 1.2 * footprint / size, 0, 1)
            grain, _ = value_noise(jit.Array3f(u / size, v / size, 0.35 * (u - v) / size + 7.3 * number))
            total += kept * (0.45 - 1.5 * dr.abs(grain)) + (1 - kept) * _MEAN_LACE
        return dr.clip(total * (1 / _SHARP) + 0.5, 0, 1) * dr.minimum(0.3 + 0.8 * white, 0.9)

    return dr.if_stmt((white,), white > 0.02, torn, lambda white: 0 * white, mode="symbolic")


def foam_radiance(light: LightArrays, under: Array) -> Array:
    """Light of foam under an open sky `Array3f` [cd/m^2], seen from above or, where `under`, from below."""
    above = light.sun * dr.maximum(light.towards_sun.z, 0) + light.sky
    return above * (dr.select(under, THROUGH, ALBEDO) / math.pi)

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
_LACE_M: Final = (2.1, 0.55, 0.17)  # size of holes, coarse to fine
_SHARP: Final = 0.22  # of the whiteness, from water to foam


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
        lace = jit.Float(0)
        for number, (size, weight) in enumerate(zip(_LACE_M, (0.4, 0.4, 0.3), strict=True)):
            kept = dr.clip(1.6 - 1.2 * footprint / size, 0, 1)
            grain, _ = value_noise(jit.Array3f(x / size, y / size, 7.3 * number))
            lace += weight * kept * grain
        return dr.clip((white - 0.55 - 0.5 * lace) * (1 / _SHARP) + 0.5, 0, 1)

    return dr.if_stmt((white,), white > 0.02, torn, lambda white: 0 * white, mode="symbolic")


def foam_radiance(light: LightArrays, under: Array) -> Array:
    """Light of foam under an open sky `Array3f` [cd/m^2], seen from above or, where `under`, from below."""
    above = light.sun * dr.maximum(light.towards_sun.z, 0) + light.sky
    return above * (dr.select(under, THROUGH, ALBEDO) / math.pi)

"""Light along a line of sight through water: what is left of a surface's light, and what the water adds.

Linear light throughout. With range z, absorption a, scattering b, backscatter b_b:

    I = J e^{-c' z}  +  near(J (T_1 - e^{-c' z}))  +  far(J (T_2 - T_1))  +  V(z)

The first term is the sharp image. Petzold's measurements put a fifth of all scattering within one degree and half
within about five (C. D. Mobley, Light and Water, 1994, Section 3.8), so that c' = a + 0.8 b is what a pixel, and a
beam transmissometer with its acceptance of a degree, see as attenuation. Light scattered by a few degrees still
arrives near its place, T_1 = e^{-(a + b / 2) z}, and light scattered forward by more arrives farther off, T_2 =
e^{-l z} with the loss l of `light_field.LightField` (the split into near and far is that of B. L. McGlamery, Proc. SPIE
208:221, 1979, and J. S. Jaffe 1990, doi 10.1109/48.50695). V is veiling light with rates of its own, as D. Akkaynak
and T. Treibitz 2018 (doi 10.1109/CVPR.2018.00703) ask for: what the light field sends into the line of sight.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos.jit import Array
from pelagos.optics.water import WaterArrays

WITHIN_A_DEGREE: Final = 0.2  # of all scattering
WITHIN_FIVE_DEGREES: Final = 0.5


def sharp_transmission(water: WaterArrays, distance: Array) -> Array:
    """e^{-(a + 0.8 b) z}, `Array3f`: share of a point's light that arrives within a degree of its direction."""
    return dr.exp(-(water.absorption + (1 - WITHIN_A_DEGREE) * water.scattering) * distance)


def near_transmission(water: WaterArrays, distance: Array) -> Array:
    """e^{-(a + b / 2) z}, `Array3f`: share that arrives from within about five degrees."""
    return dr.exp(-(water.absorption + (1 - WITHIN_FIVE_DEGREES) * water.scattering) * distance)


_MOST: Final = (
    60.0  # e-folds that a light is let grow along its way: where it starts as 0, infinity times it is no number
)


def path_length(rate: Array, distance: Array) -> Array:
    """(1 - e^{-rate s}) / rate [m]: how many metres' worth of a light that falls along the way arrives.

    Args:
        rate: `Array3f` [1/m], of any sign.
        distance: s [m].
    """
    x = rate * distance
    small = dr.abs(x) < 1e-3
    return dr.select(small, distance * (1 - 0.5 * x), (1 - dr.exp(dr.minimum(-x, _MOST))) / dr.select(small, 1, rate))


def fitted_rate(whole: Array, source: Array, distance: Array) -> Array:
    """The rate with source path_length(rate, distance) = whole, `Array3f` [1/m], by Newton's method.

    f(x) = (1 - e^{-x}) / x falls and is convex, and lies over 1 - x / 2 and 1 / (1 + x): the greater of both answers is
    a start from which Newton's steps do not overshoot.
    """
    y = dr.clip(whole / dr.maximum(source * distance, 1e-20), 1e-6, 5)
    x = dr.maximum(2 * (1 - y), dr.rcp(y) - 1)
    for _ in range(4):
        small = dr.abs(x) < 1e-2
        safe = dr.select(small, 1, x)
        kept = dr.exp(-safe)
        f = dr.select(small, 1 - 0.5 * x + x * x / 6, (1 - kept) / safe)
        slope = dr.select(small, -0.5 + x / 3, (kept * (1 + safe) - 1) / (safe * safe))
        x -= (f - y) / slope
    return x / distance

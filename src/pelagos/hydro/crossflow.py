"""Cross-flow drag by strips along the hull, FRD. F21 Section 6.4."""

from __future__ import annotations

from typing import Final

import drjit as dr
import numpy as np

from pelagos.hydro.algebra import Vector, fma
from pelagos.jit import Array

# S. F. Hoerner, "Fluid-Dynamic Drag", 1965, as digitised in the MSS toolbox (T. I. Fossen and T. Perez, MIT licence)
HOERNER_B_OVER_2T: Final = (
    0.0109, 0.1766, 0.353, 0.4519, 0.4728, 0.4929, 0.4933, 0.5585, 0.6464, 0.8336,
    0.988, 1.3081, 1.6392, 1.86, 2.3129, 2.6, 3.0088, 3.4508, 3.7379, 4.0031,
)  # fmt: skip
HOERNER_CD: Final = (
    1.9661, 1.9657, 1.8976, 1.7872, 1.5837, 1.2786, 1.2108, 1.0836, 0.9986, 0.8796,
    0.8284, 0.7599, 0.6914, 0.6571, 0.6307, 0.5962, 0.5868, 0.5859, 0.5599, 0.5593,
)  # fmt: skip

_STILL: Final = 1e-6
"""Added to the flow past a strip, so that its direction is defined at rest [m/s] (MSS, `npsauv.m`)."""


def hoerner_drag_coefficient(beam: float, draught: float) -> float:
    """Two-dimensional drag coefficient of a section [-]: linear in B/(2T), clamped at the ends of the table."""
    return float(np.interp(beam / (2 * draught), HOERNER_B_OVER_2T, HOERNER_CD))


def strips(length: float, count: int, *, closed: bool) -> tuple[tuple[float, ...], float]:
    """Places [m] and width [m] of strips along a hull whose middle is at x = 0.

    `closed`: places from end to end, both included, as Fossen's programs have it (their widths then sum to
    `count`/(`count` - 1) of the length); otherwise the middles of `count` equal strips.
    """
    if closed:
        width = length / (count - 1)
        return tuple(-length / 2 + i * width for i in range(count)), width
    width = length / count
    return tuple(-length / 2 + (i + 0.5) * width for i in range(count)), width


def strip_drag(factor: Array, places: tuple[float, ...], across: Array, rate: Array) -> tuple[Array, Array]:
    """Sum over strips of |a| a and x |a| a with a = across + x rate, times -factor.

    Args:
        factor: rho/2 T Cd dx of one strip [kg/m].
        places: x of each strip [m].
        across: relative velocity across the axis at x = 0 [m/s].
        rate: its change along the axis [1/s] (rate of turn against the water).

    Returns:
        force [N] and its first moment in x [N m].
    """
    force = _drag(fma(places[0], rate, across))
    moment = places[0] * force
    for x in places[1:]:
        strip = _drag(fma(x, rate, across))
        force = force + strip
        if x != 0:
            moment = fma(x, strip, moment)
    return -factor * force, -factor * moment


def _drag(a: Array) -> Array:
    return dr.abs(a) * a


def crossflow(factors: tuple[Array, Array], places: tuple[float, ...], nu_r: Vector, *, heave: bool) -> list[Array]:
    """Wrench (6) [N, N m] of cross-flow drag in sway and yaw, and in heave and pitch if `heave`.

    `nu_r`: velocity relative to the water (6); its rates are those against the line of water along the hull.
    """
    y, n = strip_drag(factors[0], places, nu_r[1], nu_r[5])
    if not heave:
        return [0.0, y, 0.0, 0.0, 0.0, n]
    z, m = strip_drag(factors[1], places, nu_r[2], -nu_r[4])
    return [0.0, y, z, 0.0, -m, n]


def oblique_crossflow(factors: tuple[Array, Array], places: tuple[float, ...], nu_r: Vector) -> list[Array]:
    """Wrench (6) [N, N m] of cross-flow drag where sway and heave share the flow: each strip drags along its own flow.

    Of a strip at x, a = v + x r across and c = w - x q below: (C_y h a^2 + C_z b c^2) (a, c)/sqrt(a^2 + c^2). A. J.
    Healey, D. Lienard, IEEE J. Oceanic Eng. 18(3):327 (1993), doi 10.1109/JOE.1993.236372; T. I. Fossen's MSS toolbox,
    `npsauv.m`.

    Args:
        factors: rho/2 h C_y dx and rho/2 b C_z dx of one strip [kg/m].
        places: x of each strip [m].
        nu_r: velocity relative to the water (6).
    """
    y: Array = 0.0
    z: Array = 0.0
    m: Array = 0.0
    n: Array = 0.0
    for x in places:
        a, c = fma(x, nu_r[5], nu_r[1]), fma(-x, nu_r[4], nu_r[2])
        drag = (factors[0] * a * a + factors[1] * c * c) / (dr.sqrt(a * a + c * c) + _STILL)
        y, z = y - drag * a, z - drag * c
        m, n = m + x * drag * c, n - x * drag * a
    return [0.0, y, z, 0.0, m, n]

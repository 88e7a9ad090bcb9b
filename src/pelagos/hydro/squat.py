"""Squat of a ship in shallow open water: its sinkage and trim by speed and depth.

To slender-body theory a ship in shallow water of speed U and depth h sinks and trims by its sections alone, in
proportion to F^2/sqrt(1 - F^2), F = U/sqrt(g h): E. O. Tuck, J. Fluid Mech. 26:81 (1966), doi
10.1017/S0022112066001101. J. P. Hooft, "The behaviour of a ship in head waves at restricted water depths", Int.
Shipbuilding Progress 21:367 (1974), writes the integrals as two coefficients, 1.46 and 1.0 for usual ships: 1.96
together at the bow, as PIANC Report 121 (2014) has it. Level ground without banks, F up to 0.7: nearer to
F = 1 the theory has no limit, and speeds beyond F = 0.7 count as F = 0.7.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos.jit import Array

FASTEST: Final = 0.7
"""Froude number of the depth up to which the formula holds (PIANC 2014)."""
_DRY: Final = 1e-3
"""Least depth [m], at which ships lie that have fallen dry."""


def depth_froude_squared(speed: Array, depth: Array, gravity: float) -> Array:
    """F^2 = U^2/(g h) of a speed [m/s] in a depth of water [m], held at `FASTEST`; a speed astern counts as ahead."""
    return dr.minimum(dr.square(speed) / (gravity * dr.maximum(depth, _DRY)), FASTEST**2)


def squat(
    coefficients: tuple[Array, Array], volume: Array, length: Array, speed: Array, depth: Array, gravity: float
) -> tuple[Array, Array]:
    """Sinkage of the centre of flotation [m], positive down, and trim [rad], positive bow down.

    Args:
        coefficients: of sinkage by volume/length^2, and of trim by volume/length^3 [-].
        volume: displaced [m^3].
        length: between perpendiculars [m].
        speed: ahead through the water [m/s].
        depth: of the water, from surface to ground [m].
        gravity: [m/s^2].
    """
    square = depth_froude_squared(speed, depth, gravity)
    growth = square * dr.rsqrt(1 - square) * (volume / length**2)
    return coefficients[0] * growth, coefficients[1] / length * growth

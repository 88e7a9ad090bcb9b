"""Shallow water's part in manoeuvring: added masses and linear derivatives by depth, and the speed that a depth takes.

D. Clarke, P. Gedling, G. Hine, "The application of manoeuvring criteria in hull design using linear theory", Trans.
RINA 125:45 (1983), with the weights of D. Clarke, "The shallow water effect on linear derivatives in the ship
manoeuvring equations" (1997), Eq. 5: a section of beam b has K0 + K1 b/T + K2 (b/T)^2 times its added mass in deep
water, and b is parabolic along the hull. Beam over draught up to 4, depth over draught from 1.2: less water acts as
1.2 draughts. For resistance, H. Lackenby, "The effect of shallow water on ship speed", Shipbuilder and Marine Engine
Builder 70:446 (1963), as ITTC 7.5-04-01-01.1 has it; a speed in deep water beyond sqrt(g h), that of the
longest waves, counts as that. Level ground, no banks.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.jit import Array

SHALLOWEST: Final = 1.2
"""Depth over draught, below which the factors are held."""
_LOSS: Final = 0.1242
_LOSS_FROM: Final = 0.05
"""Midship section over depth squared from which it takes speed."""
_STEPS: Final = 12  # of the fixed point: speed to 3e-3; to 2e-2 for B/T = 4 in 1.2 draughts
_STILL: Final = 1e-3
"""Least speed that waves are taken against [m/s]."""


@dataclass(frozen=True)
class DepthFactors:
    """Factors on values of deep water: added mass in sway and in yaw, Yv, Yr, Nv and Nr."""

    sway_mass: Array
    yaw_mass: Array
    yv: Array
    yr: Array
    nv: Array
    nr: Array


def depth_factors(depth_over_draught: Array, beam_over_draught: float) -> DepthFactors:
    """Factors of a depth of water (Clarke 1997, Eq. 5, with K0, K1 and K2 of 1983).

    Args:
        depth_over_draught: h/T [-], held from `SHALLOWEST` on.
        beam_over_draught: B/T [-].
    """
    under = 1 / (dr.maximum(depth_over_draught, SHALLOWEST) - 1)
    square = under * under
    fifth = square * square * under
    k0 = 1 + 0.0775 * square - 0.0110 * square * under + 0.000068 * fifth
    k1 = -0.0643 * under + 0.0724 * square - 0.0113 * square * under + 0.0000767 * fifth
    k2 = 0.0342 * under

    def mean(first: float, second: float) -> Array:
        """With the means of b/B and of its square that count."""
        return k0 + first * beam_over_draught * k1 + second * beam_over_draught**2 * k2

    sway = mean(2 / 3, 8 / 15)
    return DepthFactors(
        sway_mass=sway, yaw_mass=mean(2 / 5, 24 / 105), yv=mean(1, 1), yr=sway, nv=sway, nr=mean(1 / 2, 1 / 3)
    )


def speed_loss(midship_area: float, depth: Array, speed: Array, gravity: float) -> Array:
    """Share of a speed [m/s] in deep water that is lost at the same thrust in a depth [m] (Lackenby 1963).

    midship_area: of the wet midship section [m^2].
    """
    blocked = dr.maximum(midship_area / dr.square(depth) - _LOSS_FROM, 0.0)
    waves = dr.tanh(dr.maximum(gravity * depth / dr.maximum(dr.square(speed), _STILL**2), 1.0))
    return _LOSS * blocked + 1 - dr.sqrt(waves)


def deep_speed_ratio(midship_area: float, depth: Array, speed: Array, gravity: float) -> Array:
    """Speed in deep water at which a ship has the resistance that it has at `speed` [m/s] in a depth [m], over that."""
    ratio: Array = 1.0
    for _ in range(_STEPS):
        ratio = 1 / (1 - speed_loss(midship_area, depth, speed * ratio, gravity))
    return ratio

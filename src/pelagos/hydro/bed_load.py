"""Grains of a river's or a sea's bed that the current carries along: when they move, and how fast.

R. L. Soulsby, Dynamics of Marine Sands (1997), Chapters 3 and 6 (skin friction of a rough bed, z0 = d/12) and the
threshold of motion of R. L. Soulsby and R. J. S. Whitehouse, Proc. Pacific Coasts and Ports '97, 149 (1997). L. C. van
Rijn, "Sediment transport, part I: bed load transport", J. Hydraul. Eng. 110:1431 (1984), doi
10.1061/(ASCE)0733-9429(1984)110:10(1431): the mean velocity of saltating grains, for quartz of 0.2 to 2 mm; it saw
fresh water, transport stages up to 25, and 0.07 to 1.5 m/s of the flow's mean velocity.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos.jit import Array
from pelagos.math.constants import GRAVITY

VON_KARMAN: Final = 0.4
EXCESS: Final = 1.65  # density of quartz over that of water, less one
VISCOSITY: Final = 1.14e-6  # kinematic, of fresh water at 15 degC [m^2/s]


def grain_number(grain: float) -> float:
    """D* = d ((s - 1) g/nu^2)^(1/3) of a grain's size [m]."""
    return grain * math.cbrt(EXCESS * GRAVITY / VISCOSITY**2)


def threshold(grain: float) -> float:
    """Friction velocity [m/s] at which grains of a size [m] begin to move.

    Shields' parameter is 0.30/(1 + 1.2 D*) + 0.055 (1 - exp(-0.020 D*)) (Soulsby and Whitehouse 1997).
    """
    number = grain_number(grain)
    shields = 0.30 / (1.0 + 1.2 * number) + 0.055 * (1.0 - math.exp(-0.020 * number))
    return math.sqrt(shields * EXCESS * GRAVITY * grain)


def skin_friction(speed: Array, height: float, grain: float) -> Array:
    """Friction velocity [m/s] of the grains alone, by the current's speed [m/s] at a height above the bed [m].

    u = (u*/0.4) ln(z/z0), z0 = d/12; what dunes add does not move grains.
    """
    return speed * (VON_KARMAN / math.log(12.0 * height / grain))


def grain_speed(friction: Array, grain: float) -> Array:
    """Mean speed of moving grains [m/s] by the friction velocity of the grains [m/s]; 0 below the threshold.

    1.5 T^0.6 ((s - 1) g d)^(1/2), T = (u*/u*c)^2 - 1 (van Rijn 1984).
    """
    stage = dr.maximum(dr.square(friction * (1.0 / threshold(grain))) - 1.0, 0.0)
    return 1.5 * math.sqrt(EXCESS * GRAVITY * grain) * dr.power(stage, 0.6)

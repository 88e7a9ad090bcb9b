"""Yaw of a ship by Nomoto's model with Norrbin's cubic term, whose constants follow the speed.

T r_dot + n1 r + n3 r^3 = K delta. Sources: K. Nomoto et al., Int. Shipbuilding Progress 4:354 (1957); N. H. Norrbin,
SSPA B104-3 (1963); J. van Amerongen, "Adaptive steering of ships", PhD thesis, Delft 1982; T. I. Fossen, "Handbook of
Marine Craft Hydrodynamics and Motion Control", 2nd ed., 2021, Section 6.5. For ships under way, at small drift angles.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.jit import Array

_HELD: Final = 0.1
"""Share of the lowest speed of the table below which damping no longer falls."""


@dataclass(frozen=True)
class Nomoto:
    """Constants by speed [m/s], rising: gain K [1/s], time T [s], cubic n3 [s^2]; linear: n1 [-]."""

    speeds: Sequence[float]
    gain: Sequence[float]
    time: Sequence[float]
    cubic: Sequence[float]
    linear: Array


def straight_lines(x: Array, at: Sequence[float], values: Sequence[float]) -> Array:
    """Straight lines through points; constant outside."""
    found: Array = values[0]
    for a, b, low, high in zip(at[:-1], at[1:], values[:-1], values[1:], strict=True):
        found = found + (high - low) / (b - a) * dr.clip(x - a, 0.0, b - a)
    return found


def yaw_acceleration(c: Nomoto, u: Array, r: Array, helm: Array) -> Array:
    """r_dot [rad/s^2] at a speed ahead u [m/s], yaw rate r [rad/s] and helm delta [rad], positive to starboard.

    Between and above the speeds of the table its constants hold, straight lines between them. Below the lowest, U1,
    with s = u/U1, those of a ship whose non-dimensional constants K L/U, T U/L, n3 (U/L)^2 stay: K s, T/s, n3/s^2.
    Astern nothing steers.
    """
    speed = dr.maximum(u, 0.0)
    gain, time = (straight_lines(speed, c.speeds, values) for values in (c.gain, c.time))
    cubic = straight_lines(speed, c.speeds, c.cubic)
    steer = dr.minimum(speed / c.speeds[0], 1.0)
    slow = dr.clip(dr.abs(u) / c.speeds[0], _HELD, 1.0)
    return (gain * steer * steer * helm - c.linear * slow * r - cubic / slow * r * r * r) / time

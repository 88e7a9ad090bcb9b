"""Depth of vehicles that no thruster pitches: flow and righting moment alone tilt them."""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector, matvec, transpose
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow

LEAN_RAD: Final = 0.2  # that a vehicle without pitch control takes to change its depth at speed


def upright_heave(flow: Flow, sinking: Array, current: Vector, neutral: float) -> Array:
    """Velocity along the body's z [m/s] that makes it sink through the water at a speed, and keeps it upright.

    Held level in depth, one that noses up by a meets the flow at w = V sin a, whose moment tilts it further; moved
    along its own x it meets no such flow. So the velocity is one through the water, across the body's own axes. A
    steady w tilts it by (V / V0)^2 w / V, V0 the neutral speed: of w it goes down with 1 - (V / V0)^2, beyond V0
    upwards. Small angles; where that factor is beyond 1 it is undone, so that the loop stays as slow, and w is limited
    to what tilts it by `LEAN_RAD`.

    Args:
        flow: how it lies and moves.
        sinking: speed through the water that is wanted beside that of its way ahead, downwards [m/s].
        current: velocity of the water, NED (3) [m/s].
        neutral: way through the water from which on the flow tilts it more than its weight rights it [m/s].
    """
    water = matvec(transpose(flow.rotation), current)
    way = flow.nu[0] - water[0]
    factor = 1 - way * way / neutral**2
    most = LEAN_RAD * neutral**2 * dr.rcp(dr.maximum(dr.abs(way), 1e-3 * neutral))
    return water[2] + dr.clip(sinking * factor / dr.maximum(factor * factor, 1.0), -most, most)

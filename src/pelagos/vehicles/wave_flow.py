"""Flow of waves past a vehicle.

The acceleration of the water that goes along, Dw/Dt = dw/dt + w . grad w with w of current and waves together, becomes
in the equation of motion the Froude-Krylov force and the added mass's part of a body as heavy as the water that it
displaces: exact for one much shorter than the waves (T. R. Auton, J. C. R. Hunt and M. Prud'homme, J. Fluid Mech.
197:241, 1988, doi 10.1017/S0022112088003246; J. N. Newman, Marine Hydrodynamics, 1977, Section 6.19). With the rate of
change at a place alone a neutral body would sink. A body under water feels them strip by strip, in the mean over its
length and, by that rate alone, in their change along it, as if its mass were spread like the water that it displaces:
Morison's force by strips, with the vehicle's own added mass and drag. What floats gets its vertical force and its
moments from the surface under its waterplane instead, without radiated and diffracted waves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector, add, matvec, transpose
from pelagos.jit import Array

_GAUSS: Final = 1 / math.sqrt(3)  # of half the length: exact for surfaces up to the third degree


@dataclass
class WaveFlow:
    """Waves at one vehicle.

    Attributes:
        velocity, acceleration: of the water, NED (3) [m/s], [m/s^2]; the acceleration is that of water that goes along.
        turning, turning_rate: of the line of water along a hull, body axes (3) [rad/s], [rad/s^2].
        elevation: of the surface, upwards [m].
        surface: roll and pitch of the surface (2) [rad], FRD.
    """

    velocity: list[Array]
    acceleration: list[Array]
    turning: Vector
    turning_rate: Vector
    elevation: Array
    surface: Vector


def along_hull(ocean: Any, position: Vector, rotation: Matrix, length: float, t: Array, current: Vector) -> WaveFlow:
    """The waves along a hull under water; position and current (3) [m/s] NED, rotation FRD -> NED."""
    axis = (rotation[0][0], -rotation[1][0], -rotation[2][0])
    motion = ocean.waves_along((position[0], -position[1], -position[2]), axis, length, t)
    acceleration = add(motion.acceleration, motion.carried([current[0], -current[1], -current[2]]))
    velocity, acceleration, change, rate = (
        [v[0], -v[1], -v[2]]
        for v in (motion.velocity, acceleration, motion.velocity_change, motion.acceleration_change)
    )
    back = transpose(rotation)
    turning, turning_rate = ([0.0, -c[2], c[1]] for c in (matvec(back, change), matvec(back, rate)))
    return WaveFlow(velocity, acceleration, turning, turning_rate, motion.elevation, (0.0, 0.0))


def surface_under(
    elevation: Callable[[Array, Array], Array], position: Vector, rotation: Matrix, length: float, beam: float
) -> tuple[Array, Vector]:
    """Mean elevation [m], and roll and pitch [rad], of the surface under a rectangular waterplane.

    `elevation(x, y)` at NED places; Gauss's two points along and across the hull, so that waves shorter than the hull
    move it less than long ones.
    """
    size = dr.sqrt(rotation[0][0] * rotation[0][0] + rotation[1][0] * rotation[1][0])
    cos, sin = rotation[0][0] / size, rotation[1][0] / size
    along, across = _GAUSS * length / 2, _GAUSS * beam / 2

    def at(a: float, b: float) -> Array:
        return elevation(position[0] + a * cos - b * sin, position[1] + a * sin + b * cos)

    bow_port, bow_starboard = at(along, -across), at(along, across)
    stern_port, stern_starboard = at(-along, -across), at(-along, across)
    bow, stern = bow_port + bow_starboard, stern_port + stern_starboard
    port, starboard = bow_port + stern_port, bow_starboard + stern_starboard
    roll = dr.atan2((port - starboard) / 2, 2 * across)
    pitch = dr.atan2((bow - stern) / 2, 2 * along)
    return (bow + stern) / 4, (roll, pitch)

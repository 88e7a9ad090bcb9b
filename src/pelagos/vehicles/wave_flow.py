"""What waves do to the flow past a vehicle.

The acceleration of the water becomes, in the equation of motion, the Froude-Krylov force and the added mass's part of a
body as heavy as the water that it displaces: exact for one much shorter than the waves (J. N. Newman, Marine
Hydrodynamics, 1977, Section 6.19). What floats gets its vertical force and its moments from the surface under its
waterplane instead, without radiated and diffracted waves.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector
from pelagos.jit import Array

_GAUSS: Final = 1 / math.sqrt(3)  # of half the length: exact for surfaces up to the third degree


@dataclass
class WaveFlow:
    """Waves at one vehicle.

    Attributes:
        velocity, acceleration: of the water, NED (3) [m/s], [m/s^2].
        elevation: of the surface, upwards [m].
        surface: roll and pitch of the surface (2) [rad], FRD.
    """

    velocity: list[Array]
    acceleration: list[Array]
    elevation: Array
    surface: Vector


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

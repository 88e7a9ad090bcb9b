"""The current at a vehicle: its velocity, how water that goes with it speeds up, and how it turns along the hull.

A body that displaces its own weight is pushed like the water in its place, displaced and added mass by the acceleration
of the water that goes along, Du/Dt (T. R. Auton, J. C. R. Hunt and M. Prud'homme, J. Fluid Mech. 197:241, 1988, doi
10.1017/S0022112088003246): adrift, it follows the water around a gyre.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.hydro.algebra import Matrix, Vector, add, matvec, minus, scaled, transpose
from pelagos.jit import Array
from pelagos.math.frames import flip_yz
from pelagos.ocean.current import UniformCurrent

_BEFORE: Final = 1e-3  # [s]: how far back along its path the water is asked for its speed


@dataclass
class Stream:
    """The current at a hull.

    Attributes:
        velocity: NED (3) [m/s].
        acceleration: of the water that goes along, NED (3) [m/s^2].
        turning: of the line of water along the hull, body axes (3) [rad/s].
    """

    velocity: Vector
    acceleration: Vector = (0.0, 0.0, 0.0)
    turning: Vector = (0.0, 0.0, 0.0)


def current_at(ocean: Any, position: Vector, t: Array) -> list[Array]:
    """Velocity of the water without the waves' at `position`, both NED (3)."""
    return [*flip_yz(ocean.current(flip_yz(jit.Array3f64(*position)), t))]


def stream_at(
    ocean: Any,
    position: Vector,
    rotation: Matrix,
    length: float,
    t: Array,
    velocity: Vector,
    orbital: Vector = (0.0, 0.0, 0.0),
) -> Stream:
    """The current at `position` NED [m] of a hull of `length` [m] turned by `rotation` (FRD -> NED).

    `velocity`: of the current there, see `current_at`; `orbital`: of the waves, which carry water through the current's
    changes too, NED (3) [m/s].
    """
    if all(isinstance(c, UniformCurrent) for c in getattr(ocean, "currents", [None])):
        return Stream(velocity)
    carried = add(position, scaled(-_BEFORE, add(velocity, orbital)))
    before = current_at(ocean, carried, dr.maximum(t - _BEFORE, 0.0))
    half = [0.5 * length * row[0] for row in rotation]
    bow, stern = current_at(ocean, add(position, half), t), current_at(ocean, add(position, minus(half)), t)
    along = matvec(transpose(rotation), scaled(1 / length, add(bow, minus(stern))))
    return Stream(velocity, scaled(1 / _BEFORE, add(velocity, minus(before))), [0.0, -along[2], along[1]])

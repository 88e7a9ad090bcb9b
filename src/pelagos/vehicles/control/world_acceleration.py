"""Accelerations in the world frame instead of an equation of motion: the door for a model of one's own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import drjit as dr

from pelagos import jit
from pelagos.hydro.algebra import Vector, add, matvec, minus, scaled, transpose
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.integrate import turned
from pelagos.vehicles.part import NonNegative, PartConfig, Positive

NAMES: Final = ("x_acceleration", "y_acceleration", "z_acceleration", "x_turn", "y_turn", "z_turn")


class WorldAccelerationConfig(PartConfig):
    """Linear and angular acceleration about the world's axes NWU [m/s^2], [rad/s^2], instead of the equation of motion.

    Weight, buoyancy, drag and currents do not act; what the vehicle touches stops it. Over a step the velocity of the
    origin in the world changes by the set-point times the step, whatever way the body turns.
    """

    type: Literal["world_acceleration"]
    limit_m_s2: Positive | None = None
    """Greatest set-point of an axis [m/s^2]; absent: any."""
    turn_limit_rad_s2: Positive | None = None
    """The same of the turns [rad/s^2]."""

    def build(self, plant: Plant) -> WorldAcceleration:
        """The mode."""
        return WorldAcceleration(self)


@dataclass(frozen=True)
class WorldAcceleration:
    """See `WorldAccelerationConfig`."""

    config: WorldAccelerationConfig
    memory: int = 0

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return NAMES

    def start(self, flow: Flow) -> list[Array]:
        """Nothing is kept."""
        return []

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """The body's acceleration that makes the world's."""
        moves = _limited(command[:3], self.config.limit_m_s2)
        turns = _limited(command[3:], self.config.turn_limit_rad_s2)
        return Demand(acceleration=from_world(flow, ned(moves), ned(turns), h)), []


def ned(nwu: Vector) -> list[Array]:
    """NWU (3) as NED, and the other way."""
    return [nwu[0], -nwu[1], -nwu[2]]


def from_world(
    flow: Flow, acceleration: Vector, turn: Vector, h: Array, fade: NonNegative = 0.0, turn_fade: NonNegative = 0.0
) -> list[Array]:
    """nu_dot (6), body axes, of a step of h [s] in which the world's velocity becomes (v + h a) (1 - h fade).

    Args:
        flow: where the step begins.
        acceleration: a, NED (3) [m/s^2].
        turn: angular acceleration, NED (3) [rad/s^2]; the rates become (w + h turn) (1 - h turn_fade).
        h: step [s].
        fade, turn_fade: share of the velocities that is lost in a second [1/s], as game engines damp bodies.

    A turn leaves vectors along its own axis as they are, so the new rates are the same in the old and the new body
    axes; the new velocity is seen from the new ones.
    """
    back = transpose(flow.rotation)
    rates = scaled(1 - h * turn_fade, add(flow.nu[3:], scaled(h, matvec(back, turn))))
    velocity = scaled(1 - h * fade, add(flow.nu[:3], scaled(h, matvec(back, acceleration))))
    small = turned(jit.Array4f64(1.0, 0.0, 0.0, 0.0), rates, h)
    seen = rotate_back(small, jit.Array3f64(*velocity))
    new = [seen[0], seen[1], seen[2], *rates]
    return scaled(1 / h, add(new, minus(flow.nu)))


def _limited(values: Vector, limit: float | None) -> list[Array]:
    return list(values) if limit is None else [dr.clip(v, -limit, limit) for v in values]

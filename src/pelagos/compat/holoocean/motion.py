"""The true motion of an agent at one tick, as HoloOcean's sensors report it: from the simulation's state alone."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import matrix_np
from pelagos.sim.state import ANGULAR_VELOCITY, ATTITUDE, POSITION, VELOCITY

Array = NDArray[np.float64]


class AgentMotion:
    """Of one agent, world NWU, from its row of `States.motion`.

    `before` is the tick before, for accelerations that are differences.
    """

    def __init__(self, row: Array, before: AgentMotion | None, dt: float) -> None:
        self._row, self._before, self._dt = row.copy(), before, dt
        if before is not None:
            before._before = None  # one tick is kept

    @property
    def position(self) -> Array:
        """`(3,)` of the body's origin [m]."""
        return self._row[POSITION]

    @cached_property
    def rotation(self) -> Array:
        """`(3, 3)` body FLU to world."""
        return matrix_np(self._row[ATTITUDE])

    @cached_property
    def velocity(self) -> Array:
        """`(3,)` [m/s]."""
        return np.asarray(self.rotation @ self._row[VELOCITY])

    @cached_property
    def turn(self) -> Array:
        """`(3,)` angular velocity [rad/s]."""
        return np.asarray(self.rotation @ self._row[ANGULAR_VELOCITY])

    def velocity_at(self, offset: Array) -> Array:
        """`(3,)` of a point of the body, from its origin in body axes [m/s]."""
        x, y, z = offset.tolist()
        (u, v, w), (p, q, r) = self._row[VELOCITY].tolist(), self._row[ANGULAR_VELOCITY].tolist()
        return np.asarray(self.rotation @ np.array((u + q * z - r * y, v + r * x - p * z, w + p * y - q * x)))

    @cached_property
    def acceleration(self) -> Array:
        """`(3,)` difference of velocity over the tick [m/s^2]; from rest at the first."""
        return np.asarray((self.velocity - (self._before.velocity if self._before else 0.0)) / self._dt)

    @cached_property
    def turn_acceleration(self) -> Array:
        """`(3,)` the same of the angular velocity [rad/s^2]."""
        return np.asarray((self.turn - (self._before.turn if self._before else 0.0)) / self._dt)

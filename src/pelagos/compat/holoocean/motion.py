"""The true motion of an agent at one tick, as HoloOcean's sensors report it: from the simulation's state alone."""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.frames import matrix_of_quaternion
from pelagos.sim.state import AgentState

Array = NDArray[np.float64]


class Motion:
    """Of one agent, world NWU; `before` is the tick before, for accelerations that are differences."""

    def __init__(self, state: AgentState, before: Motion | None, dt: float) -> None:
        self._state, self._before, self._dt = state, before, dt
        if before is not None:
            before._before = None  # one tick is kept

    @property
    def position(self) -> Array:
        """`(3,)` of the body's origin [m]."""
        return np.asarray(self._state.position[0])

    @cached_property
    def rotation(self) -> Array:
        """`(3, 3)` body FLU to world."""
        return matrix_of_quaternion(self._state.attitude[0])

    @property
    def attitude(self) -> Array:
        """`(4,)` (w, x, y, z)."""
        return np.asarray(self._state.attitude[0])

    @cached_property
    def velocity(self) -> Array:
        """`(3,)` [m/s]."""
        return np.asarray(self.rotation @ self._state.velocity[0])

    @cached_property
    def turn(self) -> Array:
        """`(3,)` angular velocity [rad/s]."""
        return np.asarray(self.rotation @ self._state.angular_velocity[0])

    def velocity_at(self, offset: Array) -> Array:
        """`(3,)` of a point of the body, from its origin in body axes [m/s]."""
        (x, y, z), (p, q, r) = offset.tolist(), self._state.angular_velocity[0].tolist()
        return np.asarray(self.rotation @ (self._state.velocity[0] + (q * z - r * y, r * x - p * z, p * y - q * x)))

    @cached_property
    def acceleration(self) -> Array:
        """`(3,)` difference of velocity over the tick [m/s^2]; from rest at the first."""
        return np.asarray((self.velocity - (self._before.velocity if self._before else 0.0)) / self._dt)

    @cached_property
    def turn_acceleration(self) -> Array:
        """`(3,)` the same of the angular velocity [rad/s^2]."""
        return np.asarray((self.turn - (self._before.turn if self._before else 0.0)) / self._dt)

    def settle(self) -> None:
        """Work out what the next tick needs of this one."""
        _ = self.velocity, self.turn

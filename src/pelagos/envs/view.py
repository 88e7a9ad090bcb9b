"""The vehicle as its task sees it: its state in world NWU and body FLU, as arrays with one lane a copy."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math import so3
from pelagos.math.frames import flip_quaternion, flip_yz
from pelagos.vehicles.state import VehicleState

Vector = list[Array]


class View:
    """A vehicle at one moment, and what its task remembers. All lanes `Float64`, vectors as lists of components.

    Attributes:
        position: world NWU (3) [m].
        attitude: (w, x, y, z), body FLU to world.
        velocity: over ground, body FLU (3) [m/s].
        angular_velocity: body FLU (3) [rad/s].
        acceleration: rate of change of `velocity` over the last tick (3) [m/s^2].
        angular_acceleration: rate of change of `angular_velocity` over the last tick (3) [rad/s^2].
        actuators: states, in the order of `Vehicle.actuator_names`.
        memory: what the task keeps, by name.
        current: of the water at the vehicle, world NWU (3) [m/s].
        t: since the episode began [s].
        step: decisions since the episode began, `UInt32`.
    """

    def __init__(
        self, state: VehicleState, memory: Mapping[str, Array], *, actuators: int, t: Array, step: Array, ocean: Any
    ) -> None:
        self._position = flip_yz(state.position)
        self._attitude = flip_quaternion(state.attitude)
        self.position: Vector = [*self._position]
        self.attitude: Vector = [*self._attitude]
        self.velocity: Vector = [*flip_yz(state.velocity)]
        self.angular_velocity: Vector = [*flip_yz(state.angular_velocity)]
        self.acceleration: Vector = [*flip_yz(state.acceleration)]
        self.angular_acceleration: Vector = [*flip_yz(state.angular_acceleration)]
        self.actuators: Vector = list(state.actuators[:actuators])
        self.memory = memory
        self.t, self.step = t, step
        self._ocean = ocean

    @property
    def current(self) -> Vector:
        """Of the water at the vehicle, without waves, world NWU (3) [m/s]."""
        return [*self._ocean.current(self._position, self.t)]

    @property
    def surface(self) -> Array:
        """Height of the water's surface above the vehicle's place over the mean [m]."""
        return self._ocean.elevation(self._position[0], self._position[1], self.t)

    @property
    def ground_velocity(self) -> Vector:
        """World NWU (3) [m/s]."""
        return self.to_world(self.velocity)

    @property
    def forward(self) -> Vector:
        """The body's x axis seen from the world (3)."""
        return [row[0] for row in so3.matrix(self.attitude)]

    @property
    def up(self) -> Vector:
        """The body's z axis seen from the world (3)."""
        return [row[2] for row in so3.matrix(self.attitude)]

    @property
    def yaw(self) -> Array:
        """Of the bow, from north to west [rad], -pi .. pi."""
        ahead = self.forward
        return dr.atan2(ahead[1], ahead[0])

    def to_body(self, vector: Vector) -> Vector:
        """A world vector (3) seen from the body."""
        return [*so3.rotate_back(self._attitude, jit.Array3f64(*vector))]

    def to_world(self, vector: Vector) -> Vector:
        """A body vector (3) seen from the world."""
        return [*so3.rotate(self._attitude, jit.Array3f64(*vector))]


def norm(vector: Vector) -> Array:
    """Length."""
    return dr.sqrt(sum(c * c for c in vector))


def minus(a: Vector, b: Vector) -> Vector:
    """a - b."""
    return [p - q for p, q in zip(a, b, strict=True)]


def wrapped(angle: Array) -> Array:
    """The same direction between -pi and pi [rad]."""
    return dr.atan2(dr.sin(angle), dr.cos(angle))

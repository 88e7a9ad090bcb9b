"""Keys and plant of every law for rotors that lift: the attitude of a multirotor, and its position."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.part import NonNegative, PartConfig, Positive

LEAST_LIFT: Final = 0.3  # of gravity: a multirotor without thrust cannot turn
_TURN: Final = 0.2  # rad of the attitude loop in a step: beyond it the step's delay makes it swing


class RotorcraftConfig(PartConfig):
    """Frequencies and limits of a law's two loops: of its place or height, and of its attitude."""

    frequency_rad_s: Positive
    """Of the loop that keeps place or height [rad/s]."""
    turn_frequency_rad_s: Positive
    """Of the attitude loop [rad/s]; no more than 0.2 rad a step."""
    ratio: Positive = 0.9
    """Damping ratio [-]."""
    integral: NonNegative = 0.2
    """Rate of the integrator over its loop's frequency [-]."""
    reach_m: Positive = 3.0
    """Errors of place or height count no more than this [m]."""


@dataclass(frozen=True)
class Rotorcraft:
    """A body whose rotors lift it along its own z axis, and turn it."""

    config: RotorcraftConfig
    mass: float
    inertia: Sequence[float]
    gravity: float
    allocation: Allocation

    def turn_frequency(self, h: Array) -> Array:
        """Frequency of the attitude loop [rad/s] at a step h [s]."""
        return dr.minimum(self.config.turn_frequency_rad_s, _TURN / h)

    def approach(self, frequency: Array, error: Array, integral: Array, speed: Array, h: Array) -> tuple[Array, Array]:
        """Acceleration [m/s^2] that takes an error [m] to zero (PID by pole placement), and its integral [m] a step on.

        Args:
            frequency: of the loop [rad/s].
            error: goal minus place [m].
            integral: so far [m].
            speed: away from the goal's own motion [m/s].
            h: step [s].
        """
        c = self.config
        near = dr.clip(error, -c.reach_m, c.reach_m)
        kept = dr.clip(integral + h * frequency * c.integral * near, -c.reach_m, c.reach_m)
        return frequency * frequency * (near + kept) - 2 * c.ratio * frequency * speed, kept

    def turning(self, frequency: Array, axis: int, angle: Array, rate: Array) -> Array:
        """Moment [N m] about a body axis that takes an angle [rad] to zero, at a rate of turn [rad/s]."""
        return self.inertia[axis] * (frequency * frequency * angle - 2 * self.config.ratio * frequency * rate)


def airframe(plant: Plant) -> tuple[float, list[float], float, Allocation]:
    """Mass [kg], moments of inertia [kg m^2], gravity [m/s^2] and allocation of a rotorcraft, without added mass."""
    body = plant.body
    inertia = [float(body.mass_matrix[i, i]) for i in (3, 4, 5)]
    return float(body.mass_matrix[0, 0]), inertia, body.gravity, allocation_of(plant.model, (2, 3, 4, 5))

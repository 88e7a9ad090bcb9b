"""Third-order reference model: what a set-point becomes before a control law follows it. F21 Chapter 12."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.angle import smallest_angle


@dataclass(frozen=True)
class ReferenceModel:
    """A critically or otherwise damped third-order filter with a limited rate.

    Attributes:
        frequency: [rad/s].
        damping: [-].
        rate_limit: [1/s] in the unit of the set-point.
        angle: the set-point is an angle, which goes the short way round.
    """

    frequency: float
    damping: float
    rate_limit: float
    angle: bool

    def step(self, x: Array, v: Array, a: Array, setpoint: Array, h: Array) -> tuple[Array, Array, Array]:
        """Value, rate and acceleration after one explicit Euler step of h [s]."""
        w, damping = self.frequency, 2 * self.damping + 1
        to_go = smallest_angle(setpoint - x) if self.angle else setpoint - x
        jerk = w**3 * to_go - damping * w**2 * v - damping * w * a
        moved = x + h * v
        if self.angle:
            moved = smallest_angle(moved)
        return moved, dr.clip(v + h * a, -self.rate_limit, self.rate_limit), a + h * jerk

"""Attitude of a multirotor: roll and pitch are held, the nose turns at a rate, and the height is kept.

Source: F21 Chapter 15 (PID by pole placement), with the thrust that a tilt asks for; for a pilot's sticks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive

_TURN: Final = 0.2  # rad of the attitude loop in a step: beyond it the step's delay makes it swing
_UPRIGHT: Final = 0.3  # cosine of the steepest tilt at which thrust still makes up for it
_LAG: Final = 0.5  # rad of the nose behind its rate of turn: no more counts
_LEAST_LIFT: Final = 0.3  # of gravity: a multirotor without thrust cannot turn


class AttitudeConfig(PartConfig):
    """Set-points: roll and pitch of FLU in NWU [rad], rate of turn to the left [rad/s], height z [m]."""

    type: Literal["attitude"]
    frequency_rad_s: Positive
    """Of the height loop [rad/s]."""
    turn_frequency_rad_s: Positive
    """Of the attitude loop [rad/s]; no more than 0.2 rad a step."""
    ratio: Positive = 0.9
    """Damping ratio [-]."""
    integral: NonNegative = 0.2
    """Rate of the height's integrator over its loop's frequency [-]."""
    reach_m: Positive = 3.0
    """Errors of height count no more than this [m]."""

    def build(self, plant: Plant) -> Attitude:
        """The control law."""
        body = plant.body
        inertia = [float(body.mass_matrix[i, i]) for i in (3, 4, 5)]
        allocation = allocation_of(plant.model, (2, 3, 4, 5))
        return Attitude(self, float(body.mass_matrix[0, 0]), inertia, body.gravity, allocation)


@dataclass(frozen=True)
class Attitude:
    """See `AttitudeConfig`; memory: integrals of the errors of height [m] and of the rate of turn [rad]."""

    config: AttitudeConfig
    mass: float
    inertia: Sequence[float]
    gravity: float
    allocation: Allocation
    memory: int = 2
    commands: tuple[str, ...] = ("roll", "pitch", "yaw_rate", "z")

    def start(self, flow: Flow) -> list[Array]:
        """No integrals."""
        return [0.0, 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the rotors."""
        c = self.config
        roll, pitch, rate, z = command
        f = dr.minimum(c.turn_frequency_rad_s, _TURN / h)
        angles = (smallest_angle(roll - flow.roll), smallest_angle(-pitch - flow.pitch))
        moments = [
            inertia * (f * f * angle - 2 * c.ratio * f * turn)
            for inertia, angle, turn in zip(self.inertia, angles, flow.nu[3:5], strict=False)
        ]
        slow = -rate - flow.nu[5]
        lag = dr.clip(memory[1] + h * slow, -_LAG, _LAG)
        moments.append(self.inertia[2] * f * (slow + 0.25 * f * lag))  # critically damped
        error = dr.clip(-z - flow.position[2], -c.reach_m, c.reach_m)
        w = c.frequency_rad_s
        kept = dr.clip(memory[0] + h * w * c.integral * error, -c.reach_m, c.reach_m)
        sinking = sum(r * v for r, v in zip(flow.down, flow.nu[:3], strict=True))
        wanted = w * w * (error + kept) - 2 * c.ratio * w * sinking  # down [m/s^2]
        lift = dr.maximum(self.gravity - wanted, _LEAST_LIFT * self.gravity)
        force = -self.mass * lift / dr.maximum(flow.down[2], _UPRIGHT)
        return Demand(self.allocation.commands([0.0, 0.0, force, *moments])), [kept, lag]

"""Attitude of a multirotor: roll and pitch are held, the nose turns at a rate, and the height is kept.

Source: F21 Chapter 15 (PID by pole placement), with the thrust that a tilt asks for; for a pilot's sticks.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.control.rotorcraft import LEAST_LIFT, Rotorcraft, RotorcraftConfig, airframe
from pelagos.vehicles.flow import Flow

_UPRIGHT: Final = 0.3  # cosine of the steepest tilt at which thrust still makes up for it
_LAG: Final = 0.5  # rad of the nose behind its rate of turn: no more counts


class AttitudeConfig(RotorcraftConfig):
    """Set-points: roll and pitch of FLU in NWU [rad], rate of turn to the left [rad/s], height z [m]."""

    type: Literal["attitude"]

    def build(self, plant: Plant) -> Attitude:
        """The control law."""
        return Attitude(self, *airframe(plant))


@dataclass(frozen=True)
class Attitude(Rotorcraft):
    """See `AttitudeConfig`; memory: integrals of the errors of height [m] and of the rate of turn [rad]."""

    memory: int = 2
    commands: tuple[str, ...] = ("roll", "pitch", "yaw_rate", "z")

    def start(self, flow: Flow) -> list[Array]:
        """No integrals."""
        return [0.0, 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the rotors."""
        roll, pitch, rate, z = command
        f = self.turn_frequency(h)
        angles = (smallest_angle(roll - flow.roll), smallest_angle(-pitch - flow.pitch))
        moments = [self.turning(f, axis, angle, flow.nu[3 + axis]) for axis, angle in enumerate(angles)]
        slow = -rate - flow.nu[5]
        lag = dr.clip(memory[1] + h * slow, -_LAG, _LAG)
        moments.append(self.inertia[2] * f * (slow + 0.25 * f * lag))  # critically damped
        sinking = sum(r * v for r, v in zip(flow.down, flow.nu[:3], strict=True))
        wanted, kept = self.approach(self.config.frequency_rad_s, -z - flow.position[2], memory[0], sinking, h)
        lift = dr.maximum(self.gravity - wanted, LEAST_LIFT * self.gravity)
        force = -self.mass * lift / dr.maximum(flow.down[2], _UPRIGHT)
        return Demand(self.allocation.commands([0.0, 0.0, force, *moments])), [kept, lag]

"""Heading of a ship by its rudder: PID."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import drjit as dr
from pydantic import Field

from pelagos.jit import Array
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, Number, PartConfig, Positive


class RudderHeadingConfig(PartConfig):
    """Set-point: compass heading [rad]. Source: F21 Chapter 15 (PID heading autopilot)."""

    type: Literal["rudder_heading"]
    rudder: str
    """The actuator; positive turns to starboard."""
    kp: NonNegative
    """Helm by heading error [-]."""
    kd_s: NonNegative
    """Helm by yaw rate [s]."""
    ki_1_s: NonNegative
    """Helm by the integral of the heading error [1/s]."""
    limit_deg: Positive
    """Largest helm; the integrator stands still beyond [deg]."""
    orders: dict[str, Number] = Field(default_factory=dict)
    """Orders to other actuators while this mode steers, such as revolutions of the engine, in their own units."""

    def build(self, plant: Plant) -> RudderHeading:
        """The control law."""
        return RudderHeading(self)

    @property
    def uses(self) -> list[str]:
        """Actuators that must exist."""
        return [self.rudder, *self.orders]


@dataclass(frozen=True)
class RudderHeading:
    """See `RudderHeadingConfig`; memory: integral of the heading error [rad s]."""

    config: RudderHeadingConfig
    commands: tuple[str, ...] = ("heading",)
    memory: int = 1

    def start(self, flow: Flow) -> list[Array]:
        """No integral."""
        return [0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """The helm."""
        c = self.config
        error = smallest_angle(command[0] - flow.yaw)
        asked = c.kp * error - c.kd_s * flow.nu[5] + c.ki_1_s * memory[0]
        limit = math.radians(c.limit_deg)
        free = (dr.abs(asked) < limit) | (asked * error < 0)
        return Demand({**c.orders, c.rudder: dr.clip(asked, -limit, limit)}), [
            memory[0] + dr.select(free, h * error, 0.0)
        ]

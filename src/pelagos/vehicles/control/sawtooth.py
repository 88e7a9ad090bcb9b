"""Sawtooth flight of an underwater glider: sinking and rising by buoyancy, pitched by a moving mass."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive


class SawtoothConfig(PartConfig):
    """Set-points: upper and lower turning depth [m, down], glide pitch [rad, positive], compass heading [rad]."""

    type: Literal["sawtooth"]
    buoyancy_engine: str
    """The actuator that sinks and lifts."""
    moving_mass: str
    """The actuator that pitches."""
    rudder: str
    """The actuator that steers."""
    volume_m3: Positive
    """Volume beyond neutral when rising, and as much below when sinking [m^3]."""
    kp_pitch_m: NonNegative
    """Mass position by pitch error [m/rad]."""
    ki_pitch_m_s: NonNegative
    """Mass position by the integral of the pitch error [m/(rad s)]."""
    mass_limit_m: Positive
    """Largest position of the mass; the integrator stands still beyond [m]."""
    kp_heading: NonNegative
    """Rudder by heading error [-]."""
    kd_heading_s: NonNegative
    """Rudder by yaw rate [s]."""
    rudder_limit_deg: Positive
    """[deg]"""

    def build(self, plant: Plant) -> Sawtooth:
        """The control law."""
        return Sawtooth(self)

    @property
    def uses(self) -> list[str]:
        """Actuators that must exist."""
        return [self.buoyancy_engine, self.moving_mass, self.rudder]


@dataclass(frozen=True)
class Sawtooth:
    """See `SawtoothConfig`; memory: 1 while sinking, -1 while rising, and the integral of the pitch error [rad s]."""

    config: SawtoothConfig
    commands: tuple[str, ...] = ("upper_depth", "depth", "glide_pitch", "heading")
    memory: int = 2

    def start(self, flow: Flow) -> list[Array]:
        """Sinking."""
        return [1.0, 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Volume, mass position and rudder."""
        c = self.config
        upper, lower, glide, heading = command
        depth = flow.position[2]
        sinking = dr.select(depth >= lower, -1.0 + 0 * depth, dr.select(depth <= upper, 1.0 + 0 * depth, memory[0]))
        error = -sinking * glide - flow.pitch
        asked = -c.kp_pitch_m * error - c.ki_pitch_m_s * memory[1]
        free = (dr.abs(asked) < c.mass_limit_m) | (asked * error > 0)
        integral = dr.select(sinking == memory[0], dr.select(free, memory[1] + h * error, memory[1]), -memory[1])
        limit = math.radians(c.rudder_limit_deg)
        ahead = dr.mulsign(1.0 + 0 * depth, flow.nu_r[0])
        steer = ahead * (c.kp_heading * smallest_angle(heading - flow.yaw) - c.kd_heading_s * flow.nu[5])
        demand = {
            c.buoyancy_engine: -sinking * c.volume_m3,
            c.moving_mass: dr.clip(asked, -c.mass_limit_m, c.mass_limit_m),
            c.rudder: dr.clip(steer, -limit, limit),
        }
        return Demand(demand), [sinking, integral]

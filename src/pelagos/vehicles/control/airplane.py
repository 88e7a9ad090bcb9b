"""Autopilot of a small aeroplane: altitude, course and airspeed by successive loops.

Source: R. W. Beard, T. W. McLain, "Small Unmanned Aircraft", Princeton 2012, Chapter 6.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import drjit as dr

from pelagos.hydro.algebra import dot
from pelagos.jit import Array
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, Number, PartConfig, Positive


class AirplaneConfig(PartConfig):
    """Set-points: height above the sea [m], compass heading [rad], airspeed [m/s]."""

    type: Literal["airplane"]
    elevator: str
    """The actuator that pitches; positive brings the nose down."""
    aileron: str
    """The actuator that rolls; positive rolls to starboard."""
    rudder: str
    """The actuator that yaws."""
    propeller: str
    """The actuator that drives."""
    kp_height: NonNegative
    """Pitch by height error [rad/m]."""
    ki_height: NonNegative
    """Pitch by the integral of the height error [rad/(m s)]."""
    pitch_limit_deg: Positive
    """[deg]"""
    kp_pitch: NonNegative
    """Elevator by pitch error [-]."""
    kd_pitch_s: NonNegative
    """Elevator by pitch rate [s]."""
    kp_heading: NonNegative
    """Bank by heading error [-]."""
    bank_limit_deg: Positive
    """[deg]"""
    kp_roll: NonNegative
    """Aileron by roll error [-]."""
    kd_roll_s: NonNegative
    """Aileron by roll rate [s]."""
    k_yaw_s: NonNegative
    """Rudder by yaw rate [s]."""
    kp_speed: NonNegative
    """Propeller by airspeed error, in its unit by [m/s]."""
    ki_speed: NonNegative
    """Propeller by the integral of the airspeed error, in its unit by [m]."""
    trim_drive: Number
    """Propeller in level cruise, in its unit."""

    def build(self, plant: Plant) -> Airplane:
        """The control law."""
        return Airplane(self)

    @property
    def uses(self) -> list[str]:
        """Actuators that must exist."""
        return [self.elevator, self.aileron, self.rudder, self.propeller]


@dataclass(frozen=True)
class Airplane:
    """See `AirplaneConfig`; memory: integrals of the height error [m s] and of the speed error [m]."""

    config: AirplaneConfig
    commands: tuple[str, ...] = ("height", "heading", "airspeed")
    memory: int = 2

    def start(self, flow: Flow) -> list[Array]:
        """No integrals."""
        return [0.0, 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Surfaces and propeller."""
        c = self.config
        p, q, r = flow.nu[3:]
        higher = dr.clip(command[0] + flow.position[2], -20.0, 20.0)
        climb, bank_limit = math.radians(c.pitch_limit_deg), math.radians(c.bank_limit_deg)
        asked = c.kp_height * higher + c.ki_height * memory[0]
        pitch = dr.clip(asked, -climb, climb)
        heights = dr.select(asked == pitch, memory[0] + h * higher, memory[0])
        bank = dr.clip(c.kp_heading * smallest_angle(command[1] - flow.yaw), -bank_limit, bank_limit)
        faster = command[2] - dr.sqrt(dot(flow.nu_r[:3], flow.nu_r[:3]))
        speeds = dr.clip(memory[1] + h * faster, -50.0, 50.0)
        demand = {
            c.elevator: -c.kp_pitch * (pitch - flow.pitch) + c.kd_pitch_s * q,
            c.aileron: c.kp_roll * (bank - flow.roll) - c.kd_roll_s * p,
            c.rudder: c.k_yaw_s * (r - 9.81 * dr.tan(bank) / dr.maximum(command[2], 1.0)),
            c.propeller: c.trim_drive + c.kp_speed * faster + c.ki_speed * speeds,
        }
        return Demand(demand), [heights, speeds]

"""Autopilot of surface craft with thrusters: heading by a PID with reference model, and surge force or speed.

Source: F21 Chapter 15 (PID by pole placement), as in Fossen's Python Vehicle Simulator for the Otter.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import drjit as dr

from pelagos.errors import ScenarioError
from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.actuators.thruster import QuadraticCurve, Thruster
from pelagos.vehicles.control.allocation import Allocation, allocation_of
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.control.reference import ReferenceModel
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive


class SurgeGains(PartConfig):
    """Speed through the water by a surge force."""

    kp_kg_s: NonNegative
    """Force by speed error [kg/s]."""
    ki_kg_s2: NonNegative
    """Force by the integral of the speed error [kg/s^2]."""
    drag_kg_s: NonNegative = 0.0
    """Feed-forward: force by wanted speed [kg/s]."""
    drag_kg_m: NonNegative = 0.0
    """Feed-forward: force by wanted speed squared [kg/m]."""
    limit_n: Positive
    """Largest force; the integrator stands still beyond it [N]."""


class HeadingThrustConfig(PartConfig):
    """Set-points: compass heading [rad], and surge force [N] or, with `surge`, speed through the water [m/s]."""

    type: Literal["heading_thrust"]
    inertia_kg_m2: Positive
    """m of the model m r_dot + d r = N [kg m^2]."""
    damping_kg_m2_s: NonNegative
    """d of the model [kg m^2/s]."""
    frequency_rad_s: Positive
    """Of the closed loop [rad/s]."""
    ratio: Positive = 1.0
    """Damping ratio of the closed loop [-]."""
    reference_rad_s: Positive
    """Natural frequency of the reference model [rad/s]."""
    reference_damping: Positive = 1.0
    """Damping ratio of the reference model [-]."""
    rate_limit_deg_s: Positive
    """Largest yaw rate of the reference [deg/s]."""
    short_way: bool = True
    """The reference turns the short way round, and headings wrap; otherwise angles count on."""
    moment_limit_n_m: Positive | None = None
    """Integrator stands still beyond this moment [N m]; None: never."""
    surge: SurgeGains | None = None
    """The speed loop; left out: the second set-point is the surge force."""
    allocation: Literal["saturated", "forward_coefficient"] = "saturated"
    """Thrust astern by its own coefficient and scaled at saturation, or as Fossen's program with the one for ahead."""

    def build(self, plant: Plant) -> HeadingThrust:
        """The control law.

        Raises:
            ScenarioError: the thrusters cannot do it, or one has no coefficient for thrust ahead.
        """
        allocation = allocation_of(plant.model, (0, 5))
        for name, part in allocation.thrusters.items() if self.allocation == "forward_coefficient" else ():
            if not (isinstance(part, Thruster) and isinstance(part.curve, QuadraticCurve)):
                raise ScenarioError(
                    f"allocation forward_coefficient is for actuators of the type thruster, which have a coefficient "
                    f"forward; {name!r} has none: give allocation: saturated"
                )
        return HeadingThrust(self, allocation)


@dataclass(frozen=True)
class HeadingThrust:
    """See `HeadingThrustConfig`."""

    config: HeadingThrustConfig
    allocation: Allocation
    memory: int = 5

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return ("heading", "surge_force" if self.config.surge is None else "speed")

    def start(self, flow: Flow) -> list[Array]:
        """The reference at the present heading."""
        return [0.0, flow.yaw, 0.0, 0.0, 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the thrusters."""
        c = self.config
        integral, heading, rate, acceleration, speed_integral = memory
        error = flow.yaw - heading
        if c.short_way:
            error = smallest_angle(error)
        kp = c.inertia_kg_m2 * c.frequency_rad_s**2
        kd = 2 * c.inertia_kg_m2 * c.ratio * c.frequency_rad_s - c.damping_kg_m2_s
        moment = -kp * error - kd * (flow.nu[5] - rate) - kp * c.frequency_rad_s / 10 * integral
        step = h * error
        if c.moment_limit_n_m is not None:
            step = dr.select((dr.abs(moment) < c.moment_limit_n_m) | (moment * error > 0), step, 0.0)
        reference = ReferenceModel(
            c.reference_rad_s, c.reference_damping, math.radians(c.rate_limit_deg_s), c.short_way
        )
        new = reference.step(heading, rate, acceleration, command[0], h)
        force, speed_integral = self._surge(speed_integral, flow, command[1], h)
        kept = [integral + step, *new, speed_integral]
        return Demand(self._share([force, 0.0, 0.0, 0.0, 0.0, moment])), kept

    def _surge(self, integral: Array, flow: Flow, setpoint: Array, h: Array) -> tuple[Array, Array]:
        gains = self.config.surge
        if gains is None:
            return setpoint, integral
        error = setpoint - flow.nu_r[0]
        drag = gains.drag_kg_s * setpoint + gains.drag_kg_m * dr.abs(setpoint) * setpoint
        asked = drag + gains.kp_kg_s * error + gains.ki_kg_s2 * integral
        given = dr.clip(asked, -gains.limit_n, gains.limit_n)
        free = (asked == given) | ((asked - given) * error < 0)
        return given, dr.select(free, integral + h * error, integral)

    def _share(self, wrench: Vector) -> dict[str, Array]:
        if self.config.allocation == "saturated":
            return self.allocation.commands(wrench)
        found = {}
        for (name, part), row in zip(self.allocation.thrusters.items(), self.allocation.inverse, strict=True):
            assert isinstance(part, Thruster)
            assert isinstance(part.curve, QuadraticCurve)
            scaled = (row[0] * wrench[0] + row[5] * wrench[5]) / part.curve.forward
            found[name] = dr.mulsign(dr.sqrt(dr.abs(scaled)), scaled)
        return found

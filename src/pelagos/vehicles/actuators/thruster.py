"""Fixed thrusters anywhere on the hull, with a thrust curve."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import drjit as dr
import numpy as np
from pydantic import model_validator

from pelagos.hydro import thruster
from pelagos.hydro.algebra import Vector, mul
from pelagos.jit import Array
from pelagos.vehicles.actuators.inflow import (
    BSeriesInflowConfig,
    DiscInflowConfig,
    DiscOnly,
    Inflow,
    InflowConfig,
    Shaft,
    build_inflow,
    check_diameter,
    check_direction,
)
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive, Three, check_limits
from pelagos.vehicles.wetness import HULL, Place


class ThrusterConfig(PartConfig):
    """Thrust by the square of the shaft speed. Command and state: shaft speed in the unit of the coefficients."""

    type: Literal["thruster"]
    position_m: Three
    """FRD from the origin [m]."""
    direction: Three
    """Of positive thrust, FRD; its length does not matter."""
    forward: Positive
    """Thrust by speed squared, ahead [N s^2] (or [N] where the speed is a share of the largest)."""
    reverse: Positive
    """The same astern."""
    low: Number
    """Least speed."""
    high: Number
    """Largest speed."""
    unit: str = "rad/s"
    """Of the speed: rad/s, rpm or 1/s where `inflow` is by `b_series`, which needs to know it; any name otherwise."""
    torque_m: Number = 0.0
    """Reaction torque about `direction` by thrust [m]; its sign is that of the propeller's hand."""
    time_constant_s: NonNegative
    """[s]"""
    diameter_m: Positive = 0.1
    """Of the propeller, for what it loses near the surface and above it, and by `inflow` [m]."""
    inflow: InflowConfig | None = None
    """Loss of thrust in the water that flows through it; left out: the bollard thrust at any speed."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_direction(self.direction)
        check_limits(self, "low", "high")
        check_diameter(self.inflow, "diameter_m" in self.model_fields_set)
        if isinstance(self.inflow, BSeriesInflowConfig):
            self.inflow.check(Shaft(self.forward, self.reverse, self.unit), self.diameter_m)
        return self

    def build(self, body: Body) -> Thruster:
        """The actuator."""
        return Thruster(
            effect=thrust_effect(self.position_m, self.direction, self.torque_m, deduction_of(self.inflow)),
            curve=QuadraticCurve(self.forward, self.reverse),
            lag=Lag(self.time_constant_s, self.low, self.high),
            unit=self.unit,
            site=thruster_site(body, self.position_m, self.diameter_m),
            inflow=build_inflow(
                self.inflow, position=self.position_m, direction=self.direction, diameter=self.diameter_m,
                density=body.density, shaft=Shaft(self.forward, self.reverse, self.unit),
            ),
        )  # fmt: skip


class ForceThrusterConfig(PartConfig):
    """A thruster that is commanded by its thrust. Command and state: [N]."""

    type: Literal["force_thruster"]
    position_m: Three
    """FRD from the origin [m]."""
    direction: Three
    """Of positive thrust, FRD; its length does not matter."""
    low_n: Number
    """Largest thrust astern, negative [N]."""
    high_n: Positive
    """Largest thrust ahead [N]."""
    torque_m: Number = 0.0
    """Reaction torque about `direction` by thrust [m]; its sign is that of the propeller's hand."""
    time_constant_s: NonNegative
    """[s]"""
    diameter_m: Positive = 0.1
    """Of the propeller, for what it loses near the surface and above it, and by `inflow` [m]."""
    inflow: DiscOnly | None = None
    """Loss of thrust in the water that flows through it; left out: the bollard thrust at any speed."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_direction(self.direction)
        check_limits(self, "low_n", "high_n")
        check_diameter(self.inflow, "diameter_m" in self.model_fields_set)
        return self

    def build(self, body: Body) -> Thruster:
        """The actuator."""
        return Thruster(
            effect=thrust_effect(self.position_m, self.direction, self.torque_m, deduction_of(self.inflow)),
            curve=LinearCurve(),
            lag=Lag(self.time_constant_s, self.low_n, self.high_n),
            unit="N",
            site=thruster_site(body, self.position_m, self.diameter_m),
            inflow=build_inflow(
                self.inflow, position=self.position_m, direction=self.direction, diameter=self.diameter_m,
                density=body.density,
            ),
        )  # fmt: skip


@dataclass(frozen=True)
class LinearCurve:
    """The state is the thrust."""

    def thrust(self, speed: Array) -> Array:
        """[N]"""
        return speed

    def thrust_at(self, speed: float) -> float:
        """[N]"""
        return speed

    def speed(self, thrust: Array) -> Array:
        """[N]"""
        return thrust


@dataclass(frozen=True)
class QuadraticCurve:
    """forward, reverse: thrust by speed squared."""

    forward: Array
    reverse: Array

    def thrust(self, speed: Array) -> Array:
        """[N]"""
        return thruster.quadratic_thrust(self.forward, self.reverse, speed)

    def thrust_at(self, speed: float) -> float:
        """`thrust` of a number, without a device [N]."""
        return float(self.forward if speed > 0 else self.reverse) * speed * abs(speed)

    def speed(self, thrust: Array) -> Array:
        """The speed that gives a thrust [N]."""
        return dr.mulsign(dr.sqrt(dr.select(thrust > 0, thrust / self.forward, -thrust / self.reverse)), thrust)


@dataclass(frozen=True)
class Thruster:
    """effect: wrench (6) of 1 N of thrust; curve: thrust by state; inflow: what it loses in a flow, None: nothing."""

    effect: Vector
    curve: QuadraticCurve | LinearCurve
    lag: Lag
    unit: str
    site: Place = HULL
    inflow: Inflow | None = None

    def thrust(self, state: Array, flow: Flow) -> Array:
        """At rest [N]."""
        return self.curve.thrust(state)

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        thrust = self.curve.thrust(state)
        if self.inflow is not None:
            return self.inflow.wrench(self.effect, thrust, state, flow)
        return [mul(e, thrust) for e in self.effect]

    @property
    def thrust_limits(self) -> tuple[float, float]:
        """Thrust at the limits of the state [N]: astern (negative), ahead."""
        return self.curve.thrust_at(float(self.lag.low)), self.curve.thrust_at(float(self.lag.high))

    def command(self, thrust: Array) -> Array:
        """The command that gives a thrust [N] when it has settled."""
        return self.curve.speed(thrust)


def thruster_site(body: Body, position: Three, diameter: float) -> Place:
    """Of a thruster; under a hull that floats at least as deep as its keel, whatever the line of its force.

    Published models of surface craft put the force at the waterline.
    """
    if body.in_air:
        return Place("dry")
    heave = float(body.stiffness[2])
    keel = body.weight / heave if heave > 0 else -np.inf
    return Place("propeller", (position[0], position[1], max(position[2], keel)), diameter / 2)


def thrust_effect(position: Three, direction: Three, torque: float, deduction: float = 0.0) -> list[float]:
    """Wrench (6) of 1 N along `direction` at `position`, with its reaction torque [N m].

    `deduction`: t, share of the force, not of the torque, that the hull takes away.
    """
    axis = np.array(direction) / np.linalg.norm(direction)
    force = (1 - deduction) * axis if deduction else axis
    effect = np.concatenate([force, np.cross(position, force) + torque * axis])
    return [float(x) if abs(x) > 1e-15 else 0.0 for x in effect]


def deduction_of(inflow: DiscInflowConfig | BSeriesInflowConfig | None) -> float:
    """Thrust deduction t."""
    return 0.0 if inflow is None else inflow.thrust_deduction

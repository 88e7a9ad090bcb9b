"""Thrusters whose thrust was measured command by command, such as cycloidal propellers and tunnel thrusters."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, Self

import drjit as dr
import numpy as np
from pydantic import model_validator

from pelagos.hydro.algebra import Vector, mul
from pelagos.jit import Array
from pelagos.vehicles.actuators.inflow import DiscOnly, Inflow, build_inflow, check_diameter, check_direction
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.actuators.thruster import deduction_of, thrust_effect, thruster_site
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive, Three
from pelagos.vehicles.wetness import HULL, Place

_MOST: Final = 1.5  # of the bollard thrust, in a flow from ahead of what it pushes against: beyond it nothing is known


class CurveThrusterConfig(PartConfig):
    """Thrust by a measured curve. Command and state: as the curve has it, such as a cycloidal propeller's pitch."""

    type: Literal["curve_thruster"]
    position_m: Three
    """FRD from the origin [m]."""
    direction: Three
    """Of positive thrust, FRD; its length does not matter."""
    commands: tuple[Number, ...]
    """Of the measured points, rising."""
    thrusts_n: tuple[Number, ...]
    """There, in still water, rising [N]."""
    gain: Positive = 1.0
    """Of the thrust [-]."""
    speed_share: NonNegative = 1.0
    """Rotor speed over that of the measurement; thrust goes with its square [-]."""
    zero_thrust_m_s: Positive | None = None
    """Speed through the water, along its own push, at which nothing is left of the thrust, which falls linearly until
    there (as thrust coefficients do with the advance ratio); left out: it does not fall [m/s]."""
    unit: str = ""
    """Of the command."""
    torque_m: Number = 0.0
    """Reaction torque about `direction` by thrust [m]."""
    time_constant_s: NonNegative
    """[s]"""
    diameter_m: Positive = 0.1
    """Of the propeller, for what it loses near the surface and above it, and by `inflow` [m]."""
    inflow: DiscOnly | None = None
    """Loss of thrust in the water that flows through it, in place of `zero_thrust_m_s`."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_direction(self.direction)
        if len(self.commands) != len(self.thrusts_n) or len(self.commands) < 2:
            raise ValueError(
                f"give as many thrusts_n as commands, at least 2, not {len(self.thrusts_n)} and {len(self.commands)}"
            )
        for name, values in (("commands", self.commands), ("thrusts_n", self.thrusts_n)):
            if (np.diff(values) <= 0).any():
                raise ValueError(f"{name} must rise from point to point")
        check_diameter(self.inflow, "diameter_m" in self.model_fields_set)
        if self.inflow is not None and self.zero_thrust_m_s is not None:
            raise ValueError("zero_thrust_m_s and inflow both say what its speed takes away: give one of them")
        return self

    def build(self, body: Body) -> CurveThruster:
        """The actuator."""
        axis = np.array(self.direction) / np.linalg.norm(self.direction)
        return CurveThruster(
            effect=thrust_effect(self.position_m, self.direction, self.torque_m, deduction_of(self.inflow)),
            arm=[float(x) for x in (*axis, *np.cross(self.position_m, axis))],
            curve=TableCurve(self.commands, self.thrusts_n, self.gain * self.speed_share**2),
            zero=self.zero_thrust_m_s,
            lag=Lag(self.time_constant_s, self.commands[0], self.commands[-1]),
            unit=self.unit,
            site=thruster_site(body, self.position_m, self.diameter_m),
            inflow=build_inflow(
                self.inflow, position=self.position_m, direction=self.direction, diameter=self.diameter_m,
                density=body.density,
            ),
        )  # fmt: skip


def _along(x: Array, at: Sequence[float], values: Sequence[float]) -> Array:
    """Straight lines through points; constant outside."""
    found: Array = values[0]
    for a, b, low, high in zip(at[:-1], at[1:], values[:-1], values[1:], strict=True):
        found = found + (high - low) / (b - a) * dr.clip(x - a, 0.0, b - a)
    return found


@dataclass(frozen=True)
class TableCurve:
    """commands, thrusts [N]: measured points; gain: of the thrust."""

    commands: tuple[float, ...]
    thrusts: tuple[float, ...]
    gain: Array

    def thrust(self, speed: Array) -> Array:
        """[N]"""
        return self.gain * _along(speed, self.commands, self.thrusts)

    def thrust_at(self, speed: float) -> float:
        """`thrust` of a number, without a device [N]."""
        return float(self.gain) * float(np.interp(speed, self.commands, self.thrusts))

    def speed(self, thrust: Array) -> Array:
        """The command that gives a thrust [N]."""
        return _along(thrust / self.gain, self.thrusts, self.commands)


@dataclass(frozen=True)
class CurveThruster:
    """effect: wrench (6) of 1 N of thrust; arm: its axis and moment arm (6); zero: [m/s] or None; inflow: None or
    in place of `zero`.
    """

    effect: Vector
    arm: Vector
    curve: TableCurve
    zero: Array | None
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
        if self.zero is not None:
            ahead = sum((mul(a, v) for a, v in zip(self.arm, flow.nu_r, strict=True)), 0.0)
            thrust = thrust * dr.clip(1 - dr.sign(thrust) * ahead / self.zero, 0.0, _MOST)
        return [mul(e, thrust) for e in self.effect]

    @property
    def thrust_limits(self) -> tuple[float, float]:
        """Thrust at the limits of the state [N]: astern (negative), ahead."""
        return self.curve.thrust_at(float(self.lag.low)), self.curve.thrust_at(float(self.lag.high))

    def command(self, thrust: Array) -> Array:
        """The command that gives a thrust [N] when it has settled."""
        return self.curve.speed(thrust)

"""Control surfaces of aeroplanes, by coefficients."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from pelagos.hydro.algebra import Vector, dot, mul
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.wetness import DRY, Place


class FlapConfig(PartConfig):
    """Aileron, elevator or rudder of an aeroplane. Command and state: deflection [rad].

    Source: R. W. Beard, T. W. McLain, "Small Unmanned Aircraft", Princeton 2012, Chapter 4.
    """

    type: Literal["flap"]
    area_m2: Positive
    """Reference area S [m^2]."""
    span_m: Positive
    """Reference span b [m]."""
    chord_m: Positive
    """Reference chord c [m]."""
    C_L: Number = 0.0
    """By deflection [1/rad]."""
    C_Y: Number = 0.0
    """[1/rad]"""
    C_l: Number = 0.0
    """[1/rad]"""
    C_m: Number = 0.0
    """[1/rad]"""
    C_n: Number = 0.0
    """[1/rad]"""
    limit_deg: Positive
    """[deg]"""
    time_constant_s: NonNegative
    """[s]"""

    def build(self, body: Body) -> Flap:
        """The actuator."""
        limit = math.radians(self.limit_deg)
        scale = 0.5 * body.density * self.area_m2
        effect = [0.0, self.C_Y, -self.C_L, self.span_m * self.C_l, self.chord_m * self.C_m, self.span_m * self.C_n]
        return Flap([scale * e for e in effect], Lag(self.time_constant_s, -limit, limit))


@dataclass(frozen=True)
class Flap:
    """effect: wrench (6) by deflection and speed squared [kg/m], [kg]; at small angles of attack."""

    effect: Vector
    lag: Lag
    unit: str = "rad"
    site: Place = DRY

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        push = dot(flow.nu_r[:3], flow.nu_r[:3]) * state
        return [mul(e, push) for e in self.effect]

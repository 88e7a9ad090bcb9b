"""Control surfaces in water: rudders, stern planes, single fins."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

from pelagos.hydro import lift
from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.wetness import HULL, Place


class FinConfig(PartConfig):
    """An all-moving fin. Command and state: deflection [rad], right-handed about the fin's outward axis."""

    type: Literal["fin"]
    angle_deg: Number
    """Where its axis points about x: 0 starboard, 90 down, 180 port, 270 up [deg]; a rudder is 270, a stern plane 0."""
    x_m: Number
    """Centre of pressure along x, forward of the origin [m]."""
    radius_m: NonNegative = 0.0
    """Centre of pressure from the x axis [m]; 0 for a pair that works as one."""
    area_m2: Positive
    """[m^2]"""
    lift_coefficient: Positive
    """CL by deflection [1/rad]."""
    drag_coefficient: NonNegative = 0.0
    """CD by deflection squared [1/rad^2]."""
    incidence: bool = False
    """The flow's own angle at the fin lifts too, which steadies the vehicle (Fossen's programs leave it out)."""
    astern: Literal["mirrored", "as_ahead"] = "mirrored"
    """Where the vehicle goes astern, a deflection pushes the other way; or as it does ahead (Fossen's programs)."""
    limit_deg: Positive
    """[deg]"""
    time_constant_s: NonNegative
    """[s]"""
    clip: Literal["before", "after"] = "before"
    """Whether the limit acts on the state before its use, or on the state that the lag returns."""

    def build(self, body: Body) -> Fin:
        """The actuator."""
        angle = math.radians(self.angle_deg)
        cos, sin = (round(x, 15) for x in (math.cos(angle), math.sin(angle)))
        limit = math.radians(self.limit_deg)
        place = [self.x_m, self.radius_m * cos, self.radius_m * sin]
        pressure_area = 0.5 * body.density * self.area_m2
        return Fin(
            gain=pressure_area * self.lift_coefficient,
            drag_gain=pressure_area * self.drag_coefficient,
            direction=(cos, sin),
            place=place,
            incidence=self.incidence,
            mirrored=self.astern == "mirrored",
            lag=Lag(self.time_constant_s, -limit, limit, self.clip),
            site=Place("fin", place, 0.5 * math.sqrt(self.area_m2)),
        )


@dataclass(frozen=True)
class Fin:
    """See `hydro.lift.fin`."""

    gain: Array
    drag_gain: Array
    direction: tuple[float, float]
    place: Vector
    incidence: bool
    mirrored: bool
    lag: Lag
    unit: str = "rad"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6) at a deflection [rad]."""
        return lift.fin(
            self.gain, self.drag_gain, self.direction, self.place, state, flow.nu_r,
            incidence=self.incidence, mirrored=self.mirrored,
        )  # fmt: skip

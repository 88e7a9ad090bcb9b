"""A ship as manoeuvring tests describe it: polynomials in speed, drift, yaw rate and rudder angle."""

from __future__ import annotations

import re
from dataclasses import dataclass
from typing import Final, Literal, Self

import drjit as dr
from pydantic import model_validator

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive
from pelagos.vehicles.wetness import HULL, Place

_NAME: Final = re.compile(r"([XYN])(0?)([uvrd]*)")


class ShipRudderConfig(PartConfig):
    """Hull, propeller at constant power, and rudder in one. Command and state: helm [rad], positive turns to starboard.

    Derivatives are non-dimensional with length, speed and rho/2 ("prime system I" of SNAME 1950), about a steady speed:
    `Yvvr` multiplies v' v' r', `Xudd` (u' - u0') d d, `Y0` nothing; d is the rudder angle, minus the helm.
    """

    type: Literal["ship_rudder"]
    service_speed_m_s: Positive
    """The speed at which the derivatives hold [m/s]."""
    scale: Literal["service_speed", "speed"] = "service_speed"
    """The speed that makes velocities and forces non-dimensional: the service speed, with which terms such as Yvu, Yud
    and Yuud let forces follow the speed as they must (v (1 + u'), d (1 + u')^2); or the present speed (MSS), which
    counts a loss of speed twice; below half the service speed it is then held."""
    derivatives: dict[str, float]
    """By name."""
    limit_deg: Positive
    """[deg]"""
    rate_deg_s: Positive
    """[deg/s]"""
    time_constant_s: NonNegative
    """[s]"""

    @model_validator(mode="after")
    def _named(self) -> Self:
        for name in self.derivatives:
            if not _NAME.fullmatch(name) or len(name) < 2:
                raise ValueError(f"derivative {name!r} must be X, Y or N and then letters of u, v, r, d (or 0)")
        return self

    def build(self, body: Body) -> ShipRudder:
        """The actuator."""
        limit, rate = (x * 3.141592653589793 / 180 for x in (self.limit_deg, self.rate_deg_s))
        return ShipRudder(
            derivatives=tuple((name[0], name[1:].lstrip("0"), value) for name, value in self.derivatives.items()),
            length=body.length,
            density=body.density,
            service_speed=self.service_speed_m_s,
            lag=Lag(self.time_constant_s, -limit, limit, rate_limit=rate),
            scale=self.scale,
        )


@dataclass(frozen=True)
class ShipRudder:
    """derivatives: (force, variables, value); length [m]; density [kg/m^3]; service_speed [m/s]."""

    derivatives: tuple[tuple[str, str, float], ...]
    length: Array
    density: Array
    service_speed: Array
    lag: Lag
    scale: Literal["service_speed", "speed"] = "service_speed"
    unit: str = "rad"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        u, v, r = flow.nu_r[0], flow.nu_r[1], flow.nu_r[5]
        speed = self.service_speed
        if self.scale == "speed":
            speed = dr.maximum(dr.sqrt(u * u + v * v), 0.5 * self.service_speed)
        scale = 0.5 * self.density * self.length**2 * speed * speed
        value = {"u": (u - self.service_speed) / speed, "v": v / speed, "r": r * self.length / speed, "d": -state}
        sums: dict[str, Array] = {"X": 0.0, "Y": 0.0, "N": 0.0}
        for force, variables, derivative in self.derivatives:
            product: Array = derivative
            for name in variables:
                product = product * value[name]
            sums[force] = sums[force] + product
        x, y, n = scale * sums["X"], scale * sums["Y"], scale * self.length * sums["N"]
        return [x, y, 0.0, 0.0, 0.0, n]

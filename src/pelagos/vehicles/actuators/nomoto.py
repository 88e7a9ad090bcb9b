"""A ship whose yaw is Nomoto's, at a speed that its engine holds."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Self

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos.hydro.algebra import Vector
from pelagos.hydro.nomoto import Nomoto, yaw_acceleration
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive
from pelagos.vehicles.wetness import HULL, Place


class NomotoShipConfig(PartConfig):
    """Yaw, resistance and a constant thrust in one. Command and state: helm [rad], positive turns to starboard.

    T r_dot + n1 r + n3 r^3 = K delta (`hydro/nomoto.py`), by the ship's whole inertia in yaw. The thrust is that which
    holds the service speed; resistance goes with the square of the speed.
    """

    type: Literal["nomoto_ship"]
    service_speed_m_s: Positive
    """[m/s]"""
    resistance_n: Positive
    """At the service speed [N]."""
    speeds_m_s: tuple[Positive, ...] = Field(min_length=2)
    """Of the constants, rising [m/s]."""
    gain_1_s: tuple[Positive, ...]
    """K at these speeds [1/s]."""
    time_s: tuple[Positive, ...]
    """T at these speeds [s]."""
    cubic_s2: tuple[NonNegative, ...]
    """n3 at these speeds [s^2]."""
    linear: NonNegative = 1.0
    """n1: 1 for a ship that is stable on its course [-]."""
    limit_deg: Positive
    """[deg]"""
    rate_deg_s: Positive
    """[deg/s]"""
    time_constant_s: NonNegative
    """Of the steering gear [s]."""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        if (np.diff(self.speeds_m_s) <= 0).any():
            raise ValueError("speeds_m_s must rise from point to point")
        for key in ("gain_1_s", "time_s", "cubic_s2"):
            if len(getattr(self, key)) != len(self.speeds_m_s):
                raise ValueError(f"{key} has {len(getattr(self, key))} values, speeds_m_s {len(self.speeds_m_s)}")
        return self

    def build(self, body: Body) -> NomotoShip:
        """The actuator."""
        limit, rate = math.radians(self.limit_deg), math.radians(self.rate_deg_s)
        return NomotoShip(
            yaw=Nomoto(self.speeds_m_s, self.gain_1_s, self.time_s, self.cubic_s2, self.linear),
            inertia=float(body.mass_matrix[5, 5]),
            resistance=self.resistance_n,
            service_speed=self.service_speed_m_s,
            lag=Lag(self.time_constant_s, -limit, limit, rate_limit=rate),
        )


@dataclass(frozen=True)
class NomotoShip:
    """yaw: `hydro.nomoto`; inertia: M_RB + M_A in yaw [kg m^2]; resistance [N] at service_speed [m/s]."""

    yaw: Nomoto
    inertia: Array
    resistance: Array
    service_speed: Array
    lag: Lag
    unit: str = "rad"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        u, r = flow.nu_r[0], flow.nu_r[5]
        share = u / self.service_speed
        n = self.inertia * yaw_acceleration(self.yaw, u, r, state)
        return [self.resistance * (1 - share * dr.abs(share)), 0.0, 0.0, 0.0, 0.0, n]

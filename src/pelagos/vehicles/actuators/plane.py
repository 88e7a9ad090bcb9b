"""Planes and propellers of submersibles by derivatives, as captive tests give them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal, Self

import drjit as dr
from pydantic import Field, model_validator

from pelagos.hydro.algebra import Vector, add, scaled
from pelagos.hydro.derivatives import Derivative, derivative_force, dimensional, race_change
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.terms.derivatives import check_names
from pelagos.vehicles.wetness import HULL, Place


class PlaneConfig(PartConfig):
    """A rudder or plane by derivatives: `Nuud` multiplies u u d. Command and state: d [rad], as published."""

    type: Literal["plane"]
    derivatives: dict[str, Number] = Field(min_length=1)
    """By name; non-dimensional by rho/2 and the length (`hydro/derivatives.py`)."""
    limit_deg: Positive
    """[deg]"""
    time_constant_s: NonNegative
    """[s]"""

    @model_validator(mode="after")
    def _named(self) -> Self:
        check_names(self.derivatives, deflections=True)
        return self

    def build(self, body: Body) -> Plane:
        """The actuator."""
        limit = math.radians(self.limit_deg)
        return Plane(dimensional(self.derivatives, body.density, body.length), Lag(self.time_constant_s, -limit, limit))


@dataclass(frozen=True)
class Plane:
    """derivatives: with their dimensions."""

    derivatives: tuple[Derivative, ...]
    lag: Lag
    unit: str = "rad"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        return derivative_force(self.derivatives, flow.nu_r, state)


class RacePropellerConfig(PartConfig):
    """A stern propeller by its steady speed, and its race at hull and stern plane. Command and state: [rpm]."""

    type: Literal["race_propeller"]
    drag: Positive
    """Drag straight ahead, which the thrust balances at the steady speed, by rho/2 L^2 [-]."""
    pitch_m_rad: Positive
    """Way of the vehicle by turn of the propeller, steady [m/rad]."""
    loading: Positive
    """Thrust loading of the race [1/m^2]."""
    race: dict[str, Number]
    """Derivatives times the change of the race (`hydro/derivatives.py`); d is the deflection of `plane`."""
    plane: str
    """The stern plane in the race, an actuator of the type `plane`."""
    diameter_m: Positive
    """Of the propeller, for what it loses near the surface and above it [m]."""
    limit_rpm: Positive
    """[rpm]"""
    time_constant_s: NonNegative
    """[s]"""

    @model_validator(mode="after")
    def _named(self) -> Self:
        check_names(self.race, deflections=True)
        return self

    @property
    def needs(self) -> dict[str, str]:
        """Actuators that must exist, by name, and their types."""
        return {self.plane: "plane"}

    def build(self, body: Body) -> RacePropeller:
        """The actuator."""
        return RacePropeller(
            thrust=0.5 * body.density * body.length**2 * self.drag * self.pitch_m_rad**2,
            shape=(self.loading, body.length, self.pitch_m_rad),
            race=dimensional(self.race, body.density, body.length),
            plane=self.plane,
            lag=Lag(self.time_constant_s, -self.limit_rpm, self.limit_rpm),
            site=Place("propeller", (-body.length / 2, 0.0, 0.0), self.diameter_m / 2),
        )


@dataclass(frozen=True)
class RacePropeller:
    """thrust: by the square of the shaft speed [N s^2]; shape: loading, length, pitch; race: its derivatives."""

    thrust: Array
    shape: tuple[Array, Array, Array]
    race: tuple[Derivative, ...]
    plane: str
    lag: Lag
    unit: str = "rpm"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        n = state * (2 * dr.pi / 60)
        change = race_change(*self.shape, flow.nu_r[0], n)
        race = scaled(change, derivative_force(self.race, flow.nu_r, flow.actuators[self.plane]))
        return add([self.thrust * n * dr.abs(n), 0.0, 0.0, 0.0, 0.0, 0.0], race)

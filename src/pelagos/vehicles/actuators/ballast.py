"""Moving masses and buoyancy engines."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

from pydantic import model_validator

from pelagos.hydro import restoring
from pelagos.hydro.algebra import Vector, cross
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive, Three, check_limits
from pelagos.vehicles.wetness import ALWAYS, HULL, Place


class MovingMassConfig(PartConfig):
    """A mass that slides along x and trims the vehicle. Command and state: its way from the middle, forwards [m].

    Its weight acts; its own inertia and the small change of the mass matrix do not.
    """

    type: Literal["moving_mass"]
    mass_kg: Positive
    """[kg]"""
    low_m: Number
    """[m]"""
    high_m: Number
    """[m]"""
    rate_m_s: Positive
    """[m/s]"""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_limits(self, "low_m", "high_m")
        return self

    def build(self, body: Body) -> MovingMass:
        """The actuator."""
        return MovingMass(self.mass_kg * body.gravity, Lag(0.0, self.low_m, self.high_m, rate_limit=self.rate_m_s))


@dataclass(frozen=True)
class MovingMass:
    """weight [N]."""

    weight: Array
    lag: Lag
    unit: str = "m"
    site: Place = ALWAYS

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """The moment of the weight's displacement (6)."""
        return [0.0, 0.0, 0.0, *cross([self.weight * state, 0.0, 0.0], flow.down)]


class BuoyancyEngineConfig(PartConfig):
    """A bladder that changes the displaced volume. Command and state: volume beyond neutral [m^3]."""

    type: Literal["buoyancy_engine"]
    position_m: Three
    """FRD from the origin [m]."""
    low_m3: Number
    """[m^3]"""
    high_m3: Number
    """[m^3]"""
    rate_m3_s: Positive
    """[m^3/s]"""
    time_constant_s: NonNegative = 0.0
    """[s]"""

    @model_validator(mode="after")
    def _possible(self) -> Self:
        check_limits(self, "low_m3", "high_m3")
        return self

    def build(self, body: Body) -> BuoyancyEngine:
        """The actuator."""
        return BuoyancyEngine(
            body.density * body.gravity,
            list(self.position_m),
            Lag(self.time_constant_s, self.low_m3, self.high_m3, rate_limit=self.rate_m3_s),
        )


@dataclass(frozen=True)
class BuoyancyEngine:
    """specific_weight: of the water [N/m^3]; position (3) [m]."""

    specific_weight: Array
    position: Vector
    lag: Lag
    unit: str = "m^3"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Buoyancy of the volume (6)."""
        return restoring.weight_at(-self.specific_weight * state, self.position, flow.down)

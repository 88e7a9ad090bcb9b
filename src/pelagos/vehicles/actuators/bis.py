"""A ship by van Berlekom and Goddard: hull, propeller and rudder in deep and shallow water."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final, Literal, Self

from pydantic import Field, model_validator

from pelagos.hydro.algebra import Vector
from pelagos.hydro.bis_ship import HULL_NAMES, PROPELLER_NAMES, BisShip, ship_force
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.nearby import GroundMass
from pelagos.vehicles.part import Body, Fraction, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.wetness import HULL, Place

_SLOW: Final = 0.05
"""Share of the service speed below which the drift angle is no longer taken against the speed."""


class BisShipConfig(PartConfig):
    """Hull, propeller and rudder in one. Command and state: helm [rad], positive turns to starboard.

    Derivatives are in the bis system, by the names of van Berlekom and Goddard 1972 (`hydro/bis_ship.py`); the depth of
    water is that of the added mass: one for all, or the world's.
    """

    type: Literal["bis_ship"]
    engine: str
    """The actuator that turns the propeller, a `ship_engine`."""
    service_speed_m_s: Positive
    """[m/s]"""
    hull: dict[str, Number] = Field(min_length=1)
    """Each of HULL_NAMES."""
    propeller: dict[str, Number] = Field(min_length=1)
    """Tuu, Tun, Tnn, cun, cnn."""
    thrust_deduction: Fraction
    """t."""
    limit_deg: Positive
    """[deg]"""
    rate_deg_s: Positive
    """[deg/s]"""
    time_constant_s: NonNegative
    """[s]"""

    @model_validator(mode="after")
    def _named(self) -> Self:
        for key, given, known in (("hull", self.hull, HULL_NAMES), ("propeller", self.propeller, PROPELLER_NAMES)):
            wrong = sorted(set(given) ^ set(known))
            if wrong:
                raise ValueError(
                    f"{key}: give each of {', '.join(known)} once, and nothing else; not so: {', '.join(wrong)}"
                )
        return self

    @property
    def needs(self) -> dict[str, str]:
        """Actuators that must exist, by name, and their types."""
        return {self.engine: "ship_engine"}

    def build(self, body: Body) -> BisRudder:
        """The actuator."""
        limit, rate = math.radians(self.limit_deg), math.radians(self.rate_deg_s)
        return BisRudder(
            ship=BisShip(float(body.rigid[0, 0]), body.length, body.shallow, _SLOW * self.service_speed_m_s),
            hull=dict(self.hull),
            propeller={**self.propeller, "t": self.thrust_deduction},
            engine=self.engine,
            lag=Lag(self.time_constant_s, -limit, limit, rate_limit=rate),
            ground=body.ground,
        )


@dataclass(frozen=True)
class BisRudder:
    """ship, hull, propeller: `hydro.bis_ship`; engine: name of the actuator that turns the propeller; ground: of the
    added mass, where the depth is the world's.
    """

    ship: BisShip
    hull: dict[str, Array]
    propeller: dict[str, Array]
    engine: str
    lag: Lag
    ground: GroundMass | None = None
    unit: str = "rad"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        ship = self.ship if self.ground is None else replace(self.ship, shallow=self.ground.shallow(flow))
        motion = (flow.nu_r[0], flow.nu_r[1], flow.nu_r[5])
        x, y, n = ship_force(ship, self.hull, self.propeller, motion, -state, flow.actuators[self.engine])
        return [x, y, 0.0, 0.0, 0.0, n]

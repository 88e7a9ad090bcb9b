"""A ship that heels as it turns, by Son and Nomoto: hull, propeller and rudder in four degrees of freedom."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from typing import Final, Literal, Self

from pydantic import model_validator

from pelagos.hydro.algebra import Vector
from pelagos.hydro.rolling_ship import HelmRudder, RollingShip, Screw, Term, ship_force
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, Fraction, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.wetness import HULL, Place

_NAME: Final = re.compile(r"([XYKN])((?:phi|[uvrp])+)")
_VARIABLE: Final = re.compile(r"phi|[uvrp]")
_SLOW: Final = 0.05
"""Share of the service speed below which non-dimensional velocities are held: the model is for a ship under way."""


class RollingShipConfig(PartConfig):
    """Hull, propeller and rudder in one, with heel. Command and state: helm [rad], positive turns to starboard.

    Derivatives and other constants are non-dimensional, in the prime system by the present speed, of Son and Nomoto
    1982 (`hydro/rolling_ship.py`): `Kvphiphi` multiplies v' phi phi.
    """

    type: Literal["rolling_ship"]
    engine: str
    """The actuator that turns the propeller, a `ship_engine`."""
    service_speed_m_s: Positive
    """Far below it velocities are no longer divided by the speed [m/s]."""
    derivatives: dict[str, Number]
    """By name: X, Y, K or N and then u, v, r, p, phi."""
    diameter_m: Positive
    """Of the propeller [m]."""
    thrust_coefficients: tuple[Number, Number]
    """K_T = k0 + k1 J."""
    thrust_deduction: Fraction
    """t."""
    wake_fraction: Fraction
    """w_P, straight ahead."""
    wake_change: Number
    """tau."""
    propeller_place: Number
    """x_P over the length."""
    rudder_area_m2: Positive
    """A_R [m^2]."""
    rudder_aspect: Positive
    """Aspect ratio of the rudder."""
    rudder_inflow: tuple[Positive, Number]
    """epsilon, k."""
    rudder_straightening: tuple[Number, Number, Number, Number]
    """gamma, c_Rr, c_Rrrr, c_Rrrv of the flow across the rudder."""
    rudder_drag: Number
    """c_RX: share of the rudder's force along the ship."""
    rudder_hull_share: Number
    """a_H."""
    rudder_hull_place: Number
    """x_H over the length."""
    rudder_place: Number = -0.5
    """x_R over the length."""
    rudder_depth: Number
    """z_R over the length, below the origin."""
    limit_deg: Positive
    """[deg]"""
    rate_deg_s: Positive
    """[deg/s]"""
    time_constant_s: NonNegative
    """[s]"""

    @model_validator(mode="after")
    def _named(self) -> Self:
        for name in self.derivatives:
            if not _NAME.fullmatch(name):
                raise ValueError(f"derivative {name!r} must be X, Y, K or N and then u, v, r, p, phi")
        return self

    @property
    def needs(self) -> dict[str, str]:
        """Actuators that must exist, by name, and their types."""
        return {self.engine: "ship_engine"}

    def build(self, body: Body) -> RollingRudder:
        """The actuator."""
        limit, rate = math.radians(self.limit_deg), math.radians(self.rate_deg_s)
        epsilon, race = self.rudder_inflow
        gamma, *across = self.rudder_straightening
        return RollingRudder(
            ship=RollingShip(body.length, body.density, _SLOW * self.service_speed_m_s),
            terms=tuple((k[0], tuple(_VARIABLE.findall(k[1:])), value) for k, value in self.derivatives.items()),
            screw=Screw(
                self.diameter_m, self.propeller_place, self.wake_fraction, self.wake_change, self.thrust_deduction,
                list(self.thrust_coefficients),
            ),
            rudder=HelmRudder(
                self.rudder_area_m2, self.rudder_aspect, epsilon, race, gamma, across, self.rudder_drag,
                self.rudder_hull_share, self.rudder_hull_place, self.rudder_place, self.rudder_depth,
            ),
            engine=self.engine,
            lag=Lag(self.time_constant_s, -limit, limit, rate_limit=rate),
        )  # fmt: skip


@dataclass(frozen=True)
class RollingRudder:
    """ship, terms, screw, rudder: `hydro.rolling_ship`; engine: name of the actuator that turns the propeller."""

    ship: RollingShip
    terms: tuple[Term, ...]
    screw: Screw
    rudder: HelmRudder
    engine: str
    lag: Lag
    unit: str = "rad"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        nu = flow.nu_r
        motion = (nu[0], nu[1], nu[5], nu[3], flow.roll)
        controls = (state, flow.actuators[self.engine])
        x, y, k, n = ship_force(self.ship, self.terms, self.screw, self.rudder, motion, controls)
        return [x, y, 0.0, k, 0.0, n]

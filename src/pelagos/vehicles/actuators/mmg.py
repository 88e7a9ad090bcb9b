"""A ship of one propeller and one rudder by the MMG standard model: hull, propeller at constant revolutions, rudder."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Literal, Self

import drjit as dr
from pydantic import model_validator

from pelagos.hydro.algebra import Vector, add
from pelagos.hydro.manoeuvring import (
    Rudder,
    Ship,
    Wake,
    hull_force,
    propeller_thrust,
    rudder_normal_force,
    wake_fraction,
)
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.actuators.shallow_water import ShallowWater, ShallowWaterConfig
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, Number, PartConfig, Positive
from pelagos.vehicles.wetness import HULL, Place

HULL_NAMES: Final = (
    "R0", "Xvv", "Xvr", "Xrr", "Xvvvv", "Yv", "Yr", "Yvvv", "Yvvr", "Yvrr", "Yrrr", "Nv", "Nr", "Nvvv", "Nvvr", "Nvrr",
    "Nrrr",
)  # fmt: skip
_SLOW: Final = 0.05
"""Share of the service speed below which non-dimensional velocities are held: the model is for a ship under way."""


class MmgShipConfig(PartConfig):
    """Hull, propeller at constant revolutions, and rudder in one. Command and state: helm [rad], positive turns to
    starboard. Symbols, signs and non-dimensional forms are those of Yasukawa and Yoshimura 2015.
    """

    type: Literal["mmg_ship"]
    draught_m: Positive
    """[m]"""
    service_speed_m_s: Positive
    """Speed of the approach; far below it velocities are no longer divided by the speed [m/s]."""
    hull: dict[str, float]
    """R0, Xvv, Xvr, Xrr, Xvvvv, Yv, Yr, Yvvv, Yvvr, Yvrr, Yrrr, Nv, Nr, Nvvv, Nvvr, Nvrr, Nrrr."""
    revolutions_hz: Positive
    """Of the propeller, which the engine holds [1/s]."""
    diameter_m: Positive
    """Of the propeller [m]."""
    thrust_coefficients: tuple[Number, Number, Number]
    """K_T = k0 + k1 J + k2 J^2."""
    thrust_deduction: Number
    """t_P."""
    wake_fraction: Number
    """w_P0, straight ahead."""
    wake_change: tuple[Number, Number, Number]
    """C1, and C2 for flow from starboard (beta_P > 0) and from port."""
    propeller_place: Number
    """x_P over the length."""
    rudder_area_m2: Positive
    """[m^2]"""
    rudder_height_m: Positive
    """Span [m]."""
    rudder_lift_slope: Positive
    """f_alpha."""
    rudder_deduction: Number
    """t_R."""
    rudder_hull_share: Number
    """a_H: side force of the hull that the rudder causes, in parts of its own."""
    rudder_hull_place: Number
    """x_H over the length."""
    rudder_inflow: tuple[Positive, Number]
    """epsilon, kappa."""
    rudder_straightening: tuple[Positive, Positive]
    """gamma_R for flow from starboard (beta_R > 0) and from port."""
    rudder_flow_place: Number
    """l_R over the length."""
    rudder_place: Number = -0.5
    """x_R over the length."""
    limit_deg: Positive
    """[deg]"""
    rate_deg_s: Positive
    """[deg/s]"""
    time_constant_s: NonNegative
    """[s]"""
    shallow_water: ShallowWaterConfig | None = None
    """Changes with the depth of the world's water; left out: the water is deep."""

    @model_validator(mode="after")
    def _named(self) -> Self:
        wrong = sorted(set(self.hull) ^ set(HULL_NAMES))
        if wrong:
            raise ValueError(
                f"hull: give each of {', '.join(HULL_NAMES)} once, and nothing else; not so: {', '.join(wrong)}"
            )
        return self

    def build(self, body: Body) -> MmgShip:
        """The actuator."""
        limit, rate = (x * 3.141592653589793 / 180 for x in (self.limit_deg, self.rate_deg_s))
        c1, c2_starboard, c2_port = self.wake_change
        epsilon, kappa = self.rudder_inflow
        gamma_starboard, gamma_port = self.rudder_straightening
        return MmgShip(
            ship=Ship(body.length, self.draught_m, body.density, _SLOW * self.service_speed_m_s),
            hull=dict(self.hull),
            wake=Wake(self.diameter_m, self.propeller_place, self.wake_fraction, c1, c2_starboard, c2_port),
            thrust=list(self.thrust_coefficients),
            deduction=self.thrust_deduction,
            revolutions=self.revolutions_hz,
            rudder=Rudder(
                self.rudder_area_m2, self.diameter_m / self.rudder_height_m, self.rudder_lift_slope,
                self.rudder_deduction, self.rudder_hull_share, self.rudder_hull_place, epsilon, kappa, gamma_starboard,
                gamma_port, self.rudder_flow_place, self.rudder_place,
            ),
            lag=Lag(self.time_constant_s, -limit, limit, rate_limit=rate),
            shallow=None if self.shallow_water is None else self.shallow_water.build(body, self.draught_m),
        )  # fmt: skip


@dataclass(frozen=True)
class MmgShip:
    """ship, hull, wake, rudder: `hydro.manoeuvring`; thrust: K_T's polynomial; deduction: t_P; revolutions [1/s];
    shallow: what depends on the depth, None where the water is deep.
    """

    ship: Ship
    hull: dict[str, Array]
    wake: Wake
    thrust: Vector
    deduction: Array
    revolutions: Array
    rudder: Rudder
    lag: Lag
    shallow: ShallowWater | None = None
    unit: str = "rad"
    site: Place = HULL

    @property
    def feels_planes(self) -> bool:
        """True if the depth of water counts."""
        return self.shallow is not None

    def image_mass(self, flow: Flow) -> list[list[Array]]:
        """Added mass by the ground `(6, 6)`."""
        assert self.shallow is not None
        return self.shallow.image_mass(flow)

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Force and moment (6)."""
        ship, rudder = self.ship, self.rudder
        u, v, r = flow.nu_r[0], flow.nu_r[1], flow.nu_r[5]
        hull = self.hull if self.shallow is None else self.shallow.derivatives(self.hull, flow)
        x, y, n = hull_force(ship, hull, u, v, r)
        advance = u * (1 - wake_fraction(ship, self.wake, u, v, r))
        thrust, kt, j = propeller_thrust(ship, self.wake, self.thrust, advance, self.revolutions)
        tip = self.revolutions * self.wake.diameter
        normal = rudder_normal_force(ship, rudder, state, (u, v, r), (tip, kt, j))
        sin, cos = dr.sincos(state)
        x = x + (1 - self.deduction) * thrust - (1 - rudder.deduction) * normal * sin
        y = y - (1 + rudder.hull_share) * normal * cos
        n = n - (rudder.place + rudder.hull_share * rudder.hull_place) * ship.length * normal * cos
        load: list[Array] = [x, y, 0.0, 0.0, 0.0, n]
        return load if self.shallow is None else add(load, self.shallow.shoaling(flow))

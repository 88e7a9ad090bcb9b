"""A stern propeller with an open-water diagram."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from pelagos.hydro import thruster
from pelagos.hydro.algebra import Vector, norm
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, Fraction, NonNegative, PartConfig, Positive
from pelagos.vehicles.wetness import HULL, Place


class PropellerConfig(PartConfig):
    """A propeller along x. Command and state: shaft speed [rpm]."""

    type: Literal["propeller"]
    diameter_m: Positive
    """[m]"""
    thrust_deduction: Fraction
    """t: thrust on the vehicle is (1 - t) of the propeller's [-]."""
    wake_fraction: Fraction
    """w: the propeller sees (1 - w) of the vehicle's speed [-]."""
    KT_0: Positive
    """Thrust coefficient at rest [-]."""
    KT_limit: NonNegative
    """Thrust coefficient at `J_limit` [-]."""
    KQ_0: NonNegative
    """Torque coefficient at rest [-]."""
    KQ_limit: NonNegative
    """Torque coefficient at `J_limit` [-]."""
    J_limit: Positive
    """Advance number of the second point [-]."""
    torque_fraction: NonNegative = 1.0
    """Share of the propeller's torque that turns the hull [-]."""
    advance_from: Literal["ground", "water"] = "water"
    """Advance speed from the speed over ground (Fossen's programs) or through the water."""
    limit_rpm: Positive
    """[rpm]"""
    time_constant_s: NonNegative
    """[s]"""
    clip: Literal["before", "force"] = "before"
    """Whether the limit acts on the state before its use and its lag, or on the force alone."""

    def build(self, body: Body) -> Propeller:
        """The actuator."""
        d, rho = self.diameter_m, body.density
        return Propeller(
            thrust=thruster.open_water(rho, d, self.KT_0, self.KT_limit, self.J_limit, torque=False),
            torque=thruster.open_water(rho, d, self.KQ_0, self.KQ_limit, self.J_limit, torque=True),
            thrust_factor=1.0 - self.thrust_deduction,
            torque_factor=self.torque_fraction,
            advance_factor=1.0 - self.wake_fraction,
            over_ground=self.advance_from == "ground",
            lag=Lag(self.time_constant_s, -self.limit_rpm, self.limit_rpm, self.clip),
            site=Place("dry") if body.in_air else Place("propeller", (-body.length / 2, 0.0, 0.0), d / 2),
        )


@dataclass(frozen=True)
class Propeller:
    """Coefficients of `hydro.thruster.open_water_load`, and the factors between propeller and hull."""

    thrust: tuple[Array, Array]
    torque: tuple[Array, Array]
    thrust_factor: Array
    torque_factor: Array
    advance_factor: Array
    over_ground: bool
    lag: Lag
    unit: str = "rpm"
    site: Place = HULL

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Thrust along x and reaction torque about it (6) at a shaft speed [rpm]."""
        n = state * (1 / 60)
        advance = self.advance_factor * norm((flow.nu if self.over_ground else flow.nu_r)[:3])
        x = self.thrust_factor * thruster.open_water_load(self.thrust, n, advance)
        k = self.torque_factor * thruster.open_water_load(self.torque, n, advance)
        return [x, 0.0, 0.0, k, 0.0, 0.0]

"""Loss of thrust of a thruster in the water that flows through it: by the vehicle's way, and in others' jets."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, Final, Literal, Protocol, TypeAlias

import drjit as dr
import numpy as np
from pydantic import BeforeValidator, Field

from pelagos.hydro import b_series, momentum_disc, wash
from pelagos.hydro.algebra import Vector, add, cross, dot, mul
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Fraction, NonNegative, PartConfig, Three

_ALIKE: Final = 2.0
"""Ratio of a thruster's thrust coefficient to that of the series, either way, beyond which it is another propeller."""
_WATER: Final = 1000.0  # [kg/m^3], close enough for that
_SLOWEST: Final = 1e-6  # [1/s]: a shaft below this counts as still
PER_SECOND: Final = {"rad/s": 1 / (2 * math.pi), "rpm": 1 / 60, "1/s": 1.0}
"""Revolutions by the unit of a shaft speed [1/s]."""


class _InflowConfig(PartConfig):
    wake_fraction: Fraction = 0.0
    """w: the thruster sees (1 - w) of the vehicle's speed through the water along its axis [-]."""
    thrust_deduction: Fraction = 0.0
    """t: the vehicle feels (1 - t) of the thrust, since the thruster sucks at the hull ahead of it, or its jet rubs
    along the hull or clings to it [-]."""
    tunnel_loss_s2_m2: NonNegative = 0.0
    """c of exp(-c U^2), share of a tunnel thruster's force that is left where the hull moves across its jet with U; 0:
    no tunnel. 0.35 for the 70 mm thrusters of Delphin2 [s^2/m^2]."""


class DiscInflowConfig(_InflowConfig):
    """A thruster known by its bollard thrust: momentum theory, at the power that it takes at rest. Its reaction torque
    falls as its thrust does.
    """

    type: Literal["disc"]
    ducted: bool = False
    """Whether it turns in a nozzle or a tunnel, whose share of the thrust is in the bollard thrust."""

    def law(self) -> Disc:
        """Loss by the flow."""
        return Disc(self.ducted)


class BSeriesInflowConfig(_InflowConfig):
    """An open propeller of known shaft speed: thrust and torque fall as KT(J), KQ(J) of the Wageningen B-series."""

    type: Literal["b_series"]
    pitch_ratio: float = Field(ge=b_series.PITCH[0], le=b_series.PITCH[1])
    """P/D [-]."""
    area_ratio: float = Field(ge=b_series.AREA[0], le=b_series.AREA[1])
    """Expanded blade area over the disc's, AE/A0 [-]."""
    blades: int = Field(ge=b_series.BLADES[0], le=b_series.BLADES[1])
    """Number of blades."""

    def check(self, shaft: Shaft, diameter: float) -> None:
        """Refuse a thrust that is not this propeller's.

        Raises:
            ValueError: says which thrust coefficient was given, and which the series has.
        """
        if shaft.unit not in PER_SECOND:
            known = ", ".join(PER_SECOND)
            raise ValueError(
                f"inflow by the B-series needs the speed of the shaft: unit is {shaft.unit!r}, none of {known}"
            )
        given = shaft.forward / (PER_SECOND[shaft.unit] ** 2 * _WATER * diameter**4)
        series = b_series.thrust_polynomial(self.pitch_ratio, self.area_ratio, self.blades)[0]
        if not series / _ALIKE < given < series * _ALIKE:
            raise ValueError(
                f"forward gives a thrust coefficient of {given:.3g} at rest, and this propeller of the B-series has "
                f"{series:.3g}: check forward and its unit, diameter_m and pitch_ratio"
            )

    def law(self, shaft: Shaft, diameter: float, density: float) -> OpenWater:
        """Loss by the flow."""
        shape = self.pitch_ratio, self.area_ratio, self.blades
        thrust, torque = b_series.thrust_polynomial(*shape), b_series.torque_polynomial(*shape)
        hertz = PER_SECOND[shaft.unit]
        tip = diameter * hertz * math.sqrt(2 * density * math.pi / 4 * diameter**2)
        drawn = math.sqrt(shaft.reverse) / tip, math.sqrt(shaft.forward) / tip
        return OpenWater(thrust, torque, b_series.advance_at(thrust, 0.0), diameter, hertz, drawn)


InflowConfig: TypeAlias = Annotated[DiscInflowConfig | BSeriesInflowConfig, Field(discriminator="type")]


def _of_no_shaft(given: Any) -> Any:
    """Refuse the B-series where no shaft speed is known.

    Raises:
        ValueError: says which thruster it is for.
    """
    kind = given.get("type") if isinstance(given, Mapping) else getattr(given, "type", None)
    if kind == "b_series":
        known = ", ".join(PER_SECOND)
        raise ValueError(
            f"b_series needs the speed of the shaft, which only a thruster of the type `thruster` has as its state "
            f"(unit {known}): use one, or inflow of the type disc"
        )
    return given


DiscOnly: TypeAlias = Annotated[DiscInflowConfig, BeforeValidator(_of_no_shaft)]
"""For thrusters whose state is not the speed of a shaft."""


@dataclass(frozen=True)
class Shaft:
    """Thrust by the square of a shaft speed, ahead and astern, and the unit of that speed."""

    forward: float
    reverse: float
    unit: str


class Law(Protocol):
    """Thrust and torque by the flow from ahead of what a thruster pushes against."""

    def shares(self, ahead: Array, still: Array, state: Array) -> tuple[Array, Array]:
        """Shares of thrust and torque left: flow from ahead [m/s], `momentum_disc.flow_at_rest` [m/s], state."""
        ...

    def flow_for(self, share: float, sign: float) -> float:
        """The flow from ahead, over `momentum_disc.flow_at_rest`, that leaves a share of a thrust of a sign."""
        ...


@dataclass(frozen=True)
class Disc:
    """ducted: whether in a nozzle."""

    ducted: bool

    def shares(self, ahead: Array, still: Array, state: Array) -> tuple[Array, Array]:
        """See `Law`."""
        share = (momentum_disc.duct_share if self.ducted else momentum_disc.open_share)(ahead / still)
        return share, share

    def flow_for(self, share: float, sign: float) -> float:
        """See `Law`."""
        return (momentum_disc.duct_inflow if self.ducted else momentum_disc.open_inflow)(share)


@dataclass(frozen=True)
class OpenWater:
    """thrust, torque: KT(J), KQ(J) from J^0 on; limit: J of zero thrust; diameter [m]; hertz: revolutions by state;
    drawn: `momentum_disc.flow_at_rest` over n D, astern and ahead.

    J is held between 0 and `limit`: no propeller brakes, and one in a flow from behind, or one that turns astern, is as
    the one ahead.
    """

    thrust: tuple[float, ...]
    torque: tuple[float, ...]
    limit: float
    diameter: float
    hertz: float
    drawn: tuple[float, float]

    def shares(self, ahead: Array, still: Array, state: Array) -> tuple[Array, Array]:
        """See `Law`."""
        turning = dr.maximum(dr.abs(state) * self.hertz, _SLOWEST)
        j = dr.clip(ahead / (turning * self.diameter), 0.0, self.limit)
        return _at(self.thrust, j), _at(self.torque, j)

    def flow_for(self, share: float, sign: float) -> float:
        """See `Law`."""
        return b_series.advance_at(self.thrust, share * self.thrust[0]) / self.drawn[1 if sign > 0 else 0]


def _at(polynomial: tuple[float, ...], j: Array) -> Array:
    """Of its value at 0."""
    found: Array = polynomial[-1] / polynomial[0]
    for c in polynomial[-2::-1]:
        found = found * j + c / polynomial[0]
    return found


@dataclass(frozen=True)
class Inflow:
    """A thruster in the water that flows through it.

    Attributes:
        law: loss by the flow.
        axis, point: of the thruster, from the origin (3) [m].
        diameter: [m]; density: of the water [kg/m^3].
        wake: 1 - w.
        deduction: t; it is in the actuator's `effect` already.
        tunnel: c of `hydro.wash.tunnel_share` [s^2/m^2].
    """

    law: Disc | OpenWater
    axis: tuple[float, ...]
    point: tuple[float, ...]
    diameter: float
    density: float
    wake: float
    deduction: float
    tunnel: float

    def still(self, thrust: Array) -> Array:
        """Flow that a thrust [N] draws through the disc at rest [m/s]."""
        return momentum_disc.flow_at_rest(thrust, self.density, self.diameter)

    def shares(self, thrust: Array, state: Array, flow: Flow) -> tuple[Array, Array]:
        """Shares of thrust and torque left of those at rest."""
        velocity = add(flow.nu_r[:3], cross(flow.nu_r[3:], self.point))
        along = dot(self.axis, velocity)
        ahead = mul(self.wake, along)
        if flow.wash is not None:
            ahead = ahead + flow.wash
        shares = self.law.shares(dr.mulsign(ahead, thrust), self.still(thrust), state)
        if self.tunnel == 0:
            return shares
        left = wash.tunnel_share(dr.maximum(dot(velocity, velocity) - along * along, 0.0), self.tunnel)
        return shares[0] * left, shares[1]

    def wrench(self, effect: Vector, thrust: Array, state: Array, flow: Flow) -> Vector:
        """Force and moment (6); `effect`: of 1 N at rest, `thrust`: at rest [N]."""
        push, turn = self.shares(thrust, state, flow)
        hand = dot(self.axis, effect[3:])  # the force has no moment about its own axis
        moment = [m - hand * a for m, a in zip(effect[3:], self.axis, strict=True)]
        pushed, turned = thrust * push, hand * thrust * turn
        return [
            *(mul(e, pushed) for e in effect[:3]),
            *(m * pushed + a * turned for m, a in zip(moment, self.axis, strict=True)),
        ]


def build_inflow(
    config: DiscInflowConfig | BSeriesInflowConfig | None,
    *,
    position: Three,
    direction: Three,
    diameter: float,
    density: float,
    shaft: Shaft | None = None,
) -> Inflow | None:
    """The loss of a thruster, in the water that its vehicle is for; `shaft`: where its speed is known."""
    if config is None:
        return None
    if isinstance(config, DiscInflowConfig):
        law: Disc | OpenWater = config.law()
    else:
        assert shaft is not None
        law = config.law(shaft, diameter, density)
    axis = np.array(direction) / np.linalg.norm(direction)
    return Inflow(
        law=law,
        axis=tuple(float(a) for a in axis),
        point=tuple(float(p) for p in position),
        diameter=diameter,
        density=density,
        wake=1 - config.wake_fraction,
        deduction=config.thrust_deduction,
        tunnel=config.tunnel_loss_s2_m2,
    )


def check_direction(direction: Three) -> None:
    """Refuse an axis that points nowhere.

    Raises:
        ValueError: says what was given, where it is not 0, 0, 0.
    """
    if not any(direction):
        raise ValueError("direction must not be 0, 0, 0")
    if not 0 < sum(d * d for d in direction) < math.inf:
        raise ValueError(f"direction must have a length that a number can hold, not that of {list(direction)}")


def check_diameter(inflow: object, given: bool) -> None:
    """Refuse a disc of no stated size.

    Raises:
        ValueError: says what is missing.
    """
    if inflow is not None and not given:
        raise ValueError("inflow needs the propeller's diameter: give diameter_m")

"""Thrusters of a vehicle in each other's jets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.errors import did_you_mean
from pelagos.hydro import wash
from pelagos.hydro.algebra import mul, total
from pelagos.jit import Array
from pelagos.vehicles.actuators.inflow import Inflow
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import PartConfig

_SEEN: Final = 1e-3
"""Loss below which one thruster does not feel another."""
_SAME_PLACE: Final = 1e-9  # diameters: nearer than that no line from one to the other says whom a jet meets


class InteractionConfig(PartConfig):
    """Thrusters that lose thrust in the jets of others, each with an `inflow`."""

    thrusters: tuple[str, ...]
    """Names of those that may stand in each other's jets, at least two; those that do are of about equal diameter."""
    under_hull: bool = False
    """Whether the jets run along a flat bottom, which they follow and along which they slow down less."""

    def check(self, actuators: Mapping[str, Any]) -> None:
        """Refuse what cannot be.

        Raises:
            ValueError: names the thruster, and why.
        """
        if len(set(self.thrusters)) < max(2, len(self.thrusters)):
            raise ValueError(
                f"interaction is among two thrusters at least, each named once, not {list(self.thrusters)}"
            )
        for name in self.thrusters:
            part = actuators.get(name)
            if part is None and name in actuators:
                raise ValueError(
                    f"interaction names the thruster {name!r}, which is null: leave it out of interaction too"
                )
            if part is None:
                hint = did_you_mean(name, [n for n, a in actuators.items() if a is not None])
                raise ValueError(f"interaction names the thruster {name!r}, which this vehicle does not have{hint}")
            if not hasattr(part, "inflow"):
                raise ValueError(f"interaction names {name!r}, a {part.type}, whose thrust no jet can change")
            if part.inflow is None:
                raise ValueError(f"interaction needs to know how {name!r} loses thrust in a flow: give it an inflow")


@dataclass(frozen=True)
class Jet:
    """Jet of one thruster at another.

    Attributes:
        source, target: names.
        ahead, astern: flow from ahead at the target, by its own direction, over the flow that the source draws at rest,
            while the source pushes ahead or astern; 0: none.
    """

    source: str
    target: str
    ahead: float
    astern: float


@dataclass(frozen=True)
class Interaction:
    """jets: those that reach another thruster."""

    jets: tuple[Jet, ...]

    def wash(
        self, actuators: Mapping[str, Any], states: Sequence[Array], left: Sequence[Array], flow: Flow
    ) -> dict[str, Array]:
        """Flow from ahead that jets bring to each thruster [m/s], by name.

        `states`: of all actuators; `left`: shares of their forces left near the surface. A jet is that of the thrust
        that the vehicle's speed leaves its thruster; that this one stands in a jet itself does not count. Jets that
        meet add their momentum, V |V| = sum of v |v|.
        """
        rows = dict(zip(actuators, zip(states, left, strict=True), strict=True))
        drawn: dict[str, tuple[Array, Array]] = {}
        for name in dict.fromkeys(jet.source for jet in self.jets):
            part, (state, share) = actuators[name], rows[name]
            thrust = part.thrust(state, flow)
            thrust = mul(mul(part.inflow.shares(thrust, state, flow)[0], share), thrust)
            drawn[name] = thrust, part.inflow.still(thrust)
        found: dict[str, Array] = {}
        for jet in self.jets:
            thrust, still = drawn[jet.source]
            v = dr.select(thrust > 0, jet.ahead * still, dr.select(thrust < 0, jet.astern * still, 0.0))
            found[jet.target] = total(found.get(jet.target, 0.0), v * dr.abs(v))
        return {name: _signed_root(square) for name, square in found.items()}

    def left(self, actuators: Mapping[str, Any], jet: Jet, *, source: float, target: float) -> float:
        """Share of the target's thrust [N] that the jet of the source's [N] leaves, at rest."""
        first, second = actuators[jet.source].inflow, actuators[jet.target].inflow
        ahead = (jet.ahead if source > 0 else jet.astern) * float(first.still(_number(source))[0])
        part = actuators[jet.target]
        state = part.command(_number(target))
        share, _ = second.law.shares(_number(ahead if target > 0 else -ahead), second.still(_number(target)), state)
        return float(share[0])


def _number(x: float) -> Array:
    """A number as an array of one lane."""
    return jit.Float64(x)


def _signed_root(square: Array) -> Array:
    """sign(x) sqrt(|x|); its gradient at 0 is 0, not NaN."""
    there = square != 0
    return dr.select(there, dr.mulsign(dr.sqrt(dr.select(there, dr.abs(square), 1.0)), square), 0.0)


def build_interaction(config: InteractionConfig | None, actuators: Mapping[str, Any]) -> Interaction | None:
    """Jets among thrusters that do not turn: by distance and angle, once.

    The tandem formula was measured on two equal thrusters at the same command, the one behind in line. A jet's speed
    goes with the square root of its thrust over its area, so what the formula says of equal ones is kept as a flow in
    units of that which the source draws, and holds for any two thrusts. The flow runs from thruster to thruster; its
    part along the target's axis counts, which nobody has measured for targets that are not in line.

    That flow is two to three times a free jet's: swirl, turbulence and the shape of the jet cost thrust too.

    Raises:
        ValueError: two thrusters are closer than the formula's data, or of unequal size.
    """
    if config is None:
        return None
    base = wash.UNDER_HULL if config.under_hull else wash.OPEN_WATER
    jets = []
    for source in config.thrusters:
        for target in config.thrusters:
            if source != target:
                way = [_reach(source, target, actuators, base, sign) for sign in (1, -1)]
                if any(way):
                    jets.append(Jet(source, target, *way))
    return Interaction(tuple(jets))


def _reach(source: str, target: str, actuators: Mapping[str, Any], base: float, sign: int) -> float:
    """Flow from ahead at the target over the flow that the source draws; `sign`: of the source's thrust."""
    first: Inflow = actuators[source].inflow
    second: Inflow = actuators[target].inflow
    line = np.subtract(second.point, first.point)
    sizes = sorted((first.diameter, second.diameter))
    distance = float(np.linalg.norm(line)) / first.diameter
    ahead_of_jet = float(-sign * np.dot(first.axis, line)) / first.diameter
    if distance > _SAME_PLACE and ahead_of_jet <= 1e-9 * min(distance, 1.0):
        return 0.0
    apart = float(np.linalg.norm(line)) / sizes[1]
    if apart < wash.LEAST_DISTANCE:
        raise ValueError(
            f"the jet of {source!r} reaches {target!r} at {apart:.2g} diameters, nearer than anything was measured: "
            f"leave one of them out of interaction, or place them {wash.LEAST_DISTANCE:g} diameter apart"
        )
    angle = float(np.degrees(np.arccos(np.clip(ahead_of_jet / distance, -1.0, 1.0))))
    share = wash.steered_share(wash.tandem_share(distance, base), angle)
    if 1 - share < _SEEN:
        return 0.0
    against = float(-np.dot(line, second.axis)) / (distance * first.diameter)
    if abs(against) > 1e-9 and sizes[1] > wash.LARGEST_RATIO * sizes[0]:
        raise ValueError(
            f"the jet of {source!r}, diameter {first.diameter:g} m, reaches {target!r}, {second.diameter:g} m: losses "
            f"were measured on equal thrusters, and are taken for diameters of a ratio up to {wash.LARGEST_RATIO:g}: "
            "leave one of them out of interaction"
        )
    return second.law.flow_for(share, against) * against

"""Vehicles whose parameters differ from copy to copy."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

from pelagos.errors import LookupFailed
from pelagos.hydro.algebra import Matrix, Vector, add, minus, mul
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.model import Inertia
from pelagos.vehicles.nearby import feels_planes
from pelagos.vehicles.seakeeping import Seakeeping
from pelagos.vehicles.terms.floating import Surplus
from pelagos.vehicles.vehicle import Vehicle
from pelagos.vehicles.wetness import Keeps

GENERAL = ("mass", "added_mass", "thrust", "lag")
_SURPLUS = "surplus weight"


def check_names(vehicle: Vehicle, names: Iterable[str], where: str) -> None:
    """Refuse what the vehicle does not have.

    Raises:
        LookupFailed: names the key and the nearest that there is.
    """
    general = [*GENERAL]
    actuators = vehicle.model.actuators.values()
    if not all(hasattr(a, "effect") for a in actuators):
        general.remove("thrust")
    if not any(_lags(a) for a in actuators):
        general.remove("lag")
    known = [*general, *(n for n, t in vehicle.model.terms.items() if not hasattr(t, "image_mass"))]
    for name in names:
        if name not in known:
            raise LookupFailed("parameter of the vehicle", name, known, where=where)


def varied(vehicle: Vehicle, factors: Mapping[str, Array]) -> Vehicle:
    """A vehicle with parameters times `factors`, arrays of one lane a copy.

    `mass`: of the body, its inertia and its weight, at the same volume, so that what floats sinks deeper; `added_mass`:
    of the water that goes along, in waves that at infinite frequency;
    `thrust`: of every actuator; `lag`: time constants of actuators; a term's name: its force and moment.
    """
    if not factors:
        return vehicle
    model = vehicle.model
    terms: dict[str, Any] = dict(model.terms)
    mass, body = factors.get("mass"), vehicle.config.body
    floats = bool(body.stiffness.any())  # its hydrostatics are in balance at its own weight, payloads' included
    for name, term in model.terms.items():
        if mass is not None and not floats and hasattr(term, "weight"):
            terms[name] = replace(cast(Any, term), weight=mul(mass, cast(Any, term).weight))
        if name in factors:
            terms[name] = Scaled(terms[name], factors[name])
    actuators = dict(model.actuators)
    for name, actuator in model.actuators.items():
        lag: Any = actuator.lag
        if "lag" in factors and _lags(actuator):
            actuators[name] = replace(actuator, lag=replace(lag, time_constant=mul(factors["lag"], lag.time_constant)))  # type: ignore[type-var]
        if "thrust" in factors:
            effect = [mul(factors["thrust"], c) for c in actuators[name].effect]  # type: ignore[attr-defined]
            actuators[name] = replace(actuators[name], effect=effect)  # type: ignore[type-var]
    if mass is not None and floats:
        terms[_SURPLUS] = Surplus(mul(mass - 1.0, body.weight), [float(x) for x in body.center_of_gravity])
    made = replace(
        model, terms=terms, actuators=actuators, inertia=_inertia(model.inertia, factors),
        sea=None if model.sea is None else _sea(model.sea, factors),
        sea_inertia=None if model.sea_inertia is None else _inertia(model.sea_inertia, factors),
    )  # fmt: skip
    return vehicle.with_model(made)


def _lags(actuator: Any) -> bool:
    """Whether it follows with a time constant of the first order."""
    return isinstance(actuator.lag, Lag) and actuator.lag.time_constant != 0


def _sea(sea: Seakeeping, factors: Mapping[str, Array]) -> Seakeeping:
    added = _times(factors.get("added_mass", 1.0), sea.added)
    ahead = sea.ahead
    if ahead is not None:
        upright = ahead.upright
        if upright is not None:
            rigid = [add(row, minus(other)) for row, other in zip(upright, ahead.added, strict=True)]
            upright = [add(*rows) for rows in zip(_times(factors.get("mass", 1.0), rigid), added, strict=True)]
        ahead = replace(ahead, added=added, upright=upright)
    return replace(sea, added=added, ahead=ahead)


def _inertia(inertia: Inertia, factors: Mapping[str, Array]) -> Inertia:
    if "mass" not in factors and "added_mass" not in factors:
        return inertia
    rigid, added = inertia.rigid, inertia.added
    if "mass" in factors:
        rigid = _times(factors["mass"], rigid)
    if "added_mass" in factors:
        added = _times(factors["added_mass"], added)
    angular, excess = inertia.angular, inertia.excess
    if "mass" in factors and angular is not None:
        angular = (mul(factors["mass"], angular[0]), _times(factors["mass"], angular[1]), angular[2])
    if "mass" in factors and inertia.displaced is not None:
        excess = [add(row, minus(other)) for row, other in zip(rigid, inertia.displaced, strict=True)]
    return replace(inertia, rigid=rigid, added=added, inverse=None, angular=angular, excess=excess)


def _times(factor: Array, matrix: Matrix) -> Matrix:
    return [[mul(factor, c) for c in row] for row in matrix]


@dataclass(frozen=True)
class Scaled:
    """A term, times a factor."""

    term: Any
    factor: Array

    @property
    def keeps(self) -> Keeps:
        """Share of it left out of the water, as of the term; one that says none has that of its vehicle's medium.

        Raises:
            AttributeError: the term says none.
        """
        kept: Keeps = self.term.keeps
        return kept

    @property
    def on_host(self) -> bool:
        """True if the term computes in NumPy."""
        return bool(getattr(self.term, "on_host", False))

    @property
    def feels_planes(self) -> bool:
        """True if the term depends on ground or walls."""
        return feels_planes(self.term)

    def wrench(self, flow: Flow) -> Vector:
        """Force and moment (6)."""
        return [mul(self.factor, c) for c in self.term.wrench(flow)]

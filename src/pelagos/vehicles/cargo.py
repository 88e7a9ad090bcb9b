"""Mass that a vehicle carries for a while: what an actuator has aboard at one moment."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Protocol, runtime_checkable

from pelagos.hydro import restoring
from pelagos.hydro.algebra import Matrix, Vector, add, minus, mul, neg, scaled, total
from pelagos.hydro.carried_mass import about_center, mass_matrix, skew
from pelagos.jit import Array
from pelagos.vehicles.actuators.actuator import Actuator, Follower
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.wetness import HULL

if TYPE_CHECKING:
    from pelagos.vehicles.model import Inertia


@dataclass(frozen=True)
class Cargo:
    """A mass aboard; one that is gone, of a vehicle whose own mass holds it, is negative.

    Attributes:
        mass: [kg].
        displaced: mass of the water that it displaces beyond the hull [kg].
        center: of both, from the origin (3) [m].
        inertia: `(3, 3)` about the centre [kg m^2].
    """

    mass: Array
    displaced: Array
    center: Vector
    inertia: Matrix

    def matrix(self) -> list[list[Array]]:
        """M `(6, 6)` about the origin."""
        return mass_matrix(self.mass, self.inertia, self.center)

    def water(self) -> list[list[Array]]:
        """That of the water displaced, as a point `(6, 6)`."""
        return mass_matrix(self.displaced, [[0.0] * 3] * 3, self.center)

    def wrench(self, gravity: float, flow: Flow) -> Vector:
        """Weight, and buoyancy where the hull is wet (6) [N], [N m]."""
        lift = mul(HULL.share(flow), self.displaced)
        if flow.heaviness is not None:
            lift = mul(flow.heaviness, lift)
        weight = mul(gravity, total(self.mass, neg(lift)))
        return restoring.weight_at(weight, self.center, flow.down)


@runtime_checkable
class Carrier(Protocol):
    """An actuator whose state is a mass aboard; every control mode has a set-point for it besides its own."""

    def cargo(self, state: Array, flow: Flow) -> Cargo:
        """Mass aboard."""
        ...

    def taken(self, now: Array, after: Array, flow: Flow) -> Cargo:
        """Mass that comes aboard between two states, at rest in the water before; what goes keeps its momentum."""
        ...

    def follower(self, flow: Flow) -> Follower:
        """Law by which its state changes in this water."""
        ...


def carriers_of(actuators: Mapping[str, Actuator]) -> dict[str, Carrier]:
    """Those actuators that carry mass, by name."""
    return {name: actuator for name, actuator in actuators.items() if isinstance(actuator, Carrier)}


def carrying(inertia: Inertia, cargo: Sequence[Cargo]) -> Inertia:
    """Mass of a vehicle with what it carries; the added mass is that of the hull."""
    rigid = _sum([inertia.rigid, *(c.matrix() for c in cargo)])
    angular = inertia.angular
    if angular is not None:
        mass, inside, center = about_center(rigid)
        back = [minus(row) for row in skew(center)]
        top = [[1.0 if i == j else 0.0 for j in range(3)] + list(back[i]) for i in range(3)]
        shift = top + [[0.0] * 3 + [1.0 if i == j else 0.0 for j in range(3)] for i in range(3)]
        angular = (mass, inside, shift)
    displaced, excess = inertia.displaced, inertia.excess
    if displaced is not None:
        displaced = _sum([displaced, *(c.water() for c in cargo)])
        excess = [add(row, minus(other)) for row, other in zip(rigid, displaced, strict=True)]
    return replace(inertia, rigid=rigid, inverse=None, angular=angular, displaced=displaced, excess=excess)


def growing(inertia: Inertia, growth: Matrix, h: Array) -> Inertia:
    """Mass after a step of h [s] in which it grows by `growth` a second `(6, 6)`."""
    rigid = [add(row, scaled(h, more)) for row, more in zip(inertia.rigid, growth, strict=True)]
    return replace(inertia, rigid=rigid, inverse=None)


def growth_of(carriers: Sequence[tuple[Carrier, Array, Array]], flow: Flow, h: Array) -> list[list[Array]]:
    """Growth of the mass matrix by what comes aboard within h [s], `(6, 6)` a second; each with its two states."""
    whole = _sum([carrier.taken(now, after, flow).matrix() for carrier, now, after in carriers])
    return [[mul(1.0 / h, entry) for entry in row] for row in whole]


def _sum(matrices: Sequence[Matrix]) -> list[list[Array]]:
    return [add(*rows) for rows in zip(*matrices, strict=True)]

"""Things that are carried until they are released, or picked up: drop weights, shot ballast, instruments, samples."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, Self

import drjit as dr
import numpy as np
from pydantic import model_validator

from pelagos.hydro.algebra import Matrix, Vector, mul, scaled
from pelagos.jit import Array
from pelagos.vehicles.actuators.lag import Lag
from pelagos.vehicles.cargo import Cargo
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Body, NonNegative, PartConfig, Positive, Three, numbers
from pelagos.vehicles.wetness import ALWAYS, Place


class ReleasableConfig(PartConfig):
    """A thing that is released, or picked up, by command. Command and state: 0 as at the start, 1 the other way round,
    in between a share of it (shot ballast).

    Released, it takes its momentum along: no velocity jumps. Picked up, it was at rest in the water, and takes its
    share of the vehicle's momentum. Weight, buoyancy, centre of gravity, mass matrix and Coriolis forces follow; the
    added mass stays that of the hull.
    """

    type: Literal["releasable"]
    mass_kg: Positive
    """[kg]"""
    position_m: Three
    """Its centre, FRD from the origin [m]."""
    volume_m3: NonNegative = 0.0
    """Water that it displaces beyond the hull [m^3]; 0: it is inside."""
    inertia_kg_m2: tuple[NonNegative, NonNegative, NonNegative] = (0.0, 0.0, 0.0)
    """About its own centre, along body axes [kg m^2]."""
    start: Literal["carried", "absent"] = "carried"
    """At the start it is carried, and 1 releases it; or it is absent, and 1 picks it up."""
    in_vehicle_mass: bool = False
    """The vehicle's mass, inertia, centres and volume hold it already, as those of a published vehicle that is weighed
    with its drop weight."""
    for_good: bool = True
    """A release for good: a smaller command later does nothing. Otherwise the state follows both ways."""
    duration_s: NonNegative = 0.0
    """Duration from 0 to 1 [s]; 0: at once."""
    release_after_s: NonNegative | None = None
    """The command counts as 1 from so long after the start of the episode on, such as by a corroding link [s]."""

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        if self.in_vehicle_mass and self.start == "absent":
            raise ValueError("in_vehicle_mass: the vehicle's own mass cannot hold what is absent at the start")
        x, y, z = sorted(self.inertia_kg_m2)
        if z > (x + y) * (1 + 1e-9):
            raise ValueError(f"inertia_kg_m2: {z:g} kg m^2 is more than the sum of the others, {x:g} and {y:g}")
        return self

    def build(self, body: Body) -> Releasable:
        """The actuator."""
        rate = None if self.duration_s == 0 else 1 / self.duration_s
        return Releasable(
            mass=self.mass_kg,
            displaced=body.density * self.volume_m3,
            center=list(self.position_m),
            inertia=numbers(np.diag(self.inertia_kg_m2)),
            gravity=body.gravity,
            begins=0.0 if self.start == "absent" or self.in_vehicle_mass else 1.0,
            turns=1.0 if self.start == "absent" else -1.0,
            lag=Release(rate, self.for_good, self.release_after_s),
        )


@dataclass(frozen=True)
class Release:
    """Law of the share that has changed hands.

    Attributes:
        rate: fastest change [1/s]; None: at once.
        for_good: it never falls.
        alone_s: time after which the command counts as 1 [s], and which is kept beside the state; None: never.
    """

    rate: float | None
    for_good: bool
    alone_s: float | None
    low: float = 0.0
    high: float = 1.0
    time_constant: float = 0.0

    @property
    def memory(self) -> int:
        """See `Follower`."""
        return 0 if self.alone_s is None else 1

    def limited(self, state: Array) -> Array:
        """The state as forces see it."""
        return dr.clip(state, 0.0, 1.0)

    def rates(self, state: Array, kept: list[Array], command: Array) -> list[Array]:
        """Time derivatives; at once counts as within 1 s."""
        return [self._lag.rate(self.limited(state), self._wanted(state, kept, command)), *(0 * k + 1.0 for k in kept)]

    def after(self, state: Array, kept: list[Array], command: Array, h: Array) -> list[Array]:
        """The state, and the time, after h [s] of a constant command."""
        new = self._lag.advanced(self.limited(state), self._wanted(state, kept, command), h)
        return [new, *(k + h for k in kept)]

    @property
    def _lag(self) -> Lag:
        return Lag(0.0, 0.0, 1.0, rate_limit=self.rate)

    def _wanted(self, state: Array, kept: list[Array], command: Array) -> Array:
        if self.alone_s is not None:
            command = dr.select(kept[0] >= self.alone_s, 1.0, command)
        wanted = self.limited(command)
        return dr.maximum(wanted, self.limited(state)) if self.for_good else wanted


@dataclass(frozen=True)
class Releasable:
    """The thing.

    Attributes:
        mass, displaced: its own, and that of the water in its place [kg].
        center: from the origin (3) [m].
        inertia: `(3, 3)` about its centre [kg m^2].
        gravity: [m/s^2].
        begins, turns: share of it in the sums of forces at state 0, and how that changes up to state 1.
    """

    mass: Array
    displaced: Array
    center: Vector
    inertia: Matrix
    gravity: float
    begins: float
    turns: float
    lag: Release
    unit: str = "share"
    site: Place = ALWAYS

    def cargo(self, state: Array, flow: Flow) -> Cargo:
        """See `Carrier`."""
        return self._part(self.begins + self.turns * state)

    def taken(self, now: Array, after: Array, flow: Flow) -> Cargo:
        """See `Carrier`."""
        return self._part(dr.maximum(self.turns * (self.lag.limited(after) - self.lag.limited(now)), 0.0))

    def follower(self, flow: Flow) -> Release:
        """See `Carrier`."""
        return self.lag

    def wrench(self, state: Array, flow: Flow) -> Vector:
        """Weight and buoyancy (6)."""
        return self.cargo(state, flow).wrench(self.gravity, flow)

    def _part(self, share: Array) -> Cargo:
        inertia = [scaled(share, row) for row in self.inertia]
        return Cargo(mul(share, self.mass), mul(share, self.displaced), self.center, inertia)

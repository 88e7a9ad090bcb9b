"""Wetness of a vehicle: one immersion for buoyancy, added mass, damping and actuators."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Final, Literal, Protocol

import drjit as dr

from pelagos import jit
from pelagos.hydro import immersion
from pelagos.hydro.algebra import dot, total
from pelagos.jit import Array
from pelagos.math.either import either

if TYPE_CHECKING:
    from pelagos.vehicles.flow import Flow

_FELT: Final = 1.4  # sizes: how far below the surface a propeller or a fin still feels it
_HEAVE: Final = (0.5, 0.8)  # of draught or freeboard
_TILT: Final = (math.cos(math.radians(15)), math.cos(math.radians(25)))

Keeps = Literal["always", "hull", "propeller", "fin", "dry"]
"""What a force depends on: nothing; the hull's wet share; a propeller's or a fin's depth; the dry share."""


@dataclass
class Wetness:
    """share: 1 where all coefficients hold, 0 in the air; rate: of it [1/s], see `hydro.immersion`."""

    share: Array
    rate: Array


class Wetting(Protocol):
    """A shape that knows how wet it is."""

    def of(self, flow: Flow) -> Wetness:
        """At one moment."""
        ...


@dataclass(frozen=True)
class Submersible:
    """semi_axes, center: of the ellipsoid that a submerged hull is for its buoyancy (3) [m]."""

    semi_axes: Sequence[float]
    center: Sequence[float]

    def of(self, flow: Flow) -> Wetness:
        """See `Wetting`."""
        found = immersion.ellipsoid_share(self.semi_axes, self.center, flow.down, flow.immersion, _sinking(flow))
        return Wetness(*found)


@dataclass(frozen=True)
class Floating:
    """A hull that floats.

    Attributes:
        semi_axes, center: of its box (3) [m].
        fade: half its draught [m].
        reach: draught or freeboard, whichever is less [m].
    """

    semi_axes: Sequence[float]
    center: Sequence[float]
    fade: float
    reach: float

    def far(self, flow: Flow) -> Array:
        """0 where linear hydrostatics hold, 1 where they do not, from half to 0.8 of `reach` and from 15 to 25 deg."""
        heave = (dr.abs(flow.immersion) / self.reach - _HEAVE[0]) * (1 / (_HEAVE[1] - _HEAVE[0]))
        tilt = (_TILT[0] - flow.down[2]) * (1 / (_TILT[0] - _TILT[1]))
        x = dr.clip(dr.maximum(heave, tilt), 0.0, 1.0)
        return x * x * (3 - 2 * x)

    def of(self, flow: Flow) -> Wetness:
        """See `Wetting`."""
        found = immersion.keel_share(self.semi_axes, self.center, flow.down, flow.immersion, _sinking(flow), self.fade)
        return Wetness(*found)


@dataclass(frozen=True)
class Place:
    """Place at which an actuator acts.

    Attributes:
        keeps: what of its force is left near the surface and above it.
        point: from the origin (3) [m].
        size: radius of a propeller, or half the span of a fin [m].
    """

    keeps: Keeps = "hull"
    point: Sequence[float] = (0.0, 0.0, 0.0)
    size: float = 0.0

    def share(self, flow: Flow) -> Array:
        """Of the force that is left, 0 to 1."""
        if flow.wet is None or self.keeps == "always":
            return 1.0
        if self.keeps == "hull":
            return flow.wet.share
        if self.keeps == "dry":
            return 1 - flow.wet.share
        return self.share_at(flow.immersion, flow.down)

    def share_at(self, depth: Array, down: Sequence[Array]) -> Array:
        """That of a propeller or a fin, the origin at a depth [m]; `down`: body axes (3)."""
        share = immersion.propeller_share if self.keeps == "propeller" else immersion.fin_share
        return share(total(depth, dot(self.point, down)), self.size)


def shares_of(places: Sequence[Place], flow: Flow) -> list[Array]:
    """Shares of the force left at each place; those near the surface are looked at only where the vehicle is."""
    if flow.wet is None:
        return [1.0] * len(places)
    local = [place for place in places if place.keeps in ("propeller", "fin")]
    if not local:
        return [place.share(flow) for place in places]
    reach: Array = 0.0
    for place in local:
        reach = dr.maximum(reach, dr.sqrt(dot(place.point, place.point)) + _FELT * place.size)
    f64 = jit.Float64

    def near(immersion: Array, down: list[Array]) -> list[Array]:
        return [f64(place.share_at(immersion, down)) for place in local]

    def deep(immersion: Array, down: list[Array]) -> list[Array]:
        return [f64(1.0) for _ in local]

    given = f64(flow.immersion), [f64(d) for d in flow.down]
    found = iter(either(given, given[0] < reach, near, deep))
    return [next(found) if place.keeps in ("propeller", "fin") else place.share(flow) for place in places]


ALWAYS: Final = Place("always")
HULL: Final = Place("hull")
DRY: Final = Place("dry")


def _sinking(flow: Flow) -> Array:
    return dot(flow.down, flow.nu_r[:3])

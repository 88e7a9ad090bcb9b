"""Planes near a vehicle: ground and walls as a step is told of them, and added mass by the depth of water."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Protocol, TypeGuard

import drjit as dr

from pelagos import jit
from pelagos.hydro.algebra import Matrix, Vector, add, dot, matvec, minus, mul, transpose
from pelagos.hydro.images import Plane
from pelagos.hydro.shallow_water import SHALLOWEST
from pelagos.hydro.shoaling import shoaling_wrench
from pelagos.jit import Array
from pelagos.vehicles.flow import FAR_M, Flow


class Image(Protocol):
    """A part whose added mass changes with the planes that are near."""

    def image_mass(self, flow: Flow) -> list[list[Array]]:
        """Added mass by the planes `(6, 6)`."""
        ...


def has_image(part: Any) -> TypeGuard[Image]:
    """True for a part that changes the added mass near a plane."""
    return hasattr(part, "image_mass") and feels_planes(part)


def feels_planes(part: Any) -> bool:
    """True for a term or an actuator that depends on ground or walls."""
    return bool(getattr(part, "feels_planes", False))


def feels_depth(part: Any) -> bool:
    """True for a term or an actuator that depends on the ground even where no wall is near."""
    return feels_planes(part) and bool(getattr(part, "feels_depth", True))


@dataclass(frozen=True)
class GroundMass:
    """Added mass that grows as the water under the keel gets less, by draught over its depth.

    Attributes:
        draught: [m].
        growth: of the matrix's diagonal (6) [kg], [kg m^2].
        momentum: whether a change of depth under way takes the momentum that it must (`hydro.shoaling`).
    """

    draught: float
    growth: Sequence[float]
    momentum: bool = False

    def shallow(self, flow: Flow) -> Array:
        """Draught over the depth of water under the keel [-], held where there is less than 1.2 draughts of water."""
        return self.draught / (dr.maximum(flow.depth, SHALLOWEST * self.draught) - self.draught)

    def image_mass(self, flow: Flow) -> list[list[Array]]:
        """Added mass by the ground `(6, 6)`."""
        return self._diagonal(self.shallow(flow))

    def shoaling(self, flow: Flow) -> list[Array]:
        """Force and moment (6) of the depth's change on the way."""
        under = flow.depth - self.draught
        held = flow.depth < SHALLOWEST * self.draught
        steepness = dr.select(held, 0.0, -self.draught / dr.square(dr.select(held, self.draught, under)))
        return shoaling(self._diagonal(steepness), flow)

    def _diagonal(self, share: Array) -> list[list[Array]]:
        return [[mul(share, x) if row == column else 0.0 for column in range(6)] for row, x in enumerate(self.growth)]


def shoaling(mass_by_depth: Matrix, flow: Flow) -> list[Array]:
    """Force and moment (6) where the depth changes on the way, of added mass with the slope dM_A/dh `(6, 6)`."""
    gradient = flow.depth_gradient
    return shoaling_wrench(mass_by_depth, flow.nu_c, gradient, dot(gradient, flow.nu[:3]))


@jit.struct
class Walls:
    """Planes beside each vehicle that stand still, such as the ground below it and the nearest wall.

    Attributes:
        points: by plane `Array3f64`, on it, NED [m]; far away where there is none.
        normals: by plane `Array3f64`, unit, towards the vehicle, NED.
    """

    points: list[Array]
    normals: list[Array]


def planes_of(walls: Walls | None, position: Vector, rotation: Matrix) -> list[Plane]:
    """The planes as a vehicle at a position NED (3) [m] with a rotation `(3, 3)` FRD -> NED has them."""
    if walls is None:
        return []
    return [
        Plane(dot([*normal], add(position, minus([*point]))), matvec(transpose(rotation), [*normal]))
        for point, normal in zip(walls.points, walls.normals, strict=True)
    ]


def level_ground(position: Vector, depth: Array, reach: Array) -> Walls:
    """Level ground under each vehicle at a position NED (3) [m]; far where it is further than `reach` [m].

    `depth`: of the ground below z = 0 [m]. The same as rays find above it in a world that is flat.
    """
    gap = depth - position[2]
    gap = dr.select((gap >= 0) & (gap <= reach), gap, FAR_M)
    point = jit.Array3f64(position[0], position[1], position[2] + gap)
    return Walls([point], [jit.Array3f64(0.0, 0.0, -1.0)])

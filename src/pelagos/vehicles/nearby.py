"""Planes near a vehicle: ground and walls as a step is told of them."""

from __future__ import annotations

from pelagos import jit
from pelagos.hydro.algebra import Matrix, Vector, add, dot, matvec, minus, transpose
from pelagos.hydro.images import Plane
from pelagos.jit import Array


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

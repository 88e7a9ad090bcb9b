"""Rays of sensors and hulls, and their hits. Both are Dr.Jit structs: lanes are rays."""

from __future__ import annotations

from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


@jit.struct
class Rays:
    """Rays in the world frame NWU.

    Attributes:
        origin: `Array3f64`, world [m] (double, so that a large world keeps millimetres).
        direction: `Array3f`, unit vectors.
        max_range: `Float` [m].
        copy: `UInt32`, the row of the fleet axis that each ray belongs to; of several vehicles, the copy is
            this row modulo the copies.
        own: `UInt32`, row of the moving-body table that a ray passes through (its own hull), `NO_BODY` for none.
        drift: `Array3f`, how far bodies have moved since the moving scene was brought up to date, when the ray meets
            them [m]: for rays within one exposure. None where they stand where the scene has them.
    """

    origin: Array
    direction: Array
    max_range: Array
    copy: Array
    own: Array
    drift: Array | None = None


NO_BODY = 0xFFFFFFFF
_LEAST: Final = 1e-17  # of a direction's component that is not 0: coherent packets of Embree lose rays from 1e-18 down


def ray_of(start: Array, direction: Array, reach: Array) -> Any:
    """The `mi.Ray3f` from `start`, `Array3f` [m], in a direction, `Array3f`, as far as `reach`, `Float` [m].

    A component next to 0 becomes 0. Such are those of whatever has turned by a rounding from an axis of the world.
    """
    straight = jit.Array3f([dr.select(dr.abs(x) < _LEAST, 0.0, x) for x in direction])
    return jit.mi.Ray3f(start, straight, reach, 0.0, [])


@jit.struct
class Hits:
    """The nearest hit of each ray. Where `valid` is false, `t` is infinite and the rest is zero.

    Attributes:
        valid: `Bool`.
        t: `Float`, distance along the ray [m].
        position: `Array3f64`, world NWU [m].
        place: `Array3f`, the same for static surfaces; on a body, in the body's own frame, so that it moves along [m].
        normal: `Array3f`, unit geometric normal, turned towards the ray's origin.
        shading_normal: `Array3f`, interpolated over the surface where the mesh is smooth, else `normal`.
        label: `UInt32`, semantic label.
        instance: `UInt32`, instance id: 0 is nothing, static objects and bodies count from 1.
        material: `UInt32`, row of the material table.
        velocity: `Array3f`, world velocity of the surface point [m/s].
    """

    valid: Array
    t: Array
    position: Array
    place: Array
    normal: Array
    shading_normal: Array
    label: Array
    instance: Array
    material: Array
    velocity: Array


def no_hits() -> Hits:
    """A ray that has met nothing."""
    none, whole = jit.Array3f(0), jit.UInt32(0)
    return Hits(jit.Bool(False), jit.Float(dr.inf), jit.Array3f64(0), none, none, none, whole, whole, whole, none)

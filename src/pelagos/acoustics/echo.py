"""From hits to a sonar's signal: a ray is a patch of surface, a patch an echo spread over the bins that it spans.

A ray stands for a stratum of directions (`Strata`). The stratum cuts a strip out of the surface that was hit; its echo
energy is spread over the strip's span of ranges, so that neighbouring strata tile a smooth surface without gaps or
rings whatever the number of rays. Each range bin of a strip is a facet of its own, with its own roughness
(`speckle`) and its own two-way phase.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.quick import larger, smaller

_COARSE: Final = 5e-3  # [rad], stratum whose span a strip may be moved by half of, however thin its own is


@jit.struct
class Patches:
    """Strips of surface seen by rays, one lane a ray (pings by fans): a Dr.Jit struct.

    Attributes:
        valid: `Bool`.
        distance: `Float`, to the ray's hit [m].
        near, far: `Float`, the span of ranges of the strip [m].
        energy: `Float`, echo intensity of the whole strip before range losses' gain, in the sonar's unit.
        slide: `Array3f`, way along the surface per metre of range, in the world frame [1].
        direction: `Array3f`, ray direction, world frame.
        label, instance: `UInt32`.
        length, width: `Float`, of the strip along the surface, and of what it stands for square to that [m]; None: rays
            meet no facet of the roughness together.
    """

    valid: Array
    distance: Array
    near: Array
    far: Array
    energy: Array
    slide: Array
    direction: Array
    label: Array
    instance: Array
    length: Array | None = None
    width: Array | None = None


def strip_span(
    distance: Array, direction: Array, normal: Array, along: Array, aside: Array, lower: Array, upper: Array,
    longest: Array,
) -> tuple[Array, Array, Array]:  # fmt: skip
    """Range span [m] of the strip that a stratum cuts out of a plane, and how a point moves along it.

    The stratum reaches from angle `lower` (negative) to `upper` [rad] about the ray, towards the unit vector `along`.
    On a plane with unit normal n the range at angle a is t (n.d)/(n.(d cos a + u sin a)). Rays of one beam lie off its
    middle by `-aside`; strips longer than what this changes in range are moved to where they lie in the beam's middle,
    so that they tile.

    Returns:
        near [m], far [m], and `Array3f` slide [1]: displacement on the plane per metre of range.
    """
    facing = -dr.dot(normal, direction)
    tilt = -dr.dot(normal, along)
    flat = larger(facing, 1e-4)
    whole = flat * distance
    reach_low = whole / larger(_facing_at(lower, flat, tilt), 1e-4 * flat)
    reach_up = whole / larger(_facing_at(upper, flat, tilt), 1e-4 * flat)
    near = larger(smaller(reach_low, reach_up), distance - longest)
    far = smaller(larger(reach_low, reach_up), distance + longest)
    middle = whole / larger(flat - dr.dot(normal, aside), 1e-4 * flat) - distance
    limit = 0.5 * (far - near) * larger(_COARSE / (upper - lower), 1.0)
    shift = larger(smaller(middle, limit), -limit)
    slope = dr.select(dr.abs(tilt) > 0.02, facing / dr.select(tilt == 0.0, 1.0, tilt), 0.0)
    return near + shift, far + shift, direction - along * slope


def _facing_at(angle: Array, flat: Array, tilt: Array) -> Array:
    """flat cos + tilt sin of a small angle [rad]: within 1e-6 up to 0.3, wider than any stratum."""
    square = angle * angle
    cosine = dr.fma(square, dr.fma(square, 1.0 / 24.0, -0.5), 1.0)
    sine = angle * dr.fma(square, dr.fma(square, 1.0 / 120.0, -1.0 / 6.0), 1.0)
    return dr.fma(flat, cosine, tilt * sine)


def widened(
    near: Array, far: Array, distance: Array, direction: Array, normal: Array, along: Array, half: Array, longest: Array
) -> tuple[Array, Array]:
    """`strip_span` of a stratum that also reaches `half` [rad] to both sides, square to `along`: near, far [m]."""
    facing = larger(-dr.dot(normal, direction), 1e-4)
    lean = dr.abs(dr.dot(normal, dr.cross(direction, along)))
    reach = smaller(distance * half * lean / facing, longest)
    return near - reach, far + reach

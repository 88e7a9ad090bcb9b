"""Weight and buoyancy, FRD; wrenches act on the body (minus g of the equation of motion)."""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector, add, cross, dot, matvec, minus, mul, neg, scaled, total
from pelagos.jit import Array

_LINEAR: Final = math.radians(15)
_BEND: Final = math.radians(20)
_VANISHING: Final = _LINEAR + _BEND * (math.pi + math.asin(_LINEAR / _BEND))


def submerged(
    weight: Array, buoyancy: Array, center_of_gravity: Vector, center_of_buoyancy: Vector, down: Vector
) -> list[Array]:
    """Wrench (6) of weight and buoyancy of a fully wet body: F21 Section 4.1.

    Args:
        weight, buoyancy: W, B [N].
        center_of_gravity, center_of_buoyancy: r_g, r_b (3) [m].
        down: unit vector towards the centre of the earth, in body axes (3).
    """
    arm = add(scaled(weight, center_of_gravity), scaled(neg(buoyancy), center_of_buoyancy))
    return [*scaled(total(weight, neg(buoyancy)), down), *cross(arm, down)]


def emerged_ellipsoid(
    buoyancy: Array, semi_axes: Vector, center: Vector, down: Vector, immersion: Array
) -> list[Array]:
    """Wrench (6) that a fully wet ellipsoid loses where it stands out of the water; exact at any attitude.

    An ellipsoid is an affine image of a sphere, and so is its wet part: with z = depth of the centre over the
    vertical half extent, the wet share of a sphere is (2 + 3 z - z^3)/4 and its first moment 3 (1 - z^2)^2/16
    (volume and centroid of a spherical segment).

    Args:
        buoyancy: of the whole body [N].
        semi_axes: (3) [m].
        center: of the ellipsoid, and of buoyancy when fully wet (3) [m].
        down: unit vector towards the centre of the earth, in body axes (3).
        immersion: depth of the body's origin below the surface [m].
    """
    stretched = [mul(a, d) for a, d in zip(semi_axes, down, strict=True)]
    inverse = dr.rcp(dr.sqrt(dot(stretched, stretched)))
    z = dr.clip(total(immersion, dot(center, down)) * inverse, -1.0, 1.0)
    lost = buoyancy * (0.5 + z * (0.25 * z * z - 0.75))
    lever = -buoyancy * (3.0 / 16.0) * ((1 - z * z) * (1 - z * z)) * inverse
    offset = [mul(a, s) for a, s in zip(semi_axes, stretched, strict=True)]
    return add([lost * d for d in down] + [0.0] * 3, [0.0] * 3 + cross(center, scaled(lost, down)),
               [0.0] * 3 + scaled(lever, cross(offset, down)))  # fmt: skip


def hydrostatic(stiffness: Matrix, heave: Array, roll: Array, pitch: Array) -> list[Array]:
    """-G eta (6) of a floating body near its equilibrium: F21 Section 4.2.

    `stiffness`: G `(6, 6)` about CO [N/m, N, N m]; heave: how far CO is below its equilibrium [m]; angles [rad].
    """
    return minus(matvec(stiffness, [0.0, 0.0, heave, roll, pitch, 0.0]))


def righting_angle(angle: Array) -> Array:
    """The angle that a linear righting moment is taken at [rad]: itself up to 15 degrees, so that beyond the moment is
    largest at 47 and gone at 96 degrees, and negative up to 180, where a capsized hull lies still.

    A usual shape of the righting lever's curve, for hulls whose geometry is not given (assumed).
    """
    size = dr.abs(angle)
    rising = _LINEAR + _BEND * dr.sin((size - _LINEAR) * (1 / _BEND))
    capsized = -_LINEAR * dr.sin((size - _VANISHING) * (math.pi / (math.pi - _VANISHING)))
    bent = dr.select(size < _VANISHING, rising, capsized)
    return dr.select(size < _LINEAR, angle, dr.mulsign(bent, angle))


def weight_at(weight: Array, point: Vector, down: Vector) -> list[Array]:
    """Wrench (6) of a weight [N] (or, if negative, a float) at `point` (3) [m]."""
    return add([mul(weight, d) for d in down] + [0.0] * 3, [0.0] * 3 + cross(point, scaled(weight, down)))

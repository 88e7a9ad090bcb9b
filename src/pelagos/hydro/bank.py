"""A ship beside an upright wall, in ideal fluid under a lid: added mass and forces of surge, sway, yaw, FRD, about CO.

At low Froude numbers the hull and its mirror image above the waterline are one body under a lid (the double body), of
twice the hull's masses, of whose energy half is in the water. It is the row of dipoles of `hydro/images.py`; the wall
reflects it, and level ground below reflects what moves horizontally without end: the image in the wall stands once more
at every 2 h of height and depth. In little water that is several times the suction of the first image alone. One energy
gives the added mass, suction, cushion and the moment (H. Lamb, "Hydrodynamics", 6th ed., Cambridge 1932, Sections 136,
137), as in `hydro/images.py`, which has the same of any plane and motion; here a matrix of three costs a tenth of that.
Limits: the strength of the dipoles is that of deep water without a wall, so that cushions close to a quay are too
small; no waves (U^2 << g h), no viscosity, and no lift: the moment that turns the bow away from banks is not in it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector, add, dot, matvec, minus, scaled
from pelagos.hydro.images import Dipoles, spheroid_dipoles
from pelagos.jit import Array

_FINENESS: Final = 1.6  # dipoles by half the way between the foci over half the beam
_COLUMN: Final = ((0.0, 1.0), (1.133, 3.005), (3.987, 10.06), (15.47, 49.0))
"""Height over 2 h, and number, of images that stand for those at every 2 h: the flow of dipoles from 0.3 to 28 h away
to 1.4 % (fitted to the sums over (a^2 + k^2)^(-3/2) and (a^2 + k^2)^(-5/2))."""
_PART: Final = 1e-4
"""Differences in distance, over it, and in heading [rad]: truncated to 1e-8, rounded to 1e-11."""


@dataclass(frozen=True)
class Wall:
    """distance: of CO, horizontally [m]; normal: unit, from the wall to the ship, body axes (2); depth: of the water
    [m].
    """

    distance: Array
    normal: Vector
    depth: Array


def floating_dipoles(
    length: float, beam: float, draught: float, ahead: float, added: Sequence[float], displaced: float, density: float
) -> Dipoles:
    """The dipoles of a hull's double body, for its horizontal motions, with half its energy.

    Args:
        length, beam, draught: of the hull [m].
        ahead: place of its middle, from CO [m].
        added: m_a of surge and sway (2) [kg].
        displaced: m_w [kg].
        density: of the water [kg/m^3].
    """
    half = [length / 2, beam / 2, draught]
    focus = math.sqrt(max(half[0] ** 2 - half[1] * half[2], 0.0))
    count = max(3, math.ceil(_FINENESS * focus / half[1]))
    masses = [2 * added[0], 2 * added[1], 0.0]
    double = spheroid_dipoles(half, [ahead, 0.0, 0.0], masses, 2 * displaced, density, count=count)
    return replace(double, density=2 * density)  # energies go by strength^2/density


def bank_added_mass(hull: Dipoles, wall: Wall) -> list[list[Array]]:
    """Added mass of surge, sway and yaw `(3, 3)` beyond that in open water [kg, kg m, kg m^2]."""
    return _mass(hull, _clear(hull, wall)[0], wall.normal, wall.depth)


def bank_wrench(hull: Dipoles, wall: Wall, nu: Vector, over_ground: Vector) -> list[Array]:
    """Force along and across and moment (3) beside those of the added mass and its Coriolis forces [N], [N m].

    dT/dq of the energy, less dM/dt nu; a wall that the hull touches pulls as one that it nearly touches.

    Args:
        hull: the dipoles.
        wall: where it is.
        nu: velocity relative to the water: surge, sway, yaw (3).
        over_ground: velocity relative to the wall (3).
    """
    distance, free = _clear(hull, wall)
    x, y = wall.normal
    apart = _PART * distance
    by_distance = _slope([_mass(hull, distance + s * apart, [x, y], wall.depth) for s in (1.0, -1.0)], apart)
    turned = []
    for s in (_PART, -_PART):
        there = [math.cos(s) * x + math.sin(s) * y, math.cos(s) * y - math.sin(s) * x]  # in the body that turned by s
        turned.append(_mass(hull, distance + hull.center[0] * (there[0] - x), there, wall.depth))
    by_heading = _slope(turned, _PART)
    nearer, turning = matvec(by_distance, nu), matvec(by_heading, nu)
    pull = 0.5 * dot(nu, nearer)
    closing = dr.select(free, dot(wall.normal, over_ground[:2]), 0.0)
    change = add(scaled(closing, nearer), scaled(dr.select(free, over_ground[2], 0.0), turning))
    return add([pull * x, pull * y, 0.5 * dot(nu, turning)], minus(change))


def _clear(hull: Dipoles, wall: Wall) -> tuple[Array, Array]:
    """Distance of the hull's middle, at least that at which it touches the wall, or dipoles count [m]; whether it is
    further.
    """
    x, y = wall.normal
    reach = dr.sqrt(dr.square(hull.semi_axes[0] * x) + dr.square(hull.semi_axes[1] * y))
    distance, least = wall.distance + hull.center[0] * x, dr.maximum(reach, hull.nearest)
    return dr.maximum(distance, least), distance > least


def _mass(hull: Dipoles, distance: Array, normal: Vector, depth: Array) -> list[list[Array]]:
    """Added mass `(3, 3)` at a distance of the middle [m].

    Of two dipoles p and q, the second in the wall as q' = q - 2 (q.n) n, R away:
    -(3 (p.R)(q'.R)/R^5 - p.q'/R^3)/(4 pi rho).
    """
    x, y = normal
    heights = [dr.square(2 * k * depth) if k else 0.0 for k, _ in _COLUMN]
    xx = xy = yy = xr = yr = rr = 0.0
    for i, (xi, si) in enumerate(zip(hull.places, hull.shares, strict=True)):
        for j, (xj, sj) in enumerate(zip(hull.places[: i + 1], hull.shares, strict=False)):
            ai, aj = hull.center[0] + xi, hull.center[0] + xj
            off = 2 * (xj * x + distance)
            across, ahead = off * y, (xi - xj) + off * x
            height = (xi - xj) * x + off
            ahead_image, across_image = ahead - 2 * height * x, across - 2 * height * y
            square = dr.square(ahead) + dr.square(across)
            third = fifth = 0.0
            for up, (_, number) in zip(heights, _COLUMN, strict=True):
                inverse = dr.rsqrt(square + up)
                second = dr.square(inverse)
                part = number * inverse * second
                third, fifth = third + part, fifth + part * second
            pairs = (1.0 if i == j else 2.0) * si * sj / (4 * math.pi * hull.density)
            fifth = fifth * 3
            along = third * (1 - 2 * x * x) - fifth * ahead * ahead_image
            aside = third * (1 - 2 * y * y) - fifth * across * across_image
            both = -2 * third * x * y
            ahead_aside, aside_ahead = both - fifth * ahead * across_image, both - fifth * across * ahead_image
            xx, yy = xx + pairs * along, yy + pairs * aside
            xy = xy + 0.5 * pairs * (ahead_aside + aside_ahead)
            xr = xr + (0.5 * pairs) * (aj * ahead_aside + ai * aside_ahead)
            yr, rr = yr + (0.5 * pairs * (ai + aj)) * aside, rr + (pairs * ai * aj) * aside
    a, b = hull.strength[:2]
    return [
        [a * a * xx, a * b * xy, a * b * xr],
        [a * b * xy, b * b * yy, b * b * yr],
        [a * b * xr, b * b * yr, b * b * rr],
    ]


def _slope(ends: Sequence[Matrix], half: Array) -> list[list[Array]]:
    """Slope of a matrix from its values on both sides, `half` the way between them."""
    after, before = ends
    return [scaled(0.5 / half, add(a, minus(b))) for a, b in zip(after, before, strict=True)]

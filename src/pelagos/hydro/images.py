"""A body near a plane: added mass and forces by the image of its dipoles, ideal fluid. FRD, about CO.

To a fluid a moving spheroid is a row of dipoles between its foci, with the density 1 - t^2 along them (A. T. Chwang,
T. Y. Wu, J. Fluid Mech. 63(3):607, 1974, doi 10.1017/S0022112074001819), of the total strength (m_a + m_w) U/rho with
its added mass m_a and the mass m_w of the water displaced. A plane reflects them: a rigid one, the bottom, a wall, or
the surface at low Froude numbers (g d >> U^2), turns the part along its normal round; the surface at high ones
(g d << U^2) turns the part along the plane round instead. The energy of the dipoles in the flow of their images is the
first term of a series by (size/distance)^3: that of a sphere is Lamb's, T/T_0 = 1 + 3/8 (a/d)^3 across and
1 + 3/16 (a/d)^3 along the plane (H. Lamb, "Hydrodynamics", 6th ed., Cambridge 1932, Sections 99 and 138). In turning,
each dipole has the velocity of its place (slender bodies). A sphere that touches the plane has 0.69 and 0.59 of its
displaced mass by this, exactly 0.80 and 0.62: forces within a diameter are too small. A plane nearer than 1.5 radii of
a slender body acts as at that distance. Forces follow from the energy (Lamb, Sections 136, 137).
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector, add, cross, dot, matmul, matvec, minus, scaled, total, transpose
from pelagos.jit import Array

_FINENESS: Final = 1.6  # dipoles by half the way between the foci over the radius
_NEAREST: Final = (
    1.2  # spacings: there a row of dipoles pulls by 9 % more than a continuous one (tests), nearer by more
)


@dataclass(frozen=True)
class Dipoles:
    """A row of dipoles that stands for a body.

    Attributes:
        places: from the middle along x [m].
        shares: of the whole, their sum is 1.
        center: the middle, from CO (3) [m].
        strength: m_a + m_w of each axis (3) [kg].
        density: of the water [kg/m^3].
        semi_axes: of the body (3) [m]: no plane comes nearer than its surface.
        nearest: distance from which on the row stands for a continuous one [m].
    """

    places: Sequence[float]
    shares: Sequence[float]
    center: Vector
    strength: Vector
    density: float
    semi_axes: Sequence[float]
    nearest: float


@dataclass(frozen=True)
class Plane:
    """distance: of CO [m]; normal: unit, from the plane to the body, body axes (3); sign: 1 rigid, -1 the surface at
    high Froude numbers.
    """

    distance: Array
    normal: Vector
    sign: float = 1.0


def spheroid_dipoles(
    semi_axes: Sequence[float],
    center: Vector,
    added: Vector,
    displaced: float,
    density: float,
    *,
    count: int | None = None,
) -> Dipoles:
    """The dipoles of a spheroid, or of a body that is nearly one; its foci on x where that is its longest axis.

    Args:
        semi_axes: (3) [m].
        center: from CO (3) [m].
        added: m_a of each axis (3) [kg].
        displaced: m_w [kg].
        density: of the water [kg/m^3].
        count: number of dipoles; None: as many as a plane 1.5 radii away takes.
    """
    from scipy.special import roots_jacobi  # a sixth of the time that all imports take

    focus = math.sqrt(max(semi_axes[0] ** 2 - semi_axes[1] * semi_axes[2], 0.0))
    if count is None:
        count = 1 if focus == 0 else max(3, math.ceil(_FINENESS * focus / min(semi_axes[1:])))
    nodes, weights = roots_jacobi(count, 1.0, 1.0)
    return Dipoles(
        places=[focus * float(t) for t in nodes],
        shares=[0.75 * float(w) for w in weights],
        center=center,
        strength=[float(m) + displaced for m in added],
        density=density,
        semi_axes=semi_axes,
        nearest=_NEAREST * 2 * focus / count,
    )


def image_added_mass(body: Dipoles, plane: Plane) -> list[list[Array]]:
    """Added mass `(6, 6)` beyond that in unbounded water [kg, kg m, kg m^2]."""
    n, d = plane.normal, _clear(body, plane)
    sums = [[[0.0] * 3 for _ in range(3)] for _ in range(3)]  # by moment of the places: 1, x_j, x_i x_j
    for i, (xi, si) in enumerate(zip(body.places, body.shares, strict=True)):
        for j, (xj, sj) in enumerate(zip(body.places, body.shares, strict=True)):
            if j < i:
                continue  # the pair the other way round is the transpose
            pair = _pair(plane.sign, si * sj, _between(xi, xj, n, d), n, body.density)
            both = pair if i == j else [add(a, b) for a, b in zip(pair, transpose(pair), strict=True)]
            first = scaled_matrix(xj, pair)
            if i != j:
                first = [add(a, b) for a, b in zip(first, scaled_matrix(xi, transpose(pair)), strict=True)]
            for k, part in enumerate((both, first, scaled_matrix(xi * xj, both))):
                sums[k] = [add(a, b) for a, b in zip(sums[k], part, strict=True)]
    arm = _skew_transposed(body.center)
    along = _skew_transposed([1.0, 0.0, 0.0])
    b0 = [[body.strength[r] if r == c else 0.0 for c in range(3)] + scaled(body.strength[r], arm[r]) for r in range(3)]
    b1 = [[0.0] * 3 + scaled(body.strength[r], along[r]) for r in range(3)]
    parts = [
        matmul(transpose(b0), matmul(sums[0], b0)),
        matmul(transpose(b0), matmul(sums[1], b1)),
        matmul(transpose(b1), matmul(transpose(sums[1]), b0)),
        matmul(transpose(b1), matmul(sums[2], b1)),
    ]
    return [add(*rows) for rows in zip(*parts, strict=True)]


def image_energy_gradient(body: Dipoles, plane: Plane, nu: Vector) -> tuple[Array, list[Array]]:
    """Slope of the energy by the distance [N], and by the plane's normal (3) [N m], at a velocity nu (6)."""
    n, d = plane.normal, _clear(body, plane)
    places = [[x, 0.0, 0.0] for x in body.places]
    dipoles = [
        [k * (v + t) for k, v, t in zip(body.strength, nu[:3], cross(nu[3:], add(body.center, r)), strict=True)]
        for r in places
    ]
    slope: Array = 0.0
    turned: list[Array] = [0.0] * 3
    for i, (p, xi, si) in enumerate(zip(dipoles, body.places, body.shares, strict=True)):
        for j in range(i + 1):  # the pair the other way round has the same energy
            q, r, xj, sj = dipoles[j], places[j], body.places[j], body.shares[j]
            away, along = _between(xi, xj, n, d), dot(n, q)
            image = [plane.sign * (a - 2 * along * b) for a, b in zip(q, n, strict=True)]
            by_away, by_image = _field_slopes(away, p, image)
            factor = -(0.5 if i == j else 1.0) * si * sj / (4 * math.pi * body.density)
            across = dot(n, by_away)
            slope = slope + 2 * factor * across
            height = total(dot(n, r), d)
            part = add(
                scaled(2 * across, r), scaled(2 * height, by_away),
                scaled(-2 * plane.sign * dot(n, by_image), q), scaled(-2 * plane.sign * along, by_image),
            )  # fmt: skip
            turned = add(turned, scaled(factor, part))
    return slope, add(turned, scaled(slope, body.center))


def image_wrench(body: Dipoles, plane: Plane, nu: Vector, over_ground: Vector, moment: Array) -> list[Array]:
    """Force and moment (6) beside those of the added mass and its Coriolis forces [N], [N m].

    dT/dq of the energy, less dM/dt nu, a difference over a `moment` [s] before and after.

    Args:
        body: the dipoles.
        plane: where it is.
        nu: velocity relative to the water (6).
        over_ground: velocity relative to the plane (6).
        moment: short beside the time in which the distance changes [s].
    """
    slope, turned = image_energy_gradient(body, plane, nu)
    v, w = over_ground[:3], over_ground[3:]
    turning, closing = cross(plane.normal, w), dot(plane.normal, v)
    after, before = (
        matvec(image_added_mass(body, Plane(total(plane.distance, s * closing), add(plane.normal, scaled(s, turning)),
                                            plane.sign)), nu)
        for s in (moment, -1.0 * moment)
    )  # fmt: skip
    change = scaled(0.5 / moment, add(after, minus(before)))
    return add([*scaled(slope, plane.normal), *cross(turned, plane.normal)], minus(change))


def scaled_matrix(factor: Array, matrix: Matrix) -> list[list[Array]]:
    """A matrix times a number."""
    return [scaled(factor, row) for row in matrix]


def _clear(body: Dipoles, plane: Plane) -> Array:
    """Distance of the body's middle, at least that at which its surface touches the plane, or dipoles count [m]."""
    reach = dr.sqrt(total(*(dr.square(a * b) for a, b in zip(body.semi_axes, plane.normal, strict=True))))
    return dr.maximum(total(plane.distance, dot(body.center, plane.normal)), dr.maximum(reach, body.nearest))


def _between(xi: float, xj: float, n: Vector, d: Array) -> list[Array]:
    """From the image of the place xj to the place xi (3) [m]."""
    twice = 2 * (xj * n[0] + d)
    return [total(xi - xj if k == 0 else 0.0, twice * n[k]) for k in range(3)]


def _pair(sign: float, share: float, away: Vector, n: Vector, density: float) -> list[list[Array]]:
    """Matrix of a dipole's energy in the flow of another's image."""
    inverse = dr.rsqrt(dot(away, away))
    unit = scaled(inverse, away)
    strength = -sign * share / (4 * math.pi * density) * inverse * inverse * inverse
    along = dot(unit, n)
    return [
        [
            strength * (3 * unit[r] * (unit[c] - 2 * along * n[c]) - (1.0 if r == c else 0.0) + 2 * n[r] * n[c])
            for c in range(3)
        ]
        for r in range(3)
    ]


def _field_slopes(away: Vector, p: Vector, q: Vector) -> tuple[list[Array], list[Array]]:
    """Slopes of 3 (p.R)(q.R)/R^5 - p.q/R^3 by R and by q."""
    square = dr.rcp(dot(away, away))
    fifth = square * square * dr.sqrt(square)
    third = square * dr.sqrt(square)
    pr, qr, pq = dot(p, away), dot(q, away), dot(p, q)
    by_away = add(
        scaled(3 * fifth * qr, p), scaled(3 * fifth * pr, q), scaled(3 * fifth * (pq - 5 * square * pr * qr), away)
    )
    return by_away, add(scaled(3 * fifth * pr, away), scaled(-1.0 * third, p))


def _skew_transposed(r: Vector) -> list[list[Array]]:
    x, y, z = r
    return [[0.0, z, -y], [-z, 0.0, x], [y, -x, 0.0]]

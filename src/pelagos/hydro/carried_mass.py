"""Mass matrices of bodies whose mass and place change in a run: entries are numbers or arrays. FRD, about CO.

Source: F21 Section 3.3 (see `hydro.rigid_body`, whose matrices of constants these are with `hydro.algebra`).
"""

from __future__ import annotations

from pelagos.hydro.algebra import Matrix, Vector, add, dot, matmul, minus, mul, neg, scaled, total
from pelagos.jit import Array


def skew(a: Vector) -> list[list[Array]]:
    """S(a) `(3, 3)` with S(a) b = a x b."""
    x, y, z = a
    return [[0.0, neg(z), y], [z, 0.0, neg(x)], [neg(y), x, 0.0]]


def mass_matrix(mass: Array, inertia: Matrix, center: Vector) -> list[list[Array]]:
    """M `(6, 6)` about CO [kg, kg m, kg m^2].

    Args:
        mass: m [kg].
        inertia: `(3, 3)` about the body's own centre [kg m^2].
        center: r from CO (3) [m].
    """
    shifted = [scaled(mass, row) for row in skew(center)]  # m S(r)
    square = dot(center, center)
    moved = [
        [total(inertia[i][j], mul(mass, total(square if i == j else 0.0, neg(mul(center[i], center[j])))))
         for j in range(3)]
        for i in range(3)
    ]  # fmt: skip
    top = [[mass if i == j else 0.0 for j in range(3)] + minus(shifted[i]) for i in range(3)]
    return top + [shifted[i] + moved[i] for i in range(3)]


def about_center(matrix: Matrix) -> tuple[Array, list[list[Array]], list[Array]]:
    """Mass, inertia `(3, 3)` about the centre of gravity, and r_g (3), of a rigid body's M `(6, 6)` about CO."""
    mass = matrix[0][0]
    center = [mul(1.0 / mass, entry) for entry in (matrix[5][1], matrix[3][2], matrix[4][0])]
    s = skew(center)
    inside = [add(row[3:], scaled(mass, turned)) for row, turned in zip(matrix[3:], matmul(s, s), strict=True)]
    return mass, inside, center

"""Coriolis and centripetal forces, FRD. Power-free: nu . C(nu) nu = 0."""

from __future__ import annotations

from collections.abc import Collection

from pelagos.hydro.algebra import Matrix, Vector, add, cross, matmul, matvec, mul, neg, transpose
from pelagos.jit import Array


def coriolis_matrix(mass: Matrix, nu: Vector, without: Collection[tuple[int, int]] = ()) -> list[list[Array]]:
    """C(M, nu) `(6, 6)` of a symmetric M, from the momentum p = M nu: F21 Theorem 3.2.

    `without`: entries (row, column), counted from 0, that a published model leaves out.
    """
    p = matvec(mass, nu)
    c: list[list[Array]] = [[0.0] * 6 for _ in range(6)]
    for row, column, i in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        for top, left, entry in ((0, 3, p[i]), (3, 0, p[i]), (3, 3, p[3 + i])):
            c[top + row][left + column] = entry
            c[top + column][left + row] = neg(entry)
    for row, column in without:
        c[row][column] = 0.0
    return c


def coriolis_force(mass: Matrix, nu: Vector, without: Collection[tuple[int, int]] = ()) -> list[Array]:
    """C(M, nu) nu (6) [N, N m], on the left of the equation of motion."""
    if without:
        return matvec(coriolis_matrix(mass, nu, without), nu)
    p = matvec(mass, nu)
    v, w = nu[:3], nu[3:]
    return [*cross(w, p[:3]), *add(cross(v, p[:3]), cross(w, p[3:]))]


def coriolis_force_angular(mass: Array, inertia: Matrix, shift: Matrix, nu: Vector) -> list[Array]:
    """H^T blkdiag(m S(w), -S(I w)) H nu (6): the form that does not contain the linear velocity, F21 Section 3.3.

    Args:
        mass: m [kg].
        inertia: `(3, 3)` about the centre of gravity [kg m^2].
        shift: H(r_g) `(6, 6)`.
        nu: velocity (6) FRD [m/s], [rad/s].
    """
    return matvec(coriolis_matrix_angular(mass, inertia, shift, nu), nu)


def coriolis_matrix_angular(mass: Array, inertia: Matrix, shift: Matrix, nu: Vector) -> list[list[Array]]:
    """The `(6, 6)` matrix of `coriolis_force_angular`."""
    w = nu[3:]
    momentum = matvec(inertia, w)
    middle: list[list[Array]] = [[0.0] * 6 for _ in range(6)]
    for row, column, i in ((0, 1, 2), (1, 2, 0), (2, 0, 1)):
        for corner, entry in ((0, neg(mul(mass, w[i]))), (3, momentum[i])):
            middle[corner + row][corner + column] = entry
            middle[corner + column][corner + row] = neg(entry)
    return matmul(transpose(shift), matmul(middle, shift))

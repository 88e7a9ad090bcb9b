"""Vectors of 3 and 6 and small matrices as Python lists, so that zeros that are known while tracing cost nothing.

An entry is a Python number (part of the program, folded into it) or a Dr.Jit array (data, which may carry gradients).
A product with the number 0 is the number 0, and a sum skips it: a matrix with eight entries costs eight products.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeAlias

import drjit as dr

from pelagos.jit import Array

Vector: TypeAlias = Sequence[Array]
Matrix: TypeAlias = Sequence[Sequence[Array]]


def is_zero(a: Array) -> bool:
    """Whether `a` is the number 0, known while tracing."""
    return isinstance(a, (int, float)) and a == 0


def mul(a: Array, b: Array) -> Array:
    """a b."""
    if is_zero(a) or is_zero(b):
        return 0.0
    if isinstance(a, (int, float)) and a == 1:
        return b
    if isinstance(b, (int, float)) and b == 1:
        return a
    return a * b


def total(*terms: Array) -> Array:
    """The sum, from left to right."""
    result: Array = 0.0
    for term in terms:
        if not is_zero(term):
            result = term if is_zero(result) else result + term
    return result


def neg(a: Array) -> Array:
    """-a."""
    return 0.0 if is_zero(a) else -a


def fma(a: Array, b: Array, c: Array) -> Array:
    """a b + c, in one operation where it is one."""
    product_is_simple = is_zero(c) or any(isinstance(x, (int, float)) and x in (0, 1) for x in (a, b))
    if product_is_simple or (isinstance(a, (int, float)) and isinstance(b, (int, float))):
        return total(c, mul(a, b))
    return dr.fma(a, b, c)


def dot(a: Vector, b: Vector) -> Array:
    """Sum of the products of two vectors."""
    result: Array = 0.0
    for x, y in zip(a, b, strict=True):
        result = fma(x, y, result)
    return result


def matvec(m: Matrix, x: Vector) -> list[Array]:
    """M x."""
    return [dot(row, x) for row in m]


def matmul(a: Matrix, b: Matrix) -> list[list[Array]]:
    """A B."""
    columns = list(zip(*b, strict=True))
    return [[dot(row, column) for column in columns] for row in a]


def transpose(m: Matrix) -> list[list[Array]]:
    """The transpose."""
    return [list(column) for column in zip(*m, strict=True)]


def add(*vectors: Vector) -> list[Array]:
    """The sum of vectors."""
    return [total(*entries) for entries in zip(*vectors, strict=True)]


def minus(a: Vector) -> list[Array]:
    """-a."""
    return [neg(x) for x in a]


def scaled(s: Array, a: Vector) -> list[Array]:
    """s a."""
    return [mul(s, x) for x in a]


def cross(a: Vector, b: Vector) -> list[Array]:
    """a x b, three components."""
    return [fma(a[j], b[k], neg(mul(a[k], b[j]))) for j, k in ((1, 2), (2, 0), (0, 1))]


def solve_symmetric(m: Matrix, b: Vector) -> list[Array]:
    """x of M x = b for a symmetric positive definite M, by an unrolled L D L^T factorisation.

    For matrices with array entries (gradients by mass); a matrix of numbers is inverted once on the host instead.
    """
    n = len(b)
    lower: list[list[Array]] = [[0.0] * n for _ in range(n)]
    diagonal: list[Array] = [0.0] * n
    for j in range(n):
        diagonal[j] = total(m[j][j], *(neg(mul(mul(lower[j][k], lower[j][k]), diagonal[k])) for k in range(j)))
        for i in range(j + 1, n):
            rest = total(m[i][j], *(neg(mul(mul(lower[i][k], lower[j][k]), diagonal[k])) for k in range(j)))
            lower[i][j] = mul(rest, 1.0 / diagonal[j])
    y: list[Array] = []
    for i in range(n):
        y.append(total(b[i], *(neg(mul(lower[i][k], y[k])) for k in range(i))))
    x = [mul(y[i], 1.0 / diagonal[i]) for i in range(n)]
    for i in reversed(range(n)):
        x[i] = total(x[i], *(neg(mul(lower[k][i], x[k])) for k in range(i + 1, n)))
    return x


def solve_blocks(m: Matrix, b: Vector) -> list[Array]:
    """x of M x = b for six equations, by elimination of the first three.

    For a matrix whose symmetric part is positive definite: no pivot can vanish. Where the first block is made of
    numbers it is inverted while tracing.
    """
    top, right = [row[:3] for row in m[:3]], [row[3:] for row in m[:3]]
    left, corner = [row[:3] for row in m[3:]], [row[3:] for row in m[3:]]
    inverse = inverse3(top)
    carried = matmul(left, inverse)
    schur = [add(row, minus(taken)) for row, taken in zip(corner, matmul(carried, right), strict=True)]
    y = matvec(inverse3(schur), add(b[3:], minus(matvec(carried, b[:3]))))
    return [*matvec(inverse, add(b[:3], minus(matvec(right, y)))), *y]


def inverse3(m: Matrix) -> list[list[Array]]:
    """Inverse of a `(3, 3)` matrix: its adjugate over its determinant."""
    columns = [cross(m[1], m[2]), cross(m[2], m[0]), cross(m[0], m[1])]
    scale = 1.0 / dot(m[0], columns[0])
    return transpose([scaled(scale, column) for column in columns])


def norm(a: Vector) -> Array:
    """The length of a vector; its gradient at 0 is 0, not NaN."""
    square = dot(a, a)
    if isinstance(square, (int, float)):
        return float(square) ** 0.5
    positive = square > 0
    return dr.select(positive, dr.sqrt(dr.select(positive, square, 1.0)), 0.0)


def inflow_angle(across: Array, ahead: Array) -> Array:
    """atan2(across, ahead) [rad]; at rest it and its gradient are 0, not NaN."""
    still = (across == 0) & (ahead == 0)
    return dr.atan2(across, dr.select(still, 1.0, ahead))

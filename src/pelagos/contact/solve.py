"""Small symmetric systems, solved lane by lane."""

from __future__ import annotations

from collections.abc import Sequence

from pelagos.jit import Array


def solve_symmetric(a: Sequence[Sequence[Array]], b: Sequence[Array]) -> list[Array]:
    """x of A x = b for symmetric positive definite A, by L D L^T without pivots.

    Args:
        a: rows of A; only the lower triangle, row i up to column i, is read.
        b: right-hand side.

    Source: G. H. Golub, C. F. Van Loan, "Matrix Computations", 4th ed. (2013), Algorithm 4.1.2.
    """
    size = len(b)
    lower: list[list[Array]] = [[0.0] * size for _ in range(size)]
    diagonal: list[Array] = []
    for j in range(size):
        d = a[j][j]
        for k in range(j):
            d = d - lower[j][k] * lower[j][k] * diagonal[k]
        diagonal.append(d)
        for i in range(j + 1, size):
            s = a[i][j]
            for k in range(j):
                s = s - lower[i][k] * lower[j][k] * diagonal[k]
            lower[i][j] = s / d
    y: list[Array] = []
    for i in range(size):
        s = b[i]
        for k in range(i):
            s = s - lower[i][k] * y[k]
        y.append(s)
    x: list[Array] = [v / d for v, d in zip(y, diagonal, strict=True)]
    for i in reversed(range(size)):
        for k in range(i + 1, size):
            x[i] = x[i] - lower[k][i] * x[k]
    return x

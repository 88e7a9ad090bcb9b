"""Complex numbers as pairs (real, imaginary) of whatever arrays they are made of: floats, single or double."""

from __future__ import annotations

from typing import TypeAlias

import drjit as dr

from pelagos.jit import Array

Pair: TypeAlias = tuple[Array, Array]


def times(a: Pair, b: Pair) -> Pair:
    """The product a b."""
    return a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]


def divide(a: Pair, b: Pair) -> Pair:
    """The quotient a/b."""
    scale = 1.0 / (b[0] * b[0] + b[1] * b[1])
    return (a[0] * b[0] + a[1] * b[1]) * scale, (a[1] * b[0] - a[0] * b[1]) * scale


def root(a: Pair) -> Pair:
    """The square root with a positive real part."""
    size = dr.sqrt(a[0] * a[0] + a[1] * a[1])
    real = dr.sqrt(dr.maximum(0.5 * (size + a[0]), 0.0))
    imaginary = dr.sqrt(dr.maximum(0.5 * (size - a[0]), 0.0))
    return real, dr.select(a[1] < 0.0, -imaginary, imaginary)


def squared(a: Pair) -> Array:
    """|a|^2."""
    return a[0] * a[0] + a[1] * a[1]

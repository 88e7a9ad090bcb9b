"""Functions of float32 arguments that are known to be ordinary: half the work of the general ones, or less.

The polynomials are minimax fits; their errors, below those of float32 arithmetic on the values they are used for, are
stated with each function and tested.
"""

from __future__ import annotations

from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array

_SQRT_HALF: Final = 0x3F3504F3  # bits of sqrt(1/2)
_LOG2: Final = (1.44269973, -0.72137587, 0.48046502, -0.35896190, 0.29726290, -0.27269752, 0.17063285)
_SINE: Final = (3.14158202, -5.16714280, 2.54189902, -0.55463618)
_COSINE: Final = (0.99999995, -4.93479286, 4.05841191, -1.33188016, 0.21969680)


def log2(x: Array) -> Array:
    """Base-2 logarithm of `Float` x, which must be positive, normal and finite; within 4e-7 plus half a last place."""
    bits = dr.reinterpret_array(jit.Int32, x)
    exponent = (bits - _SQRT_HALF) >> 23
    rest = dr.reinterpret_array(jit.Float, bits - (exponent << 23)) - 1.0
    return dr.fma(rest, _polynomial(rest, _LOG2), jit.Float(exponent))


def cosine_sine(turns: Array) -> tuple[Array, Array]:
    """Cosine and sine of 2 pi `turns`, `Float` within +-2^22; within 3e-6, besides what `turns` is rounded by."""
    half = turns - dr.round(turns)
    square = half * half
    sine, cosine = half * _polynomial(square, _SINE), _polynomial(square, _COSINE)
    double = sine + sine
    return dr.fma(-double, sine, 1.0), double * cosine


def larger(a: Array | float, b: Array | float) -> Array:
    """The larger of two numbers, neither NaN: one instruction, where `dr.maximum` takes three to six."""
    return dr.select(a > b, a, b)


def smaller(a: Array | float, b: Array | float) -> Array:
    """The smaller of two numbers, likewise."""
    return dr.select(a < b, a, b)


def _polynomial(x: Array, coefficients: tuple[float, ...]) -> Array:
    """Pairs of terms first, then pairs of pairs, and so on (G. Estrin 1960): few steps wait for each other.

    The constant coefficient comes first.
    """
    terms: list[Any] = [jit.Float(c) for c in coefficients]
    while len(terms) > 1:
        pairs = [dr.fma(high, x, low) for low, high in zip(terms[::2], terms[1::2], strict=False)]
        terms, x = pairs + terms[len(pairs) * 2 :], x * x
    return terms[0]

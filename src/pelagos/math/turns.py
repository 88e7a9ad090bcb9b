"""Sine and cosine of angles in turns, in double precision: cheaper than of radians, because reduction is a subtraction.

Taylor polynomials of sin(pi q) and cos(pi q) for |q| <= 1/2, then the double angle; the error is below 1e-13.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos.jit import Array

_SIN: Final = tuple((-1) ** n * math.pi ** (2 * n + 1) / math.factorial(2 * n + 1) for n in range(10))
_COS: Final = tuple((-1) ** n * math.pi ** (2 * n) / math.factorial(2 * n) for n in range(11))


def cos_turns(turns: Array) -> Array:
    """cos(2 pi turns), `Float64`."""
    q = turns - dr.round(turns)
    s = q * _polynomial(_SIN, q * q)
    return dr.fma(-2 * s, s, 1.0)


def sincos_turns(turns: Array) -> tuple[Array, Array]:
    """(sin, cos)(2 pi turns), `Float64`."""
    q = turns - dr.round(turns)
    s, c = q * _polynomial(_SIN, q * q), _polynomial(_COS, q * q)
    return 2 * s * c, dr.fma(-2 * s, s, 1.0)


def _polynomial(coefficients: tuple[float, ...], x: Array) -> Array:
    value = dr.fma(x, coefficients[-1], coefficients[-2])
    for c in coefficients[-3::-1]:
        value = dr.fma(value, x, c)
    return value

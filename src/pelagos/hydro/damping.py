"""Linear and quadratic damping, FRD; wrenches act on the body (they oppose the relative velocity)."""

from __future__ import annotations

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector, is_zero, matvec, minus, mul, neg, norm
from pelagos.jit import Array


def linear_damping(matrix: Matrix, nu_r: Vector) -> list[Array]:
    """-D nu_r (6) [N, N m]."""
    return minus(matvec(matrix, nu_r))


def quadratic_damping(coefficients: Vector, nu_r: Vector) -> list[Array]:
    """-d_i |nu_i| nu_i (6), diagonal, coefficients positive [kg/m, kg m^2]; F21 Section 6.4."""
    return [0.0 if is_zero(d) else neg(mul(d, dr.abs(x) * x)) for d, x in zip(coefficients, nu_r, strict=True)]


def low_speed_fade(decay: Array, nu_r: Vector) -> Array:
    """exp(-k U_r): how potential and skin-friction damping fade with speed; k [s/m]."""
    return dr.exp(-decay * norm(nu_r[:3]))

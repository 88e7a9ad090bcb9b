"""Advancing a vehicle by one step: attitude as a quaternion, semi-implicit Euler or Runge-Kutta 4.

Semi-implicit Euler takes the new velocity to move the body (order 1, a swinging body keeps its energy); Runge-Kutta 4
has order 4 while commands and currents are smooth in time. Sources: E. Hairer, C. Lubich, G. Wanner, "Geometric
Numerical Integration", 2nd ed., Springer 2006, Sections I.1 and II.1. Coriolis forces that do no work in a step are the
matter of `model.Inertia.accelerate_over`.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from pelagos.hydro.algebra import Matrix, Vector, matvec
from pelagos.jit import Array
from pelagos.math import so3


@dataclass
class Rigid:
    """Pose and velocity as components: position (3) NED [m], attitude FRD -> NED (4-array), nu (6)."""

    position: Vector
    attitude: Array
    nu: Vector


@dataclass
class Slope:
    """Rate of change of a `Rigid`: position (3) [m/s], attitude (4) [1/s], nu (6); as a function of state and time."""

    position: Vector
    attitude: Array
    nu: Vector


Accelerate = Callable[[Rigid, float], Vector]
"""State and fraction of the step passed (0, 1/2 or 1) -> nu_dot (6)."""


def semi_implicit(state: Rigid, accelerate: Accelerate, rotation: Matrix, h: Array) -> tuple[Rigid, Vector]:
    """One step of h [s], and the acceleration (6) in it; `rotation` `(3, 3)` is that of the attitude."""
    nu_dot = accelerate(state, 0.0)
    nu = [v + h * a for v, a in zip(state.nu, nu_dot, strict=True)]
    moved = matvec(rotation, nu[:3])
    position = [p + h * v for p, v in zip(state.position, moved, strict=True)]
    return Rigid(position, turned(state.attitude, nu[3:], h), nu), nu_dot


def turned(q: Array, rates: Vector, h: Array) -> Array:
    """q after turning with constant body rates [rad/s] for h [s].

    The exponential map as a series (to 1e-16 up to 0.2 rad a step, 3e-7 at 2 rad), then a Newton step to unit length.
    """
    half = 0.5 * h
    x, y, z = rates[0] * half, rates[1] * half, rates[2] * half
    s = x * x + y * y + z * z
    cos = 1 + s * (-1 / 2 + s * (1 / 24 + s * (-1 / 720 + s * (1 / 40320))))
    sinc = 1 + s * (-1 / 6 + s * (1 / 120 + s * (-1 / 5040 + s * (1 / 362880))))
    p = so3.multiply(q, type(q)(cos, sinc * x, sinc * y, sinc * z))
    return p * (1.5 - 0.5 * (p[0] * p[0] + p[1] * p[1] + p[2] * p[2] + p[3] * p[3]))


def runge_kutta(
    state: Rigid, accelerate: Accelerate, h: Array, rotate: Callable[[Array], Matrix]
) -> tuple[Rigid, Vector]:
    """One step of h [s], and the mean acceleration (6) in it; `rotate`: unit quaternion -> `(3, 3)`."""
    k1 = _slope(state, accelerate, 0.0, rotate)
    k2 = _slope(_along(state, k1, 0.5 * h), accelerate, 0.5, rotate)
    k3 = _slope(_along(state, k2, 0.5 * h), accelerate, 0.5, rotate)
    k4 = _slope(_along(state, k3, h), accelerate, 1.0, rotate)
    mean = Slope(
        [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(*(k.position for k in (k1, k2, k3, k4)), strict=True)],
        (k1.attitude + 2 * k2.attitude + 2 * k3.attitude + k4.attitude) / 6,
        [(a + 2 * b + 2 * c + d) / 6 for a, b, c, d in zip(*(k.nu for k in (k1, k2, k3, k4)), strict=True)],
    )
    return _along(state, mean, h), mean.nu


def _slope(state: Rigid, accelerate: Accelerate, fraction: float, rotate: Callable[[Array], Matrix]) -> Slope:
    q, w = state.attitude, state.nu[3:]
    spin = so3.multiply(q, type(q)(0.0, *w)) * 0.5
    return Slope(matvec(rotate(q), state.nu[:3]), spin, accelerate(state, fraction))


def _along(state: Rigid, slope: Slope, h: Array) -> Rigid:
    return Rigid(
        [p + h * v for p, v in zip(state.position, slope.position, strict=True)],
        so3.normalize(state.attitude + slope.attitude * h),
        [v + h * a for v, a in zip(state.nu, slope.nu, strict=True)],
    )

"""Thrust of a disc in axial flow by momentum theory, at the power that it takes at rest.

Sources: J. S. Carlton, "Marine Propellers and Propulsion", 4th ed., 2019, Chapter 8 (W. J. M. Rankine 1865, R. E.
Froude 1889): an open disc. J. D. van Manen, M. W. C. Oosterveld, "Analysis of ducted-propeller design", SNAME
Transactions 74, 1966: one in a straight duct, whose slipstream leaves with the disc's area, T = rho A Ve (Ve - V),
P = rho A Ve (Ve^2 - V^2)/2.

Assumptions: uniform loading, no swirl, no friction, constant power (a motor that is held at a current and a voltage).
Speeds are in units of v0 = sqrt(T0/(2 rho A)), the flow that an open disc of thrust T0 draws through itself at rest.
Valid for flow from ahead of the push. In flow from behind the thrust of rest is kept, within 15 % of J. G. Leishman,
"Principles of Helicopter Aerodynamics", 2nd ed., 2006, equation (2.96), down to -v0; in a faster one nothing
is known. A real propeller reaches zero thrust at a finite speed; a disc of constant power falls as P/V.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos.jit import Array

_LEAST: Final = 1e-9  # [N]: a thrust below this draws no flow
_TURNS: Final = 4  # Newton's, from 5 % below the root: exact to rounding


def flow_at_rest(thrust: Array, density: float, diameter: float) -> Array:
    """v0 = sqrt(|T0|/(2 rho A)) [m/s] of a thrust [N] at rest, diameter [m]."""
    area = math.pi / 4 * diameter**2
    return dr.sqrt(dr.maximum(dr.abs(thrust), _LEAST) * (0.5 / (density * area)))


def open_share(inflow: Array) -> Array:
    """T/T0 of an open disc, flow from ahead in units of v0.

    Root of t^3 + u t = 1, from T = 2 rho A (V + v) v and T (V + v) = T0 v0. Cardano's, without its cancellation.
    """
    u = dr.maximum(inflow, 0.0)
    a = dr.cbrt(0.5 + dr.sqrt(0.25 + u * u * u * (1 / 27)))
    b = u / (3 * a)
    return 1 / (a * a + a * b + b * b)


def open_inflow(share: float) -> float:
    """The flow [v0] that leaves an open disc this share of its thrust: u = 1/t - t^2."""
    return 1 / share - share**2


def duct_share(inflow: Array) -> Array:
    """T/T0 of a disc in a straight duct, duct included, flow from ahead in units of v0.

    With e = Ve/Ve0, s = V/Ve0, Ve0 = sqrt(T0/(rho A)): e^3 - s^2 e = 1, t = e (e - s) = 1/(e + s). Newton's method
    from (1 + s^3)^(1/3) has e exactly in 4 turns.
    """
    s = dr.maximum(inflow, 0.0) * math.sqrt(0.5)
    e = dr.cbrt(1 + s * s * s)
    for _ in range(_TURNS):
        e = e - (e * e * e - s * s * e - 1) / (3 * e * e - s * s)
    return 1 / (e + s)


def duct_inflow(share: float) -> float:
    """The flow [v0] that leaves a disc in a duct this share of its thrust: s = e - t/e, 2 t e^2 - e = t^2."""
    e = (1 + math.sqrt(1 + 8 * share**3)) / (4 * share)
    return math.sqrt(2) * (e - share / e)

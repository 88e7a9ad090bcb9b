"""Added mass of bodies with closed forms, ideal unbounded fluid. Host side: constants of a vehicle, computed once.

Source: H. Lamb, "Hydrodynamics", 6th ed., Cambridge 1932, Sections 92, 114, 115 and Section 68 (cylinder);
in Fossen's notation F21 Chapter 8. Frame: the body's own axes at its centre, x along the axis of revolution.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class LambFactors:
    """Added mass of a prolate spheroid over the mass (or inertia across the axis) of the fluid that it displaces.

    Attributes:
        axial: k1, motion along the axis.
        lateral: k2, motion across it.
        rotary: k', rotation about an axis across.
    """

    axial: float
    lateral: float
    rotary: float


def lamb_factors(a: float, b: float) -> LambFactors:
    """k1, k2, k' of a prolate spheroid, half length a, radius b [m], a >= b. The sphere is the limit 1/2, 1/2, 0.

    Below an eccentricity of 0.02 the closed form loses its digits, and the series of first order in e^2 is used.
    """
    e2 = 1.0 - (b / a) ** 2
    e = math.sqrt(e2)
    if e < 0.02:
        return LambFactors(0.5 - 0.3 * e2, 0.5 + 0.15 * e2, 0.0)
    if e == 1.0:  # a needle, thinner than 1e-8 of its length
        return LambFactors(0.0, 1.0, 1.0)
    log = math.log((1 + e) / (1 - e))
    alpha = 2 * (1 - e2) / e**3 * (log / 2 - e)
    beta = 1 / e2 - (1 - e2) / (2 * e**3) * log
    rotary = e2**2 * (beta - alpha) / ((2 - e2) * (2 * e2 - (2 - e2) * (beta - alpha)))
    return LambFactors(alpha / (2 - alpha), beta / (2 - beta), rotary)


def spheroid(density: float, a: float, b: float) -> NDArray[np.float64]:
    """M_A `(6, 6)` [kg, kg m^2] of a prolate spheroid; none about its axis."""
    k = lamb_factors(a, b)
    mass = density * 4.0 / 3.0 * math.pi * a * b * b
    inertia = mass * (a * a + b * b) / 5.0
    return np.diag([k.axial * mass, k.lateral * mass, k.lateral * mass, 0.0, k.rotary * inertia, k.rotary * inertia])


def sphere(density: float, radius: float) -> NDArray[np.float64]:
    """M_A `(6, 6)`: half the displaced mass in each direction, no added inertia. Lamb Section 92."""
    half = density * 2.0 / 3.0 * math.pi * radius**3
    return np.diag([half, half, half, 0.0, 0.0, 0.0])


def cylinder(density: float, radius: float, length: float) -> NDArray[np.float64]:
    """M_A `(6, 6)` of a slender cylinder along x by strip theory: rho pi r^2 a metre across, nothing along."""
    per_metre = density * math.pi * radius**2
    across, rotary = per_metre * length, per_metre * length**3 / 12.0
    return np.diag([0.0, across, across, 0.0, rotary, rotary])

"""Mass and inertia of a rigid body. Host side, NumPy float64: constants of a vehicle, computed once.

Frame FRD, origin CO. Source: T. I. Fossen, "Handbook of Marine Craft Hydrodynamics and Motion Control", 2nd ed.,
Wiley 2021 (below: F21), Section 3.3.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike, NDArray


def skew(a: ArrayLike) -> NDArray[np.float64]:
    """S(a) `(3, 3)` with S(a) b = a x b."""
    x, y, z = np.asarray(a, dtype=np.float64)
    return np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])


def transport(r: ArrayLike) -> NDArray[np.float64]:
    """H(r) `(6, 6)`: velocity at CO -> velocity at r [m]; M_CO = H^T M_r H. F21 Appendix C."""
    h = np.eye(6)
    h[:3, 3:] = skew(r).T
    return h


def moved(matrix: NDArray[np.float64], r: ArrayLike) -> NDArray[np.float64]:
    """A `(6, 6)` inertia, damping or stiffness given about the point r [m], about CO."""
    h = transport(r)
    return np.asarray(h.T @ matrix @ h)


def mass_matrix(mass: float, inertia: NDArray[np.float64], center_of_gravity: ArrayLike) -> NDArray[np.float64]:
    """M_RB `(6, 6)` about CO [kg, kg m, kg m^2], F21 Section 3.3; `inertia` `(3, 3)` about the centre of gravity."""
    about_cg = np.zeros((6, 6))
    about_cg[:3, :3] = mass * np.eye(3)
    about_cg[3:, 3:] = inertia
    return moved(about_cg, center_of_gravity)


def spheroid_volume(a: float, b: float) -> float:
    """Volume [m^3] of a spheroid with half length a and radius b [m]."""
    return 4.0 / 3.0 * math.pi * a * b * b


def spheroid_inertia(mass: float, a: float, b: float) -> NDArray[np.float64]:
    """Inertia `(3, 3)` [kg m^2] of a homogeneous spheroid about its centre, x along its axis."""
    across = mass * (a * a + b * b) / 5.0
    return np.diag([2.0 / 5.0 * mass * b * b, across, across])

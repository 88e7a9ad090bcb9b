"""Momentum of the water that goes along with a ship as the depth under it changes on its way. FRD, about CO.

Added mass that depends on the depth h, M_A(h), has the energy T = 1/2 nu' M_A(h) nu; Lagrange's equations ask for
-dM_A/dt nu + dT/dq beside M_A and its Coriolis forces (H. Lamb, "Hydrodynamics", 6th ed., Cambridge 1932, Sections 136,
137), which together keep energy, and momentum along the lines of equal depth. The depth is that under the origin, over
ground that is nearly level beside the ship's length; derivatives from captive tests, at one depth each, do not have it.
"""

from __future__ import annotations

from pelagos.hydro.algebra import Matrix, Vector, add, dot, matvec, mul, scaled
from pelagos.jit import Array


def shoaling_wrench(mass_by_depth: Matrix, nu: Vector, gradient: Vector, deepening: Array) -> list[Array]:
    """Force and moment (6) [N], [N m].

    Args:
        mass_by_depth: dM_A/dh `(6, 6)` [kg/m], [kg], [kg m].
        nu: velocity relative to the water (6) [m/s], [rad/s].
        gradient: of the depth by the place, horizontal, in body axes (3) [-].
        deepening: dh/dt along the way over ground [m/s].
    """
    momentum = matvec(mass_by_depth, nu)
    along = scaled(mul(0.5, dot(nu, momentum)), gradient)
    return add([*along, 0.0, 0.0, 0.0], scaled(-1.0 * deepening, momentum))

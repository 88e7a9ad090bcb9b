"""Loads that waves and wind put on a body: inertia of the moving water, strip-wise Morison loads, mean drift, wind.

Frame-neutral unless stated: vectors are 3-arrays in the body's axes, right-handed. Sources:
F90: O. M. Faltinsen, Sea Loads on Ships and Offshore Structures (1990). M50: J. R. Morison et al., Petroleum Trans.
AIME 189:149 (1950). N74: J. N. Newman, "Second-order slowly varying forces on vessels in irregular waves", Int. Symp.
Dynamics of Marine Vehicles (1974). F21: T. I. Fossen, Handbook of Marine Craft Hydrodynamics and Motion Control, 2nd
ed. (2021), Section 10.1.
"""

from __future__ import annotations

from collections.abc import Sequence

import drjit as dr

from pelagos.hydro.algebra import Matrix, Vector, add, cross, matvec, scaled, total
from pelagos.jit import Array


def moving_water(displaced_mass: Array, center: Vector, added_mass: Matrix, acceleration: Vector) -> list[Array]:
    """Wrench (6) on a small body in water that accelerates: F90, equation 3.35 and Section 3.5 (long waves).

    Froude-Krylov force, the displaced mass times the acceleration at the centre of buoyancy, and diffraction in the
    limit of waves much longer than the body, the added mass times the same acceleration. Valid where the wave is
    longer than five times the body (F90, p. 61). The added mass's reaction to the body's own acceleration is not in it.

    Args:
        displaced_mass: rho times the volume [kg].
        center: of buoyancy (3) [m].
        added_mass: `(6, 6)` about the body's origin.
        acceleration: of the undisturbed water at the centre of buoyancy, body axes (3) [m/s^2].
    """
    force = scaled(displaced_mass, acceleration)
    diffraction = matvec(added_mass, [*acceleration, 0.0, 0.0, 0.0])
    return add([*force, *cross(center, force)], diffraction)


def morison(
    density: Array, diameter: Array, inertia: Array, drag: Array, velocity: Vector, acceleration: Vector, axis: Vector
) -> list[Array]:
    """Force on a metre of a cylinder (3) [N/m]: M50, with the components across the axis only.

    rho (pi d^2 / 4) C_M a_n + rho d C_D |u_n| u_n / 2.

    Args:
        density: of the water [kg/m^3].
        diameter: [m].
        inertia: C_M = 1 + C_a.
        drag: C_D.
        velocity: of the water relative to the strip (3) [m/s].
        acceleration: of the water (3) [m/s^2].
        axis: unit vector along the cylinder (3).
    """
    a, u = across(acceleration, axis), across(velocity, axis)
    speed = dr.sqrt(u[0] * u[0] + u[1] * u[1] + u[2] * u[2])
    area = 0.25 * dr.pi * diameter * diameter
    return add(scaled(density * inertia * area, a), scaled(0.5 * density * drag * diameter * speed, u))


def across(vector: Vector, axis: Vector) -> list[Array]:
    """The part of a vector across a unit vector."""
    along = vector[0] * axis[0] + vector[1] * axis[1] + vector[2] * axis[2]
    return add(vector, scaled(-along, axis))


def strip_wrench(forces: Sequence[Vector], places: Sequence[Vector], length: Array) -> list[Array]:
    """Wrench (6) of forces per metre on strips of equal `length` [m] at `places` (3) [m]."""
    wrench: list[Array] = [0.0] * 6
    for force, place in zip(forces, places, strict=True):
        whole = scaled(length, force)
        wrench = add(wrench, [*whole, *cross(place, whole)])
    return wrench


def newman_drift(plain: tuple[Array, Array], weighted: tuple[Array, Array]) -> Array:
    """Slowly varying drift force [N] from four sums over the wave components: N74.

    Each pair of components pushes with the mean of what each does alone, (D_i + D_j) / 2 a_i a_j cos(p_i - p_j), D the
    mean force of a regular wave over its amplitude squared [N/m^2], p the phase at the body. The double sum is a
    product of single ones; its mean is sum a_i^2 D_i, and it holds differences of frequencies only.

    Args:
        plain: sum a_i cos p_i and sum a_i sin p_i [m].
        weighted: sum D_i a_i cos p_i and sum D_i a_i sin p_i [N/m].
    """
    return plain[0] * weighted[0] + plain[1] * weighted[1]


def wind_wrench(
    air_density: Array,
    velocity: Vector,
    frontal: Array,
    lateral: Array,
    length: Array,
    coefficients: tuple[Array, Array, Array],
    height: Array = 0.0,
) -> list[Array]:
    """Wrench (6) of wind on a superstructure, symmetric vessel: F21 equations 10.21 to 10.27.

    X = -q c_x cos g A_f, Y = q c_y sin g A_l, N = q c_n sin 2g A_l L, with g the angle that the wind comes from; roll
    and pitch by `height`. Body axes forward, starboard, down (FRD).

    Args:
        air_density: [kg/m^3].
        velocity: of the air relative to the vessel, body axes FRD (3) [m/s].
        frontal, lateral: projected areas [m^2].
        length: over all [m].
        coefficients: c_x, c_y, c_n, positive (0.5 to 0.9, 0.7 to 0.95, 0.05 to 0.2).
        height: of the areas' centre above the body's origin [m].
    """
    u, v = velocity[0], velocity[1]
    speed = dr.sqrt(u * u + v * v)
    cx, cy, cn = coefficients
    x = 0.5 * air_density * cx * frontal * u * speed
    y = 0.5 * air_density * cy * lateral * v * speed
    n = -air_density * cn * lateral * length * u * v  # q c_n sin 2g A L: from ahead it pushes the bow down wind
    return [x, y, 0.0, total(height * y), -height * x, n]

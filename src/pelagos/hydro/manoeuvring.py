"""Forces of the MMG standard model of a ship: hull, propeller and rudder, about its middle.

Source of all: H. Yasukawa, Y. Yoshimura, "Introduction of MMG standard method for ship maneuvering predictions", J.
Mar. Sci. Technol. 20:37 (2015), doi 10.1007/s00773-014-0293-y; equation numbers are the paper's. For ships of one
propeller and one rudder in its wake, ahead, in calm and deep water, drift angles to some 20 deg.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array

_SLOW: Final = 1e-3
"""Least speed ahead that angles are taken against, in parts of the speed or in m/s."""

_ABEAM: Final = 0.05
"""Speed ahead in parts of the whole below which a ship is carried aside, and resistance no longer has a side."""


@dataclass(frozen=True)
class Ship:
    """length, draught [m]; density [kg/m^3]; slow: speed below which non-dimensional velocities are held [m/s]."""

    length: Array
    draught: Array
    density: Array
    slow: Array


@dataclass(frozen=True)
class Wake:
    """Propeller and its inflow: diameter [m]; place x/L; fraction of the wake ahead; C1, C2 on either side (Eq. 16)."""

    diameter: Array
    place: Array
    fraction: Array
    c1: Array
    c2_starboard: Array
    c2_port: Array


@dataclass(frozen=True)
class Rudder:
    """area [m^2]; share of its height in the propeller's race (eta); lift slope f_alpha; thrust deduction t_R; a_H,
    x_H/L of the hull's share; epsilon and kappa of the inflow; gamma on either side; l_R/L; place x/L (Eqs. 18 to 24).
    """

    area: Array
    eta: Array
    lift_slope: Array
    deduction: Array
    hull_share: Array
    hull_place: Array
    epsilon: Array
    kappa: Array
    gamma_starboard: Array
    gamma_port: Array
    flow_place: Array
    place: Array


def speed_and_drift(ship: Ship, u: Array, v: Array, r: Array) -> tuple[Array, Array, Array]:
    """Speed U [m/s], v' = v/U and r' = r L/U, with U held below `ship.slow`."""
    speed = dr.maximum(dr.sqrt(u * u + v * v), ship.slow)
    return speed, v / speed, r * ship.length / speed


def hull_force(ship: Ship, c: dict[str, Array], u: Array, v: Array, r: Array) -> tuple[Array, Array, Array]:
    """X, Y [N] and N [N m] of the hull (Eqs. 7, 8).

    R0 multiplies U^2, against the way ahead. Astern, which the paper leaves out, it is turned round, and it passes
    through 0 over the last 3 deg before a drift from abeam.

    Args:
        ship: its size.
        c: R0, Xvv, Xvr, Xrr, Xvvvv, Yv, Yr, Yvvv, Yvvr, Yvrr, Yrrr, Nv, Nr, Nvvv, Nvvr, Nvrr, Nrrr, by rho/2 L d U^2
            (N: L^2).
        u, v: surge and sway amidships [m/s]; r: yaw rate [rad/s].
    """
    speed, a, b = speed_and_drift(ship, u, v, r)
    scale = 0.5 * ship.density * ship.length * ship.draught * speed * speed
    ahead = dr.clip(u / (_ABEAM * speed), -1.0, 1.0)
    drag = 0.5 * ship.density * ship.length * ship.draught * c["R0"] * (u * u + v * v) * ahead
    x = scale * (c["Xvv"] * a * a + c["Xvr"] * a * b + c["Xrr"] * b * b + c["Xvvvv"] * a * a * a * a) - drag

    def lateral(k: str) -> Array:
        return (
            c[f"{k}v"] * a + c[f"{k}r"] * b + c[f"{k}vvv"] * a * a * a + c[f"{k}vvr"] * a * a * b
            + c[f"{k}vrr"] * a * b * b + c[f"{k}rrr"] * b * b * b
        )  # fmt: skip

    return x, scale * lateral("Y"), scale * ship.length * lateral("N")


def wake_fraction(ship: Ship, wake: Wake, u: Array, v: Array, r: Array) -> Array:
    """w_P in a drift: (1 - w)/(1 - w0) = 1 + (1 - exp(-C1 |beta_P|)) (C2 - 1), beta_P = beta - x_P' r' (Eq. 16)."""
    speed, _, b = speed_and_drift(ship, u, v, r)
    beta = dr.atan2(-v, dr.maximum(u, _SLOW * speed)) - wake.place * b
    c2 = dr.select(beta > 0, wake.c2_starboard, wake.c2_port)
    return 1 - (1 - wake.fraction) * (1 + (1 - dr.exp(-wake.c1 * dr.abs(beta))) * (c2 - 1))


def propeller_thrust(
    ship: Ship, wake: Wake, kt: Vector, advance: Array, revolutions: Array
) -> tuple[Array, Array, Array]:
    """Thrust [N], KT and J of a propeller that turns ahead at `revolutions` [1/s], in an inflow [m/s] (Eqs. 9 to 11).

    kt: K_T = kt[0] + kt[1] J + kt[2] J^2.
    """
    j = dr.maximum(advance, 0.0) / (revolutions * wake.diameter)
    coefficient = kt[0] + kt[1] * j + kt[2] * j * j
    return ship.density * revolutions**2 * wake.diameter**4 * coefficient, coefficient, j


def rudder_normal_force(
    ship: Ship, rudder: Rudder, helm: Array, motion: tuple[Array, Array, Array], race: tuple[Array, Array, Array]
) -> Array:
    """Normal force F_N of the rudder [N] at a helm [rad], positive to starboard (Eqs. 19 to 24).

    The race u_P sqrt(1 + 8 KT/(pi J^2)) is written as tip sqrt(J^2 + 8 KT/pi), which holds at J = 0 too.

    Args:
        ship: its size; rudder: its constants; helm: [rad].
        motion: u, v [m/s], r [rad/s] of the ship; race: n D of the propeller [m/s], its K_T and J.
    """
    u, v, r = motion
    tip, kt, j = race
    speed, _, b = speed_and_drift(ship, u, v, r)
    beta = dr.atan2(-v, dr.maximum(u, _SLOW * speed)) - rudder.flow_place * b
    across = speed * dr.select(beta > 0, rudder.gamma_starboard, rudder.gamma_port) * beta
    advance = j * tip
    jet = (1 - rudder.kappa) * advance + rudder.kappa * tip * dr.sqrt(j * j + 8 / dr.pi * dr.maximum(kt, 0.0))
    along = rudder.epsilon * dr.sqrt(rudder.eta * jet * jet + (1 - rudder.eta) * advance * advance)
    angle = helm - dr.atan2(across, dr.maximum(along, _SLOW))
    return 0.5 * ship.density * rudder.area * (along * along + across * across) * rudder.lift_slope * dr.sin(angle)

"""Forces of a ship that heels as it turns, by Son and Nomoto: hull, propeller and rudder in surge, sway, roll and yaw.

Source of all: K. Son, K. Nomoto, "On the coupled motion of steering and rolling of a high speed container ship", Naval
Architecture and Ocean Engineering 20:73 (1982), from J. Soc. Naval Arch. Japan 150 (1981); as T. I. Fossen's MSS
toolbox has it (`container.m`, MIT). Prime system: velocities by the present speed U, rates by U/L, forces by rho/2 L^2
U^2, moments by rho/2 L^3 U^2. For a ship under way in calm, deep water, FRD, heels to some 0.4 rad.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array

Term = tuple[str, tuple[str, ...], float]
"""Force (X, Y, K or N), the variables whose product it multiplies (u, v, r, p, phi), value."""
_LIFT: Final = (6.13, 2.25)
"""Fujii's formula: slope of the lift of a rudder of aspect ratio A is 6.13 A/(A + 2.25)."""
_SPIN: Final = 1.0
"""Largest r' (full helm: 0.6)."""
_HEEL: Final = 0.7
"""Largest heel that hull forces know [rad]."""
_LITTLE: Final = 1e-3
"""Least inflow ahead that the angle of the rudder's is taken against, by the speed."""


@dataclass(frozen=True)
class RollingShip:
    """length [m]; density [kg/m^3]; slow: speed below which non-dimensional velocities are held [m/s]."""

    length: Array
    density: Array
    slow: Array


@dataclass(frozen=True)
class Screw:
    """diameter D [m]; place x_P/L; wake fraction w_P, tau of its change; deduction t; K_T = kt[0] + kt[1] J."""

    diameter: Array
    place: Array
    wake: Array
    wake_change: Array
    deduction: Array
    kt: Vector


@dataclass(frozen=True)
class HelmRudder:
    """area A_R [m^2]; aspect ratio; epsilon, k of the inflow along; gamma, c_Rr, c_Rrrr, c_Rrrv of that across; c_RX of
    the drag; a_H, x_H/L of the hull's share; place x_R/L and depth z_R/L.
    """

    area: Array
    aspect: Array
    epsilon: Array
    race: Array
    gamma: Array
    across: Vector
    drag: Array
    hull_share: Array
    hull_place: Array
    place: Array
    depth: Array


def primes(ship: RollingShip, motion: tuple[Array, Array, Array, Array, Array]) -> tuple[Array, dict[str, Array]]:
    """Speed U [m/s], and u', v', r', p', phi of u, v [m/s], r, p [rad/s], phi [rad].

    U is held at `ship.slow` and above, and where a ship turns on the spot at r L and above, so that r' is at most 1 and
    its damping goes with r |r|; heel is held at 40 deg. Beyond, polynomials fitted to steady turns mean nothing.
    """
    u, v, r, p, phi = motion
    speed = dr.maximum(dr.maximum(dr.sqrt(u * u + v * v), ship.slow), dr.abs(r) * ship.length / _SPIN)
    phi = dr.clip(phi, -_HEEL, _HEEL)
    turn = ship.length / speed
    return speed, {"u": u / speed, "v": v / speed, "r": r * turn, "p": p * turn, "phi": phi}


def hull_force(terms: Iterable[Term], prime: Mapping[str, Array]) -> dict[str, Array]:
    """X', Y', K', N' of the hull: the sum of derivatives times products of their variables."""
    sums: dict[str, Array] = {"X": 0.0, "Y": 0.0, "K": 0.0, "N": 0.0}
    for force, variables, value in terms:
        product: Array = value
        for name in variables:
            product = product * prime[name]
        sums[force] = sums[force] + product
    return sums


def screw_inflow(screw: Screw, prime: Mapping[str, Array]) -> Array:
    """u_P' past the propeller, never astern: u' ((1 - w_P) + tau (v' + x_P' r')^2)."""
    sideways = prime["v"] + screw.place * prime["r"]
    return dr.maximum(prime["u"] * (1 - screw.wake + screw.wake_change * sideways * sideways), 0.0)


def screw_coefficient(screw: Screw, inflow: Array, tip: Array) -> Array:
    """K_T at an inflow u_P and a tip speed n D, both in the same unit; an idle screw counts as one at J = 1."""
    j = dr.select(tip > 0, inflow / dr.select(tip > 0, tip, 1.0), 1.0)
    return screw.kt[0] + screw.kt[1] * j


def rudder_normal_force(
    ship: RollingShip, rudder: HelmRudder, prime: Mapping[str, Array], angle: Array, race: tuple[Array, Array, Array]
) -> Array:
    """F_N' of a rudder at an angle [rad], whose positive turns to starboard.

    The race epsilon u_P sqrt(1 + 8 k K_T/(pi J^2)) is written as epsilon sqrt(u_P^2 + 8 k K_T (n D)^2/pi), which holds
    at J = 0 too.

    Args:
        ship: its size; rudder: its constants; prime: velocities; angle: of the rudder.
        race: u_P', n D/U, K_T.
    """
    inflow, tip, kt = race
    v, r = prime["v"], prime["r"]
    c_r, c_rrr, c_rrv = rudder.across
    across = rudder.gamma * v + c_r * r + c_rrr * r * r * r + c_rrv * r * r * v
    push = inflow * inflow + 8 * rudder.race / dr.pi * kt * tip * tip
    along = rudder.epsilon * dr.sqrt(dr.maximum(push, 0.0))
    attack = angle + dr.atan2(across, dr.maximum(along, _LITTLE))
    slope = _LIFT[0] * rudder.aspect / (rudder.aspect + _LIFT[1])
    return -slope * rudder.area / ship.length**2 * (along * along + across * across) * dr.sin(attack)


def ship_force(
    ship: RollingShip,
    terms: Iterable[Term],
    screw: Screw,
    rudder: HelmRudder,
    motion: tuple[Array, Array, Array, Array, Array],
    controls: tuple[Array, Array],
) -> Vector:
    """X, Y [N], K and N [N m] of hull, propeller and rudder, without restoring and the rigid body's inertia.

    Args:
        ship, terms, screw, rudder: its size and constants.
        motion: u, v [m/s], r, p [rad/s] through the water, heel phi [rad].
        controls: rudder angle [rad], positive turns to starboard; revolutions [1/s].
    """
    angle, n = controls
    speed, prime = primes(ship, motion)
    hull = hull_force(terms, prime)
    inflow, tip = screw_inflow(screw, prime), n * screw.diameter / speed
    kt = screw_coefficient(screw, inflow, tip)
    thrust = 2 * (screw.diameter / ship.length) ** 2 * kt * tip * dr.abs(tip)
    normal = rudder_normal_force(ship, rudder, prime, angle, (inflow, tip, kt))
    sin, cos = dr.sincos(angle)
    side = (1 + rudder.hull_share) * normal * cos
    scale = 0.5 * ship.density * ship.length**2 * speed * speed
    return [
        scale * (hull["X"] + (1 - screw.deduction) * thrust + rudder.drag * normal * sin),
        scale * (hull["Y"] + side),
        scale * ship.length * (hull["K"] - rudder.depth * side),
        scale * ship.length * (hull["N"] + (rudder.place + rudder.hull_share * rudder.hull_place) * normal * cos),
    ]

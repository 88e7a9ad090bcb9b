"""Hydrodynamic forces by derivatives of the second degree, as captive tests of submersibles give them, FRD.

Source: M. Gertler, G. R. Hagen, "Standard equations of motion for submarine simulation", NSRDC 2510 (1967); J. Feldman,
DTNSRDC/SPD-0393-09 (1979): X = rho/2 L^(2+k) (X'_vv v v + ...), k the number of rates in the product, one power of L
more for moments. For fully wetted bodies, ahead, at drift angles to some 15 deg.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector, mul
from pelagos.jit import Array

NAME: Final = re.compile(r"([XYZKMN])([uvwpqr]{2})(d{0,2})")
"""A derivative: the force, two velocities, and a deflection none, one or two times."""
FORCES: Final = "XYZKMN"
VELOCITIES: Final = "uvwpqr"
_LITTLE: Final = 0.05
"""Speed ahead below which the race is no longer taken against it [m/s]."""


@dataclass(frozen=True)
class Derivative:
    """force: number of the axis; velocities: numbers of two; power: of the deflection; value: dimensional."""

    force: int
    velocities: tuple[int, int]
    power: int
    value: Array


def dimensional(derivatives: Mapping[str, float], density: float, length: float) -> tuple[Derivative, ...]:
    """Derivatives by name, such as `Yur` or `Zuud`, with rho/2 and the powers of the length [m] that they are over."""
    found = []
    for name, value in derivatives.items():
        match = NAME.fullmatch(name)
        assert match is not None
        force, pair, deflections = match.groups()
        power = 2 + sum(v in "pqr" for v in pair) + (force in "KMN")
        numbers = (VELOCITIES.index(pair[0]), VELOCITIES.index(pair[1]))
        found.append(Derivative(FORCES.index(force), numbers, len(deflections), 0.5 * density * length**power * value))
    return tuple(found)


def derivative_force(derivatives: Iterable[Derivative], nu_r: Vector, deflection: Array = 0.0) -> list[Array]:
    """Wrench (6) [N], [N m]: each derivative times its product.

    u u is u |u|, so that drag and the lift of a plane turn round where the body goes astern.

    Args:
        derivatives: `dimensional` ones.
        nu_r: velocity relative to the water (6).
        deflection: of the plane [rad].
    """
    load: list[Array] = [0.0] * 6
    products: dict[tuple[tuple[int, int], int], Array] = {}
    for one in derivatives:
        key = (one.velocities, one.power)
        if key not in products:
            i, j = one.velocities
            product = nu_r[0] * dr.abs(nu_r[0]) if i == j == 0 else nu_r[i] * nu_r[j]
            for _ in range(one.power):
                product = product * deflection
            products[key] = product
        load[one.force] = load[one.force] + mul(one.value, products[key])
    return load


def race_change(loading: Array, length: Array, pitch: Array, u: Array, n: Array) -> Array:
    """epsilon: change of the flow past the planes against that of steady speed, by the propeller's race [-].

    epsilon = (sqrt(C_t + 1) - 1)/(sqrt(C_t1 + 1) - 1) - 1, C_t = loading L^2/2 eta |eta|, eta = pitch n/u, C_t1 that
    of eta = 1, where propulsion and drag are in balance. A. J. Healey, D. Lienard, IEEE J. Oceanic Eng. 18(3):327
    (1993), doi 10.1109/JOE.1993.236372; T. I. Fossen's MSS toolbox, `npsauv.m`. Astern it is -1: no race.

    Args:
        loading: thrust loading [1/m^2]; length: of the hull [m].
        pitch: way of the vehicle by turn of the propeller, steady [m/rad].
        u: speed ahead through the water [m/s]; n: shaft speed [rad/s].
    """
    eta = dr.maximum(pitch * n / dr.maximum(u, _LITTLE), 0.0)
    eta = dr.select(u > 0, eta, 0.0)
    steady = 0.5 * loading * length * length
    return (dr.sqrt(steady * eta * eta + 1) - 1) / (dr.sqrt(steady + 1) - 1) - 1

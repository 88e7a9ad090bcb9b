"""Hull forces by products of velocities, of their magnitudes and of the heel, as captive tests of ships give them, FRD.

Second-order modulus terms of A. I. Fedyaevsky, G. V. Sobolev, "Control and stability in ship design" (1964, Russian),
and N. H. Norrbin, SSPA publication 68 (1971), with heel as M. Blanke, A. Christensen, "Rudder-roll damping autopilot
robustness to sway-yaw-roll couplings", 10th Ship Control Systems Symposium, Ottawa 1993, have them. A coefficient has a
dimension: [N] or [N m] over that of its product in m/s, rad/s and rad. Valid at speeds and angles of the tests.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector, mul
from pelagos.jit import Array

FORCES: Final = "XYZKMN"
VARIABLES: Final = ("u", "v", "w", "p", "q", "r", "phi")
HEEL: Final = 0.7
"""Largest heel that these forces know [rad]: no captive test goes beyond 40 deg."""
_NAME: Final = re.compile(r"([XYZKMN])((?:\|(?:phi|[uvwpqr])+\||phi|[uvwpqr])+)")
_FACTOR: Final = re.compile(r"\|[a-z]+\||phi|[uvwpqr]")
_VARIABLE: Final = re.compile(r"phi|[uvwpqr]")


@dataclass(frozen=True)
class Product:
    """force: number of the axis; factors: variables that are multiplied; magnitudes: those of which the magnitude is
    multiplied; value: [N] or [N m] over the product's unit.
    """

    force: int
    factors: tuple[str, ...]
    magnitudes: tuple[str, ...]
    value: Array


def is_name(name: str) -> bool:
    """True for the name of a product, such as `Yur`, `Nr|r|` or `Kphi|uv|`."""
    return _NAME.fullmatch(name) is not None


def products_of(coefficients: Mapping[str, float]) -> tuple[Product, ...]:
    """Products by name: `Yphi|uv|` multiplies phi |u v|."""
    found = []
    for name, value in coefficients.items():
        match = _NAME.fullmatch(name)
        assert match is not None
        parts = _FACTOR.findall(match.group(2))
        within = "".join(part for part in parts if part[0] == "|")
        plain = tuple(part for part in parts if part[0] != "|")
        found.append(Product(FORCES.index(match.group(1)), plain, tuple(_VARIABLE.findall(within)), value))
    return tuple(found)


def modulus_force(products: Iterable[Product], nu_r: Vector, heel: Array) -> list[Array]:
    """Force and moment (6) [N], [N m]: the sum of the products by their coefficients.

    Args:
        products: `products_of` coefficients.
        nu_r: velocity relative to the water (6) [m/s], [rad/s].
        heel: phi [rad], held at `HEEL` to either side.
    """
    value = dict(zip(VARIABLES, [*nu_r, dr.clip(heel, -HEEL, HEEL)], strict=True))
    load: list[Array] = [0.0] * 6
    for one in products:
        product: Array = one.value
        for name in one.factors:
            product = mul(product, value[name])
        for name in one.magnitudes:
            product = mul(product, dr.abs(value[name]))
        load[one.force] = load[one.force] + product
    return load

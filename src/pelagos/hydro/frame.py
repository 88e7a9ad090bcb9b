"""Drag and lift of box-shaped frames in a flow from any side, FRD.

Drag: an open frame is many small bluff members, each of which drags against the flow that it meets, F = -k |V| V by
direction (S. F. Hoerner, "Fluid-Dynamic Drag", 1965, Chapters 3 and 8; Morison's form for a flow from any side,
DNV-RP-C205, Section 6.2). A flow along one axis has the published drag of that axis; a slight flow across a fast one is
resisted by the product of both, which coefficients of |u| u, |v| v by axis leave out.

Lift: behind a blunt base the flow separates, and the momentum that the cross-flow gave to the water there stays in the
wake. H. J. Allen and E. W. Perkins, NACA Report 1048 (1951), equations 8 and 10: a normal force (k2 - k1) S_b q sin 2a
at the base, which for a box (base S_b = V / L) leaves half of Munk's moment.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Final, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.hydro.algebra import Vector, add, cross, dot, fma, mul, scaled
from pelagos.jit import Array

_STILL: Final = 1e-20  # (m/s)^2: keeps the root's gradient finite at rest

Pair: TypeAlias = tuple[int, int, float, float]
"""Axis of the flow, axis of the force, added mass a metre [kg/m] and half the length [m], see `blunt_pairs`."""


def frame_places(
    quadratic: Vector, turning: Sequence[float], size: Sequence[float]
) -> tuple[list[list[float]], list[float]]:
    """Points at which the drag of a frame attacks, and the drag that turning on the spot meets besides.

    Six places on the axes of a box have the mean squares of its volume. They move together, towards its middle, until
    turning alone meets nowhere more drag than was measured; what is missing elsewhere is kept as drag on turning.

    Args:
        quadratic: -X|u|u, -Y|v|v, -Z|w|w (3), none below 0 [kg/m].
        turning: -K|p|p, -M|q|q, -N|r|r (3), none below 0 [kg m^2], measured.
        size: of the box (3) [m].

    Returns:
        Places `(6, 3)` [m] about its middle, and the rest of `turning` (3).
    """
    half = np.array(size) / 2
    full = np.array([sum(quadratic[k] * half[j] ** 3 for j, k in _others(i)) / 3 for i in range(3)])
    met = full > 0  # turning about the other axes moves no place across a drag
    share = float(min(1.0, *(np.array(turning)[met] / full[met]) ** (1 / 3)))
    places = [(side * share * half[i] * np.eye(3)[i]).tolist() for i in range(3) for side in (1, -1)]
    rest = np.maximum(np.array(turning) - share**3 * full, 0.0)
    return places, [float(r) if r > 1e-12 else 0.0 for r in rest]


def _others(axis: int) -> tuple[tuple[int, int], tuple[int, int]]:
    j, k = (axis + 1) % 3, (axis + 2) % 3
    return (j, k), (k, j)


def frame_drag(quadratic: Vector, rest: Vector, places: Sequence[Vector], center: Vector, nu_r: Vector) -> list[Array]:
    """Wrench (6) of drag that attacks in equal parts at `places`, see `frame_places`.

    Args:
        quadratic: by direction (3) [kg/m].
        rest: on turning alone (3) [kg m^2].
        places: about the drag's centre (3) [m].
        center: of the drag (3) [m].
        nu_r: relative velocity (6).
    """
    turn = nu_r[3:]
    part = [mul(q, 1 / len(places)) for q in quadratic]
    wrench: list[Array] = [0.0, 0.0, 0.0, *(mul(mul(-r, abs(w)), w) for r, w in zip(rest, turn, strict=True))]
    for place in places:
        at = add(center, place)
        velocity = add(nu_r[:3], cross(turn, at))
        speed = dr.sqrt(dot(velocity, velocity) + _STILL)
        force = [mul(mul(-k, speed), v) for k, v in zip(part, velocity, strict=True)]
        wrench = add(wrench, [*force, *cross(at, force)])
    return wrench


def blunt_pairs(added: NDArray[np.float64], size: Sequence[float]) -> tuple[Pair, ...]:
    """The pairs of axes in which a box has a lift: flow along the one of less added mass, force along the other."""
    mass = np.diag(added)
    return tuple(
        (i, j, float(mass[j] - mass[i]) / size[i], size[i] / 2)
        for i in range(3)
        for j in range(3)
        if i != j and mass[j] > mass[i]
    )


def blunt_lift(pairs: Sequence[Pair], nu_r: Vector) -> list[Array]:
    """Wrench (6): at the base, half a length down the flow, -a |u| times the cross-flow there.

    It never drives the body: the power is -a |u| v_b^2, v_b across the base.
    """
    wrench: list[Array] = [0.0] * 6
    for i, j, mass, half in pairs:
        k = 3 - i - j
        side = 1.0 if j == (i + 1) % 3 else -1.0
        u, v, w = nu_r[i], nu_r[j], nu_r[3 + k]
        size = abs(u)
        force = scaled(-mass, [fma(size, v, -half * side * u * w)])[0]
        moment = side * mass * half * fma(u, v, -half * side * size * w)
        wrench[j], wrench[3 + k] = add([wrench[j], wrench[3 + k]], [force, moment])
    return wrench

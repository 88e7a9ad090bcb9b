"""The liquid in a tank that is partly full: a box cut by a level surface, exact at any fill and attitude. FRD.

The surface lies level (quasi-static: no sloshing; O. M. Faltinsen, A. N. Timokha, "Sloshing", Cambridge 2009, treat
what that leaves out). While it cuts the four upright walls alone, the liquid's centre moves sideways by i/V times the
tangent of the heel, i the second moment of the surface: the loss of metacentric height by a free surface, i/V of the
liquid times its weight over the ship's (E. V. Lewis (ed.), "Principles of Naval Architecture", vol. I, SNAME 1988,
Section 3.6 of Chapter II).

With coordinates u_k in -1 .. 1 along the sides and w_k = a_k |d_k| of the half sides a and the direction d of gravity,
the liquid is where w . u > c. Integrals along the side that lies most upright and the next are closed forms; along the
third, whose w is least, they are polynomials up to degree 4 between the places where the surface passes a corner, and
Gauss's with three nodes, exact up to degree 5, from each of these to the next.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise
from typing import Final

import drjit as dr
import numpy as np

from pelagos.hydro.algebra import Vector, total
from pelagos.jit import Array

_NODES, _WEIGHTS = ([float(x) for x in part] for part in np.polynomial.legendre.leggauss(3))
_TURNS: Final = 7  # steps of Newton: rounding is reached after 6, at any fill and attitude (tests)
_LEAST_FILL: Final = 1e-6  # the centre of less is that of so much
_FLAT: Final = 1e-9  # of a side: a slope that no surface has


def box_liquid_center(fill: Array, half_sides: Vector, down: Vector) -> list[Array]:
    """Centre (3) of a liquid from the middle of its box, body axes [m].

    Args:
        fill: share of the box's volume, 0 to 1.
        half_sides: of the box, along body axes (3) [m].
        down: unit vector towards the centre of the earth, in body axes (3).
    """
    w, order = _sides(half_sides, down)
    less = dr.maximum(dr.minimum(fill, 1.0 - fill), _LEAST_FILL)
    level = _level(less, w)
    moments = _moments(level, w)
    empty = 1.0 - fill  # of a fuller box what is empty is the mirrored liquid, and both together are the box
    scale = dr.select(fill <= 0.5, 1.0, empty / dr.maximum(fill, 0.5)) / less
    found: list[Array] = []
    for axis, (a, d) in enumerate(zip(half_sides, down, strict=True)):
        own = total(*(dr.select(rank == axis, m, 0.0) for rank, m in zip(order, moments, strict=True)))
        found.append(dr.mulsign(a * scale * own, d))
    return found


def box_liquid_level(fill: Array, half_sides: Vector, down: Vector) -> tuple[Array, Array]:
    """Depth of the liquid's surface below the middle of its box [m], negative: above; and its rise by the fill [m].

    Arguments as of `box_liquid_center`.
    """
    w = _sides(half_sides, down)[0]
    level = _level(dr.maximum(dr.minimum(fill, 1.0 - fill), _LEAST_FILL), w)
    rise = 1.0 / dr.maximum(_share(level, w)[1], 1e-30)
    return dr.select(fill <= 0.5, level, -level), rise


def _sides(half_sides: Vector, down: Vector) -> tuple[list[Array], list[Array]]:
    """w, the largest first, and the axis of each."""
    slopes = [dr.abs(d) * a for d, a in zip(down, half_sides, strict=True)]
    order = _by_size(slopes)
    return [dr.maximum(_picked(slopes, rank), _FLAT * _picked(slopes, order[0])) for rank in order], order


def _by_size(values: Vector) -> list[Array]:
    """Numbers of three values, the largest first."""
    x, y, z = values
    first = dr.select((x >= y) & (x >= z), 0.0, dr.select(y >= z, 1.0, 2.0))
    last = dr.select((z <= y) & (z <= x), 2.0, dr.select(y <= x, 1.0, 0.0))
    return [first, 3.0 - first - last, last]


def _picked(values: Vector, number: Array) -> Array:
    return dr.select(number == 0.0, values[0], dr.select(number == 1.0, values[1], values[2]))


def _level(fill: Array, w: Vector) -> Array:
    """c at which a share `fill` of at most a half is beyond; Newton's method on the square root of the share."""
    low, high = 0.0, w[0] + w[1] + w[2]
    c = dr.maximum(w[0] * (1.0 - 2.0 * fill), 0.0)
    wanted = dr.sqrt(fill)
    for _ in range(_TURNS):
        share, density = _share(c, w)
        root = dr.sqrt(dr.maximum(share, 1e-30))
        low, high = dr.select(root > wanted, c, low), dr.select(root > wanted, high, c)
        new = c + (root - wanted) * 2.0 * root / dr.maximum(density, 1e-30)
        c = dr.select((new >= low) & (new <= high), new, 0.5 * (low + high))
    return c


def _share(c: Array, w: Vector) -> tuple[Array, Array]:
    """Share of the box beyond c, and its slope by -c."""
    w0, w1, w2 = w
    share: Array = 0.0
    density: Array = 0.0
    for x, g in _third(c, w):
        near, far = w0 - c + w2 * x, -w0 - c + w2 * x
        share = share + g * (_ramp(near, w1) - _ramp(far, w1))
        density = density + g * (_step(near, w1) - _step(far, w1))
    return share / (2 * w0), density / (2 * w0)


def _moments(c: Array, w: Vector) -> list[Array]:
    """Means over the box of each u, 0 before c."""
    w0, w1, w2 = w
    share: Array = 0.0
    excess: Array = 0.0
    second: Array = 0.0
    third: Array = 0.0
    for x, g in _third(c, w):
        near, far = w0 - c + w2 * x, -w0 - c + w2 * x
        part = _ramp(near, w1) - _ramp(far, w1)
        share = share + g * part
        third = third + g * x * part
        second = second + g * (_arm(near, w1) - _arm(far, w1))
        excess = excess + g * (_square(near, w1) - _square(far, w1))
    share, second, third, excess = (m / (2 * w0) for m in (share, second, third, 0.5 * excess))
    return [(c * share + excess - w1 * second - w2 * third) / w0, second, third]


def _third(c: Array, w: Vector) -> Iterator[tuple[Array, Array]]:
    """Nodes along the third side and their weights, of a mean over it."""
    w0, w1, w2 = w
    lowest = (c - w0 - w1) / w2  # the surface passes the last corner; it and the next lie two or more apart, as w1 > w2
    first = dr.clip(dr.select(lowest > -1.0, lowest, (c - w0 + w1) / w2), -1.0, 1.0)
    second = dr.clip((c + w0 - w1) / w2, -1.0, 1.0)  # beyond 1 where the last is within
    for start, end in pairwise((-1.0, first, second, 1.0)):
        middle, half = 0.5 * (start + end), 0.5 * (end - start)
        for x, g in zip(_NODES, _WEIGHTS, strict=True):
            yield middle + half * x, 0.5 * g * half


# means over u in -1 .. 1, with (x)+ = max(x, 0)


def _step(a: Array, w: Array) -> Array:
    """Of 1 where a + w u > 0."""
    return dr.clip(0.5 + 0.5 * a / w, 0.0, 1.0)


def _ramp(a: Array, w: Array) -> Array:
    """Of (a + w u)+."""
    return dr.select(a >= w, a, dr.square(dr.maximum(a + w, 0.0)) / (4 * w))


def _square(a: Array, w: Array) -> Array:
    """Of ((a + w u)+)^2."""
    rest = dr.maximum(a + w, 0.0)
    return dr.select(a >= w, a * a + w * w / 3, rest * rest * rest / (6 * w))


def _arm(a: Array, w: Array) -> Array:
    """Of u (a + w u)+."""
    t = dr.clip(-a / w, -1.0, 1.0)
    return w * ((1 - t * t * t) / 6 - t * (1 - t * t) / 4)

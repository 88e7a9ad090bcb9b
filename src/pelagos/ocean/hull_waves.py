"""Waves under a hull that is short against the longest of them: one pass over the components a hull, not a corner.

Elevation and pressure are sampled at nodes of a grid that goes with the hull's heading, and between them are
polynomials: 8 nodes along, 3 across and 3 downwards. Components whose length is more than the hull's are exact to 1e-3
of their amplitude; shorter ones are smoothed. The same pass gives the motion of a rigid sheet of water that fits that
of the waves over the waterplane best, for the loads that relative motion makes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.turns import sincos_turns
from pelagos.ocean.waves import Waves

_ALONG: Final = np.polynomial.legendre.leggauss(8)
_ACROSS: Final = np.polynomial.legendre.leggauss(3)


@dataclass(frozen=True)
class Waterplane:
    """The box that a hull's wet part is in, about its origin.

    Attributes:
        length, draught: [m].
        sides: distance of the outermost centre lines, or half the beam of a single hull [m].
        twin: whether the hulls are at the sides.
    """

    length: float
    sides: float
    draught: float
    twin: bool

    @property
    def across(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Nodes [m] and weights across the hull."""
        if self.twin:
            return np.array([-1.0, 0.0, 1.0]) * self.sides, np.array([0.5, 0.0, 0.5])
        return _ACROSS[0] * self.sides, _ACROSS[1] / 2


@dataclass
class HullWaves:
    """Waves at one hull, axes along the heading: forward, to starboard and down.

    Attributes:
        powers: coefficients of the elevation, and of the pressure over rho g, by power down, across and along.
        velocity, acceleration: of the water as a rigid sheet (6): surge, sway, heave [m/s], [m/s^2], roll, pitch and
            yaw [rad/s], [rad/s^2].
        scale: 1 / (half the length, the sides, the draught) [1/m].
    """

    powers: list[list[list[Array]]]
    velocity: list[Array]
    acceleration: list[Array]
    scale: tuple[float, float, float]

    def at(self, forward: Array, starboard: Array, depth: Array) -> tuple[Array, Array]:
        """(elevation [m], dynamic pressure over rho g [m]) at places from the hull's origin, `depth` below z = 0."""
        u = dr.clip(forward * self.scale[0], -1.1, 1.1)
        v = dr.clip(starboard * self.scale[1], -1.6, 1.6)
        s = dr.clip(depth * self.scale[2], 0.0, 1.5)
        levels = [_horner([_horner(row, u) for row in level], v) for level in self.powers]
        return levels[0], _horner(levels, s)


def hull_waves(
    waves: Waves, north: Array, west: Array, heading: tuple[Array, Array], t: Array, plane: Waterplane
) -> HullWaves:
    """Waves about a place.

    Args:
        waves: the sea.
        north, west: of the hull's origin [m].
        heading: cosine and sine of the compass heading.
        t: time [s].
        plane: of the hull.
    """
    cos, sin = heading
    half = 0.5 * plane.length
    places, weights = half * _ALONG[0], _ALONG[1] / 2
    sides, share = plane.across
    nx, ny = len(places), len(sides)
    spread_x = float(np.sum(weights * places**2))
    spread_y = float(np.sum(share * sides**2))
    nothing = 0 * (north + west + t + cos)

    def add(i: Array, *sums: Array) -> tuple[Array, ...]:
        first, second = waves._rows(i)
        a, k = second[0], second[1]
        ahead, aside = first[0] * cos - first[1] * sin, -(first[0] * sin + first[1] * cos)
        turns = dr.fma(first[0], north, dr.fma(first[1], west, dr.fma(-first[2], t, first[3])))
        s, c = sincos_turns(turns)
        s, c = a * s, a * c
        xs = [sincos_turns(float(x) * ahead) for x in places[nx // 2 :]]
        ys = [sincos_turns(float(y) * aside) for y in sides[ny // 2 + 1 :]]
        cos_x, sin_x = [p[1] for p in xs], [p[0] for p in xs]
        columns = [(c, s)]  # cosine and sine parts at each side
        for sy, cy in ys:
            columns = [(c * cy + s * sy, s * cy - c * sy), *columns, (c * cy - s * sy, s * cy + c * sy)]
        surface = []
        for cc, ss in columns:
            right = [cc * x - ss * y for x, y in zip(cos_x, sin_x, strict=True)]
            left = [cc * x + ss * y for x, y in zip(cos_x, sin_x, strict=True)]
            surface += [*left[::-1], *right]
        deeper = [waves._decay(k, jit.Float64(-d * plane.draught), second) for d in (0.5, 1.0)]
        values = [*surface, *(e * deeper[0][2] for e in surface), *(e * deeper[1][2] for e in surface)]
        # means over the waterplane of cos(x), cos(y), and of their first moments
        mean_x = sum(2 * float(w) * x for w, x in zip(weights[nx // 2 :], cos_x, strict=True))
        lean_x = sum(2 * float(w * p) * x for w, p, x in zip(weights[nx // 2 :], places[nx // 2 :], sin_x, strict=True))
        mean_y, lean_y = float(share[ny // 2]) + nothing, nothing
        for w, p, (sy, cy) in zip(share[ny // 2 + 1 :], sides[ny // 2 + 1 :], ys, strict=True):
            mean_y, lean_y = mean_y + 2 * float(w) * cy, lean_y + 2 * float(w * p) * sy
        lean_x, lean_y = lean_x * (1 / spread_x), lean_y * (1 / spread_y)
        along, up = deeper[0][0], deeper[1][1]  # sides feel the motion half way down, bottoms that at the draught
        rate = 2 * math.pi * first[2]
        to = 2 * math.pi / k
        fx, fy = to * ahead * along, to * aside * along
        whole, nod, tilt = mean_x * mean_y, lean_x * mean_y, mean_x * lean_y
        # velocity: forward and aside go with cos, upwards with sin; first moments turn cos to -sin and sin to cos
        cw, sw = rate * whole * c, rate * whole * s
        motion = [fx * cw, fy * cw, -up * sw, -up * rate * tilt * c, up * rate * nod * c, -fy * rate * nod * s]
        fast = rate * rate
        cw, sw = fast * whole * c, fast * whole * s
        change = [fx * sw, fy * sw, up * cw, -up * fast * tilt * s, up * fast * nod * s, fy * fast * nod * c]
        return i + 1, *(x + y for x, y in zip(sums, [*values, *motion, *change], strict=True))

    found = list(waves._loop(add, *([nothing] * (3 * nx * ny + 12))))
    grid, motion = found[: 3 * nx * ny], found[3 * nx * ny :]
    scale = (1 / half, 1 / plane.sides, 1 / plane.draught)
    powers = _powers(grid, _ALONG[0], sides / plane.sides, np.array([0.0, 0.5, 1.0]))
    return HullWaves(powers, motion[:6], motion[6:], scale)


def _powers(grid: Sequence[Array], x: NDArray, y: NDArray, z: NDArray) -> list[list[list[Array]]]:  # type: ignore[type-arg]
    """From values at nodes, z by y by x, to coefficients of powers."""
    to_x, to_y, to_z = (np.linalg.inv(np.vander(n, increasing=True)) for n in (x, y, z))
    nx, ny = len(x), len(y)
    rows = [_times(to_x, grid[i : i + nx]) for i in range(0, len(grid), nx)]
    levels = []
    for k in range(len(z)):
        block = rows[k * ny : (k + 1) * ny]
        columns = [_times(to_y, [row[p] for row in block]) for p in range(nx)]
        levels.append([[columns[p][q] for p in range(nx)] for q in range(ny)])
    mixed = [[_times(to_z, [level[q][p] for level in levels]) for p in range(nx)] for q in range(ny)]
    return [[[mixed[q][p][k] for p in range(nx)] for q in range(ny)] for k in range(len(z))]


def _times(matrix: NDArray, values: Sequence[Array]) -> list[Array]:  # type: ignore[type-arg]
    return [sum(float(m) * v for m, v in zip(row, values, strict=True) if abs(m) > 1e-14) for row in matrix]


def _horner(coefficients: Sequence[Array], x: Array) -> Array:
    value = coefficients[-1]
    for c in coefficients[-2::-1]:
        value = dr.fma(value, x, c)
    return value

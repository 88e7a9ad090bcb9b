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
from typing import Final, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.turns import sincos_turns
from pelagos.ocean.waves import Waves

_ALONG: Final = np.polynomial.legendre.leggauss(8)
_ACROSS: Final = np.polynomial.legendre.leggauss(3)
_Phase: TypeAlias = tuple[Array, Array]  # sine and cosine


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
        twin: whether the hulls are at the sides.
        velocity, acceleration: of the water as a rigid sheet (6): surge, sway, heave [m/s], [m/s^2], roll, pitch and
            yaw [rad/s], [rad/s^2].
        scale: 1 / (half the length, the sides, the draught) [1/m].
    """

    powers: list[list[list[Array]]]
    velocity: list[Array]
    acceleration: list[Array]
    scale: tuple[float, float, float]
    twin: bool

    def plane(self) -> tuple[Array, Array, Array]:
        """Mean elevation under the waterplane [m], and how it rises ahead and to starboard, by least squares [-]."""
        rows = self.powers[0]
        along = [1 / (p + 1) if p % 2 == 0 else 3 / (p + 2) for p in range(len(rows[0]))]
        across = [1.0 if self.twin else 1 / (q + 1) if q % 2 == 0 else 3 / (q + 2) for q in range(len(rows))]

        def part(odd_p: int, odd_q: int) -> Array:
            return sum(
                along[p] * across[q] * rows[q][p]
                for q in range(odd_q, len(rows), 2)
                for p in range(odd_p, len(rows[0]), 2)
            )

        return part(0, 0), self.scale[0] * part(1, 0), self.scale[1] * part(0, 1)

    def at(self, forward: Array, starboard: Array, depth: Array) -> tuple[Array, Array]:
        """(elevation [m], dynamic pressure over rho g [m]) at places from the hull's origin, `depth` below z = 0."""
        u = dr.clip(forward * self.scale[0], -1.1, 1.1)
        v = dr.clip(starboard * self.scale[1], -1.6, 1.6)
        s = dr.clip(depth * self.scale[2], 0.0, 1.5)
        levels = [_horner([_horner(row, u) for row in level], v) for level in self.powers]
        return levels[0], _horner(levels, s)


def hull_waves(
    waves: Waves,
    north: Array,
    west: Array,
    heading: tuple[Array, Array],
    t: Array,
    plane: Waterplane,
    *,
    speed: Array | None = None,
) -> HullWaves:
    """Waves about a place.

    Args:
        waves: the sea.
        north, west: of the hull's origin [m].
        heading: cosine and sine of the compass heading.
        t: time [s].
        plane: of the hull.
        speed: of the place along the heading [m/s]: the acceleration is then that of the sheet of water which goes with
            the hull, at the frequency of encounter; None: of the water at a place that stays.
    """
    cos, sin = heading
    half = 0.5 * plane.length
    nodes = _Nodes.of(plane)
    nothing = 0 * (north + west + t + cos)

    def add(i: Array, *sums: Array) -> tuple[Array, ...]:
        first, second = waves._rows(i)
        ahead, aside = first[0] * cos - first[1] * sin, -(first[0] * sin + first[1] * cos)
        s, c = sincos_turns(dr.fma(first[0], north, dr.fma(first[1], west, dr.fma(-first[2], t, first[3]))))
        wave = second[0] * s, second[0] * c
        xs = [sincos_turns(float(x) * ahead) for x in nodes.places]
        ys = [sincos_turns(float(y) * aside) for y in nodes.sides]
        decays = [waves._decay(second[1], jit.Float64(-d * plane.draught), second) for d in (0.5, 1.0)]
        products = _products(wave, xs, ys, [d[2] for d in decays])
        grid = [dr.fma(part, x, total) for (part, x), total in zip(products, sums, strict=False)]
        towards = 2 * math.pi / second[1]
        # sides feel the motion half way down, bottoms that at the draught
        water = _Water(towards * ahead * decays[0][0], towards * aside * decays[0][0], decays[1][1])
        rate = 2 * math.pi * first[2]
        met = rate if speed is None else rate - 2 * math.pi * ahead * speed
        motion = _sheet(wave, (rate, met), water, nodes.fit(xs, ys))
        return i + 1, *grid, *(total + v for total, v in zip(sums[len(grid) :], motion, strict=True))

    count = 3 * len(_ALONG[0]) * len(plane.across[0])
    found = list(waves._loop(add, *([nothing] * (count + 12))))
    grid, motion = _along(found[:count], len(_ALONG[0])), found[count:]
    powers = _powers(grid, _ALONG[0], plane.across[0] / plane.sides, np.array([0.0, 0.5, 1.0]))
    return HullWaves(powers, motion[:6], motion[6:], (1 / half, 1 / plane.sides, 1 / plane.draught), plane.twin)


@dataclass(frozen=True)
class _Nodes:
    """Nodes of a waterplane forward of its middle and to starboard, for sums that are even or odd about it.

    Attributes:
        places, sides: [m].
        weights, shares: of both nodes at these distances; the centre line has the rest of the shares.
        spread_x, spread_y: mean squares of the distances [m^2].
    """

    places: NDArray[np.float64]
    sides: NDArray[np.float64]
    weights: NDArray[np.float64]
    shares: NDArray[np.float64]
    spread_x: float
    spread_y: float

    @classmethod
    def of(cls, plane: Waterplane) -> _Nodes:
        """Those of a hull."""
        x, wx = 0.5 * plane.length * _ALONG[0][len(_ALONG[0]) // 2 :], _ALONG[1][len(_ALONG[1]) // 2 :]
        across, share = plane.across
        y, wy = across[len(across) // 2 + 1 :], 2 * share[len(share) // 2 + 1 :]
        return cls(x, y, wx, wy, float(np.sum(wx * x**2)), float(np.sum(wy * y**2)))

    def fit(self, xs: Sequence[_Phase], ys: Sequence[_Phase]) -> tuple[Array, Array, Array]:
        """Means over the waterplane of cos(x) cos(y), and slopes of the best straight lines through sin(x) cos(y) along
        and cos(x) sin(y) across.
        """
        mean_x = sum(float(w) * c for w, (_, c) in zip(self.weights, xs, strict=True))
        lean_x = sum(float(w * p) * s for w, p, (s, _) in zip(self.weights, self.places, xs, strict=True))
        mean_y: Array = 1 - float(self.shares.sum())
        lean_y: Array = 0.0
        for w, p, (s, c) in zip(self.shares, self.sides, ys, strict=True):
            mean_y, lean_y = mean_y + float(w) * c, lean_y + float(w * p) * s
        return mean_x * mean_y, lean_x * (1 / self.spread_x) * mean_y, mean_x * lean_y * (1 / self.spread_y)


@dataclass
class _Water:
    """Motion of the water under a wave of 1 m and 1 rad/s: ahead and aside in phase, and upwards."""

    ahead: Array
    aside: Array
    up: Array


def _products(
    wave: _Phase, xs: Sequence[_Phase], ys: Sequence[_Phase], decays: Sequence[Array]
) -> list[tuple[Array, Array]]:
    """Factors of a wave's parts at the nodes: by level and column first what is even along the hull, then what is odd.

    cos(p + x + y) = (cos p cos y - sin p sin y) cos x - (sin p cos y + cos p sin y) sin x.
    """
    s, c = wave
    columns = [(s, c)]
    for sy, cy in ys:
        columns = [(s * cy - c * sy, c * cy + s * sy), *columns, (s * cy + c * sy, c * cy - s * sy)]
    levels = [columns, *([(d * s, d * c) for s, c in columns] for d in decays)]
    return [
        factors
        for level in levels
        for s, c in level
        for factors in (*((c, x[1]) for x in xs), *((s, x[0]) for x in xs))
    ]


def _sheet(wave: _Phase, rates: tuple[Array, Array], water: _Water, fit: tuple[Array, Array, Array]) -> list[Array]:
    """Velocity (6) and acceleration (6) of a wave's rigid sheet of water, see `HullWaves`; rates [rad/s]: of the wave,
    and at which the hull meets it.
    """
    s, c = wave
    rate, met = rates
    whole, nod, tilt = fit
    # velocity: forward and aside go with cos, upwards with sin; first moments turn cos to -sin and sin to cos
    cw, sw = rate * whole * c, rate * whole * s
    velocity = [water.ahead * cw, water.aside * cw, -water.up * sw]
    velocity += [-water.up * rate * tilt * c, water.up * rate * nod * c, -water.aside * rate * nod * s]
    fast = rate * met
    cw, sw = fast * whole * c, fast * whole * s
    change = [water.ahead * sw, water.aside * sw, water.up * cw]
    change += [-water.up * fast * tilt * s, water.up * fast * nod * s, water.aside * fast * nod * c]
    return [*velocity, *change]


def _along(sums: Sequence[Array], nodes: int) -> list[Array]:
    """From even and odd parts at the nodes forward of the middle, column by column, to values at all nodes."""
    values: list[Array] = []
    for i in range(0, len(sums), nodes):
        even, odd = sums[i : i + nodes // 2], sums[i + nodes // 2 : i + nodes]
        right = [e - o for e, o in zip(even, odd, strict=True)]
        left = [e + o for e, o in zip(even, odd, strict=True)]
        values += [*left[::-1], *right]
    return values


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

"""Waves along a slender body under water: its motion as that of a straight line of water, in one pass over the waves.

Strips of the body feel the water at their own places. Over a hull that is short against the waves that motion is its
mean and its change along the hull, found here by Gauss' three points: exact for motions up to the fifth power of the
distance, within 1 % for waves down to 1.5 hull lengths, while shorter ones are smoothed as a sum over strips smooths
them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector, add, matvec, scaled
from pelagos.jit import Array
from pelagos.math.turns import sincos_turns
from pelagos.ocean.waves import Waves

_PLACE: Final = math.sqrt(3 / 5)  # of half the length
_END: Final = 5 / 18  # weight of an end; the middle has 4 / 9


@dataclass
class SlenderMotion:
    """Motion of the water along a line, NWU.

    Attributes:
        elevation: of the surface over its middle [m].
        velocity, acceleration: means along it (3) [m/s], [m/s^2].
        velocity_change, acceleration_change: best straight line through them, per metre of it (3) [1/s], [1/s^2].
        gradient, gradient_change: of the velocity `(3, 3)`, row by component and column by direction: mean along the
            line [1/s], and best straight line through it [1/(m s)].
        length: of the line [m].
    """

    elevation: Array
    velocity: list[Array]
    acceleration: list[Array]
    velocity_change: list[Array]
    acceleration_change: list[Array]
    gradient: list[list[Array]]
    gradient_change: list[list[Array]]
    length: float

    def carried(self, current: Vector) -> list[Array]:
        """(c + u) . grad u, u the waves' velocity, in the mean along the line (3) [m/s^2].

        Straight lines through u and grad u make their product's mean that of the means and L^2/12 of the changes.
        `current`: velocity c that carries the water besides, NWU (3) [m/s].
        """
        spread = scaled(self.length**2 / 12, matvec(self.gradient_change, self.velocity_change))
        return add(matvec(self.gradient, add(current, self.velocity)), spread)


def slender_waves(
    waves: Waves, position: tuple[Array, Array, Array], axis: tuple[Array, Array, Array], length: float, t: Array
) -> SlenderMotion:
    """The waves along a line.

    Args:
        waves: the sea.
        position: of its middle, NWU (3) [m]; z from the mean surface. Above it the motion is held at z = 0.
        axis: unit vector along it, NWU (3).
        length: [m].
        t: time [s].
    """
    x, y, z = position
    half = 0.5 * length
    rise = _PLACE * half * axis[2]
    levels = [dr.minimum(z - rise, 0.0), dr.minimum(z, 0.0), dr.minimum(z + rise, 0.0)]
    weights = (_END, 1 - 2 * _END, _END)
    slope = 3 * _PLACE * _END / half

    def sum_up(i: Array, *sums: Array) -> tuple[Array, ...]:
        first, second = waves._rows(i)
        turns = dr.fma(first[0], x, dr.fma(first[1], y, dr.fma(-first[2], t, first[3])))
        s, c = sincos_turns(turns)
        ds, dc = sincos_turns(_PLACE * half * (first[0] * axis[0] + first[1] * axis[1]))
        k, rate = second[1], 2 * math.pi * first[2]
        cosines = (c * dc + s * ds, c, c * dc - s * ds)
        sines = (s * dc - c * ds, s, s * dc + c * ds)
        decay = [waves._decay(k, level, second) for level in levels]
        parts = []
        for which, wave in ((0, cosines), (1, sines), (0, sines), (1, cosines)):
            values = [d[which] * w for d, w in zip(decay, wave, strict=True)]
            mean = sum(w * v for w, v in zip(weights, values, strict=True))
            parts.append((mean, slope * (values[2] - values[0])))
        fast, towards = second[0] * rate, 2 * math.pi / k
        nx, ny, slow = towards * first[0], towards * first[1], fast * rate
        new = [second[0] * c]
        for j in (0, 1):
            ahead, up, ahead_rate, up_rate = (p[j] for p in parts)
            ahead, ahead_rate = fast * ahead, slow * ahead_rate
            new += [nx * ahead, ny * ahead, fast * up, nx * ahead_rate, ny * ahead_rate, -slow * up_rate]
        for j in (0, 1):
            sine, cosine = k * fast * parts[2][j], k * fast * parts[3][j]
            new += [-nx * nx * sine, -nx * ny * sine, -ny * ny * sine, nx * cosine, ny * cosine]
        return i + 1, *(a + b for a, b in zip(sums, new, strict=True))

    found = list(waves._loop(sum_up, *([0 * (x + y + z + t)] * 23)))
    return SlenderMotion(
        found[0], found[1:4], found[4:7], found[7:10], found[10:13], _potential(found[13:18]), _potential(found[18:]),
        length,
    )  # fmt: skip


def _potential(five: Vector) -> list[list[Array]]:
    """A gradient `(3, 3)` without curl or divergence from xx, xy, yy, xz, yz."""
    xx, xy, yy, xz, yz = five
    return [[xx, xy, xz], [xy, yy, yz], [xz, yz, -(xx + yy)]]

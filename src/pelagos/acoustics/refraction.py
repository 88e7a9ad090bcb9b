"""Rays of sonars in water whose sound speed changes with depth: a few arcs of equal travel time, in single precision.

Echoes need places at given times, between casts into the world; `layered_rays` follows the same rays to given places,
layer by layer and in double precision. Both take their arcs from `ray_arc`; here one arc stands for all layers that it
passes through, and the exact rays are what it is held against.
"""

from __future__ import annotations

from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.ray_arc import chord_of, curvature, rotated, snell_invariant, turn_between
from pelagos.jit import Array

LEVELS: Final = 64  # of a profile on the device
_ROUNDS: Final = 4  # in which an arc finds its own end
_LEVEL: Final = 0.1  # [m], rise of an arc below which its layer's own gradient counts


@jit.struct
class Profile:
    """Sound speed against height at some places, one row each, linear between its levels: a Dr.Jit struct.

    Attributes:
        excess: `Float` rows by `LEVELS`, sound speed over that at height 0 [m/s].
        column: `Float` rows by `LEVELS`, integral of `excess` over the height from height 0 on [m^2/s].
        speed: `Float`, sound speed at height 0 [m/s].
        lowest, step: `Float`, height of the first level and distance of levels [m], z up; beyond its ends the water is
            as at the ends.
    """

    excess: Array
    column: Array
    speed: Array
    lowest: Array
    step: Array

    @property
    def size_key(self) -> int:
        """Number of rows."""
        return len(self.speed)


@jit.struct
class Bend:
    """A ray on its way, one lane a ray: a Dr.Jit struct.

    Attributes:
        row: `UInt32`, of the profile.
        height: `Float`, where it is, relative to the profile's height 0 [m].
        sine, cosine: `Float`, of its angle above the horizontal.
        slowness: `Float`, Snell's invariant cos(theta)/c [s/m].
    """

    row: Array
    height: Array
    sine: Array
    cosine: Array
    slowness: Array


@jit.struct
class Chord:
    """The straight line between both ends of an arc: a Dr.Jit struct.

    Attributes:
        length: `Float` [m].
        sine, cosine: `Float`, of its angle above the horizontal.
        turn: `Float`, by which the ray's angle has grown over the arc [rad].
        skew: `Float`, see `reduced_range` [1].
    """

    length: Array
    sine: Array
    cosine: Array
    turn: Array
    skew: Array


def profile_from(excess: Array, speed: Array, lowest: Array, step: Array) -> Profile:
    """A profile with its integral (trapezoidal, as the profile is linear between its levels).

    The integral begins at height 0: there nearly level rays take the difference of two values, which would drown in
    the rounding of an integral over all the water below.
    """
    rows = dr.width(speed)
    row = dr.arange(jit.UInt32, rows) * LEVELS
    height, place = jit.Float64(step), -jit.Float64(lowest) / jit.Float64(step)
    totals = dr.zeros(jit.Float64, rows * LEVELS)

    def climb(k: Array, total: Array, base: Array, below: Array) -> tuple[Array, ...]:
        above = dr.gather(jit.Float, excess, row + k)
        part = place - (jit.Float64(k) - 1.0)
        here = jit.Float64(below) + part * jit.Float64(above - below)
        to_here = total + 0.5 * part * height * (jit.Float64(below) + here)
        total = total + 0.5 * height * jit.Float64(below + above)
        dr.scatter(totals, total, row + k, mode=dr.ReduceMode.Permute)
        return k + 1, total, dr.select((part >= 0.0) & (part < 1.0), to_here, base), above

    none = dr.zeros(jit.Float64, rows)
    start = (dr.full(jit.UInt32, 1, rows), none, none, dr.gather(jit.Float, excess, row))
    base = dr.while_loop(start, lambda k, *_: k < LEVELS, climb, mode="symbolic")[2]
    dr.eval(totals, base)
    level = dr.arange(jit.UInt32, rows * LEVELS)
    column = jit.Float(totals - dr.gather(jit.Float64, base, level // LEVELS))
    dr.eval(column)
    return Profile(excess, column, speed, lowest, step)


def excess_at(profile: Profile, row: Array, height: Array) -> tuple[Array, Array, Array]:
    """Sound speed over that at height 0 [m/s], its gradient in that layer [1/s], and the profile's `column` there."""
    step, lowest = dr.gather(jit.Float, profile.step, row), dr.gather(jit.Float, profile.lowest, row)
    place = (height - lowest) / step
    inside = dr.clip(place, 0.0, LEVELS - 1.0)
    layer = dr.minimum(jit.UInt32(inside), LEVELS - 2)
    index, part = row * LEVELS + layer, inside - jit.Float(layer)
    low = dr.gather(jit.Float, profile.excess, index)
    rise = dr.gather(jit.Float, profile.excess, index + 1) - low
    here = dr.fma(rise, part, low)
    column = dr.gather(jit.Float, profile.column, index) + step * (0.5 * part * (low + here) + (place - inside) * here)
    return here, rise / step, column


def depart(profile: Profile, row: Array, height: Array, sine: Array) -> Bend:
    """A ray at `height` [m] whose angle above the horizontal has this `sine`."""
    cosine = dr.sqrt(dr.maximum(1.0 - sine * sine, 0.0))
    speed = dr.gather(jit.Float, profile.speed, row) + excess_at(profile, row, height)[0]
    return Bend(row, height, sine, cosine, snell_invariant(cosine, speed))


def arc(profile: Profile, ray: Bend, reach: Array) -> tuple[Bend, Chord]:
    """Follow a ray along one arc.

    In a linear gradient the arc is the circle that the ray is.
    In layers, the angle at its end is what Snell's law gives there, exactly; direction and duration follow from the
    mean sound speed of the layers that it passes through, to first order in how that departs from the mean of both
    ends. What is left is of second order in the turn over the arc: a tenth of the arc's length times its square.

    Args:
        reach: c at height 0 times the time under way [m].

    Returns:
        the ray at the end of the arc, and the arc's chord.
    """
    speed = dr.gather(jit.Float, profile.speed, ray.row)
    here, slope, column = excess_at(profile, ray.row, ray.height)
    length, turn, shift = jit.Float(reach), curvature(slope, ray.slowness) * reach, jit.Float(0)
    there = here
    for _ in range(_ROUNDS):
        middle = _ahead(ray, 0.5 * turn)[0]
        rise = chord_of(length, turn) * _ahead(ray, 0.5 * turn + shift)[0]
        there, slope, above = excess_at(profile, ray.row, ray.height + rise)
        ends = 0.5 * (here + there)
        flat = (dr.abs(rise) < _LEVEL) | (dr.abs(middle) < 1e-3)
        mean = dr.select(flat, ends, (above - column) / dr.select(flat, 1.0, rise))
        steep = dr.select(flat, 1.0, middle)
        by_snell = turn_between(ray.slowness, there - here, steep)
        turn = dr.select(flat, curvature(slope, ray.slowness) * length, by_snell)
        shift = dr.select(flat, 0.0, ray.slowness * (ends - mean) / steep)
        shift = dr.clip(shift, -0.5 * dr.abs(turn), 0.5 * dr.abs(turn))
        varied = (there - here) / (speed + mean)
        length = reach / (1.0 - mean / (speed + mean) + varied * varied * (speed / (speed + mean) / 12.0))
    chord = chord_of(length, turn)
    sine, cosine = _ahead(ray, 0.5 * turn + shift)
    after = Bend(ray.row, ray.height + chord * sine, *_ahead(ray, turn), ray.slowness)
    return after, Chord(chord, sine, cosine, turn, (there - here) / (2.0 * speed + here + there))


def reduced_range(chord: Chord, part: Array, reach: Array) -> Array:
    """c at height 0 times the time to a `part` (0 .. 1) of an arc that takes `reach` in all [m].

    The slowness is linear along it to first order.
    """
    return reach * part * (1.0 + chord.skew * (1.0 - part))


def turned(direction: Array, sine: Array, cosine: Array) -> Array:
    """`Array3f`: the vertical plane of `direction`, another angle above the horizontal."""
    horizontal = dr.sqrt(direction.x * direction.x + direction.y * direction.y)
    scale = cosine / dr.maximum(horizontal, 1e-9)
    return jit.Array3f(direction.x * scale, direction.y * scale, sine)


def path_end(profile: Profile, row: Array, direction: Array, reach: Array, *, arcs: int) -> Array:
    """`Array3f` [m]: how far from its start a ray is after the time `reach`/c, c at height 0 where it starts."""
    ray, place = depart(profile, row, dr.zeros(jit.Float, dr.width(reach)), direction.z), jit.Array3f(0)
    for _ in range(arcs):
        ray, chord = arc(profile, ray, reach * (1.0 / arcs))
        place += chord.length * turned(direction, chord.sine, chord.cosine)
    return place


def _ahead(ray: Bend, turn: Array) -> tuple[Array, Array]:
    """Sine and cosine of the ray's angle after a turn [rad]."""
    return rotated(ray.sine, ray.cosine, turn)


def entered(before: Profile, ray: Bend, after: Profile, row: Array) -> Bend:
    """A ray that goes on in another profile: across a vertical boundary square to its way, along which sin(theta)/c
    stays as it is. Of slow changes along the way it follows the vertical part, to first order in their size."""
    old = dr.gather(jit.Float, before.speed, ray.row) + excess_at(before, ray.row, ray.height)[0]
    new = dr.gather(jit.Float, after.speed, row) + excess_at(after, row, ray.height)[0]
    sine = dr.clip(ray.sine * new / old, -1.0, 1.0)
    cosine = dr.sqrt(dr.maximum(1.0 - sine * sine, 0.0))
    return Bend(row, ray.height, sine, cosine, snell_invariant(cosine, new))


def displacements(depths: NDArray[np.float64], speeds: NDArray[np.float64], reach: float) -> NDArray[np.float64]:
    """Largest bend of a level ray aside over `reach` [m], in parts of it: reach |c'|/(2 c), by column of water.

    Gradients are taken over a twentieth of the reach, the height that such a ray passes through.

    Args:
        depths: `(d,)`, increasing [m].
        speeds: `(columns, d)` [m/s].
    """
    span = max(reach / 20.0, 1e-3)
    below = np.minimum(np.searchsorted(depths, depths[:-1] + span), len(depths) - 1)
    fall = depths[below] - depths[:-1]
    gradient = np.abs(speeds[:, below] - speeds[:, :-1]) / fall
    return np.asarray((reach * gradient / (2.0 * speeds[:, :-1])).max(axis=1))

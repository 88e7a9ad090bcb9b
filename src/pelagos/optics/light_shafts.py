"""Shafts of light: the waves' pattern in the sun's beam, in what the water scatters of it along a line of sight.

The line is walked from the eye in growing steps; each asks the maps of focused light (`caustics`) for the nearest cell.
Where the line runs along the sun's rays the pattern stays the same and is seen; across them it averages out.
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.caustics import CELLS, PLANES, TILE, Waves, map_of
from pelagos.optics.light_field import LightField, pattern_left

_STEPS: Final = 32
_MARKS: Final = 4  # distances for which the pattern is kept
_FIRST: Final = 0.12  # [m]
_GROWTH: Final = 1.08


def shafts(
    waves: Waves, field: LightField, place: Array, depth: Array, direction: Array, lane: Array, jitter: Array
) -> Array:
    """By how much scattered sunlight is more or less than under a calm sea, up to four distances: `Array4f`, mean 0.

    Args:
        waves: maps of the moment.
        field: of the water.
        place: x, y of where the lines start, `Array2f` world [m].
        depth: of the same [m].
        direction: unit `Array3f`.
        lane: `UInt32`, row of `waves`.
        jitter: 0 .. 1 of a step, by line.
    """
    to_sun = field.below
    rate = field.loss.y * (1 - direction.z / to_sun.z)
    left = pattern_left(field, 1.0)

    def step(k: Array, length: Array, way: Array, more: Array, whole: Array, marks: Array) -> tuple[Array, ...]:
        s = way + jitter * length
        below = depth - direction.z * s
        back = below / to_sun.z
        x, y = place.x + direction.x * s + back * to_sun.x, place.y + direction.y * s + back * to_sun.y
        focus = _nearest(waves, x, y, below, lane)
        weight = dr.select(below > 0, length * dr.exp(-rate * s), 0)
        kept = dr.power(left, dr.maximum(below, 0)) * dr.clip(below / PLANES[0], 0, 1)
        more, whole = more + weight * kept * (focus - 1), whole + weight
        mean = more / dr.maximum(whole, 1e-12)
        marked = [dr.select((k + 1) * _MARKS <= _STEPS * (m + 1), mean, marks[m]) for m in range(_MARKS)]
        return k + 1, length * _GROWTH, way + length, more, whole, jit.Array4f(*marked)

    zero = dr.zeros(jit.Float, dr.width(depth))
    start = (jit.UInt32(0), jit.Float(_FIRST), jit.Float(0), zero, zero + 0, jit.Array4f(zero))
    return dr.while_loop(start, lambda k, *_: k < _STEPS, step, mode="symbolic")[-1]


def shaft_gain(kept: Array, distance: Array) -> Array:
    """Factor on scattered sunlight along a line that ends at `distance` [m], from what `shafts` gives."""
    steps = dr.log2(1 + dr.maximum(distance, 0) * ((_GROWTH - 1) / _FIRST)) * (1 / math.log2(_GROWTH))
    u = dr.clip(steps * (_MARKS / _STEPS) - 1, 0, _MARKS - 1)
    value = kept[0]
    for m in range(1, _MARKS):
        value = dr.lerp(value, kept[m], dr.clip(u - (m - 1), 0, 1))
    return dr.maximum(1 + value, 0)


def _nearest(waves: Waves, x: Array, y: Array, depth: Array, lane: Array) -> Array:
    """Focused light at the nearest cell of the nearest map."""
    step = dr.log2(dr.maximum(depth, 1e-3) / PLANES[0]) * (1 / math.log2(PLANES[1] / PLANES[0]))
    plane = jit.UInt32(dr.clip(step + 0.5, 0, len(PLANES) - 1))
    i, j = (jit.UInt32(jit.Int32(dr.floor(v * (CELLS / TILE) + 0.5)) & (CELLS - 1)) for v in (x, y))
    return dr.gather(jit.Float, waves.focus, ((map_of(waves, lane) * len(PLANES) + plane) * CELLS + i) * CELLS + j)

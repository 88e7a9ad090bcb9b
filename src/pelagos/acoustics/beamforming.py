"""From one field a beam sector to beams with side lobes, and from bins to a pulse with side lobes."""

from __future__ import annotations

from dataclasses import dataclass

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


@dataclass
class Field:
    """Echoes by cell (lanes x beams x bins, bins fastest), a Dr.Jit struct.

    Attributes:
        real, imaginary: `Float`, complex amplitude.
        energy: `Float`, mean intensity without interference.
    """

    real: Array
    imaginary: Array
    energy: Array


def convolve(field: Field, taps: Array, *, count: int, length: int, stride: int, rows: bool) -> Field:
    """Weighted sum over neighbours along one axis of a field.

    Args:
        field: cells.
        taps: `Float`, amplitude weights, `count` of them, or `(length, count)` of them where each place has its own.
        count: odd number of neighbours, centred.
        length: size of the axis.
        stride: distance of neighbours in memory.
        rows: whether every place on the axis has its own weights.
    """
    if count == 1 and not rows:
        return field
    reach = count // 2
    packed = dr.ravel(jit.Array4f(field.real, field.imaginary, field.energy, 0.0))
    cell = dr.arange(jit.UInt32, dr.width(field.real))
    place = (cell // stride) % length
    first = place * count if rows else jit.UInt32(0)
    real, imaginary, energy = jit.Float(0), jit.Float(0), jit.Float(0)
    for k in range(count):
        shift = k - reach
        there = jit.Int32(place) + shift
        inside = (there >= 0) & (there < length)
        index = dr.select(inside, jit.UInt32(jit.Int32(cell) + shift * stride), cell)
        weight = dr.select(inside, dr.gather(jit.Float, taps, first + k), 0.0)
        value = dr.gather(jit.Array4f, packed, index)
        real = dr.fma(weight, value[0], real)
        imaginary = dr.fma(weight, value[1], imaginary)
        energy = dr.fma(weight * weight, value[2], energy)
    return Field(real, imaginary, energy)

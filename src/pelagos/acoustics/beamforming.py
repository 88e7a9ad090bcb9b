"""From one field a beam sector to beams with side lobes, and from bins to a pulse with side lobes."""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


@jit.struct
class Field:
    """Echoes by cell (lanes x beams x bins, bins fastest), a Dr.Jit struct.

    Attributes:
        real, imaginary: `Float`, complex amplitude.
        energy: `Float`, mean intensity without interference.
    """

    real: Array
    imaginary: Array
    energy: Array


def form_beams(field: Field, steering: Array, *, reach: int, energy_reach: int, beams: int, bins: int) -> Field:
    """Let every beam hear its neighbours.

    Args:
        field: cells, one beam a sector.
        steering: `Float` `(beams, 2 reach + 1)`, amplitude weights, 0 for neighbours that do not exist.
        reach: neighbours on each side.
        energy_reach: neighbours on each side that add to the mean energy, which is scaled up for the rest.
        beams, bins: size of an image.
    """
    cell = dr.arange(jit.Int32, dr.width(field.real))
    first = jit.UInt32(cell // bins % beams) * (2 * reach + 1)
    real, imaginary, energy, captured = jit.Float(0), jit.Float(0), jit.Float(0), jit.Float(0)
    for k in range(2 * reach + 1):
        shift = k - reach
        there = jit.UInt32(dr.clip(cell + shift * bins, 0, dr.width(field.real) - 1))
        weight = dr.gather(jit.Float, steering, first + k)
        real = dr.fma(weight, dr.gather(jit.Float, field.real, there), real)
        imaginary = dr.fma(weight, dr.gather(jit.Float, field.imaginary, there), imaginary)
        if abs(shift) <= energy_reach:
            energy = dr.fma(weight * weight, dr.gather(jit.Float, field.energy, there), energy)
            captured = dr.fma(weight, weight, captured)
    return Field(real, imaginary, energy / captured)


def spread_pulse(field: Field, pulse: Array, *, count: int, bins: int) -> Field:
    """Convolve with the pulse along the range; `pulse` `Float` `(count,)`, odd, amplitude weights."""
    if count == 1:
        return field
    cell = dr.arange(jit.Int32, dr.width(field.real))
    bin_ = cell % bins
    real, imaginary, energy = jit.Float(0), jit.Float(0), jit.Float(0)
    for k in range(count):
        shift = k - count // 2
        inside = (bin_ + shift >= 0) & (bin_ + shift < bins)
        there = jit.UInt32(cell + shift)
        weight = dr.gather(jit.Float, pulse, jit.UInt32(k))
        real = dr.fma(weight, dr.gather(jit.Float, field.real, there, inside), real)
        imaginary = dr.fma(weight, dr.gather(jit.Float, field.imaginary, there, inside), imaginary)
        energy = dr.fma(weight * weight, dr.gather(jit.Float, field.energy, there, inside), energy)
    dr.eval(real, imaginary, energy)  # else every neighbour's pulse is computed again for every beam that hears it
    return Field(real, imaginary, energy)

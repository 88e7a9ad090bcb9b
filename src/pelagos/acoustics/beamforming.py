"""From one field a beam sector to beams with side lobes, and from bins to a pulse with side lobes."""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


@jit.struct
class Field:
    """Echoes by cell (pings x beams x bins, bins fastest), a Dr.Jit struct.

    Attributes:
        signal: `UInt64`, complex amplitude: a pair of `Float`, see `pair`.
        energy: `Float`, mean intensity without interference.
    """

    signal: Array
    energy: Array


def pair(low: Array, high: Array) -> Array:
    """Two `Float` as one `UInt64`, which is read from memory at the cost of one."""
    low, high = dr.reinterpret_array(jit.UInt32, low), dr.reinterpret_array(jit.UInt32, high)
    return jit.UInt64(low) | (jit.UInt64(high) << 32)


def unpair(word: Array) -> tuple[Array, Array]:
    """The two `Float` of a `pair`."""
    low, high = jit.UInt32(word & 0xFFFFFFFF), jit.UInt32(word >> 32)
    return dr.reinterpret_array(jit.Float, low), dr.reinterpret_array(jit.Float, high)


def spread_pulse(echoes: Array, source: Array, exists: Array, pulse: Array, *, count: int, bins: int) -> Field:
    """Convolve echoes with the pulse along the range.

    Args:
        echoes: four `Float` a cell, see `accumulate`.
        source, exists: cell, `Int32`, that each cell reads, and whether there is one.
        pulse: `Float` `(count,)`, odd, amplitude weights.
        count, bins: samples of the pulse, range bins of a beam.
    """
    bin_ = source % bins
    real, imaginary, energy = jit.Float(0), jit.Float(0), jit.Float(0)
    for k in range(count):
        shift = k - count // 2
        inside = exists & (bin_ + shift >= 0) & (bin_ + shift < bins) if shift != 0 else exists
        value = dr.gather(jit.Array4f, echoes, jit.UInt32(source + shift), inside)
        weight = dr.gather(jit.Float, pulse, jit.UInt32(k))
        real = dr.fma(weight, value[0], real)
        imaginary = dr.fma(weight, value[1], imaginary)
        energy = dr.fma(weight * weight, value[2], energy)
    field = Field(pair(real, imaginary), energy)
    dr.eval(field)  # else every neighbour's pulse is computed again for every beam that hears it
    return field


def form_beams(
    field: Field,
    steering: Array,
    first: Array,
    row: Array,
    bin_: Array,
    *,
    count: int,
    reach: int,
    energy_reach: int,
    beams: int,
    bins: int,
) -> list[tuple[Array, Array, Array]]:
    """What `count` neighbouring beams hear in a bin, their own sectors and those on both sides.

    Args:
        field: one beam a sector.
        steering: `Float` `(beams, 2 reach + 1)`, amplitude weights, 0 for neighbours that do not exist.
        first: `Int32`, the first of the beams.
        row: `Int32`, its ping times `beams`.
        bin_: `Int32`.
        count: how many beams; those beyond the last one are worth nothing.
        reach: neighbours on each side.
        energy_reach: neighbours on each side that add to the mean energy, which is scaled up for the rest.
        beams, bins: size of an image.

    Returns:
        real and imaginary amplitude and energy of each beam.
    """

    def cell(shift: int) -> Array:
        return jit.UInt32((row + dr.clip(first + shift, 0, beams - 1)) * bins + bin_)

    heard = [unpair(dr.gather(jit.UInt64, field.signal, cell(s))) for s in range(-reach, count + reach)]
    energies = [dr.gather(jit.Float, field.energy, cell(s)) for s in range(-energy_reach, count + energy_reach)]
    formed = []
    for i in range(count):
        start = jit.UInt32(dr.minimum(first + i, beams - 1)) * (2 * reach + 1)
        real, imaginary, energy, captured = jit.Float(0), jit.Float(0), jit.Float(0), jit.Float(0)
        for k in range(2 * reach + 1):
            weight = dr.gather(jit.Float, steering, start + k)
            real = dr.fma(weight, heard[i + k][0], real)
            imaginary = dr.fma(weight, heard[i + k][1], imaginary)
            if abs(k - reach) <= energy_reach:
                power = weight * weight
                energy = dr.fma(power, energies[i + k - reach + energy_reach], energy)
                captured += power
        formed.append((real, imaginary, energy / captured))
    return formed

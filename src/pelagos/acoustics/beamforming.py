"""From one field a beam sector to beams with side lobes, and from bins to a pulse with side lobes."""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo_sum import pitch
from pelagos.jit import Array


def spread_pulse(echoes: Array, pulse: Array, *, count: int, bins: int) -> Array:
    """Convolve echoes with the pulse along the range.

    Args:
        echoes: four `Float` a cell, see `accumulate`.
        pulse: `Float` `(count,)`, odd, amplitude weights.
        count, bins: samples of the pulse, range bins of a beam, whose rows are `pitch(bins)` apart.

    Returns:
        the same of the convolved echoes, in memory: else every beam that hears a neighbour would compute its pulse.
    """
    cell = dr.arange(jit.Int32, dr.width(echoes) // 4)
    bin_ = cell % pitch(bins)
    total = dr.zeros(jit.Array3f)
    for k in range(count):
        at = bin_ + (k - count // 2)
        value = dr.gather(jit.Array4f, echoes, jit.UInt32(cell + (k - count // 2)), (at >= 0) & (at < bins))
        total += taken(value, dr.gather(jit.Float, pulse, jit.UInt32(k)))
    spread = dr.ravel(jit.Array4f(*total, 0.0))
    dr.eval(spread)
    return spread


def taken(value: Array, weight: Array) -> Array:
    """Complex amplitude and energy (`value[0]` to `value[2]`), times an amplitude weight."""
    return jit.Array3f(value[0] * weight, value[1] * weight, value[2] * (weight * weight))


@jit.struct
class Weights:
    """How neighbouring beams hear their neighbours, one lane a group of beams: a Dr.Jit struct.

    Attributes:
        amplitude: for each beam of a group the `Float` weights of itself and its neighbours.
        captured: for each beam the `Float` sum of the squares of those that count for its energy.
    """

    amplitude: list[list[Array]]
    captured: list[Array]


def weights(steering: Array, first: Array, *, count: int, reach: int, energy_reach: int, beams: int) -> Weights:
    """The weights of `count` beams from `first` on; see `form_beams`."""
    amplitude = []
    for i in range(count):
        start = jit.UInt32(dr.minimum(first + i, beams - 1)) * (2 * reach + 1)
        amplitude.append([dr.gather(jit.Float, steering, start + k) for k in range(2 * reach + 1)])
    near = slice(reach - energy_reach, reach + energy_reach + 1)
    return Weights(amplitude, [1.0 / sum(w * w for w in row[near]) for row in amplitude])


def form_beams(
    echoes: Array,
    weights: Weights,
    first: Array,
    shift: Array,
    row: Array,
    bin_: Array,
    *,
    reach: int,
    energy_reach: int,
    beams: int,
    bins: int,
) -> list[Array]:
    """What neighbouring beams hear in a bin, their own sectors and those on both sides.

    Args:
        echoes: four `Float` a cell, see `accumulate`; one beam a sector.
        weights: of these beams, 0 for neighbours that do not exist.
        first: `Int32`, the first of the beams.
        shift: `Int32`, beams that the sonar turned since the sound was sent.
        row: `Int32`, the ping times `beams`.
        bin_: `Int32`; outside the image nothing is heard.
        reach: neighbours on each side.
        energy_reach: neighbours on each side that add to the mean energy, which is scaled up for the rest.
        beams, bins: size of an image, whose rows are `pitch(bins)` apart.

    Returns:
        `Array3f` of each beam: real and imaginary amplitude, energy; those beyond the last beam are worth nothing.
    """
    count = len(weights.amplitude)
    inside = (bin_ >= 0) & (bin_ < bins)

    def heard(k: int) -> Array:
        sent = dr.clip(first + k, 0, beams - 1) - shift
        cell = jit.UInt32((row + sent) * pitch(bins) + bin_)
        return dr.gather(jit.Array4f, echoes, cell, inside & (sent >= 0) & (sent < beams))

    sectors = [heard(k) for k in range(-reach, count + reach)]
    formed = []
    for i, (row_weights, captured) in enumerate(zip(weights.amplitude, weights.captured, strict=True)):
        real, imaginary, energy = jit.Float(0), jit.Float(0), jit.Float(0)
        for k, weight in enumerate(row_weights):
            sector = sectors[i + k]
            real, imaginary = dr.fma(weight, sector[0], real), dr.fma(weight, sector[1], imaginary)
            if abs(k - reach) <= energy_reach:
                energy = dr.fma(weight * weight, sector[2], energy)
        formed.append(jit.Array3f(real, imaginary, energy * captured))
    return formed

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
        weight = dr.gather(jit.Float, pulse, jit.UInt32(k))
        total = added(total, value, weight, weight * weight)
    spread = dr.ravel(jit.Array4f(*total, 0.0))
    dr.eval(spread)
    return spread


def added(total: Array, value: Array, amplitude: Array, energy: Array) -> Array:
    """`total`, real and imaginary amplitude and energy, plus `value` times its weights of amplitude and of energy."""
    real, imaginary = dr.fma(amplitude, value[0], total[0]), dr.fma(amplitude, value[1], total[1])
    return jit.Array3f(real, imaginary, dr.fma(energy, value[2], total[2]))


@jit.struct
class Weights:
    """How neighbouring beams hear their neighbours, one lane a group of beams: a Dr.Jit struct.

    Attributes:
        amplitude: for each beam of a group the `Float` weights of itself and its neighbours.
        energy: their squares, of those that count for its energy, to a sum of 1.
    """

    amplitude: list[list[Array]]
    energy: list[list[Array]]


def weights(steering: Array, first: Array, *, count: int, reach: int, energy_reach: int, beams: int) -> Weights:
    """The weights of `count` beams from `first` on; see `form_beams`."""
    amplitude = []
    for i in range(count):
        start = jit.UInt32(dr.minimum(first + i, beams - 1)) * (2 * reach + 1)
        amplitude.append([dr.gather(jit.Float, steering, start + k) for k in range(2 * reach + 1)])
    energy = []
    for row in amplitude:
        squares = [w * w for w in row[reach - energy_reach : reach + energy_reach + 1]]
        captured = 1.0 / sum(squares)
        energy.append([s * captured for s in squares])
    return Weights(amplitude, energy)


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
    count, inner = len(weights.amplitude), reach - energy_reach
    inside = (bin_ >= 0) & (bin_ < bins)
    start = first - shift
    cell = jit.UInt32((row + start) * pitch(bins) + bin_)

    def heard(k: int) -> Array:
        exists = jit.UInt32(start + k) < beams  # negative ones are large
        return dr.gather(jit.Array4f, echoes, cell + jit.UInt32(k * pitch(bins) % 2**32), inside & exists)

    sectors = [heard(k) for k in range(-reach, count + reach)]
    formed = []
    for i, (amplitude, energy) in enumerate(zip(weights.amplitude, weights.energy, strict=True)):
        heard_here = sectors[i : i + len(amplitude)]
        real = _weighted(amplitude, [s[0] for s in heard_here])
        imaginary = _weighted(amplitude, [s[1] for s in heard_here])
        power = _weighted(energy, [s[2] for s in heard_here[inner : inner + len(energy)]])
        formed.append(jit.Array3f(real, imaginary, power))
    return formed


def _weighted(weights: list[Array], values: list[Array]) -> Array:
    """Sum of products."""
    total = jit.Float(0)
    for weight, value in zip(weights, values, strict=True):
        total = dr.fma(weight, value, total)
    return total

"""From one field a beam sector to beams with side lobes, and from bins to a pulse with side lobes."""

from __future__ import annotations

from typing import Any, Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.echo_walk import pitch
from pelagos.jit import Array

_LONG: Final = 200  # samples of a pulse beyond which fewer are taken
_TAPS: Final = 100  # of them, then
_WIDE_BLOCK: Final = 8  # beams that read a sector once
_PACKETS: Final = {1: "Float", 2: "Array2f"}  # a cell of as many channels


def cell_at(echoes: Array, cell: Array, where: Array, channels: int) -> list[Array]:
    """The channels of a cell, 0 except `where`."""
    kind = getattr(jit, _PACKETS[channels])
    found = dr.gather(kind, echoes, cell, where)
    return [found] if channels == 1 else list(found)


def spread_pulse(echoes: Array, pulse: Array, *, channels: int, bins: int) -> Array:
    """Convolve echoes with the pulse along the range.

    Args:
        echoes: `channels` `Float` a cell.
        pulse: `Float`, an odd number of weights.
        channels: of a cell.
        bins: of a beam, whose rows are `pitch(bins)` apart.

    Returns:
        the same of the convolved echoes, in memory: else every beam that hears a neighbour would compute its pulse.
    """
    count = dr.width(pulse)
    if count > _LONG:
        return _spread_coarsely(echoes, pulse, channels=channels, bins=bins, step=-(-count // _TAPS))
    cell = dr.arange(jit.Int32, dr.width(echoes) // channels)
    bin_ = cell % pitch(bins)
    total = [jit.Float(0)] * channels
    for k in range(count):
        at = bin_ + (k - count // 2)
        values = cell_at(echoes, jit.UInt32(cell + (k - count // 2)), (at >= 0) & (at < bins), channels)
        total = added(total, values, dr.gather(jit.Float, pulse, jit.UInt32(k)))
    spread = total[0] if channels == 1 else dr.ravel(getattr(jit, _PACKETS[channels])(*total))
    dr.eval(spread)
    return spread


def _spread_coarsely(echoes: Array, pulse: Array, *, channels: int, bins: int, step: int) -> Array:
    """The same for long pulses: echoes summed over `step` bins, pulses sampled as coarsely, lines between the results.

    Of c/(2B) some twenty samples are left: what is heard is within a percent of the peak.
    """
    kind = getattr(jit, _PACKETS[channels])
    count, row = dr.width(pulse), pitch(bins)
    rows = dr.width(echoes) // channels // row
    coarse = -(-bins // step) + 2  # one more on either side, to draw lines to
    node = dr.arange(jit.Int32, rows * coarse)
    first = (node % coarse - 1) * step

    def gathered(k: Array, total: Any) -> tuple[Array, Any]:
        at = first + k
        cell = jit.UInt32(node // coarse * row + at)
        return k + 1, total + dr.gather(kind, echoes, cell, (at >= 0) & (at < bins))

    start = (dr.zeros(jit.Int32, dr.width(node)), dr.zeros(kind, dr.width(node)))
    _, blocks = dr.while_loop(start, lambda k, _: k < step, gathered, mode="symbolic")
    blocks = blocks if channels == 1 else dr.ravel(blocks)
    dr.eval(blocks)
    half = count // 2 // step

    def heard(k: Array, total: Any) -> tuple[Array, Any]:
        at = node % coarse + k
        values = dr.gather(kind, blocks, jit.UInt32(node + k), (at >= 0) & (at < coarse))
        return k + 1, total + dr.gather(jit.Float, pulse, jit.UInt32(count // 2 + k * step)) * values

    start = (dr.full(jit.Int32, -half, dr.width(node)), dr.zeros(kind, dr.width(node)))
    _, formed = dr.while_loop(start, lambda k, _: k <= half, heard, mode="symbolic")
    formed = formed if channels == 1 else dr.ravel(formed)
    dr.eval(formed)

    cell = dr.arange(jit.Int32, rows * row)
    place = (jit.Float(cell % row) + 0.5) / step + 0.5  # in nodes: the middle of block 0 is node 1
    low = dr.minimum(jit.Int32(place), coarse - 2)
    below, above = (dr.gather(kind, formed, jit.UInt32(cell // row * coarse + low + i)) for i in (0, 1))
    spread = dr.lerp(below, above, place - jit.Float(low))
    spread = spread if channels == 1 else dr.ravel(spread)
    dr.eval(spread)
    return spread


def added(total: list[Array], values: list[Array], weight: Array) -> list[Array]:
    """`total` plus `values` times `weight`, by channel."""
    return [dr.fma(weight, value, so_far) for value, so_far in zip(values, total, strict=True)]


def amplitude_weights(steering: Array, first: Array, *, count: int, reach: int, beams: int) -> list[list[Array]]:
    """For `count` beams from `first` on, how each hears itself and its `reach` neighbours on both sides."""
    rows = []
    for i in range(count):
        start = jit.UInt32(dr.minimum(first + i, beams - 1)) * (2 * reach + 1)
        rows.append([dr.gather(jit.Float, steering, start + k) for k in range(2 * reach + 1)])
    return rows


def energy_weights(amplitudes: list[list[Array]], reach: int) -> list[list[Array]]:
    """The squares of each beam's amplitude weights within `reach` neighbours, to a sum of 1."""
    rows = []
    for row in amplitudes:
        middle = len(row) // 2
        squares = [w * w for w in row[middle - reach : middle + reach + 1]]
        captured = 1.0 / sum(squares)
        rows.append([s * captured for s in squares])
    return rows


def steer_widely(
    echoes: Array, steering: Array, *, channels: int, beams: int, bins: int, squared: bool = False
) -> Array:
    """Signals of every beam from all sectors, however far away: as `form_beams` over a whole array, in memory.

    Args:
        echoes: `channels` `Float` a cell, one beam a sector, whose rows are `pitch(bins)` apart.
        steering: `(beams, 2 beams - 1)`, see `steering_matrix`.
        channels: of a cell.
        beams, bins: size of an image.
        squared: echoes are energies: weights count by their squares.
    """
    kind, row = getattr(jit, _PACKETS[channels]), pitch(bins)
    pings, blocks = dr.width(echoes) // (channels * beams * row), -(-beams // _WIDE_BLOCK)
    lane = dr.arange(jit.UInt32, pings * blocks * bins)
    bin_, first, ping = lane % bins, lane // bins % blocks * _WIDE_BLOCK, lane // (bins * blocks)
    own = [dr.minimum(first + i, beams - 1) for i in range(_WIDE_BLOCK)]

    def hear(k: Array, sums: list[Any]) -> tuple[Array, list[Any]]:
        heard = dr.gather(kind, echoes, (ping * beams + k) * row + bin_)
        weights = [dr.gather(jit.Float, steering, beam * (2 * beams - 1) + (beams - 1) + k - beam) for beam in own]
        return k + 1, [dr.fma(w * w if squared else w, heard, total) for w, total in zip(weights, sums, strict=True)]

    start = (dr.zeros(jit.UInt32, dr.width(lane)), [dr.zeros(kind, dr.width(lane)) for _ in own])
    _, sums = dr.while_loop(start, lambda k, _: k < beams, hear, mode="symbolic")
    formed = dr.zeros(jit.Float, dr.width(echoes))
    for i, total in enumerate(sums):
        dr.scatter(formed, total, (ping * beams + first + i) * row + bin_, first + i < beams)
    dr.eval(formed)
    return formed


def form_beams(
    echoes: Array, weights: list[list[Array]], first: Array, shift: Array, row: Array, bin_: Array, *,
    channels: int, beams: int, bins: int,
) -> list[list[Array]]:  # fmt: skip
    """Signals of neighbouring beams in a bin, from their own sectors and those on both sides.

    Args:
        echoes: `channels` `Float` a cell; one beam a sector.
        weights: of these beams, 0 for neighbours that do not exist: `amplitude_weights` or `energy_weights`.
        first: `Int32`, the first of the beams.
        shift: `Int32`, beams that the sonar turned since the sound was sent.
        row: `Int32`, the ping times `beams`.
        bin_: `Int32`; outside the image nothing is heard.
        channels: of a cell.
        beams, bins: size of an image, whose rows are `pitch(bins)` apart.

    Returns:
        the channels of each beam; those beyond the last beam are worth nothing.
    """
    count, reach = len(weights), len(weights[0]) // 2
    inside = (bin_ >= 0) & (bin_ < bins)
    start = first - shift
    cell = jit.UInt32((row + start) * pitch(bins) + bin_)

    def heard(k: int) -> list[Array]:
        exists = jit.UInt32(start + k) < beams  # negative ones are large
        return cell_at(echoes, cell + jit.UInt32(k * pitch(bins) % 2**32), inside & exists, channels)

    sectors = [heard(k) for k in range(-reach, count + reach)]
    return [
        [_weighted(row_, [s[c] for s in sectors[i : i + len(row_)]]) for c in range(channels)]
        for i, row_ in enumerate(weights)
    ]


def _weighted(weights: list[Array], values: list[Array]) -> Array:
    """Sum of products."""
    total = jit.Float(0)
    for weight, value in zip(weights, values, strict=True):
        total = dr.fma(weight, value, total)
    return total

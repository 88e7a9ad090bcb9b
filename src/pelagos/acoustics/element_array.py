"""Signals of an array's single elements, and beams formed of them by phases: the way there and back.

A plane wave from the angle a off broadside meets an element at y along the array earlier than one at y = 0, by
y sin(a)/c; at a carrier f that is a phase of 2 pi f y sin(a)/c. Delay and sum takes it off again and adds by weights.
Sampled at its own elements, half a wavelength apart or less, the pattern of a shaded line departs from the continuous
line's by (pi d s)^2/6 of its level at a difference s of sines, d the elements' distance in wavelengths.

Source: H. L. Van Trees, Optimum Array Processing (2002), Sections 2.3 and 2.4, doi 10.1002/0471221104.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_weights
from pelagos.acoustics.echo_walk import pitch
from pelagos.jit import Array
from pelagos.math.quick import cosine_sine

_BLOCK: Final = 8  # neighbours that a lane sums at once: their sources are read once
_WIDEST: Final = 0.5  # wavelengths between elements: no grating lobes at any angle


@dataclass(frozen=True)
class ElementLine:
    """Point receivers along a line, evenly spaced about its middle.

    Attributes:
        places: along the line `(elements,)` [wavelengths at the nominal sound speed].
        weights: of the device's own beamformer `(elements,)`, sum 1.
        channels: what each receive channel makes of a unit signal `(elements,)`, see `channel_factors`; None: nothing.
    """

    places: NDArray[np.float64]
    weights: NDArray[np.float64]
    channels: NDArray[np.complex128] | None = None

    @property
    def count(self) -> int:
        """Number of elements."""
        return len(self.places)

    @property
    def spacing(self) -> float:
        """Distance of neighbours [wavelengths]."""
        return float(self.places[1] - self.places[0]) if self.count > 1 else 0.0

    @property
    def noise_gain(self) -> float:
        """Power of a beam over that of one element, of noise that elements do not share: the sum of squared weights."""
        return float((self.weights**2).sum())


def element_line(length: float, shading: str) -> ElementLine:
    """As few elements as stand at most half a wavelength apart on a line of `length` [wavelengths], with the weights
    of its `shading` (see `weighted_line_np`)."""
    count = max(math.ceil(length / _WIDEST), 1)
    places = ((np.arange(count) + 0.5) / count - 0.5) * length
    weights = line_weights(places / length, shading)
    return ElementLine(places, weights / weights.sum())


def line_amplitude(line: ElementLine, sine: NDArray[np.float64]) -> NDArray[np.complex128]:
    """Pattern of a line with its channels' errors, same shape as `sine` (of the angle off broadside): 1 on axis without
    any."""
    made = line.weights if line.channels is None else line.weights * line.channels
    return np.asarray(np.exp(2j * np.pi * np.multiply.outer(sine, line.places)) @ made)


def channel_factors(
    count: int, *, gain_db: float, phase_rad: float, dead: float, seed: int | tuple[int, ...]
) -> NDArray[np.complex128]:
    """Errors of an array's channels `(count,)`: independent gains and phases, and channels that are silent.

    Args:
        count: channels.
        gain_db, phase_rad: standard deviations, normally distributed [dB], [rad].
        dead: share of channels that are silent, rounded to whole ones.
        seed: of the draw.

    Their mean m and variance v leave a beam's main lobe with m^2 of its power and raise a floor of side lobes of v/m^2
    times the sum of squared weights over the square of their sum: (s_a^2 + s_p^2)/N for N even weights and small
    errors. Source: J. K. Hsiao, Normalized relationship among errors and sidelobe levels, Radio Science 19(1), 292
    (1984), doi 10.1029/RS019i001p00292.
    """
    rng = np.random.Generator(np.random.PCG64([*np.atleast_1d(seed).tolist(), count]))
    gain, phase, order = rng.standard_normal(count), rng.standard_normal(count), rng.permutation(count)
    factors = 10.0 ** (gain_db * gain / 20.0) * np.exp(1j * phase_rad * phase)
    factors[order[: round(dead * count)]] = 0.0
    return np.asarray(factors)


@dataclass(frozen=True)
class Bearings:
    """Sines of directions off broadside, one a sector or beam, by ping.

    Attributes:
        sine, cosine: `Float`, of the directions.
        turn: `Float` by ping, angle a bin that the array turns on while the sound is under way [rad]; None: at rest.
        scale: `Float` by ping: wavelengths at the nominal sound speed over those that phases are of.
    """

    sine: Array
    cosine: Array
    scale: Array
    turn: Array | None = None

    def cycles(self, row: Array, ping: Array, delay: Array) -> Array:
        """Cycles of phase per nominal wavelength along the array, of direction `row` at `delay` bins."""
        sine, scale = dr.gather(jit.Float, self.sine, row), dr.gather(jit.Float, self.scale, ping)
        if self.turn is None:
            return sine * scale
        angle = dr.gather(jit.Float, self.turn, ping) * delay
        return (sine * dr.cos(angle) - dr.gather(jit.Float, self.cosine, row) * dr.sin(angle)) * scale


def at_elements(field: Array, line: ElementLine, bearings: Bearings, *, pings: int, sectors: int, bins: int,
                first_delay: float) -> Array:  # fmt: skip
    """Signals of all elements from those of all sectors: two `Float` for each of pings x elements x bins.

    Args:
        field: two `Float` for each of pings x sectors x `pitch(bins)`.
        line: the elements.
        bearings: of the sectors.
        pings, sectors, bins: their numbers.
        first_delay: of the first bin's middle [bins].
    """
    blocks = -(-line.count // _BLOCK)
    lane = dr.arange(jit.UInt32, pings * blocks * bins)
    bin_, first, ping = lane % bins, lane // bins % blocks * _BLOCK, lane // (bins * blocks)
    place = jit.Float(first) * line.spacing + float(line.places[0])
    delay = jit.Float(bin_) + first_delay

    def hear(k: Array, sums: list[Any]) -> tuple[Array, list[Any]]:
        value = dr.gather(jit.Array2f, field, (ping * sectors + k) * pitch(bins) + bin_)
        per_wavelength = bearings.cycles(k, ping, delay)
        phase, step = (jit.Array2f(*cosine_sine(per_wavelength * reach)) for reach in (place, line.spacing))
        turned = _product(value, phase)
        out = []
        for total in sums:
            out.append(total + turned)
            turned = _product(turned, step)
        return k + 1, out

    start = (dr.zeros(jit.UInt32, dr.width(lane)), [dr.zeros(jit.Array2f, dr.width(lane)) for _ in range(_BLOCK)])
    _, sums = dr.while_loop(start, lambda k, _: k < sectors, hear, mode="symbolic")
    return _rows(sums, first, ping, bin_, count=line.count, pings=pings, bins=bins)


def by_delay_and_sum(signals: Array, line: ElementLine, weights: Array, bearings: Bearings, *, pings: int, beams: int,
                     bins: int) -> Array:  # fmt: skip
    """Beams of elements' signals: two `Float` for each of pings x beams x bins.

    Args:
        signals: two `Float` for each of pings x elements x bins.
        line: the elements.
        weights: `Float`, theirs.
        bearings: of the beams.
        pings, beams, bins: their numbers.
    """
    blocks = -(-beams // _BLOCK)
    lane = dr.arange(jit.UInt32, pings * blocks * bins)
    bin_, first, ping = lane % bins, lane // bins % blocks * _BLOCK, lane // (bins * blocks)
    rows = [dr.minimum(first + i, beams - 1) for i in range(_BLOCK)]
    per_wavelength = [bearings.cycles(row, ping, jit.Float(0)) for row in rows]
    phases = [jit.Array2f(*cosine_sine(cycles * -float(line.places[0]))) for cycles in per_wavelength]
    steps = [jit.Array2f(*cosine_sine(cycles * -line.spacing)) for cycles in per_wavelength]

    def add(n: Array, sums: list[Any], turns: list[Any]) -> tuple[Array, list[Any], list[Any]]:
        value = dr.gather(jit.Array2f, signals, (ping * line.count + n) * bins + bin_)
        value *= dr.gather(jit.Float, weights, n)
        sums = [total + _product(value, turn) for total, turn in zip(sums, turns, strict=True)]
        return n + 1, sums, [_product(turn, step) for turn, step in zip(turns, steps, strict=True)]

    start = (dr.zeros(jit.UInt32, dr.width(lane)), [dr.zeros(jit.Array2f, dr.width(lane)) for _ in rows], phases)
    _, sums, _ = dr.while_loop(start, lambda n, *_: n < line.count, add, mode="symbolic")
    return _rows(sums, first, ping, bin_, count=beams, pings=pings, bins=bins)


def _product(a: Array, b: Array) -> Array:
    """Product of complex numbers as pairs."""
    return jit.Array2f(a.x * b.x - a.y * b.y, a.x * b.y + a.y * b.x)


def _rows(sums: list[Array], first: Array, ping: Array, bin_: Array, *, count: int, pings: int, bins: int) -> Array:
    """Blocks of neighbours in memory, one after another."""
    made = dr.empty(jit.Float, 2 * pings * count * bins)  # all are written
    for i, total in enumerate(sums):
        row = (ping * count + first + i) * bins + bin_
        dr.scatter(made, total, row, first + i < count, mode=dr.ReduceMode.Permute)
    dr.eval(made)
    return made

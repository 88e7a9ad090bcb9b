"""From echoes by beam sector and range bin to what a sonar gives: pulse, beams, noise, gain, scale."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.beam_pattern import energy_reach, line_length, line_np
from pelagos.acoustics.beamforming import (
    added,
    amplitude_weights,
    energy_weights,
    form_beams,
    spread_pulse,
    steer_widely,
)
from pelagos.acoustics.echo_walk import pitch
from pelagos.acoustics.reverberation import volume_intensity
from pelagos.acoustics.spreading import from_db, time_varied_gain, to_db
from pelagos.acoustics.target_tag import untag
from pelagos.jit import Array
from pelagos.math.philox import complex_normal32
from pelagos.math.quick import cosine_sine, larger, log2, smaller
from pelagos.sensors.noise import words32
from pelagos.sensors.sonar.ping.aperture import Aperture, Facing
from pelagos.sensors.sonar.ping.fan import Lanes, Medium
from pelagos.sensors.sonar.ping.painted_noise import paint, streaked
from pelagos.sensors.sonar.ping.ping_spec import Disturber, PingSpec
from pelagos.sensors.sonar.ping.volume_echo import Haze, haze_at

_DECIBELS: Final = 3.0102999566398120  # of a factor of two
_DISTURBED: Final = 0x20000000  # counts of the random phases of another sonar's pulse begin here
_BLOCK: Final = 16  # beams that a lane forms: they hear mostly the same neighbours, which are read once
_RUN: Final = 54  # bins, at most, that a lane forms one after the other: their weights are read once
_LONGEST: Final = 5  # samples of a pulse beyond which it is spread before beams are formed


@dataclass(frozen=True)
class Layout:
    """How a sonar divides directions.

    Attributes:
        beams: number of beams.
        sector: angle between neighbouring beams, or of the only one [rad]: with the bin width it is the cell that
            levels are calibrated to.
        horizontal_width, vertical_width: half-power widths of a receive beam [rad].
        steering: `(beams, 2 reach + 1)`, how beams hear their neighbours; None: not at all.
        azimuths: `(beams,)` [rad], positive to the left.
        facet: edge of the roughness lattice [m]; None: by beam and bin width.
        single_file: whether a beam's rays stand one behind another along their strata, and none beside another.
        equivalent: `(beams,)`, integral of each receive beam's power pattern over the angle [rad]; None: rays carry it,
            and a sector is heard as a whole.
        aperture: how beams hear any direction.
        hears_all: every beam hears every sector, by its side lobes; `steering` is of the whole array.
    """

    beams: int
    sector: float
    horizontal_width: float
    vertical_width: float
    azimuths: NDArray[np.float64]
    aperture: Aperture
    steering: NDArray[np.float32] | None = None
    facet: float | None = None
    single_file: bool = False
    equivalent: NDArray[np.float64] | None = None
    hears_all: bool = False

    @property
    def heard_parts(self) -> NDArray[np.float32]:
        """`(beams,)`, of a sector's energy how much a beam hears: beams may overlap, or leave something between."""
        if self.equivalent is None:
            return np.ones(self.beams, np.float32)
        return np.asarray(self.equivalent / self.sector, dtype=np.float32)


@dataclass(frozen=True)
class Din:
    """What is heard besides echoes and noise: the water, what is coherent; and beams with painted streaks.

    `coherent` see `coherent_echoes`; other sonars' pulses too, see `arrivals`.
    """

    coherent: Array | None = None
    haze: Haze | None = None
    streaks: Array | None = None


@jit.struct
class Cells:
    """Cells of an image, one lane each: a Dr.Jit struct.

    Attributes:
        ping, beam, bin: `Int32`.
        distance: `Float`, middle of the bin [m].
        raised: `Float`, intensity gain 30 log r + 2 a r.
        gain: `Float`, `raised` over the size of what a sample hears: from intensity re the
            source level at 1 m to the strength of an even bottom.
        heard: `Float`, see `Constants`.
    """

    ping: Array
    beam: Array
    bin: Array
    distance: Array
    raised: Array
    gain: Array
    heard: Array | None = None


@jit.struct
class Constants:
    """What a ping is called with, and never changes: a Dr.Jit struct.

    Attributes:
        steering, pulse: weights, see `amplitude_weights` and `spread_pulse`.
        noise: power, see `noise_power`.
        seed: of the roughness.
        order: see `Walk`.
        facing: see `Facing`.
        boost: by beam, over a point's energy in the field that which a sample and a beam hear of it as a whole.
        cell: what levels are calibrated to, sector times bin width [rad m].
        heard: by beam, over the energy of a cell that of an even bottom in what a sample hears: the equivalent width of
            the beam and of the pulse over those of the cell.
    """

    steering: Array
    pulse: Array
    noise: Array
    seed: Array
    order: Array
    cell: Array
    heard: Array
    facing: Facing
    boost: Array


@dataclass(frozen=True)
class Moment:
    """When and where a ping is sent.

    Attributes:
        lanes: see `Lanes`.
        spin: `Array3f64`, of the sensor in its own frame by lane [rad/s].
        t_ns: `UInt64`, time by lane [ns].
        key: random stream of the noise.
    """

    lanes: Lanes
    spin: Array
    t_ns: Array
    key: Any


def receive(
    spec: PingSpec, layout: Layout, constants: Constants, echoes: Array, tags: Array | None, moment: Moment, din: Din
) -> list[Array]:
    """Hear echoes: data, with `iq` the complex signal before gain, with `labels` the strongest echo's tag.

    Args:
        echoes, tags: see `sum_amplitudes`.
        din: what is heard besides.
    """
    lanes, key = moment.lanes, moment.key
    beams, bins, pings = layout.beams, spec.bins, dr.width(lanes.position)
    reach = 0 if layout.steering is None else layout.steering.shape[1] // 2
    hearing = _Hearing(spec, layout, constants, lanes.medium, moment.spin)
    if layout.hears_all:
        echoes = steer_widely(echoes, constants.steering, channels=2, beams=beams, bins=bins)
        weights = [[jit.Float(1)] for _ in range(hearing.count)]
    else:
        weights = amplitude_weights(constants.steering, hearing.first, count=hearing.count, reach=reach, beams=beams)
    counter = [dr.gather(jit.UInt32, v, hearing.ping) for v in (lanes.environment, lanes.tick)]
    words: tuple[Array, ...] = ()

    def finish(i: int, here: Cells, signal: list[Array]) -> list[Array]:
        nonlocal words
        if i % 4 == 0:  # four words of noise serve four beams
            words = words32(key, jit.UInt32(here.beam // 4 * bins + here.bin), *counter)
        power = din_power(spec, layout, here, moment, constants.noise, din)
        if din.coherent is not None:
            extra = dr.gather(jit.Array2f, din.coherent, cell_of(layout, spec, here), here.beam < beams)
            signal = [dr.fma(part, dr.sqrt(here.gain), value) for part, value in zip(extra, signal, strict=True)]
        if spec.disturber is not None:
            signal = with_disturber(signal, spec, layout, here, moment, counter)
        return levels(spec, signal, words[i % 4], here, power)

    out = hearing(echoes, constants.pulse, weights, finish, channels=2, outputs=3 if spec.iq else 1)
    if spec.display.painting is not None:
        out[0] = painted(spec, layout, out[0], lanes, key, din.streaks)
    if tags is not None:
        cell = dr.arange(jit.Int32, pings * beams * bins)
        bin_, beam, ping = cell % bins, cell // bins % beams, cell // (beams * bins)
        sent = beam - beams_turned(spec, layout, lanes.medium, moment.spin, ping)(bin_)
        source = jit.UInt32((ping * beams + sent) * pitch(bins) + bin_)
        out += untag(dr.gather(jit.UInt64, tags, source, (sent >= 0) & (sent < beams)))
    return out


def mean_levels(
    spec: PingSpec, layout: Layout, constants: Constants, energies: Array, medium: Medium, spin: Array,
    din: Din,
) -> Array:  # fmt: skip
    """Truth: the levels of the echoes' energies, as beams hear them without noise and interference.

    The water's echo is of so many scatterers that it is noise to a ping; it is part of the truth too. Arguments as of
    `receive`, `energies` see `sum_energies`.
    """
    pulse = constants.pulse
    reach = inner = 0
    if layout.steering is not None:
        reach, inner = layout.steering.shape[1] // 2, energy_reach(layout.steering)

    hearing = _Hearing(spec, layout, constants, medium, spin)
    if layout.hears_all:
        energies = steer_widely(
            energies, constants.steering, channels=1, beams=layout.beams, bins=spec.bins, squared=True
        )
        heard = [[jit.Float(1)] for _ in range(hearing.count)]
    else:
        amplitudes = amplitude_weights(
            constants.steering, hearing.first, count=hearing.count, reach=reach, beams=layout.beams
        )
        heard = energy_weights(amplitudes, inner)

    def finish(_: int, here: Cells, signal: list[Array]) -> list[Array]:
        energy = signal[0]
        if din.haze is not None:
            energy += water_echo(spec, layout, din.haze, here, medium) * here.gain
        if din.coherent is not None:
            known = here.beam < layout.beams
            energy += dr.gather(jit.Float, din.coherent, cell_of(layout, spec, here), known) * here.gain
        return [scaled(spec, tilted(spec, energy, here))]

    squares = pulse * pulse
    dr.eval(squares)
    return hearing(energies, squares, heard, finish, channels=1, outputs=1)[0]


class _Hearing:
    """From echoes by beam sector and bin to what beams hear: each lane bin after bin, for a few beams at a time.

    Attributes:
        count: beams of a lane.
        ping, first: `Int32` of each lane, its ping and the first of its beams.
    """

    def __init__(self, spec: PingSpec, layout: Layout, constants: Constants, medium: Medium, spin: Array) -> None:
        self._spec, self._layout, self._medium, self._constants = spec, layout, medium, constants
        pings = dr.width(medium.sound_speed)
        self.count = 1 if layout.steering is None else _BLOCK
        blocks, runs = -(-layout.beams // self.count), -(-spec.bins // _RUN)
        self._run, self._size = -(-spec.bins // runs), pings * layout.beams * spec.bins
        lane = dr.arange(jit.Int32, pings * blocks * runs)
        self.ping, self.first = lane // (blocks * runs), lane // runs % blocks * self.count
        self._start = lane % runs * self._run
        self._turned = beams_turned(spec, layout, medium, spin, self.ping)

    def __call__(
        self, echoes: Array, pulse: Array, weights: list[list[Array]],
        finish: Callable[[int, Cells, list[Array]], list[Array]], *, channels: int, outputs: int,
    ) -> list[Array]:  # fmt: skip
        """For each of pings x beams x bins as many `Float` as there are `outputs`.

        Args:
            echoes: `channels` `Float` a cell.
            pulse: weights of its samples.
            weights: of the lanes' beams, see `form_beams`.
            finish: (place among a lane's beams, cells, what they hear by channel) -> what is given.
            channels, outputs: of a cell.
        """
        spec, layout, ping, first = self._spec, self._layout, self.ping, self.first
        beams, bins = layout.beams, spec.bins
        taps = dr.width(pulse)
        if taps > _LONGEST:
            echoes, pulse, taps = spread_pulse(echoes, pulse, channels=channels, bins=bins), jit.Float(1), 1
        gains = [dr.gather(jit.Float, pulse, jit.UInt32(k)) for k in range(taps)]
        out = [dr.empty(jit.Float, self._size) for _ in range(outputs)]  # all are written

        def hear(step: Array, before: list[list[list[Array]]]) -> tuple[Array, list[list[list[Array]]]]:
            ahead = self._start + step
            formed = form_beams(echoes, weights, first, self._turned(ahead), ping * beams, ahead, channels=channels,
                                beams=beams, bins=bins)  # fmt: skip
            window = [*before, formed]
            bin_ = ahead - taps // 2
            due = (step >= taps // 2) & (bin_ < bins)
            place = cells_at(spec, self._medium, self._constants, ping, first, bin_)
            for i in range(self.count):
                here = cells_of_beam(place, self._constants, first + i)
                signal = [jit.Float(0)] * channels
                for formed_then, gain in zip(window, gains, strict=True):
                    signal = added(signal, formed_then[i], gain)
                index = jit.UInt32((ping * beams + here.beam) * bins + bin_)
                for into, values in zip(out, finish(i, here, signal), strict=True):
                    dr.scatter(into, values, index, due & (here.beam < beams), mode=dr.ReduceMode.Permute)
            return step + 1, window[1:]

        width = dr.width(ping)
        silent = [[[dr.zeros(jit.Float, width)] * channels for _ in range(self.count)] for _ in range(taps - 1)]
        state = (dr.full(jit.Int32, -(taps // 2), width), silent)
        last = self._run + taps // 2
        dr.while_loop(state, lambda step, _: step < last, hear, mode="symbolic", labels=("step", "before"))
        return out


def painted(spec: PingSpec, layout: Layout, intensity: Array, lanes: Lanes, key: Any, rows: Array | None) -> Array:
    """Noise painted on intensities, and their scale; `rows` `Bool` of pings by beams that have streaks."""
    noise = spec.display.painting
    assert noise is not None
    cell = dr.arange(jit.Int32, dr.width(intensity))
    row, bin_ = cell // spec.bins, cell % spec.bins
    ping, beam = row // layout.beams, row % layout.beams
    counter = dr.gather(jit.UInt32, lanes.environment, ping), dr.gather(jit.UInt32, lanes.tick, ping)
    words = words32(key, jit.UInt32(beam * spec.bins + bin_) + 0x40000000, *counter)
    dr.eval(intensity)
    result = paint(noise, intensity, words, bin_=bin_, bin_width=spec.bin_width_m)
    if rows is None:
        return scaled(spec, result)
    level = scaled(replace(spec, display=replace(spec.display, scale="unit")), result)
    level = streaked(noise, level, dr.gather(jit.Bool, rows, jit.UInt32(row)))
    if spec.display.scale == "unit":
        return level
    level = level * spec.display.dynamic_range_db + spec.display.floor_db
    return level if spec.display.scale == "db" else from_db(level)


def beams_turned(
    spec: PingSpec, layout: Layout, medium: Medium, spin: Array, ping: Array
) -> Callable[[Array], Array]:  # fmt: skip
    """A function bin -> beams, `Int32`, by which the sonar has turned when the echo comes back, for lanes' pings.

    A sonar that turns hears an echo in the beam that points at the target when it comes back.
    """
    if not spec.doppler or layout.steering is None:
        return lambda bin_: jit.Int32(0)
    delay = 2.0 / medium.sound_speed
    rate = dr.gather(jit.Float, jit.Float(spin.z) * delay * (1.0 / layout.sector), jit.UInt32(ping))
    return lambda bin_: jit.Int32(dr.round(rate * middle(spec, bin_)))


def middle(spec: PingSpec, bin_: Array) -> Array:
    """Middle of a range bin [m]."""
    return spec.range_min_m + (jit.Float(bin_) + 0.5) * spec.bin_width_m


def cell_of(layout: Layout, spec: PingSpec, cells: Cells) -> Array:
    """Row of cells in a table of pings by beams by bins."""
    bin_ = dr.clip(cells.bin, 0, spec.bins - 1)
    return jit.UInt32((cells.ping * layout.beams + cells.beam) * spec.bins + bin_)


def cells_at(spec: PingSpec, medium: Medium, constants: Constants, ping: Array, beam: Array, bin_: Array) -> Cells:
    """Cells with their ranges and gains."""
    distance = middle(spec, bin_)
    loss = dr.gather(jit.Float, medium.absorption, jit.UInt32(ping))
    raised = time_varied_gain(distance, loss, spreading=30.0)
    return cells_of_beam(Cells(ping, beam, bin_, distance, raised, raised), constants, beam)


def cells_of_beam(cells: Cells, constants: Constants, beam: Array) -> Cells:
    """The same cells of another beam."""
    row = dr.minimum(jit.UInt32(beam), dr.width(constants.heard) - 1)
    heard = dr.gather(jit.Float, constants.heard, row)
    size = heard * constants.cell
    return replace(cells, beam=beam, heard=heard, gain=cells.raised / size)


def water_echo(spec: PingSpec, layout: Layout, haze: Haze, cells: Cells, medium: Medium) -> Array:
    """Intensity of the water's echo re the source level at 1 m."""
    beam = haze_at(haze, cells.ping, cells.beam, cells.distance, layout.beams)
    loss = dr.gather(jit.Float, medium.absorption, jit.UInt32(cells.ping))
    return volume_intensity(beam, cells.distance, loss, spec.bin_width_m) * cells.heard


def din_power(spec: PingSpec, layout: Layout, cells: Cells, moment: Moment, noise: Array, din: Din) -> Array:
    """Intensity of all that is no echo of a surface, re the source level at 1 m."""
    lanes, power = moment.lanes, noise
    if din.haze is not None:
        power = power + water_echo(spec, layout, din.haze, cells, lanes.medium)
    if spec.ringing is not None:
        power = power + ringing(spec, cells, lanes.medium)
    return power


def with_disturber(
    signal: list[Array], spec: PingSpec, layout: Layout, cells: Cells, moment: Moment, counter: list[Array]
) -> list[Array]:
    """Amplitudes with another sonar's pulse, which has one phase in all beams, and another one in each bin: behind a
    filter that does not match, a pulse goes on and on."""
    assert spec.disturber is not None
    size = dr.sqrt(disturbance(spec.disturber, spec, layout, cells, moment) * cells.gain)
    word = words32(moment.key, jit.UInt32(cells.bin) + _DISTURBED, *counter)[0]
    cosine, sine = cosine_sine(jit.Float(word) * 2.0**-32)
    return [dr.fma(size, part, value) for part, value in zip((cosine, sine), signal, strict=True)]


def levels(spec: PingSpec, signal: list[Array], word: Array, cells: Cells, power: Array) -> list[Array]:
    """Add noise of a power to amplitudes, set gain and scale: data, with `iq` the complex signal before gain."""
    strength, turn = complex_normal32(word)
    size = dr.sqrt(power * cells.gain * strength)
    cosine, sine = cosine_sine(turn)
    real, imaginary = dr.fma(size, cosine, signal[0]), dr.fma(size, sine, signal[1])
    if spec.converter is not None:
        real, imaginary = (converted(spec, part, cells.gain) for part in (real, imaginary))
    intensity = real * real + imaginary * imaginary
    intensity = tilted(spec, intensity, cells)
    out = [intensity if spec.display.painting is not None else scaled(spec, intensity)]
    if spec.iq:
        raw = dr.rsqrt(cells.gain)
        out += [real * raw, imaginary * raw]
    return out


def converted(spec: PingSpec, part: Array, gain: Array) -> Array:
    """A part of the signal with a gain, as a converter before that gain gives it: in steps, and cut off."""
    assert spec.converter is not None
    bits, full_scale_db = spec.converter
    largest = 2.0 ** (bits - 1) - 1.0
    step = 10.0 ** ((full_scale_db - spec.source_level_db) / 20.0) / largest
    root = dr.sqrt(gain)
    return dr.clip(dr.round(part / (root * step)), -largest - 1.0, largest) * (step * root)


def ringing(spec: PingSpec, cells: Cells, medium: Medium) -> Array:
    """Intensity of the transducer's own ringing re the source level at 1 m, from the end of the pulse on."""
    assert spec.ringing is not None
    level, fall = spec.ringing
    speed = dr.gather(jit.Float, medium.sound_speed, jit.UInt32(cells.ping))
    since_ms = 1e3 * dr.maximum(2.0 * cells.distance / speed, 0.0)
    return from_db(level - spec.source_level_db - fall * since_ms)


def tilted(spec: PingSpec, intensity: Array, cells: Cells) -> Array:
    """Intensity under another spreading of the gain than 30 log r."""
    if spec.display.tvg_db == 30.0:
        return intensity
    return intensity * cells.distance ** ((spec.display.tvg_db - 30.0) / 10.0)


def trace_levels(
    spec: PingSpec, layout: Layout, constants: Constants, energies: Array, data: Array, lanes: Lanes, trace: Any
) -> None:
    """Tell echoes and signal-to-noise ratio before beams are formed, and the data."""
    cell = dr.arange(jit.Int32, dr.width(data))
    row, bin_ = cell // spec.bins, cell % spec.bins
    energy = dr.gather(jit.Float, energies, jit.UInt32(row * pitch(spec.bins) + bin_))
    here = cells_at(spec, lanes.medium, constants, row // layout.beams, row % layout.beams, bin_)
    trace("echo intensity by cell, before beams are formed", energy, "1")
    trace("signal-to-noise ratio", to_db(dr.maximum(energy, 1e-20) / (constants.noise * here.gain)), "dB")
    trace("echo level after gain", data, {"db": "dB", "unit": "1", "linear": "1"}[spec.display.scale])


def scaled(spec: PingSpec, intensity: Array) -> Array:
    """Intensity as the configuration wants it."""
    if spec.display.scale == "linear":
        return intensity
    octaves = log2(larger(intensity, 1e-20))
    if spec.display.scale == "db":
        return _DECIBELS * octaves
    span = spec.display.dynamic_range_db
    unit = dr.fma(octaves, _DECIBELS / span, -spec.display.floor_db / span)
    return larger(smaller(unit, 1.0), 0.0)


def disturbance(other: Disturber, spec: PingSpec, layout: Layout, cells: Cells, moment: Moment) -> Array:
    """Intensity of another sonar's direct pulse re the source level at 1 m, where it falls into this ping.

    The other one's clock starts at t = 0; a pulse that was sent at its k-th period arrives distance/c later, and is
    heard in the bin of its time after this sonar's own transmission, in all beams by their pattern.
    """
    lanes, t_ns = moment.lanes, moment.t_ns
    lane = jit.UInt32(cells.ping)
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
    period_ns = round(1e9 / other.rate_hz)
    start_ns = dr.gather(jit.UInt64, t_ns, lane) % jit.UInt64(period_ns)
    since = 2.0 * cells.distance / speed - (other.distance_m / speed - jit.Float(start_ns) * 1e-9)
    period = period_ns * 1e-9
    phase = since / period
    within = (phase - dr.floor(phase)) * period
    level = other.source_level_db - spec.source_level_db - loss * other.distance_m
    level -= 20.0 * math.log10(other.distance_m)
    table = jit.Float(0)
    length = line_length(layout.horizontal_width)
    seen = line_np(np.sin(layout.azimuths) - math.sin(other.azimuth), length) ** 2
    for k in np.flatnonzero(seen > 1e-4):
        table = dr.select(cells.beam == int(k), float(seen[k]), table)
    return dr.select(within < other.pulse_s, from_db(level) * table, 0.0)

"""Levels of a sonar's image: noise and all that is no echo, converter, gain, scale."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.reverberation import volume_intensity
from pelagos.acoustics.spreading import from_db
from pelagos.jit import Array
from pelagos.math.philox import complex_normal32
from pelagos.math.quick import cosine_sine, larger, log2, smaller
from pelagos.sensors.noise import Key, words32
from pelagos.sensors.sonar.ping.cells import Cells
from pelagos.sensors.sonar.ping.clumps import clumped
from pelagos.sensors.sonar.ping.fan import Lanes
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.medium import Medium
from pelagos.sensors.sonar.ping.ping_spec import Disturber, PingSpec
from pelagos.sensors.sonar.ping.volume_echo import Haze, haze_at

_DECIBELS: Final = 3.0102999566398120  # of a factor of two
_DISTURBED: Final = 0x20000000  # counts of the random phases of another sonar's pulse begin here


@dataclass(frozen=True)
class Din:
    """Sound besides echoes and noise: of the water, coherent echoes, vehicles; and beams with painted streaks.

    `coherent` see `coherent_echoes`; other sonars' pulses too, see `arrivals`; `vehicles` see `noise_by_beam`;
    `disturber`, pings by beams, the pattern towards the sonar that is not in the scenario.
    """

    coherent: Array | None = None
    haze: Haze | None = None
    streaks: Array | None = None
    vehicles: Array | None = None
    disturber: Array | None = None


@dataclass(frozen=True)
class Moment:
    """Time and place at which a ping is sent.

    Attributes:
        lanes: see `Lanes`.
        spin: `Array3f64`, of the sensor in its own frame by lane [rad/s].
        t_ns: `UInt64`, time by lane [ns].
        key: random stream of the noise.
    """

    lanes: Lanes
    spin: Array
    t_ns: Array
    key: Key


def water_echo(spec: PingSpec, layout: Layout, haze: Haze, cells: Cells, medium: Medium) -> Array:
    """Mean intensity of the water's echo re the source level at 1 m."""
    beam = haze_at(haze, cells.ping, cells.beam, cells.distance, layout.beams)
    loss = dr.gather(jit.Float, medium.absorption, jit.UInt32(cells.ping))
    return volume_intensity(beam, cells.distance, loss, spec.bin_width_m) * cells.heard


def din_power(spec: PingSpec, layout: Layout, cells: Cells, moment: Moment, noise: Array, din: Din) -> Array:
    """Intensity of all that is no echo of a surface, re the source level at 1 m."""
    lanes, power = moment.lanes, noise
    if din.vehicles is not None:
        row = jit.UInt32(cells.ping * layout.beams + cells.beam)
        power = power + dr.gather(jit.Float, din.vehicles, row, cells.beam < layout.beams)
    if din.haze is not None:
        echo = water_echo(spec, layout, din.haze, cells, lanes.medium)
        if din.haze.clumps is not None:
            echo = echo * clumped(din.haze.clumps, cells.ping, cells.beam, cells.distance, layout.beams)
        power = power + echo
    if spec.ringing is not None:
        power = power + ringing(spec, cells, lanes.medium)
    return power


def with_disturber(
    signal: list[Array], spec: PingSpec, cells: Cells, moment: Moment, pattern: Array, counter: list[Array]
) -> list[Array]:
    """Amplitudes with another sonar's pulse, which has one phase in all beams, and another one in each bin: behind a
    filter that does not match, a pulse goes on and on. `pattern` is of each cell's beam towards it, one way."""
    assert spec.disturber is not None
    size = dr.sqrt(disturbance(spec.disturber, spec, cells, moment) * pattern * cells.gain)
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
        real, imaginary = (quantise(spec, part, cells.gain) for part in (real, imaginary))
    intensity = real * real + imaginary * imaginary
    intensity = apply_spreading(spec, intensity, cells)
    out = [intensity if spec.display.painting is not None else to_scale(spec, intensity)]
    if spec.iq:
        raw = dr.rsqrt(cells.gain)
        out += [real * raw, imaginary * raw]
    return out


def quantise(spec: PingSpec, part: Array, gain: Array) -> Array:
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


def apply_spreading(spec: PingSpec, intensity: Array, cells: Cells) -> Array:
    """Intensity under another spreading of the gain than 30 log r."""
    if spec.display.tvg_db == 30.0:
        return intensity
    return intensity * cells.distance ** ((spec.display.tvg_db - 30.0) / 10.0)


def to_scale(spec: PingSpec, intensity: Array) -> Array:
    """Intensity as the configuration wants it."""
    if spec.display.scale == "linear":
        return intensity
    octaves = log2(larger(intensity, 1e-20))
    if spec.display.scale == "db":
        return _DECIBELS * octaves
    span = spec.display.dynamic_range_db
    unit = dr.fma(octaves, _DECIBELS / span, -spec.display.floor_db / span)
    return larger(smaller(unit, 1.0), 0.0)


def disturbance(other: Disturber, spec: PingSpec, cells: Cells, moment: Moment) -> Array:
    """Intensity of another sonar's direct pulse re the source level at 1 m, where it falls into this ping.

    The other one's clock starts at t = 0; a pulse that was sent at its k-th period arrives distance/c later, and is
    heard in the bin of its time after this sonar's own transmission.
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
    return dr.select(within < other.pulse_s, from_db(level), 0.0)

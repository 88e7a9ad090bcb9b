"""From echoes by beam sector and range bin to what a sonar gives: pulse, beams, noise, gain, scale."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.beam_pattern import energy_reach
from pelagos.acoustics.beamforming import (
    added,
    amplitude_weights,
    energy_weights,
    form_beams,
    spread_pulse,
    steer_widely,
)
from pelagos.acoustics.echo_walk import pitch
from pelagos.acoustics.spreading import from_db, to_db
from pelagos.acoustics.target_tag import untag
from pelagos.jit import Array
from pelagos.sensors.noise import Key, words32
from pelagos.sensors.sonar.ping.cells import Cells, Constants, cell_of, cells_at, cells_of_beam, middle
from pelagos.sensors.sonar.ping.fan import Lanes
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.levels import (
    Din,
    Moment,
    apply_spreading,
    din_power,
    levels,
    to_scale,
    water_echo,
    with_disturber,
)
from pelagos.sensors.sonar.ping.medium import Medium
from pelagos.sensors.sonar.ping.painted_noise import paint, paint_streaks, speckled
from pelagos.sensors.sonar.ping.ping_spec import PingSpec

_BLOCK: Final = 16  # beams that a lane forms: they hear mostly the same neighbours, which are read once
_RUN: Final = 54  # bins, at most, that a lane forms one after the other: their weights are read once
_LONGEST: Final = 5  # samples of a pulse beyond which it is spread before beams are formed


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
        if i % 4 == 0:  # four words of noise serve four beams of a lane; a beam that is alone draws its own
            row = here.beam if hearing.count == 1 else here.beam // 4
            words = words32(key, jit.UInt32(row * bins + here.bin), *counter)
        power = din_power(spec, layout, here, moment, constants.noise, din)
        if din.coherent is not None:
            extra = dr.gather(jit.Array2f, din.coherent, cell_of(layout, spec, here), here.beam < beams)
            signal = [dr.fma(part, dr.sqrt(here.gain), value) for part, value in zip(extra, signal, strict=True)]
        if din.disturber is not None:
            row, known = jit.UInt32(here.ping * beams + here.beam), here.beam < beams
            signal = with_disturber(
                signal, spec, here, moment, dr.gather(jit.Float, din.disturber, row, known), counter
            )
        return levels(spec, signal, words[i % 4], here, power)

    out = hearing(echoes, constants.pulse, weights, finish, channels=2, outputs=3 if spec.iq else 1)
    if spec.display.painting is not None:
        out[0] = painted_levels(spec, layout, out[0], lanes, key, din.streaks)
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
        return [to_scale(spec, apply_spreading(spec, energy, here))]

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


def painted_levels(
    spec: PingSpec, layout: Layout, intensity: Array, lanes: Lanes, key: Key, rows: Array | None
) -> Array:
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
    if rows is None and noise.onto == "intensity":
        return to_scale(spec, result)
    level = to_scale(replace(spec, display=replace(spec.display, scale="unit")), result)
    if noise.onto == "level":
        level = dr.minimum(speckled(noise, level, words, noise.additive), 1.0)
    if rows is not None:
        level = paint_streaks(noise, level, dr.gather(jit.Bool, rows, jit.UInt32(row)))
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


def trace_levels(
    spec: PingSpec,
    layout: Layout,
    constants: Constants,
    energies: Array,
    data: Array,
    moment: Moment,
    din: Din,
    *,
    trace: Callable[[str, Array, str], None],
) -> None:
    """Tell echoes and signal-to-noise ratio before beams are formed, and the data."""
    cell = dr.arange(jit.Int32, dr.width(data))
    row, bin_ = cell // spec.bins, cell % spec.bins
    energy = dr.gather(jit.Float, energies, jit.UInt32(row * pitch(spec.bins) + bin_))
    here = cells_at(spec, moment.lanes.medium, constants, row // layout.beams, row % layout.beams, bin_)
    noise = din_power(spec, layout, here, moment, constants.noise, Din(vehicles=din.vehicles))
    trace("echo intensity by cell, before beams are formed", energy, "1")
    trace("signal-to-noise ratio", to_db(dr.maximum(energy, 1e-20) / (noise * here.gain)), "dB")
    trace("echo level after gain", data, {"db": "dB", "unit": "1", "linear": "1"}[spec.display.scale])

"""Echoes of pairs of pulses: surfaces and water move on from the first to the second, and phases tell how fast.

The first pulse is a `Pinger`'s. The second hears the same scatterers a lag later: in each beam and bin the echoes of
all rays turn by their own closing speeds; their mean turns the sample, their spread takes from its coherence and leaves
room for as much of a new echo. Both pulses are taken to be told apart, as by codes.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.echo import Patches
from pelagos.acoustics.pulse import point_spread, range_resolution
from pelagos.acoustics.pulse_pair import BEAM_SPREAD, pulse_correlation, speed_per_radian
from pelagos.acoustics.reverberation import volume_intensity
from pelagos.acoustics.spreading import from_db, time_varied_gain, to_db
from pelagos.jit import Array
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.math.philox import normal_pair32
from pelagos.math.so3 import rotate, rotate_back
from pelagos.sensors.mount import sensor_angular_velocity, sensor_velocity
from pelagos.sensors.noise import Key, words32
from pelagos.sensors.sonar.ping.fan import Fan, FanHits, Lanes
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.ping_spec import PingSpec, noise_power
from pelagos.sensors.sonar.ping.pinger import Pinger
from pelagos.sensors.sonar.ping.sounder import Ping, Sounder, Waters
from pelagos.sensors.sonar.ping.volume_echo import TRACER

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean
    from pelagos.sensors.sensor import Kinematics, SensorContext

_SILENT_DB: Final = 1000.0  # source level before which the pinger's noise is nothing: it is added here, to each pulse
_NO_WATER_DB: Final = -200.0


@dataclass(frozen=True)
class Pairs:
    """Two pulses, one after the other.

    Attributes:
        lag_s: time between them [s].
        noise_mps, noise_relative: standard deviation of a speed from one strong echo, at rest [m/s], and in parts of
            the speed in quadrature; what the spread of speeds in the beam does not explain is lost to the codes.
        layer_m: length along the beam of the water whose speed has that deviation [m].
        clear_db: Sv [dB re 1/m] where neither the ping nor a tracer gives it; None: the water is silent.
    """

    lag_s: float
    noise_mps: float
    noise_relative: float
    layer_m: float
    clear_db: float | None


@dataclass(frozen=True)
class NarrowBeams:
    """A few narrow beams.

    Attributes:
        layout: see `Layout`.
        axes: their directions in the sensor frame `(beams, 3)`.
        rays: their ray pattern.
        looks: a thinner one of the same beams, in their order, that tells how echoes move on.
    """

    layout: Layout
    axes: NDArray[np.float64]
    rays: dict[str, NDArray[Any]]
    looks: dict[str, NDArray[Any]]


class PulsePairs:
    """The echoes of pairs of pulses in a few narrow beams.

    Args:
        context: the sonar's part's.
        ping: pulse, bins and levels.
        beams: see `NarrowBeams`.
        pairs: see `Pairs`.
    """

    def __init__(self, context: SensorContext, ping: PingSpec, beams: NarrowBeams, pairs: Pairs) -> None:
        layout, looks = beams.layout, beams.looks
        self._ping, self._layout, self._axes, self._lag = ping, layout, beams.axes, pairs.lag_s
        self._ocean = context.ocean
        self._noise = noise_power(ping, layout.horizontal_width, layout.vertical_width)
        self._heard = ping.equivalent_m / ping.bin_width_m  # of a cell's energy what a sample hears
        self._deviation = (pairs.noise_mps, pairs.noise_relative)
        tracer = TRACER in context.ocean.tracers
        self._strength = (
            ping.volume_scattering_db if ping.volume_scattering_db is not None or tracer else pairs.clear_db
        )
        self._hazy = tracer or self._strength is not None
        silent = replace(
            ping, source_level_db=_SILENT_DB, display=replace(ping.display, scale="linear"), iq=True,
            volume_scattering_db=_NO_WATER_DB if self._hazy else None,
        )  # fmt: skip
        self._pinger = Pinger(silent, context, beams.rays, layout)
        self._rays = len(looks["beam"]) // layout.beams
        self._psi = float(looks["weight"].sum()) / layout.beams
        self._pulse = point_spread(
            ping.bin_width_m, range_resolution(NOMINAL_SOUND_SPEED, ping.bandwidth_hz), pulse=ping.pulse
        ).tolist()
        self._taps = (pulse_correlation(np.asarray(self._pulse)) ** 2).tolist()
        self._layer_samples = pairs.layer_m / ping.bin_width_m / sum(self._taps)
        self._sounder = Sounder(ping.mounting, context, looks, Waters(ping.frequency_hz, ping.ph))
        self._recorded = self._sounder.compile(self._kernel)

    def extras(self, motion: Kinematics) -> dict[str, NDArray[Any]]:
        """`water_column`, `water_column_truth` [dB] and `labels` `(m, beams, bins)`, `iq` `(m, beams, 2, bins)`."""
        _, mean, more = self._pinger.ping(motion)
        truth = mean()
        first = [np.ascontiguousarray(v).ravel() for v in (more["iq"].real, more["iq"].imag, truth)]
        arrays = self._recorded(motion, self._ocean, *(jit.Float(v) for v in first))
        shape = truth.shape
        data, level, *parts = (np.array(a).reshape(shape) for a in arrays)
        found = {"water_column": data, "water_column_truth": level}
        if self._ping.iq:
            found["iq"] = np.stack([parts[0] + 1j * parts[1], parts[2] + 1j * parts[3]], axis=2).astype(np.complex64)
        return found | {f"water_column_{k}": more[k] for k in ("label", "instance") if k in more}

    def _kernel(self, sent: Ping, ocean: Ocean, real: Array, imaginary: Array, energy: Array) -> tuple[Array, ...]:
        layout, ping = self._layout, self._ping
        lanes, fan, motion = sent.lanes, sent.fan, sent.motion
        view = sent.cast(max_range=ping.range_max_m + ping.longest_strip_m)
        patches = sent.patches(view, longest=ping.longest_strip_m)
        dr.eval(view, patches)
        velocity = sensor_velocity(motion, self._ping.mounting)
        row = dr.arange(jit.UInt32, dr.width(lanes.position) * layout.beams)
        bow = self._along_axes(velocity, row)  # closing speed of what rests on each beam's axis [m/s]
        scale = 1.0 / speed_per_radian(
            frequency_hz=ping.frequency_hz, sound_speed=lanes.medium.sound_speed, lag_s=self._lag
        )
        dr.eval(bow, scale)
        power, sunk, tilted, free = self._moved(view, patches, fan, lanes, velocity, bow, scale)
        lost = dr.maximum(2.0 * sunk - sunk * sunk - tilted * tilted, 0.0)  # 1 - |coherence|^2
        dr.eval(power, sunk, tilted, lost, free)
        dull = self._dulled(power, bow, scale)
        dr.eval(dull)

        cell = dr.arange(jit.UInt32, dr.width(power))
        row, bin_ = cell // ping.bins, cell % ping.bins
        lane = row // layout.beams
        total = dr.maximum(lost, dr.gather(jit.Float, dull, row))
        distance = ping.range_min_m + (jit.Float(bin_) + 0.5) * ping.bin_width_m
        normals = self._normals(sent.key, lanes, cell, lane)
        water, moving_water = self._water(ocean, lanes, motion, velocity, cell, distance, free, scale, normals)
        fresh = dr.sqrt(0.5 * total * power)
        raw = dr.ravel(jit.Array4f(
            water[1], water[2], moving_water[0] + fresh * normals[8], moving_water[1] + fresh * normals[9]
        ))  # fmt: skip
        dr.eval(raw)
        heard = self._through_pulse(raw, cell, bin_)
        keep = dr.sqrt((1.0 - total) / dr.maximum(1.0 - lost, 1e-6))
        turn = dr.gather(jit.Float, bow, row) * dr.gather(jit.Float, scale, lane)
        s, c = dr.sincos(turn)
        gr, gi = keep * ((1.0 - sunk) * c - tilted * s), keep * ((1.0 - sunk) * s + tilted * c)
        hiss = math.sqrt(0.5 * self._noise)
        z1 = real + heard.x + hiss * normals[0], imaginary + heard.y + hiss * normals[1]
        z2 = (
            real * gr - imaginary * gi + heard.z + hiss * normals[2],
            real * gi + imaginary * gr + heard.w + hiss * normals[3],
        )
        loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
        gain = time_varied_gain(distance, loss, spreading=30.0) / (layout.sector * ping.equivalent_m)
        data = to_db(dr.maximum((z1[0] * z1[0] + z1[1] * z1[1]) * gain, 1e-20))
        truth = to_db(dr.maximum(energy + water[0] * gain, 1e-20))
        return data, truth, *z1, *z2

    def _through_pulse(self, raw: Array, cell: Array, bin_: Array) -> Array:
        """Four `Float` a cell, spread over neighbouring bins by the pulse: `Array4f`."""
        half, heard = len(self._pulse) // 2, jit.Array4f(0)
        for k, weight in enumerate(self._pulse):
            at = jit.Int32(bin_) + (k - half)
            inside = (at >= 0) & (at < self._ping.bins)
            heard += weight * dr.gather(jit.Array4f, raw, jit.UInt32(jit.Int32(cell) + (k - half)), inside)
        return heard

    def _along_axes(self, vector: Array, row: Array) -> Array:
        """Component of a vector of the sensor frame, by lane, along each beam: `Float`, by lane and beam."""
        beams, found = self._layout.beams, jit.Float(0)
        parts = [dr.gather(jit.Float, jit.Float(p), row // beams) for p in vector]
        for b, axis in enumerate(self._axes.tolist()):
            along = sum((p * a for p, a in zip(parts, axis, strict=True)), start=jit.Float(0))
            found = dr.select(row % beams == b, along, found)
        return found

    def _moved(
        self, view: FanHits, patches: Patches, fan: Fan, lanes: Lanes, velocity: Array, bow: Array, scale: Array
    ) -> tuple[Array, Array, Array, Array]:
        """By cell: surfaces' power; one less the cosine, and the sine of the echoes' turns about the axis's, on
        average over the pulse; and the part of the beam that is open water."""
        ping, beams, rays = self._ping, self._layout.beams, self._rays
        own = dr.gather(jit.Array3f, jit.Array3f(rotate(lanes.attitude, velocity)), view.lane)
        closing = dr.dot(own - view.hits.velocity, view.direction)
        index = dr.arange(jit.UInt32, dr.width(view.ray))
        turn = dr.gather(jit.Float, scale, view.lane) * (closing - dr.gather(jit.Float, bow, index // rays))
        near, far, t = patches.near, patches.far, view.hits.t
        if ping.sound_speed_mps is not None:
            apparent = ping.sound_speed_mps / view.of_lane(lanes.medium.sound_speed)
            near, far, t = near * apparent, far * apparent, t * apparent
        low = (near - ping.range_min_m) * (1.0 / ping.bin_width_m)
        high = dr.maximum((far - ping.range_min_m) * (1.0 / ping.bin_width_m), low + 1e-2)
        share = dr.select(patches.valid, patches.energy / (high - low), 0.0) * self._heard
        weight = dr.gather(jit.Float, fan.weight, view.ray)
        spans = dr.ravel(jit.Array4f(low, high, share, dr.select(patches.valid, t, dr.inf)))
        halved = dr.sin(0.5 * turn)
        turns = dr.ravel(jit.Array4f(2.0 * halved * halved, dr.sin(turn), weight, 0.0))
        dr.eval(spans, turns)

        cell = dr.arange(jit.UInt32, dr.width(lanes.position) * beams * ping.bins)
        row, bottom = cell // ping.bins, jit.Float(cell % ping.bins)
        middle = ping.range_min_m + (bottom + 0.5) * ping.bin_width_m
        reach = 0.5 * len(self._pulse)

        def add(k: Array, power: Array, sums: Array, free: Array) -> tuple[Array, Array, Array, Array]:
            near, far, amount, t = dr.gather(jit.Array4f, spans, row * rays + k)
            sunk, tilted, weight, _ = dr.gather(jit.Array4f, turns, row * rays + k)
            power += amount * dr.maximum(dr.minimum(far, bottom + 1.0) - dr.maximum(near, bottom), 0.0)
            low, high = bottom + (0.5 - reach), bottom + (0.5 + reach)
            wide = amount * dr.maximum(dr.minimum(far, high) - dr.maximum(near, low), 0.0)
            sums += jit.Array3f(wide, wide * sunk, wide * tilted)
            return k + 1, power, sums, free + dr.select(t > middle, weight, 0.0)

        zero = dr.zeros(jit.Float, dr.width(cell))
        start = (dr.zeros(jit.UInt32, dr.width(cell)), zero, jit.Array3f(zero, zero, zero), jit.Float(zero))
        _, power, sums, free = dr.while_loop(start, lambda k, *_: k < rays, add, mode="symbolic")
        whole = dr.select(sums.x > 0.0, 1.0 / dr.maximum(sums.x, 1e-37), 0.0)
        return power, sums.y * whole, sums.z * whole, free * (1.0 / self._psi)

    def _dulled(self, power: Array, bow: Array, scale: Array) -> Array:
        """1 - |coherence|^2 by lane and beam at which the surface's speed has the sheet's deviation."""
        bins, half = self._ping.bins, len(self._taps) // 2
        whole = dr.block_sum(power, bins)
        dr.eval(whole)
        cell = dr.arange(jit.UInt32, dr.width(power))
        part = power / dr.maximum(dr.gather(jit.Float, whole, cell // bins), 1e-37)
        dr.eval(part)
        alike = jit.Float(0)
        for k, weight in enumerate(self._taps):
            at = jit.Int32(cell % bins) + (k - half)
            alike += weight * dr.gather(
                jit.Float, part, jit.UInt32(jit.Int32(cell) + (k - half)), (at >= 0) & (at < bins)
            )
        samples = 1.0 / dr.maximum(dr.block_sum(part * alike, bins), 1e-6)
        lane = dr.arange(jit.UInt32, dr.width(bow)) // self._layout.beams
        return self._loss(samples, bow, dr.gather(jit.Float, scale, lane))

    def _loss(self, samples: Array, speed: Array, scale: Array) -> Array:
        """1 - |coherence|^2 at which `samples` independent pairs give the sheet's deviation (`pair_deviation`)."""
        floor, relative = self._deviation
        x = 2.0 * samples * (floor**2 + (relative * speed) ** 2) * scale * scale
        return x / (1.0 + x)

    def _normals(self, key: Key, lanes: Lanes, cell: Array, lane: Array) -> list[Array]:
        """Twelve standard normals a cell."""
        cells = self._layout.beams * self._ping.bins
        environment, tick = dr.gather(jit.UInt32, lanes.environment, lane), dr.gather(jit.UInt32, lanes.tick, lane)
        found: list[Array] = []
        for purpose in range(3):
            words = words32(key, cell % cells + purpose * cells, environment, tick)
            found += [*normal_pair32(words[0], words[1]), *normal_pair32(words[2], words[3])]
        return found

    def _water(
        self, ocean: Ocean, lanes: Lanes, motion: Kinematics, velocity: Array, cell: Array, distance: Array,
        free: Array, scale: Array, normals: list[Array],
    ) -> tuple[tuple[Array, Array, Array], tuple[Array, Array]]:  # fmt: skip
        """The water's power and signal in a cell, and its signal a lag later, before the pulse; `distance` as the sonar
        takes it to be."""
        if not self._hazy:
            zero = jit.Float(0)
            return (zero, zero, zero), (zero, zero)
        ping, beams = self._ping, self._layout.beams
        row = cell // ping.bins
        lane = row // beams
        if ping.sound_speed_mps is not None:
            distance = distance * dr.gather(jit.Float, lanes.medium.sound_speed, lane) * (1.0 / ping.sound_speed_mps)
        axis = jit.Array3f64(0)
        for b, direction in enumerate(self._axes.tolist()):
            axis = dr.select(row % beams == b, jit.Array3f64(*direction), axis)
        attitude = dr.gather(jit.Array4f64, lanes.attitude, lane)
        place = dr.gather(jit.Array3f64, lanes.position, lane) + rotate(attitude, axis) * jit.Float64(distance)
        t = jit.Float64(dr.gather(jit.UInt64, motion.t_ns, lane)) * 1e-9
        strength = (
            jit.Float(self._strength) if self._strength is not None else jit.Float(ocean.tracer(TRACER, place, t))
        )
        loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
        power = free * volume_intensity(from_db(strength) * self._psi, distance, loss, ping.equivalent_m)

        copy = dr.gather(jit.UInt32, motion.copy, lane)
        flow = rotate_back(attitude, ocean.current(place, t, copy)) - dr.gather(jit.Array3f64, velocity, lane)
        closing = -dr.dot(flow, axis)
        spin = dr.gather(jit.Array3f64, sensor_angular_velocity(motion, self._ping.mounting), lane)
        aside = flow + closing * axis - dr.cross(spin, axis * jit.Float64(distance))
        factor = dr.gather(jit.Float, scale, lane)
        spread = jit.Float(dr.norm(aside)) * (BEAM_SPREAD * self._layout.horizontal_width) * factor
        samples = jit.Float(self._layer_samples)
        kept = dr.exp(-spread * spread) * (1.0 - self._loss(samples, jit.Float(closing), factor))
        size = dr.sqrt(0.5 * power)
        real, imaginary = size * normals[4], size * normals[5]
        coherence, fresh = dr.sqrt(kept), dr.sqrt(1.0 - kept) * size
        s, c = dr.sincos(jit.Float(closing) * factor)
        later = (
            coherence * (real * c - imaginary * s) + fresh * normals[6],
            coherence * (real * s + imaginary * c) + fresh * normals[7],
        )
        return (power, real, imaginary), later

"""The ping of every sonar that gives intensities by range: from rays to a complex field, to levels."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.acoustics.beam_pattern import energy_reach, line_length, line_np
from pelagos.acoustics.beamforming import Field, form_beams, spread_pulse
from pelagos.acoustics.echo import Patches, accumulate
from pelagos.acoustics.pulse import point_spread, range_resolution
from pelagos.acoustics.spreading import from_db, time_varied_gain, to_db
from pelagos.acoustics.target_tag import untag
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.math.so3 import multiply, rotate
from pelagos.raycast.scene import Tables
from pelagos.sensors.echo import Fan, Lanes, Trace, View, look, patches_of
from pelagos.sensors.mount import sensor_angular_velocity, sensor_velocity
from pelagos.sensors.multipath import bounced
from pelagos.sensors.noise import normals32, words32
from pelagos.sensors.painted_noise import paint
from pelagos.sensors.ping import PingConfig, noise_power
from pelagos.sensors.scattering import Surfaces
from pelagos.sensors.sensor import Kinematics, Measurement, SensorContext
from pelagos.sensors.sounder import Sounder

_FINEST: Final = 16.0  # bins in one resolution of the pulse beyond which a finer division says nothing
_STRIP_DECAY: Final = 2  # Lambert bottom under 30 log r: energy per range falls as r^-2 along a strip


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
    """

    beams: int
    sector: float
    horizontal_width: float
    vertical_width: float
    azimuths: NDArray[np.float64]
    steering: NDArray[np.float32] | None = None
    facet: float | None = None


class Pinger:
    """What a sonar of this kind keeps from ping to ping; none of it changes.

    Args:
        config: pulse, bins, levels.
        context: see `SensorContext`.
        rays: the ray pattern.
        layout: beams.
    """

    def __init__(
        self, config: PingConfig, context: SensorContext, rays: dict[str, NDArray[Any]], layout: Layout
    ) -> None:
        self._config = config
        self._layout = layout
        self._sounder = Sounder(
            config, context, rays, frequency_hz=config.frequency_hz, ph=config.ph, wind_speed=config.wind_speed_mps,
            texture_db=config.texture_db,
        )  # fmt: skip
        resolution = range_resolution(1500.0, config.bandwidth_hz)
        if config.bin_width_m < resolution / _FINEST:
            message = f"{context.path}: bins of {config.bin_width_m:.3g} m are finer than the pulse resolves, " + (
                f"{resolution:.3g} m at a bandwidth of {config.bandwidth_hz:g} Hz"
            )
            warnings.warn(message, ValidityWarning, stacklevel=3)
        pulse = point_spread(config.bin_width_m, resolution)
        steering = np.ones((layout.beams, 1), np.float32) if layout.steering is None else layout.steering
        self._pulse_count = len(pulse)
        self._reach = (steering.shape[1] // 2, energy_reach(steering))
        noise = noise_power(config, layout.horizontal_width, layout.vertical_width)
        self._constants = (
            jit.Float(steering.ravel()),
            jit.Float(pulse),
            jit.Float(noise),
            jit.UInt32(config.roughness_seed),
        )
        dr.make_opaque(self._constants)
        self._ping = context.scene.compile(self._make)

    def ping(
        self, motion: Kinematics, turn: Array | None = None
    ) -> tuple[NDArray[np.float32], NDArray[np.float32], dict[str, NDArray[Any]]]:
        """Data and truth `(m, beams, bins)`, and extras by name.

        `turn` is a rotation of the sensor frame by lane, `Array4f64`, for heads that turn.
        """
        config = self._config
        data, truth, *rest = self._ping(*self._arguments(motion, turn))
        shape = (dr.width(motion.position), self._layout.beams, config.bins)
        extras: dict[str, NDArray[Any]] = {}
        if config.iq:
            real, imaginary = np.array(rest.pop(0)), np.array(rest.pop(0))
            extras["iq"] = (real + 1j * imaginary).astype(np.complex64).reshape(shape)
        if config.labels:
            extras["label"] = np.array(rest.pop(0)).astype(np.uint8).reshape(shape)
            extras["instance"] = np.array(rest.pop(0)).reshape(shape)
        return np.array(data).reshape(shape), np.array(truth).reshape(shape), extras

    def measurement(self, motion: Kinematics, tables: dict[str, NDArray[Any]]) -> Measurement:
        """A ping as a measurement."""
        data, truth, extras = self.ping(motion)
        return Measurement(data, truth, None, extras, tables)

    def explain(self, motion: Kinematics, turn: Array | None = None) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._make, *self._arguments(motion, turn))

    def _arguments(self, motion: Kinematics, turn: Array | None) -> tuple[Any, ...]:
        tables, lanes, fan, surfaces, key = self._sounder.arguments(motion)
        if turn is not None:
            lanes.attitude = multiply(lanes.attitude, turn)
        velocity = rotate(lanes.attitude if turn is None else multiply(lanes.attitude, _inverse(turn)),
                          sensor_velocity(motion, self._config))  # fmt: skip
        spin = sensor_angular_velocity(motion, self._config)
        return tables, lanes, fan, surfaces, key, velocity, spin, motion.t_ns, *self._constants

    def _make(self, static: Any, moving: Any, trace: Trace = None) -> Callable[..., Any]:
        config, layout = self._config, self._layout
        pulse_count, (reach, energy) = self._pulse_count, self._reach

        def ping(
            tables: Tables, lanes: Lanes, fan: Fan, surfaces: Surfaces, key: Any, velocity: Array, spin: Array,
            t_ns: Array, steering: Array, pulse: Array, noise: Array, seed: Array,
        ) -> tuple[Array, ...]:  # fmt: skip
            far = config.range_max_m + config.longest_strip_m
            view = look(static, moving, tables, fan, lanes, surfaces, max_range=far, bent=config.refraction)
            patches = [calibrated(config, layout, view, fan, lanes, surfaces, velocity, spin, trace)]
            if config.multipath != "none":
                bottom = config.bottom_loss_db if config.multipath == "surface_and_bottom" else None
                ghosts = bounced(
                    static, moving, tables, view, fan, lanes, surfaces, max_range=far, beams=layout.beams,
                    bins=config.bins, longest=config.longest_strip_m, surface_loss_db=config.surface_loss_db,
                    bottom_loss_db=bottom,
                )  # fmt: skip
                patches += [gained(config, layout, g, view, lanes) for g in ghosts]
            field, tags = echoes(config, layout, patches, view, lanes, seed, trace)
            field = spread_pulse(field, pulse, count=pulse_count, bins=config.bins)
            if reach > 0:
                field = form_beams(
                    field, steering, reach=reach, energy_reach=energy, beams=layout.beams, bins=config.bins
                )
            return levels(config, layout, field, tags, lanes, noise, key, t_ns, trace)

        return ping


def calibrated(
    config: PingConfig, layout: Layout, view: View, fan: Fan, lanes: Lanes, surfaces: Surfaces, velocity: Array,
    spin: Array, trace: Trace = None,
) -> Patches:  # fmt: skip
    """The direct echoes, as backscattering strength of the cell, at the ranges that their times mean.

    During the way of the sound the sonar and the target move: the echo of a target that closes at v arrives as from
    r (1 - v/c) (to first order in v/c; r is the range at transmission). A sonar that turns hears it in the beam that
    points at the target when the echo comes back.
    """
    patches = patches_of(
        view, fan, lanes, surfaces, beams=layout.beams, bins=config.bins, longest=config.longest_strip_m, trace=trace
    )
    if config.doppler:
        own = dr.gather(jit.Array3f, jit.Array3f(velocity), view.lane)
        closing = dr.dot(own - view.hits.velocity, view.direction)
        factor = 1.0 - closing / dr.gather(jit.Float, lanes.medium.sound_speed, view.lane)
        patches.near, patches.far = patches.near * factor, patches.far * factor
        if layout.beams > 1 and layout.steering is not None:
            turn = dr.gather(jit.Float, jit.Float(spin.z), view.lane)
            delay = 2.0 * patches.distance / dr.gather(jit.Float, lanes.medium.sound_speed, view.lane)
            beam = jit.Int32(dr.gather(jit.UInt32, fan.beam, view.ray))
            heard = beam + jit.Int32(dr.round(turn * delay / layout.sector))
            patches.valid &= (heard >= 0) & (heard < layout.beams)
            patches.row = jit.UInt32(jit.Int32(patches.row) + (heard - beam) * config.bins)
    return gained(config, layout, patches, view, lanes)


def gained(config: PingConfig, layout: Layout, patches: Patches, view: View, lanes: Lanes) -> Patches:
    """Give patches the gain 30 log r + 2 a r, and the unit of a backscattering strength."""
    loss = dr.gather(jit.Float, lanes.medium.absorption, view.lane)
    cell = layout.sector * config.bin_width_m  # solid angle times depth of a cell [rad m]
    patches.energy *= time_varied_gain(patches.distance, loss, spreading=30.0) / cell
    return patches


def echoes(
    config: PingConfig, layout: Layout, patches: list[Patches], view: View, lanes: Lanes, seed: Array,
    trace: Trace = None,
) -> tuple[Field, Array | None]:  # fmt: skip
    """The sum of all echoes by beam and bin, and the strongest one's tag."""
    total: Field | None = None
    tags: Array | None = None
    for k, group in enumerate(patches):
        real, imaginary, energy, strongest = accumulate(
            group,
            bins=config.bins,
            cells=dr.width(lanes.position) * layout.beams * config.bins,
            first_range=jit.Float(config.range_min_m),
            bin_width=jit.Float(config.bin_width_m),
            wave_cycles=2.0 * config.frequency_hz / dr.gather(jit.Float, lanes.medium.sound_speed, view.lane),
            origin=view.origin,
            facet=jit.Float(facet_size(config, layout)),
            seed=seed + k,
            decay=_STRIP_DECAY,
            tags=config.labels and k == 0,
            scattered=layout.facet is not None,
        )
        if total is None:
            total, tags = Field(real, imaginary, energy), strongest
        else:
            total = Field(total.real + real, total.imaginary + imaginary, total.energy + energy)
    assert total is not None
    if trace is not None:
        trace("echo intensity by cell, before beams are formed", total.energy, "1")
    return total, tags


def facet_size(config: PingConfig, layout: Layout) -> float:
    """Edge of the roughness lattice [m]: speckle decorrelates over half an aperture, and from bin to bin."""
    if layout.facet is not None:
        return layout.facet
    aperture = line_length(layout.horizontal_width) * 1500.0 / config.frequency_hz
    return min(0.5 * aperture, 0.5 * config.bin_width_m)


def levels(
    config: PingConfig, layout: Layout, field: Field, tags: Array | None, lanes: Lanes, noise: Array, key: Any,
    t_ns: Array, trace: Trace = None,
) -> tuple[Array, ...]:  # fmt: skip
    """Add noise, set gain and scale: data, truth, with `iq` the complex signal before gain, with `labels` the tags."""
    cells = layout.beams * config.bins
    index = dr.arange(jit.UInt32, dr.width(field.real))
    lane, cell = index // cells, index % cells
    beam, bin_ = cell // config.bins, cell % config.bins
    loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
    distance = config.range_min_m + (jit.Float(bin_) + 0.5) * config.bin_width_m
    gain = time_varied_gain(distance, loss, spreading=30.0) / (layout.sector * config.bin_width_m)
    environment, tick = dr.gather(jit.UInt32, lanes.environment, lane), dr.gather(jit.UInt32, lanes.tick, lane)
    n1, n2 = normals32(key, cell, environment, tick)
    power = noise
    if config.interference is not None:
        power = noise + interference(config, layout, beam, distance, lanes, lane, t_ns)
    size = dr.sqrt(0.5 * power * gain)
    real, imaginary = field.real + size * n1, field.imaginary + size * n2
    tilt = distance ** ((config.tvg_db - 30.0) / 10.0) if config.tvg_db != 30.0 else jit.Float(1)
    intensity = (real * real + imaginary * imaginary) * tilt
    if config.painted_noise is not None:
        words = words32(key, cell + jit.UInt32(0x40000000), environment, tick)
        intensity = paint(config.painted_noise, intensity, words)
    if trace is not None:
        trace("signal-to-noise ratio", to_db(dr.maximum(field.energy, 1e-20) / (noise * gain)), "dB")
        trace("echo level after gain", to_db(dr.maximum(intensity, 1e-20)), "dB")
    out = [scaled(config, intensity), scaled(config, field.energy * tilt)]
    if config.iq:
        raw = dr.rsqrt(gain)
        out += [real * raw, imaginary * raw]
    if tags is not None:
        out += untag(tags)
    return tuple(out)


def scaled(config: PingConfig, intensity: Array) -> Array:
    """Intensity as the configuration wants it."""
    if config.scale == "linear":
        return intensity
    level = to_db(dr.maximum(intensity, 1e-20))
    if config.scale == "db":
        return level
    return dr.clip((level - config.floor_db) / config.dynamic_range_db, 0.0, 1.0)


def interference(
    config: PingConfig, layout: Layout, beam: Array, distance: Array, lanes: Lanes, lane: Array, t_ns: Array
) -> Array:
    """Intensity of another sonar's direct pulse re the source level at 1 m, where it falls into this ping.

    The other one's clock starts at t = 0; a pulse that was sent at its k-th period arrives distance/c later, and is
    heard in the bin of its time after this sonar's own transmission, in all beams by their pattern.
    """
    other = config.interference
    assert other is not None
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
    period_ns = round(1e9 / other.rate_hz)
    start_ns = dr.gather(jit.UInt64, t_ns, lane) % jit.UInt64(period_ns)
    since = 2.0 * distance / speed - (other.distance_m / speed - jit.Float(start_ns) * 1e-9)
    period = period_ns * 1e-9
    phase = since / period
    within = (phase - dr.floor(phase)) * period
    level = other.source_level_db - config.source_level_db - loss * other.distance_m
    level -= 20.0 * math.log10(other.distance_m)
    table = jit.Float(0)
    length = line_length(layout.horizontal_width)
    seen = line_np(np.sin(layout.azimuths) - math.sin(math.radians(other.azimuth_deg)), length) ** 2
    for k in np.flatnonzero(seen > 1e-4):
        table = dr.select(beam == int(k), float(seen[k]), table)
    return dr.select(within < other.pulse_s, from_db(level) * table, 0.0)


def _inverse(q: Array) -> Array:
    return jit.Array4f64(q[0], -q[1], -q[2], -q[3])

"""Multibeam echo sounder: soundings across the track, by bottom detection in narrow beams."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length, line_np
from pelagos.acoustics.bottom_detection import amplitude_error, phase_error
from pelagos.acoustics.noise import ambient_level, band_level, directivity_index
from pelagos.acoustics.pulse import processing_gain_db
from pelagos.acoustics.spreading import from_db, patch_intensity, time_varied_gain, to_db
from pelagos.jit import Array
from pelagos.raycast.scene import Tables
from pelagos.sensors.echo import Fan, Lanes, Trace, View, look, patches_of
from pelagos.sensors.noise import normals32
from pelagos.sensors.scattering import Surfaces
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar_catalogue import with_device
from pelagos.sensors.sounder import Sounder

_ACROSS: Final = np.array([-0.8, -0.4, 0.0, 0.4, 0.8])  # places of the rays in a beam [half-power widths]
_GATE: Final = 0.06  # detection window about the strongest echo [of the range]


class MultibeamConfig(SensorConfig):
    """A multibeam echo sounder that looks down (along -z of its frame). Defaults are of the 400 kHz shallow class."""

    type: Literal["multibeam"] = "multibeam"
    rate_hz: float = Field(default=5.0, gt=0)
    """Pings per second [Hz]."""
    device: str | None = None
    """A device of the catalogue, whose keys count where the scenario gives none."""
    beams: int = Field(default=256, ge=1, le=4096)
    """Beams across the track."""
    swath_deg: float = Field(default=120.0, gt=0, le=170)
    """Angle between the outermost beams [deg]."""
    spacing: Literal["equiangular", "equidistant"] = "equiangular"
    """Whether beams are spread evenly in angle or over a flat bottom."""
    beamwidth_across_deg: float = Field(default=1.0, gt=0, le=20)
    """Half-power width across the track at nadir [deg]."""
    beamwidth_along_deg: float = Field(default=1.0, gt=0, le=20)
    """Half-power width along the track [deg]."""
    range_min_m: float = Field(default=0.5, ge=0)
    """Nearest bottom that is detected [m]."""
    range_max_m: float = Field(default=120.0, gt=0, le=12000)
    """Farthest bottom that is detected [m]."""
    frequency_hz: float = Field(default=400e3, gt=0)
    """Centre frequency [Hz]."""
    bandwidth_hz: float = Field(default=40e3, gt=0)
    """Bandwidth of the pulse [Hz]."""
    pulse_s: float = Field(default=0.5e-3, gt=0)
    """Duration of the pulse [s]."""
    source_level_db: float = Field(default=210.0)
    """Source level [dB re 1 uPa at 1 m]."""  # assumed
    self_noise_db: float = Field(default=45.0)
    """Spectral level of the receiver's own noise [dB re 1 uPa^2/Hz]."""  # assumed
    detection_snr_db: float = Field(default=10.0)
    """Signal-to-noise ratio below which a beam finds no bottom [dB]."""  # assumed
    sound_speed_mps: float | None = Field(default=None, gt=1300, lt=1700)
    """Sound speed that turns times into ranges [m/s]; absent: that of the water at the sonar."""
    wind_speed_mps: float = Field(default=5.0, ge=0)
    """Wind for ambient noise and the sea surface [m/s]."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""
    rays_along: int = Field(default=3, ge=1, le=31)
    """Rays of a beam along the track; across it they are five."""

    @model_validator(mode="before")
    @classmethod
    def _device(cls, values: Any) -> Any:
        return with_device(values, cls.model_fields["type"].default)

    @field_validator("rays_along")
    @classmethod
    def _odd(cls, value: int) -> int:
        if value % 2 == 0:
            raise ValueError(f"rays_along must be odd (one ray lies on the axis), not {value}")
        return value

    @model_validator(mode="after")
    def _ordered(self) -> MultibeamConfig:
        if self.range_min_m >= self.range_max_m:
            raise ValueError(f"range_min_m {self.range_min_m:g} must be below range_max_m {self.range_max_m:g}")
        return self

    @property
    def angles(self) -> NDArray[np.float64]:
        """Beam angles from straight down `(beams,)` [rad], positive to port, from port to starboard."""
        half = math.radians(self.swath_deg) / 2
        if self.beams == 1:
            return np.zeros(1)
        if self.spacing == "equidistant":
            return np.arctan(np.linspace(math.tan(half), -math.tan(half), self.beams))
        return np.linspace(half, -half, self.beams)

    @property
    def rays_per_beam(self) -> int:
        """Five across times `rays_along`."""
        return len(_ACROSS) * self.rays_along


def fan_rays(config: MultibeamConfig) -> dict[str, NDArray[Any]]:
    """The ray pattern in the sensor frame (x forward, beams in the y-z plane), `rays_per_beam` for each beam.

    The middle ray of a beam lies on its axis. Steered beams are wider by 1/cos of the steering angle.
    """
    places = np.linspace(-0.8, 0.8, config.rays_along) if config.rays_along > 1 else np.zeros(1)
    beam, across, along = (a.ravel() for a in np.meshgrid(np.arange(config.beams), _ACROSS, places, indexing="ij"))
    axis = config.angles[beam]
    width = math.radians(config.beamwidth_across_deg) / np.cos(axis)
    angle = axis + across * width
    tilt = along * math.radians(config.beamwidth_along_deg)
    ca, sa, ct, st = np.cos(angle), np.sin(angle), np.cos(tilt), np.sin(tilt)
    receive = line_np(across * math.radians(config.beamwidth_across_deg), _length(config.beamwidth_across_deg)) ** 2
    transmit = line_np(st, _length(config.beamwidth_along_deg)) ** 2
    step_along = math.radians(config.beamwidth_along_deg) * (places[1] - places[0] if len(places) > 1 else 1.0)
    step = 0.4 * width
    return {
        "direction": np.stack([st, ct * sa, -ct * ca], axis=-1),
        "aside": np.zeros((len(beam), 3)),
        "along": np.stack([0 * sa, ca, sa], axis=-1),
        "lower": -0.5 * step,
        "upper": 0.5 * step,
        "weight": step * step_along * ct * receive * transmit,
        "beam": beam,
    }


def _length(width_deg: float) -> float:
    return line_length(math.radians(width_deg))


@jit.struct
class Echo:
    """What each beam received, one lane a beam: a Dr.Jit struct.

    Attributes:
        found: `Bool`.
        centre: `Float`, range of the echo's centre of gravity [m].
        crossing: `Float`, range at which the echo's direction crosses the beam's axis [m].
        spread: `Float`, its rms extent in range [m].
        energy: `Float`, intensity re the source level at 1 m.
        section: `Float`, mean cross section per unit area of what was hit [1].
        axis: `Float`, range along the beam's axis [m], infinite without a hit.
        label, instance: `UInt32`, on the axis.
    """

    found: Array
    centre: Array
    crossing: Array
    spread: Array
    energy: Array
    section: Array
    axis: Array
    label: Array
    instance: Array


class Multibeam:
    """A multibeam echo sounder.

    data: `(m, beams)` float32, detected slant ranges [m]; NaN where no bottom was found.
    truth: `(m, beams)` float32, ranges along the beam axes [m]; NaN where nothing is in range.
    extras: `soundings` `(m, beams, 3)` in the sensor frame [m]; `backscatter` `(m, beams)`, of the bottom [dB];
        `quality` `(m, beams)`, 0 (none) to 1; `snr` `(m, beams)` [dB]; `label` and `instance` `(m, beams)` on the axis.
    tables: `angle` `(beams,)` [rad] from straight down, positive to port; `direction` `(beams, 3)`.
    """

    TITLE: ClassVar[str] = "multibeam echo sounder: soundings and backscatter across the track"
    Config: ClassVar[type[SensorConfig]] = MultibeamConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Sections 8.2 and 8.3: bottom detection",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
        "R. E. Francois and G. R. Garrison, J. Acoust. Soc. Am. 72, 1879 (1982), doi 10.1121/1.388673: absorption",
    )

    def __init__(self, config: MultibeamConfig, context: SensorContext) -> None:
        self.config = config
        rays = fan_rays(config)
        self._sounder = Sounder(
            config, context, rays, frequency_hz=config.frequency_hz, ph=config.ph, wind_speed=config.wind_speed_mps
        )
        self._noise = dr.opaque(jit.Float, _noise_power(config))
        self._ping = context.scene.compile(self._make)
        axis = rays["direction"][config.rays_per_beam // 2 :: config.rays_per_beam]
        self.tables = {"angle": config.angles.astype(np.float32), "direction": axis.astype(np.float32)}

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        distance, truth, backscatter, quality, snr, label, instance = self._ping(*self._arguments(motion))
        shape = (dr.width(motion.position), self.config.beams)
        data = np.array(distance).reshape(shape)
        extras = {
            "soundings": data[..., None] * self.tables["direction"],
            "backscatter": np.array(backscatter).reshape(shape),
            "quality": np.array(quality).reshape(shape),
            "snr": np.array(snr).reshape(shape),
            "label": np.array(label).reshape(shape),
            "instance": np.array(instance).reshape(shape),
        }
        return Measurement(data, np.array(truth).reshape(shape), None, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._make, *self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return (*self._sounder.arguments(motion), self._noise)

    def _make(self, static: Any, moving: Any, trace: Trace = None) -> Callable[..., Any]:
        config = self.config

        def ping(
            tables: Tables, lanes: Lanes, fan: Fan, surfaces: Surfaces, key: Any, noise: Array
        ) -> tuple[Array, ...]:
            view = look(static, moving, tables, fan, lanes, surfaces, max_range=1.1 * config.range_max_m)
            echo = beam_echoes(config, view, fan, lanes, surfaces, trace)
            return detect(config, echo, lanes, noise, key, trace)

        return ping


def beam_echoes(
    config: MultibeamConfig, view: View, fan: Fan, lanes: Lanes, surfaces: Surfaces, trace: Trace = None
) -> Echo:
    """Centre, extent and energy of the strongest echo in each beam."""
    rays = config.rays_per_beam
    patches = patches_of(view, fan, lanes, surfaces, longest=0.2 * config.range_max_m, trace=trace)
    dr.eval(patches, view)  # one cast: block reductions and gathers would each begin with their own
    loss = dr.gather(jit.Float, lanes.medium.absorption, view.lane)
    t, energy = patches.distance, patches.energy
    level = energy * time_varied_gain(t, loss, spreading=20.0)  # so that near things do not win by nearness alone
    level = dr.select(patches.valid, level, 0.0)
    strip = (patches.far - patches.near) ** 2 / 12.0
    density = energy / (dr.gather(jit.Float, fan.weight, view.ray) * patch_intensity(t, loss)) * view.sine
    dr.eval(t, energy, level, strip, density, view.hits)
    first = dr.arange(jit.UInt32, dr.width(lanes.position) * config.beams) * rays
    strongest, where = jit.Float(0), jit.Float(0)
    for k in range(rays):
        loud = dr.gather(jit.Float, level, first + k)
        where = dr.select(loud > strongest, dr.gather(jit.Float, t, first + k), where)
        strongest = dr.maximum(strongest, loud)
    total, mean, square, section = jit.Float(0), jit.Float(0), jit.Float(0), jit.Float(0)
    lean, lean2, both = jit.Float(0), jit.Float(0), jit.Float(0)
    for k in range(rays):
        distance = dr.gather(jit.Float, t, first + k)
        offset = distance - where
        heard = (dr.gather(jit.Float, level, first + k) > 0.0) & (dr.abs(offset) <= _GATE * distance + 0.2)
        weight = dr.select(heard, dr.gather(jit.Float, energy, first + k), 0.0)
        place = float(_ACROSS[k // config.rays_along])
        total += weight
        mean += weight * offset
        square += weight * (offset * offset + dr.gather(jit.Float, strip, first + k))
        lean += weight * place
        lean2 += weight * (place * place)
        both += weight * place * offset
        section += weight * dr.gather(jit.Float, density, first + k)
    scale = 1.0 / dr.maximum(total, 1e-37)
    mean, square, lean = mean * scale, square * scale, lean * scale
    lean2 = lean2 * scale - lean * lean
    slope = dr.select(lean2 > 1e-3, (both * scale - mean * lean) / dr.maximum(lean2, 1e-3), 0.0)
    middle = first + rays // 2
    valid = dr.gather(jit.Bool, view.hits.valid, middle)
    return Echo(
        found=total > 1e-36,
        centre=where + mean,
        crossing=where + mean - slope * lean,
        spread=dr.sqrt(dr.maximum(square - mean * mean, 0.0)),
        energy=total,
        section=section * scale,
        axis=dr.select(valid, dr.gather(jit.Float, view.hits.t, middle), dr.inf),
        label=dr.gather(jit.UInt32, view.hits.label, middle),
        instance=dr.gather(jit.UInt32, view.hits.instance, middle),
    )


def detect(
    config: MultibeamConfig, echo: Echo, lanes: Lanes, noise: Array, key: Any, trace: Trace = None
) -> tuple[Array, ...]:
    """Range, true range, backscatter, quality, signal-to-noise ratio, label and instance of each beam."""
    index = dr.arange(jit.UInt32, dr.width(echo.centre))
    lane, beam = index // config.beams, index % config.beams
    speed = dr.gather(jit.Float, lanes.medium.sound_speed, lane)
    resolution = speed / (2.0 * config.bandwidth_hz)
    snr = echo.energy / noise
    amplitude = amplitude_error(echo.spread, resolution, snr)
    baseline = 0.5 * _length(config.beamwidth_across_deg) * math.radians(config.beamwidth_across_deg)
    phase = phase_error(echo.centre, echo.spread, resolution, snr, baseline=baseline)
    error = dr.minimum(amplitude, phase)
    n1, n2 = normals32(
        key, beam, dr.gather(jit.UInt32, lanes.environment, lane), dr.gather(jit.UInt32, lanes.tick, lane)
    )
    measured = dr.select(phase < amplitude, echo.crossing, echo.centre) + error * n1
    if config.sound_speed_mps is not None:
        measured *= config.sound_speed_mps / speed
    snr_db = to_db(dr.maximum(snr, 1e-12))
    found = echo.found & (snr_db > config.detection_snr_db)
    found &= (measured >= config.range_min_m) & (measured <= config.range_max_m)
    looks = 1.0 + 2.0 * math.sqrt(3.0) * echo.spread / resolution
    strength = to_db(dr.maximum(echo.section, 1e-12)) + 4.34 * n2 / dr.sqrt(looks)
    quality = dr.select(found, 1.0 / (1.0 + (error / (0.002 * echo.centre + 1e-3)) ** 2), 0.0)
    true = dr.select(echo.axis <= config.range_max_m, echo.axis, dr.nan)
    if trace is not None:
        for name, value, unit in (
            ("range spread in a beam", echo.spread, "m"),
            ("signal-to-noise ratio", snr_db, "dB"),
            ("error of amplitude detection", amplitude, "m"),
            ("error of phase detection", phase, "m"),
            ("detected range", measured, "m"),
        ):
            trace(name, value, unit)
    data = dr.select(found, measured, dr.nan)
    return data, true, dr.select(found, strength, dr.nan), quality, snr_db, echo.label, echo.instance


def _noise_power(config: MultibeamConfig) -> float:
    """Noise intensity behind matched filter and beamformer re the source level at 1 m."""
    ambient = ambient_level(config.frequency_hz, config.wind_speed_mps)
    spectral = float(to_db(from_db(ambient) + from_db(config.self_noise_db)))
    gains = processing_gain_db(config.bandwidth_hz, config.pulse_s) + directivity_index(
        math.radians(config.beamwidth_across_deg), math.radians(60.0)
    )
    return float(from_db(band_level(spectral, config.bandwidth_hz) - gains - config.source_level_db))

"""Forward-looking imaging sonar: an intensity for every beam and range, as interference makes it."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.acoustics.beam_pattern import energy_reach, line_length, line_np, steering_matrix
from pelagos.acoustics.beamforming import Field as EchoField
from pelagos.acoustics.beamforming import form_beams, spread_pulse
from pelagos.acoustics.echo import accumulate
from pelagos.acoustics.noise import ambient_level, band_level, directivity_index
from pelagos.acoustics.pulse import point_spread, processing_gain_db, range_resolution
from pelagos.acoustics.spreading import from_db, time_varied_gain, to_db
from pelagos.jit import Array
from pelagos.raycast.scene import Tables
from pelagos.sensors.echo import Fan, Lanes, Trace, View, look, patches_of
from pelagos.sensors.noise import normals32
from pelagos.sensors.scattering import Surfaces
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sounder import Sounder

_STEP: Final = 0.7548776662466927  # additive recurrence of the plastic number: evenly spread in two dimensions
_STEP2: Final = 0.5698402909980532
_STRIP_DECAY: Final = 2  # Lambert bottom under 30 log r: energy per range falls as r^-2 along a strip


class ImagingSonarConfig(SensorConfig):
    """A multibeam forward-looking sonar. Defaults are of the 750 kHz class with 130 x 20 deg."""

    type: Literal["imaging_sonar"] = "imaging_sonar"
    rate_hz: float = Field(default=5.0, gt=0)
    """Pings per second [Hz]."""
    beams: int = Field(default=256, ge=1, le=4096)
    """Beams across the sector."""
    bins: int = Field(default=512, ge=8, le=16384)
    """Range bins."""
    range_min_m: float = Field(default=0.5, gt=0)
    """Near edge of the first bin [m]."""
    range_max_m: float = Field(default=60.0, gt=0, le=1000)
    """Far edge of the last bin [m]."""
    horizontal_aperture_deg: float = Field(default=130.0, gt=0, le=170)
    """Sector [deg], from the first beam's outer edge to the last one's."""
    vertical_beamwidth_deg: float = Field(default=20.0, gt=0, le=90)
    """Half-power width of the fan in elevation [deg], one way."""
    beamwidth_deg: float = Field(default=1.0, gt=0, le=20)
    """Half-power width of a receive beam at broadside [deg]."""
    shading: Literal["uniform", "light", "hamming", "hann"] = "light"
    """Weights of the receive array: side lobes at -13, -21, -43 and -31 dB."""
    side_lobe_beams: int = Field(default=8, ge=0, le=256)
    """Neighbours on each side whose echoes leak into a beam."""
    frequency_hz: float = Field(default=750e3, gt=0)
    """Centre frequency [Hz]."""
    bandwidth_hz: float = Field(default=30e3, gt=0)
    """Bandwidth of the pulse [Hz]; the range resolution is c/2B."""
    pulse_s: float = Field(default=0.5e-3, gt=0)
    """Duration of the pulse [s]; with the bandwidth it gives the gain of the matched filter."""
    source_level_db: float = Field(default=205.0)
    """Source level [dB re 1 uPa at 1 m]."""  # assumed
    self_noise_db: float = Field(default=55.0)
    """Spectral level of the receiver's own noise [dB re 1 uPa^2/Hz]."""  # assumed
    wind_speed_mps: float = Field(default=5.0, ge=0)
    """Wind for ambient noise and the sea surface [m/s]."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""
    tvg_db: float = Field(default=30.0, ge=0, le=60)
    """Spreading k of the gain k log10(r) + 2 a r: 30 keeps a bottom level, 40 point targets."""
    scale: Literal["unit", "db", "linear"] = "unit"
    """What `data` and `truth` are: decibels mapped to 0 .. 1, decibels, or linear intensity."""
    floor_db: float = Field(default=-50.0)
    """Level that `scale: unit` maps to 0 [dB]."""
    dynamic_range_db: float = Field(default=45.0, gt=0)
    """Decibels that `scale: unit` maps to 0 .. 1."""
    rays_per_beam: int = Field(default=96, ge=4, le=4096)
    """Rays a beam, stratified in elevation."""
    roughness_seed: int = Field(default=0, ge=0, lt=2**32)
    """Which realisation of the roughness of all surfaces the sonar sees."""
    iq: bool = False
    """Also give the complex signal, before gain."""

    @model_validator(mode="after")
    def _ordered(self) -> ImagingSonarConfig:
        if self.range_min_m >= self.range_max_m:
            raise ValueError(f"range_min_m {self.range_min_m:g} must be below range_max_m {self.range_max_m:g}")
        return self

    @property
    def bin_width_m(self) -> float:
        """Width of a range bin [m]."""
        return (self.range_max_m - self.range_min_m) / self.bins

    @property
    def longest_strip_m(self) -> float:
        """How far a ray's patch of surface may reach in range [m]."""
        return 0.125 * self.range_max_m

    @property
    def azimuths(self) -> NDArray[np.float64]:
        """Beam directions `(beams,)` [rad], positive to the left, from left to right as an image's columns are."""
        sector = math.radians(self.horizontal_aperture_deg)
        return np.asarray(sector * (0.5 - (np.arange(self.beams) + 0.5) / self.beams))


def fan_rays(config: ImagingSonarConfig) -> dict[str, NDArray[Any]]:
    """The ray pattern in the sensor frame, `rays_per_beam` for each beam (see `Fan`).

    Elevation strata reach to the first nulls of the vertical pattern and are thinner where the pattern is strong; each
    holds one ray. Neighbours in memory are neighbours in azimuth, whose patches are alike. Rays stand
    at low-discrepancy places in their strata and across the beam's sector.
    """
    beams, rays = config.beams, config.rays_per_beam
    length = line_length(math.radians(config.vertical_beamwidth_deg))
    limit = min(math.asin(min(1.0 / length, 1.0)), math.radians(80.0))
    grid = np.linspace(-limit, limit, 2001)
    density = 0.35 + line_np(np.sin(grid), length) ** 2
    share = np.concatenate([[0.0], np.cumsum(0.5 * (density[1:] + density[:-1]))])
    edges = np.interp(np.linspace(0, share[-1], rays + 1), share, grid)
    k, j = (a.ravel() for a in np.meshgrid(np.arange(rays), np.arange(beams), indexing="ij"))
    place = (0.5 + _STEP * j + _STEP2 * k) % 1.0
    low, high = edges[k], edges[k + 1]
    elevation = low + place * (high - low)
    width = math.radians(config.horizontal_aperture_deg) / beams
    azimuth = config.azimuths[j] + ((0.5 + _STEP * k + _STEP2 * j) % 1.0 - 0.5) * width
    ce, se, ca, sa = np.cos(elevation), np.sin(elevation), np.cos(azimuth), np.sin(azimuth)
    direction = np.stack([ce * ca, ce * sa, se], axis=-1)
    middle = config.azimuths[j]
    return {
        "direction": direction,
        "aside": np.stack([ce * np.cos(middle), ce * np.sin(middle), se], axis=-1) - direction,
        "along": np.stack([-se * ca, -se * sa, ce], axis=-1),
        "lower": low - elevation,
        "upper": high - elevation,
        "weight": width * (np.sin(high) - np.sin(low)) * line_np(se, length) ** 4,
        "beam": j,
    }


class ImagingSonar:
    """A forward-looking imaging sonar.

    data: `(m, beams, bins)` float32, echo level after time-varied gain. In decibels it is the backscattering strength
        that a horizontal bottom filling the cell would have (with tvg_db 30); `scale` says how it is given.
    truth: the same without noise and without interference (the mean over all realisations of the roughness).
    extras: with `iq`, `iq` complex64 `(m, beams, bins)`, signal and noise before gain, re the source level at 1 m.
    tables: `azimuth` `(beams,)` [rad], positive to the left; `range` `(bins,)` [m], middle of each bin.
    """

    TITLE: ClassVar[str] = "forward-looking multibeam imaging sonar: polar intensity images with coherent speckle"
    Config: ClassVar[type[SensorConfig]] = ImagingSonarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Chapters 3, 5 and 8",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
        "R. E. Francois and G. R. Garrison, J. Acoust. Soc. Am. 72, 1879 (1982), doi 10.1121/1.388673: absorption",
        "J. W. Goodman, Speckle Phenomena in Optics, 2nd ed. (2020): coherent sum",
        "G. M. Wenz, J. Acoust. Soc. Am. 34, 1936 (1962), doi 10.1121/1.1909155: ambient noise",
    )

    def __init__(self, config: ImagingSonarConfig, context: SensorContext) -> None:
        self.config = config
        self._sounder = Sounder(
            config, context, fan_rays(config), frequency_hz=config.frequency_hz, ph=config.ph,
            wind_speed=config.wind_speed_mps,
        )  # fmt: skip
        self._seed = dr.opaque(jit.UInt32, config.roughness_seed)
        width = math.radians(config.beamwidth_deg)
        steering = steering_matrix(config.azimuths, width, config.shading, config.side_lobe_beams)
        self._steering = jit.Float(steering.ravel())
        pulse = point_spread(config.bin_width_m, range_resolution(1500.0, config.bandwidth_hz))
        self._pulse = jit.Float(pulse)
        self._taps = (len(pulse), config.side_lobe_beams, energy_reach(steering))
        self._noise = dr.opaque(jit.Float, _noise_power(config))
        dr.eval(self._steering, self._pulse)
        self._ping = context.scene.compile(self._make)
        first = config.range_min_m + 0.5 * config.bin_width_m
        self.tables = {
            "azimuth": config.azimuths.astype(np.float32),
            "range": (first + config.bin_width_m * np.arange(config.bins)).astype(np.float32),
        }

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        data, truth, *signal = self._ping(*self._arguments(motion))
        shape = (dr.width(motion.position), self.config.beams, self.config.bins)
        extras = {}
        if self.config.iq:
            real, imaginary = (np.array(part) for part in signal)
            extras["iq"] = (real + 1j * imaginary).astype(np.complex64).reshape(shape)
        return Measurement(np.array(data).reshape(shape), np.array(truth).reshape(shape), None, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._make, *self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return (*self._sounder.arguments(motion), self._steering, self._pulse, self._noise, self._seed)

    def _make(self, static: Any, moving: Any, trace: Trace = None) -> Callable[..., Any]:
        config, taps = self.config, self._taps

        def ping(
            tables: Tables, lanes: Lanes, fan: Fan, surfaces: Surfaces, key: Any, steering: Array, pulse: Array,
            noise: Array, seed: Array,
        ) -> tuple[Array, ...]:  # fmt: skip
            view = look(
                static, moving, tables, fan, lanes, surfaces, max_range=config.range_max_m + config.longest_strip_m
            )
            field = echoes(config, view, fan, lanes, surfaces, seed, trace)
            field = spread_pulse(field, pulse, count=taps[0], bins=config.bins)
            field = form_beams(
                field, steering, reach=taps[1], energy_reach=taps[2], beams=config.beams, bins=config.bins
            )
            return image(config, field, lanes, noise, key, trace)

        return ping


def echoes(
    config: ImagingSonarConfig, view: View, fan: Fan, lanes: Lanes, surfaces: Surfaces, seed: Array, trace: Trace = None
) -> EchoField:
    """Echoes of what the rays saw, by beam and bin, as backscattering strength of the cell (gain 30 log r + 2 a r)."""
    beams, bins, width = config.beams, config.bins, config.bin_width_m
    patches = patches_of(
        view, fan, lanes, surfaces, beams=beams, bins=bins, longest=config.longest_strip_m, trace=trace
    )
    loss = dr.gather(jit.Float, lanes.medium.absorption, view.lane)
    cell = math.radians(config.horizontal_aperture_deg) / beams * width  # solid angle times depth of a cell [rad m]
    patches.energy *= time_varied_gain(patches.distance, loss, spreading=30.0) / cell
    real, imaginary, energy = accumulate(
        patches,
        bins=bins,
        cells=dr.width(lanes.position) * beams * bins,
        first_range=jit.Float(config.range_min_m),
        bin_width=jit.Float(width),
        wave_cycles=2.0 * config.frequency_hz / dr.gather(jit.Float, lanes.medium.sound_speed, view.lane),
        origin=view.origin,
        facet=jit.Float(facet_size(config)),
        seed=seed,
        decay=_STRIP_DECAY,
    )
    if trace is not None:
        trace("echo intensity by cell, before beams are formed", energy, "1")
    return EchoField(real, imaginary, energy)


def facet_size(config: ImagingSonarConfig) -> float:
    """Edge of the roughness lattice [m]: speckle decorrelates over half an aperture, and from bin to bin."""
    aperture = line_length(math.radians(config.beamwidth_deg)) * 1500.0 / config.frequency_hz
    return min(0.5 * aperture, 0.5 * config.bin_width_m)


def image(
    config: ImagingSonarConfig, field: EchoField, lanes: Lanes, noise: Array, key: Any, trace: Trace = None
) -> tuple[Array, ...]:
    """Add receiver noise, set the gain and the scale: data, truth, and with `iq` the complex signal before gain."""
    cells = config.beams * config.bins
    index = dr.arange(jit.UInt32, dr.width(field.real))
    lane, cell = index // cells, index % cells
    loss = dr.gather(jit.Float, lanes.medium.absorption, lane)
    distance = config.range_min_m + (jit.Float(cell % config.bins) + 0.5) * config.bin_width_m
    area = math.radians(config.horizontal_aperture_deg) / config.beams * config.bin_width_m
    gain = time_varied_gain(distance, loss, spreading=30.0) / area
    n1, n2 = normals32(
        key, cell, dr.gather(jit.UInt32, lanes.environment, lane), dr.gather(jit.UInt32, lanes.tick, lane)
    )
    size = dr.sqrt(0.5 * noise * gain)
    real, imaginary = field.real + size * n1, field.imaginary + size * n2
    tilt = distance ** ((config.tvg_db - 30.0) / 10.0) if config.tvg_db != 30.0 else 1.0
    intensity = (real * real + imaginary * imaginary) * tilt
    if trace is not None:
        trace("signal-to-noise ratio", to_db(dr.maximum(field.energy, 1e-20) / (noise * gain)), "dB")
        trace("echo level after gain", to_db(dr.maximum(intensity, 1e-20)), "dB")
    levels = scaled(config, intensity), scaled(config, field.energy * tilt)
    if not config.iq:
        return levels
    raw = dr.rsqrt(gain)
    return (*levels, real * raw, imaginary * raw)


def scaled(config: ImagingSonarConfig, intensity: Array) -> Array:
    """Intensity as the configuration wants it."""
    if config.scale == "linear":
        return intensity
    level = to_db(dr.maximum(intensity, 1e-20))
    if config.scale == "db":
        return level
    return dr.clip((level - config.floor_db) / config.dynamic_range_db, 0.0, 1.0)


def _noise_power(config: ImagingSonarConfig) -> float:
    """Noise intensity behind matched filter and beamformer re the source level at 1 m."""
    spectral = float(
        to_db(from_db(ambient_level(config.frequency_hz, config.wind_speed_mps)) + from_db(config.self_noise_db))
    )
    gains = processing_gain_db(config.bandwidth_hz, config.pulse_s) + directivity_index(
        math.radians(config.beamwidth_deg), math.radians(config.vertical_beamwidth_deg)
    )
    level = band_level(spectral, config.bandwidth_hz) - gains - config.source_level_db
    return float(from_db(level))

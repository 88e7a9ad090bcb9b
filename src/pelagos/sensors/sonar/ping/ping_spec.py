"""A ping in plain SI values: what the machinery of sonars needs to know, without any configuration."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.noise import ambient_level, band_level, directivity_index
from pelagos.acoustics.pulse import EQUIVALENT_WIDTH, SHADING_LOSS_DB, processing_gain_db, range_resolution
from pelagos.acoustics.spreading import from_db, to_db
from pelagos.math.constants import NOMINAL_SOUND_SPEED

Scale: TypeAlias = Literal["unit", "db", "linear"]
Refraction: TypeAlias = 'bool | Literal["auto"]'


@dataclass(frozen=True)
class Mounting:
    """Place of a sonar on its vehicle.

    Attributes:
        position_m: in the body frame FLU [m].
        q_body_sensor: its frame in the body frame, (w, x, y, z).
    """

    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    q_body_sensor: tuple[float, float, float, float] = (1.0, 0.0, 0.0, 0.0)


@dataclass(frozen=True)
class Painting:
    """Noise painted on a finished image; fields as of `PaintedNoise` among the keys."""

    additive: float
    additive_reference_db: float
    multiplicative: float
    range_m: float
    azimuth_streaks: Literal["none", "dark", "bright"]
    onto: Literal["intensity", "level"] = "intensity"


@dataclass(frozen=True)
class Disturber:
    """Another sonar by its own clock, which is not in the scenario.

    Attributes:
        rate_hz, distance_m, source_level_db, pulse_s: of its pings.
        direction: where it is, unit vector in the sensor frame.
    """

    rate_hz: float
    direction: tuple[float, float, float]
    distance_m: float
    source_level_db: float
    pulse_s: float


@dataclass(frozen=True)
class Bounces:
    """Echoes by way of mirrors.

    Attributes:
        bottom: also by the bottom and all else, besides the sea surface.
        order: bounces of one way at most.
        surface_loss_db: of each at the sea surface; None: by bubbles.
        bottom_loss_db: of each anywhere else, besides what its material takes.
    """

    bottom: bool
    order: int
    surface_loss_db: float | None
    bottom_loss_db: float


@dataclass(frozen=True)
class Display:
    """Scale of levels.

    Attributes:
        tvg_db: spreading k of the gain k log10(r) + 2 a r.
        scale: decibels mapped to 0 .. 1, decibels, or linear intensity.
        floor_db, dynamic_range_db: of the mapping.
        painting: noise on top; None: none.
    """

    tvg_db: float = 30.0
    scale: Scale = "unit"
    floor_db: float = -50.0
    dynamic_range_db: float = 45.0
    painting: Painting | None = None

    def decibels(self, levels: NDArray[np.float32]) -> NDArray[np.float32]:
        """Levels in the unit of `scale` as decibels (clipped at both ends where that is "unit")."""
        if self.scale == "unit":
            return np.asarray(levels * self.dynamic_range_db + self.floor_db, dtype=np.float32)
        if self.scale == "db":
            return levels
        return np.asarray(10.0 * np.log10(np.maximum(levels, 1e-20)), dtype=np.float32)


@dataclass(frozen=True)
class PingSpec:
    """A ping of a sonar that gives intensities by range.

    Attributes:
        mounting: see `Mounting`.
        rate_hz: pings per second.
        bins, range_min_m, range_max_m: of a trace: number, near edge of the first, far edge of the last.
        frequency_hz, bandwidth_hz, pulse_s, pulse: of the pulse; `pulse` is "chirp" or "cw".
        source_level_db: [dB re 1 uPa at 1 m].
        self_noise_db: spectral level of the receiver's own noise [dB re 1 uPa^2/Hz].
        wind_speed_mps, rain_mm_per_h: for ambient noise and the sea surface.
        ph: acidity of the water.
        sound_speed_mps: that turns times into ranges and phases into angles; None: that of the water.
        refraction: bend rays; "auto": where it matters.
        sea_surface: its waves, or a plane at rest.
        texture_db: rms variation of surfaces' cross sections.
        ringing: level at the end of the pulse [dB re 1 uPa], and its fall [dB/ms]; None: none.
        converter: bits, and level of its full scale [dB re 1 uPa]; None: none.
        roughness_seed: realisation of all surfaces' roughness.
        volume_scattering_db: Sv of the water; None: of the ocean's tracer.
        volume_scatterers: of the water in a cubic metre; None: many.
        doppler: motion while the sound is under way.
        bounces: echoes by mirrors; None: none.
        disturber: see `Disturber`.
        hears: which sonars of the scenario disturb this one: "none", "others", or paths.
        vehicle_noise: whose noise is heard: "all", "others", "own" or "none"; None: nobody's, in a part of a sonar.
        heard: others may hear its pulses.
        display: see `Display`.
        iq, labels: what else is given.
    """

    mounting: Mounting
    rate_hz: float
    bins: int
    range_min_m: float
    range_max_m: float
    frequency_hz: float
    bandwidth_hz: float
    pulse_s: float
    pulse: Literal["chirp", "cw"]
    source_level_db: float
    self_noise_db: float
    wind_speed_mps: float
    ph: float
    texture_db: float
    rain_mm_per_h: float = 0.0
    sound_speed_mps: float | None = None
    ringing: tuple[float, float] | None = None
    converter: tuple[int, float] | None = None
    roughness_seed: int = 0
    refraction: Refraction = "auto"
    sea_surface: Literal["waves", "flat"] = "waves"
    volume_scattering_db: float | None = None
    volume_scatterers: float | None = None
    doppler: bool = True
    bounces: Bounces | None = None
    disturber: Disturber | None = None
    hears: str | tuple[str, ...] = "none"
    vehicle_noise: str | None = None
    heard: bool = True
    display: Display = Display()
    iq: bool = False
    labels: bool = False

    @property
    def bin_width_m(self) -> float:
        """Width of a range bin [m]."""
        return (self.range_max_m - self.range_min_m) / self.bins

    @property
    def ranges(self) -> NDArray[np.float32]:
        """Middle of each range bin `(bins,)` [m]."""
        return (self.range_min_m + (np.arange(self.bins) + 0.5) * self.bin_width_m).astype(np.float32)

    @property
    def resolution_m(self) -> float:
        """Range resolution of the pulse, c/(2B) at 1500 m/s [m]."""
        return range_resolution(NOMINAL_SOUND_SPEED, self.bandwidth_hz)

    @property
    def equivalent_m(self) -> float:
        """Depth in range of what a sample hears of an even bottom [m], however wide the bins are."""
        return EQUIVALENT_WIDTH[self.pulse] * self.resolution_m

    @property
    def longest_strip_m(self) -> float:
        """Longest patch of surface that a ray stands for, in range [m]."""
        return 0.125 * self.range_max_m


def noise_power(spec: PingSpec, horizontal_width: float, vertical_width: float) -> float:
    """Noise intensity behind matched filter and beamformer re the source level at 1 m; widths [rad]."""
    ambient = ambient_level(spec.frequency_hz, spec.wind_speed_mps, rain_mm_per_h=spec.rain_mm_per_h)
    spectral = float(to_db(from_db(ambient) + from_db(spec.self_noise_db)))
    return behind_filter(spec, spectral, max(directivity_index(horizontal_width, vertical_width), 0.0))


def behind_filter(spec: PingSpec, spectral_db: float = 0.0, directivity_db: float = 0.0) -> float:
    """Intensity behind matched filter and beamformer re the source level at 1 m, of noise of a spectral level [dB re 1
    uPa^2/Hz] against which the beamformer gains `directivity_db`: nothing where it comes along a beam's axis."""
    gain = processing_gain_db(spec.bandwidth_hz, spec.pulse_s) - SHADING_LOSS_DB[spec.pulse]
    gain += directivity_db
    return float(from_db(band_level(spectral_db, spec.bandwidth_hz) - gain - spec.source_level_db))

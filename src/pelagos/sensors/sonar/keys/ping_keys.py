"""Keys of sonars that give intensities by range: their pulse, bins, levels, gain and output."""

from __future__ import annotations

import math
import warnings
from typing import Annotated, Any, ClassVar, Final, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, BaseModel, ConfigDict, Field, model_validator

from pelagos.config.described import Described
from pelagos.config.rate import Rate
from pelagos.errors import ValidityWarning
from pelagos.sensors.idle_keys import Need, idle
from pelagos.sensors.sensor import SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.conflicts import check_ambiguity, check_burst, check_order, check_pulse
from pelagos.sensors.sonar.keys.devices import device_keys, with_device
from pelagos.sensors.sonar.ping.ping_spec import Bounces, Display, Disturber, Mounting, Painting, PingSpec
from pelagos.sensors.sonar.ping.sea_state import rain_over, wind_for
from pelagos.sensors.sonar.ping.surface_scattering import TEXTURE_DB

Pulse: TypeAlias = Literal["chirp", "cw"]
FEWEST_BINS: Final = 8
_NEEDS: Final = (
    Need(("ringing_db_per_ms",), "ringing_db"),
    Need(("adc_full_scale_db",), "adc_bits"),
    Need(("multipath_order", "surface_loss_db"), "multipath", ("surface", "surface_and_bottom")),
    Need(("bottom_loss_db",), "multipath", ("surface_and_bottom",)),
)
_PAINTED: Final = (
    Need(("additive_reference_db",), "additive"),
    Need(("additive_reference_db",), "onto", ("intensity",)),
)


def _none_or_some(bins: int) -> int:
    if 0 < bins < FEWEST_BINS:
        raise ValueError(f"must be 0 (none) or at least {FEWEST_BINS}, not {bins}")
    return bins


ColumnBins: TypeAlias = Annotated[int, AfterValidator(_none_or_some)]


def with_burst(values: Any, model: type[BaseModel]) -> Any:
    """Keys of a configuration, with the bandwidth of a tone burst where they ask for one."""
    if not isinstance(values, dict) or values.get("pulse") != "cw" or "bandwidth_hz" in values:
        return values
    duration = values.get("pulse_s", model.model_fields["pulse_s"].default)
    usable = isinstance(duration, int | float) and duration > 0
    return values | {"bandwidth_hz": 1.0 / duration} if usable else values


class PaintedNoise(Described):
    """Noise painted onto a finished image, as HoloOcean's sonars have it; for comparison only.

    The intensity I becomes I (1 + N(0, multiplicative)) + Rayleigh(additive), in parts of `additive_reference_db`; its
    echoes come late by an exponential error of range, and beams that look squarely at something are streaks.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    onto: Literal["intensity", "level"] = "intensity"
    """Quantity that becomes noisy: the intensity I, or the level between `floor_db` (0) and its top (1), so that
    `additive` and `multiplicative` are brightnesses of the picture."""
    additive: float = Field(default=0.0, ge=0)
    """Scale of the Rayleigh noise that is added to every cell."""
    additive_reference_db: float = -20.0
    """Level that `additive` is relative to, onto an intensity [dB]."""
    multiplicative: float = Field(default=0.0, ge=0)
    """Standard deviation of the factor on every cell."""
    range_m: float = Field(default=0.0, ge=0)
    """Mean of the exponential error n that is added to ranges [m]; the intensity falls by exp(-n/`range_m`)."""
    azimuth_streaks: Literal["none", "dark", "bright"] = "none"
    """What happens to beams in which 8 % of the rays meet something within 8 deg of squarely: the level x between
    `floor_db` (0) and its top (1) becomes x^2 (dark) or 1 - (1 - x)^2 (bright)."""


class Interference(Described):
    """Another sonar in the same water, heard through its direct pulse; it pings by its own clock.

    Beams hear it by their pattern in its direction, which stays where it is in the sensor frame: a head that turns
    hears it in passing.
    """

    model_config = ConfigDict(frozen=True, extra="forbid")

    rate_hz: Rate
    """Its pings per second [Hz]."""
    azimuth_deg: float = 0.0
    """Where it is, in the sensor frame, positive to the left [deg]."""
    elevation_deg: float = Field(default=0.0, ge=-90, le=90)
    """Its height over the x-y plane of the sensor frame, as an angle [deg]; -90 straight below."""
    distance_m: float = Field(default=50.0, gt=0)
    """How far away it is [m]."""
    source_level_db: float = 190.0
    """Its source level in this sonar's band and direction [dB re 1 uPa at 1 m]."""
    pulse_s: float = Field(default=1e-3, gt=0)
    """Duration of its pulse behind this sonar's filter [s]."""


class PingConfig(SensorConfig):
    """Keys of every sonar that gives intensities by range."""

    STANDS: ClassVar[str] = "keel"
    device: str | None = None
    """A device of the catalogue, whose keys count where the scenario gives none."""
    bins: int = Field(default=512, ge=FEWEST_BINS, le=65536)
    """Range bins."""
    range_min_m: float = Field(default=0.5, gt=0)
    """Near edge of the first bin [m]."""
    range_max_m: float = Field(default=60.0, gt=0, le=12000)
    """Far edge of the last bin [m]."""
    frequency_hz: float = Field(default=750e3, ge=200)
    """Centre frequency [Hz]."""
    pulse: Pulse = "chirp"
    """A chirp, compressed by the matched filter, or a tone burst (CW), whose bandwidth is 1/`pulse_s`."""
    bandwidth_hz: float = Field(default=30e3, gt=0)
    """Bandwidth of the pulse [Hz]; the range resolution is c/2B. Of `pulse: cw` it follows from `pulse_s`."""
    pulse_s: float = Field(default=0.5e-3, gt=0)
    """Duration of the pulse [s]; with the bandwidth it gives the gain of the matched filter."""
    source_level_db: float = Field(default=205.0, ge=0, le=300)
    """Source level [dB re 1 uPa at 1 m]."""  # assumed
    self_noise_db: float = Field(default=55.0, ge=-300, le=200)
    """Spectral level of the receiver's own noise [dB re 1 uPa^2/Hz]."""  # assumed
    wind_speed_mps: float | None = Field(default=None, ge=0, le=60)
    """Wind for ambient noise and the sea surface [m/s]; absent: the scenario's, or that which would raise its waves."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""
    sound_speed_mps: float | None = Field(default=None, gt=1300, lt=1700)
    """Sound speed that turns times into ranges, and phases across the array into angles [m/s]; absent: that of the
    water at the sonar."""
    tvg_db: float = Field(default=30.0, ge=0, le=60)
    """Spreading k of the gain k log10(r) + 2 a r: 30 keeps a bottom level, 40 point targets."""
    scale: Literal["unit", "db", "linear"] = "unit"
    """What `data` and `truth` are: decibels mapped to 0 .. 1, decibels, or linear intensity."""
    floor_db: float = Field(default=-50.0, ge=-300, le=300)
    """Level that `scale: unit`, and the eight bits of messages and views, map to 0 [dB]."""
    dynamic_range_db: float = Field(default=45.0, gt=0, le=300)
    """Decibels above it that are mapped to 0 .. 1 likewise [dB]."""
    texture_db: float = Field(default=TEXTURE_DB, ge=0, le=10)
    """Variation of surfaces' backscatter over decimetres to metres, rms [dB]."""
    roughness_seed: int = Field(default=0, ge=0, lt=2**32)
    """Which realisation of the roughness of all surfaces the sonar sees."""
    ringing_db: float | None = Field(default=None, ge=0, le=260)
    """Level at which the transducer still rings when its pulse ends [dB re 1 uPa]; absent: not at all."""
    ringing_db_per_ms: float = Field(default=30.0, gt=0)
    """How fast the ringing fades [dB/ms]."""  # assumed
    adc_bits: int | None = Field(default=None, ge=2, le=32)
    """Bits of the converter, for each part of the complex signal; absent: as fine as single precision."""
    adc_full_scale_db: float = Field(default=180.0, ge=0, le=300)
    """Level of the converter's largest number [dB re 1 uPa]; louder echoes are cut off at it."""  # assumed
    iq: bool = False
    """Also give the complex signal, before gain."""
    labels: bool = False
    """Also give label and instance of the strongest echo in each cell."""
    doppler: bool = True
    """Motion while the sound is under way: ranges r (1 - v/c), v the closing speed, and beams that turn on."""
    multipath: Literal["none", "surface", "surface_and_bottom"] = "none"
    """Echoes by bounces at the sea surface, and at the bottom and all other surfaces."""
    multipath_order: int = Field(default=1, ge=1, le=3)
    """Bounces of one way, out or home, at most: with 2 also surface and bottom one after the other."""
    sea_surface: Literal["waves", "flat"] = "waves"
    """What rays that reach the surface meet: the ocean's waves and tide, or a plane at rest."""
    surface_loss_db: float | None = Field(default=None, ge=0)
    """Loss of a bounce at the sea surface [dB]; absent: by bubbles, from wind, frequency and grazing angle."""
    bottom_loss_db: float = Field(default=6.0, ge=0)
    """Loss by roughness of a bounce at any other surface, beyond that of its material [dB]."""  # assumed
    refraction: bool | Literal["auto"] = "auto"
    """Bend rays by the sound speed's profile, at the sonar and, where the water changes from place to place, along
    their ways; `auto`: where that matters by more than 0.4 % of the range, anywhere in the world and on its first
    day."""
    volume_scattering_db: float | None = Field(default=None, ge=-200, le=0)
    """Volume backscattering strength Sv of the water [dB re 1/m]; absent: that of the ocean's tracer
    `volume_scattering_db`, and clear water where it has none."""
    volume_scatterers_per_m3: float | None = Field(default=None, gt=0)
    """Scatterers in a cubic metre of the water whose volume backscattering strength is known: the fewer in what a
    sample hears, the more spiky (K-distributed); they drift with the current. Absent: many."""
    hears: Literal["none", "others"] | tuple[str, ...] = "none"
    """Which sonars of the scenario disturb this one: `none`, all of other vehicles (`others`), or those of a list, by
    names such as `auv1.imaging`."""
    vehicle_noise: Literal["all", "others", "own", "none"] = "all"
    """Whose `radiated_noise` disturbs this sonar: of all vehicles that make any, of all but its own, of its own, or of
    none."""
    interference: Interference | None = None
    """Another sonar, which is not in the scenario, that is heard."""
    painted_noise: PaintedNoise | None = None
    """Noise as in HoloOcean, on top of what the physics gives."""

    @model_validator(mode="before")
    @classmethod
    def _device(cls, values: Any) -> Any:
        return with_burst(with_device(values, cls.model_fields["type"].default), cls)

    @model_validator(mode="after")
    def _consistent(self) -> Self:
        check_order(self)
        check_burst(self)
        check_pulse(self)
        check_ambiguity(self)
        return self

    @property
    def bin_width_m(self) -> float:
        """Width of a range bin [m]."""
        return (self.range_max_m - self.range_min_m) / self.bins

    @property
    def ranges(self) -> NDArray[np.float32]:
        """Middle of each range bin `(bins,)` [m]."""
        return (self.range_min_m + (np.arange(self.bins) + 0.5) * self.bin_width_m).astype(np.float32)


def mounting(config: SensorConfig) -> Mounting:
    """Place of a sonar on its vehicle."""
    return Mounting(config.position_m, config.q_body_sensor)


def ping_spec(config: PingConfig, context: SensorContext) -> PingSpec:
    """The ping that a configuration asks for, in the weather of its ocean; warns of keys that change nothing."""
    if told := idle(config, _NEEDS, device=device_keys(config)):
        warnings.warn(f"{context.path}: {told}", ValidityWarning, stacklevel=4)
    if config.painted_noise is not None and (told := idle(config.painted_noise, _PAINTED)):
        warnings.warn(f"{context.path}.painted_noise: {told}", ValidityWarning, stacklevel=4)
    bounces = None
    if config.multipath != "none":
        bottom = config.multipath == "surface_and_bottom"
        bounces = Bounces(bottom, config.multipath_order, config.surface_loss_db, config.bottom_loss_db)
    return PingSpec(
        mounting=mounting(config),
        rate_hz=config.rate_hz,
        bins=config.bins,
        range_min_m=config.range_min_m,
        range_max_m=config.range_max_m,
        frequency_hz=config.frequency_hz,
        bandwidth_hz=config.bandwidth_hz,
        pulse_s=config.pulse_s,
        pulse=config.pulse,
        source_level_db=config.source_level_db,
        self_noise_db=config.self_noise_db,
        sound_speed_mps=config.sound_speed_mps,
        ringing=None if config.ringing_db is None else (config.ringing_db, config.ringing_db_per_ms),
        converter=None if config.adc_bits is None else (config.adc_bits, config.adc_full_scale_db),
        wind_speed_mps=wind_for(config.wind_speed_mps, context.ocean, context.path),
        rain_mm_per_h=rain_over(context.ocean),
        ph=config.ph,
        texture_db=config.texture_db,
        roughness_seed=config.roughness_seed,
        refraction=config.refraction,
        sea_surface=config.sea_surface,
        volume_scattering_db=config.volume_scattering_db,
        volume_scatterers=config.volume_scatterers_per_m3,
        doppler=config.doppler,
        bounces=bounces,
        disturber=_disturber(config.interference),
        hears=config.hears,
        vehicle_noise=config.vehicle_noise,
        display=Display(
            config.tvg_db, config.scale, config.floor_db, config.dynamic_range_db, _painting(config.painted_noise)
        ),
        iq=config.iq,
        labels=config.labels,
    )


def _disturber(other: Interference | None) -> Disturber | None:
    """A sonar that is not in the scenario."""
    if other is None:
        return None
    azimuth, elevation = math.radians(other.azimuth_deg), math.radians(other.elevation_deg)
    level = math.cos(elevation)
    direction = (level * math.cos(azimuth), level * math.sin(azimuth), math.sin(elevation))
    return Disturber(other.rate_hz, direction, other.distance_m, other.source_level_db, other.pulse_s)


def _painting(noise: PaintedNoise | None) -> Painting | None:
    """Noise on top of a finished image."""
    if noise is None:
        return None
    return Painting(
        noise.additive, noise.additive_reference_db, noise.multiplicative, noise.range_m, noise.azimuth_streaks,
        noise.onto,
    )  # fmt: skip

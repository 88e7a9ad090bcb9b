"""Multibeam echo sounder: soundings across the track, by bottom detection in narrow beams."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, field_validator, model_validator

from pelagos import jit
from pelagos.acoustics.beam_pattern import line_length, line_np
from pelagos.config.rate import Rate
from pelagos.jit import Array
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.sensors.mount import sensor_angular_velocity, sensor_velocity
from pelagos.sensors.schedule import warn_of_ambiguity
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.conflicts import check_burst, check_order, check_pulse
from pelagos.sensors.sonar.keys.devices import with_device
from pelagos.sensors.sonar.keys.multibeam_parts import (
    behind_filter,
    column_of,
    column_spec,
    emitter,
    noise_power,
    sector_losses,
    swath_of,
    warn_of_idle,
)
from pelagos.sensors.sonar.keys.ping_keys import ColumnBins, Pulse, mounting, with_burst
from pelagos.sensors.sonar.ping.beam_echoes import part_of
from pelagos.sensors.sonar.ping.bottom_series import Beams, beam_series
from pelagos.sensors.sonar.ping.elements import line_tables
from pelagos.sensors.sonar.ping.fan import Trace
from pelagos.sensors.sonar.ping.multibeam_column import column_layout, column_rays
from pelagos.sensors.sonar.ping.pinger import Pinger
from pelagos.sensors.sonar.ping.sea_state import rain_over, wind_for
from pelagos.sensors.sonar.ping.sounder import Ping, Sounder, Waters
from pelagos.sensors.sonar.ping.soundings import detect, quality, snippets, sounding_places
from pelagos.sensors.sonar.ping.swath import (
    Sectors,
    attitudes_heard,
    axes_heard,
    cast_swath,
    delay_ranges,
    motion_of,
    sectors_of,
)
from pelagos.sensors.sonar.ping.vehicle_noise import Bystanders, VehicleNoise, noise_by_beam

_ACROSS: Final = np.array([-0.8, -0.4, 0.0, 0.4, 0.8])  # places of the rays in a beam [half-power widths]
_BEYOND: Final = 1.1  # of range_max_m, reach of the rays: a beam's edges meet the bottom farther off than its axis
_LONGEST: Final = 0.2  # of range_max_m, longest patch of bottom in range that one ray stands for; assumed


class MultibeamConfig(SensorConfig):
    """A multibeam echo sounder that looks down (along -z of its frame). Defaults are of the 400 kHz shallow class."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["multibeam"] = "multibeam"
    rate_hz: Rate = 5.0
    """Pings per second [Hz]."""
    device: str | None = None
    """A device of the catalogue, whose keys count where the scenario gives none."""
    beams: int = Field(default=256, ge=1, le=4096)
    """Beams across the track."""
    swath_deg: float = Field(default=120.0, gt=0, le=170)
    """Angle between the outermost beams [deg]."""
    spacing: Literal["equiangular", "equidistant"] = "equiangular"
    """Whether beams are spread evenly in angle or over a flat bottom."""
    beamwidth_across_deg: float = Field(default=1.0, ge=0.01, le=20)
    """Half-power width across the track at nadir [deg]."""
    beamwidth_along_deg: float = Field(default=1.0, ge=0.01, le=20)
    """Half-power width along the track [deg]."""
    range_min_m: float = Field(default=0.5, ge=0)
    """Nearest bottom that is detected [m]."""
    range_max_m: float = Field(default=120.0, gt=0, le=12000)
    """Farthest bottom that is detected [m]; echoes that come after the next ping, from beyond c/(2 `rate_hz`), are
    lost."""
    frequency_hz: float = Field(default=400e3, ge=200)
    """Centre frequency [Hz]."""
    pulse: Pulse = "chirp"
    """A chirp, compressed by the matched filter, or a tone burst (CW), whose bandwidth is 1/`pulse_s`."""
    bandwidth_hz: float = Field(default=40e3, gt=0)
    """Bandwidth of the pulse [Hz]."""
    pulse_s: float = Field(default=0.5e-3, gt=0)
    """Duration of the pulse [s]."""
    source_level_db: float = Field(default=210.0, ge=0, le=300)
    """Source level [dB re 1 uPa at 1 m]."""  # assumed
    self_noise_db: float = Field(default=45.0, ge=-300, le=200)
    """Spectral level of the receiver's own noise [dB re 1 uPa^2/Hz]."""  # assumed
    detection_snr_db: float = Field(default=10.0, ge=-20, le=60)
    """Signal-to-noise ratio below which a beam finds no bottom [dB]."""  # assumed
    sound_speed_mps: float | None = Field(default=None, gt=1300, lt=1700)
    """Sound speed that turns times into ranges [m/s]; absent: that of the water at the sonar."""
    wind_speed_mps: float | None = Field(default=None, ge=0, le=60)
    """Wind for ambient noise and the sea surface [m/s]; absent: the scenario's, or that which would raise its waves."""
    vehicle_noise: Literal["all", "others", "own", "none"] = "all"
    """Whose `radiated_noise` disturbs this sonar: of all vehicles that make any, of all but its own, of its own, or of
    none."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""
    refraction: bool | Literal["auto"] = "auto"
    """Bend rays by the sound speed's profile, at the sonar and, where the water changes from place to place, along
    their ways; `auto`: where that matters by more than 0.4 % of the range, anywhere in the world and on its first day.
    Soundings are placed along rays through the profile at the sonar unless `sound_speed_mps` is given."""
    doppler: bool = True
    """Motion while the sound is under way: echoes are heard in the attitude, and from the place, of their arrival, and
    ranges are r (1 - v/c). Soundings are placed by both attitudes, as sounders do."""
    stabilised: tuple[Literal["roll", "pitch", "yaw"], ...] = ()
    """Axes that the beams are held about: the receiver's angles count from the vertical (roll), and the transmitter
    steers, up to 10 deg, to the plane through the vertical (pitch) square to the course over ground (yaw)."""
    sectors: int = Field(default=1, ge=1, le=16)
    """Sectors of the swath that are sent one beside another, each steered by itself where the swath is held."""
    sector_spacing_hz: float = Field(default=0.0, ge=0)
    """Difference of frequency from sector to sector, port to starboard, about `frequency_hz` [Hz]; each loses what its
    own frequency does."""
    dual_swath_deg: float | None = Field(default=None, gt=0, le=20)
    """Two swaths a ping, this angle apart along the track [deg]: the fore one's beams, then the aft one's; absent: one
    swath."""
    attitudes: bool = False
    """Also give the attitudes at which each beam was sent and heard."""
    samples: int = Field(default=64, ge=16, le=1024)
    """Samples of a beam's echo, half a range resolution apart; where the echo is longer than they are, they lie farther
    apart and the pulse is as much longer, as sounders choose it in deep water."""
    roughness_seed: int = Field(default=0, ge=0, lt=2**32)
    """Which realisation of the roughness of all surfaces the sonar sees."""
    iq: bool = False
    """Also give each beam's complex time series about the bottom, for both halves of the array, and that of the water
    column."""
    elements: bool = False
    """Also give the signal of each element of the receive array in the water column, for a beamformer of one's own."""
    labels: bool = False
    """Also give label and instance of the strongest echo in each cell of the water column."""
    volume_scattering_db: float | None = Field(default=None, ge=-200, le=0)
    """Volume backscattering strength Sv of the water [dB re 1/m] in the water column; absent: that of the ocean's
    tracer `volume_scattering_db`, and clear water where it has none."""
    water_column_bins: ColumnBins = Field(default=0, ge=0, le=16384)
    """Range bins of the water column, which comes with the reading then; 0: none."""
    rays_along: int = Field(default=3, ge=1, le=31)
    """Rays of a beam along the track; across it they are five."""

    @model_validator(mode="before")
    @classmethod
    def _device(cls, values: Any) -> Any:
        return with_burst(with_device(values, cls.model_fields["type"].default), cls)

    @field_validator("rays_along")
    @classmethod
    def _odd(cls, value: int) -> int:
        if value % 2 == 0:
            raise ValueError(f"rays_along must be odd (one ray lies on the axis), not {value}")
        return value

    @model_validator(mode="after")
    def _ordered(self) -> MultibeamConfig:
        check_burst(self)
        check_pulse(self)
        check_order(self)
        if self.stabilised and any(abs(a) > 1e-9 for a in self.orientation_deg[:2]):
            raise ValueError(
                f"stabilised {list(self.stabilised)} needs a sonar that looks straight down: orientation_deg (0, 0, "
                f"yaw), not {self.orientation_deg}"
            )
        if self.dual_swath_deg is not None and self.water_column_bins:
            raise ValueError("water_column_bins are of one swath: leave out dual_swath_deg, or the water column")
        if self.sector_spacing_hz and self.sectors == 1:
            raise ValueError("sector_spacing_hz needs more than one of sectors")
        lowest = self.frequency_hz - 0.5 * (self.sectors - 1) * self.sector_spacing_hz - 0.5 * self.bandwidth_hz
        if self.sector_spacing_hz and lowest <= 0.0:
            raise ValueError(
                f"{self.sectors} sectors {self.sector_spacing_hz:g} Hz apart about {self.frequency_hz:g} Hz begin at "
                f"{lowest:g} Hz: give a smaller sector_spacing_hz"
            )
        return self

    @property
    def swaths(self) -> int:
        """Of a ping: one or two."""
        return 1 if self.dual_swath_deg is None else 2

    @property
    def soundings(self) -> int:
        """Beams of a ping, those of both swaths."""
        return self.beams * self.swaths

    @property
    def angles(self) -> NDArray[np.float64]:
        """Beam angles from straight down `(soundings,)` [rad], positive to port, from port to starboard."""
        return np.tile(self.swath_angles, self.swaths)

    @property
    def swath_angles(self) -> NDArray[np.float64]:
        """Those of one swath `(beams,)` [rad]."""
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
    beams = np.arange(config.soundings)
    beam, across, along = (a.ravel() for a in np.meshgrid(beams, _ACROSS, places, indexing="ij"))
    axis = config.angles[beam]
    width = math.radians(config.beamwidth_across_deg) / np.cos(axis)
    angle = axis + across * width
    aside = along * math.radians(config.beamwidth_along_deg)
    swath = np.where(beam < config.beams, 0.5, -0.5) * math.radians(config.dual_swath_deg or 0.0)
    tilt = aside + swath
    ca, sa, ct, st = np.cos(angle), np.sin(angle), np.cos(tilt), np.sin(tilt)
    receive = across_pattern(config, across)
    transmit = line_np(np.sin(aside), _length(config.beamwidth_along_deg)) ** 2
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


def across_pattern(config: MultibeamConfig, across: NDArray[np.float64]) -> NDArray[np.float64]:
    """Receive power pattern at a place in a beam [half-power widths]."""
    return line_np(across * math.radians(config.beamwidth_across_deg), _length(config.beamwidth_across_deg)) ** 2


def receiver(config: MultibeamConfig) -> Beams:
    """Reception of a beam's series; the lattice of roughness is half an aperture wide."""
    length = _length(config.beamwidth_across_deg)
    return Beams(
        count=config.soundings,
        samples=config.samples,
        finest=0.5 / config.bandwidth_hz,
        length=length,
        receive=tuple(np.repeat(across_pattern(config, _ACROSS), config.rays_along).tolist()),
        facet=0.5 * length * NOMINAL_SOUND_SPEED / config.frequency_hz,
        longest=_LONGEST * config.range_max_m,
        seed=config.roughness_seed,
    )


def _length(width_deg: float) -> float:
    return line_length(math.radians(width_deg))


class Multibeam:
    """A multibeam echo sounder.

    data: `(m, beams)` float32, detected slant ranges [m]; NaN where no bottom was found.
    truth: `(m, beams)` float32, ranges along the beam axes [m]; NaN where nothing is in range.
    extras: `soundings` `(m, beams, 3)` in the sensor frame at transmission [m]; `backscatter` `(m, beams)`, of the
        bottom [dB]; `detection` `(m, beams)` uint8: 0 none, 1 by amplitude, 2 by phase; `uncertainty` `(m, beams)`,
        standard deviation of the range as the sounder estimates it from the echo [m]; `quality` `(m, beams)`, 0
        (none) to 1, half at an uncertainty of 0.2 % of the range and 1 mm; `snr` `(m, beams)` of the echo's samples
        [dB]; `label` and `instance` `(m, beams)` on the axis. With `water_column_bins`, `water_column` `(m, beams,
        bins)`, level by range as `ImagingSonar` gives it [dB], and `water_column_truth`, its mean, with `labels`
        `water_column_label` and `water_column_instance`, with `iq` complex64 `water_column_iq`, before gain, with
        `elements` `water_column_elements` and `water_column_steering_speed`, see `ImagingSonar`. With `iq`, `iq`
        complex64 `(m, beams, 2, samples)`, what the left and the right half of the array heard, before
        gain, re the source level at 1 m, and `iq_range` `(m, beams, samples)` [m]. With `attitudes`,
        `transmit_attitude` `(m, 4)` and `receive_attitude` `(m, beams, 4)`, sensor frame to world, and
        `transmit_tilt` `(m, beams)`, by which the transmitter was steered ahead [rad]. With two swaths `beams` are
        those of the fore swath and then of the aft one, and the table `swath` `(beams,)` is 0 and 1.
    tables: `angle` `(beams,)` [rad] from straight down, positive to port; `direction` `(beams, 3)`;
        `water_column_range` `(bins,)` [m]; with `elements` `element_position` and `element_weights`.
    """

    TITLE: ClassVar[str] = "multibeam echo sounder: soundings and backscatter across the track"
    KERNELS: ClassVar[int] = 23  # four look along the axes first: when each beam hears, and so where
    CASTS: ClassVar[int] = 2
    MAY_LACK: ClassVar[bool] = True
    Config: ClassVar[type[SensorConfig]] = MultibeamConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Sections 8.2 and 8.3: bottom detection",
        "C. de Moustier, Int. Hydrogr. Rev. 65(2), 25 (1988): weighted mean time, zero crossing of the phase",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
        "R. E. Francois and G. R. Garrison, J. Acoust. Soc. Am. 72, 1879 (1982), doi 10.1121/1.388673: absorption",
    )

    def __init__(self, config: MultibeamConfig, context: SensorContext) -> None:
        self.config = config
        warn_of_ambiguity(config, context.path, config.range_max_m, device=config.device)
        warn_of_idle(config, context.path)
        rays = fan_rays(config)
        wind = wind_for(config.wind_speed_mps, context.ocean, context.path)
        waters = Waters(
            config.frequency_hz, config.ph, wind, refraction=config.refraction,
            reach=_BEYOND * config.range_max_m,
        )  # fmt: skip
        self._mounting = mounting(config)
        self._sounder = Sounder(self._mounting, context, rays, waters)
        noise = noise_power(config, wind, rain_over(context.ocean))
        self._noise = dr.opaque(jit.Float, noise)
        own = emitter(config, context, rays)
        self._bystanders = Bystanders(
            config, own, context.neighbours, context.ocean, behind_filter=behind_filter(config), noise=noise
        )
        self._swath = swath_of(config)
        self._sectors = sectors_of(config.angles, config.sectors, sector_losses(config, context))
        self._recorded = self._sounder.compile(self._kernel)
        self._column: Pinger | None = None
        if config.water_column_bins > 0:
            column, spec = column_of(config), column_spec(config, context)
            part = part_of(context, "column", neighbours=context.neighbours)
            self._column = Pinger(spec, part, column_rays(column), column_layout(column))
        if context.neighbours is not None:
            context.neighbours.add(own)
        axis = rays["direction"][config.rays_per_beam // 2 :: config.rays_per_beam]
        self.tables = {"angle": config.angles.astype(np.float32), "direction": axis.astype(np.float32)}
        if config.swaths > 1:
            self.tables["swath"] = np.repeat(np.arange(config.swaths, dtype=np.uint8), config.beams)
        if self._column is not None:
            self.tables["water_column_range"] = column_spec(config, context).ranges
            if config.elements:
                self.tables |= line_tables(column_of(config).line, config.frequency_hz)

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        shape = (dr.width(motion.position), self.config.soundings)
        vehicles = self._bystanders.heard(motion)
        detected, places, aims, series = self._recorded(motion, self._noise, self._sectors, vehicles)
        extras = {name: np.array(values).reshape(shape) for name, values in detected.items()}
        data, truth = extras.pop("range"), extras.pop("truth")
        extras["detection"] = extras["detection"].astype(np.uint8)
        extras["quality"] = quality(data, extras["uncertainty"])
        extras["soundings"] = np.ascontiguousarray(np.array(places).T).reshape(*shape, 3)
        if aims is not None:
            sent, received, tilt = aims
            extras["transmit_attitude"] = np.ascontiguousarray(np.array(sent).T)
            extras["receive_attitude"] = np.ascontiguousarray(np.array(received).T).reshape(*shape, 4)
            extras["transmit_tilt"] = np.array(tilt).reshape(shape)
        if series is not None:
            extras |= snippets(series, shape, self.config.samples)
        if self._column is not None:
            levels, truth_of, more = self._column.ping(motion)
            extras |= {"water_column": levels, "water_column_truth": truth_of()}
            extras |= {f"water_column_{name}": values for name, values in more.items()}
        return Measurement(data, truth, None, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._kernel, motion, self._noise, self._sectors, self._bystanders.heard(motion))

    def _kernel(
        self, ping: Ping, noise: Array, sectors: Sectors, vehicles: VehicleNoise | None, *, trace: Trace = None
    ) -> tuple[Any, ...]:
        lanes, fan, motion = ping.lanes, ping.fan, ping.motion
        config, beams, swath = self.config, receiver(self.config), self._swath
        far = _BEYOND * config.range_max_m
        spin = sensor_angular_velocity(motion, self._mounting)
        moving = motion_of(lanes, sensor_velocity(motion, self._mounting), spin)
        if swath.plain:
            view = ping.cast(max_range=far, assumed_speed=config.sound_speed_mps)
            view.loss *= dr.gather(jit.Float, sectors.loss, dr.gather(jit.UInt32, fan.beam, view.ray))
        else:
            view = cast_swath(ping.caster, swath, sectors, fan, lanes, ping.surfaces, moving, max_range=far)
        patches = ping.patches(view, longest=beams.longest, trace=trace)
        delay_ranges(patches, view, lanes, moving, swath)
        if vehicles is not None:
            noise = noise + noise_by_beam(ping.caster, vehicles, lanes, config.soundings)
        window, series = beam_series(beams, view, patches, fan, lanes, noise, ping.key)
        detected = detect(config, window, series, lanes, noise, trace)
        direction, distance, tilt = axes_heard(swath, sectors, fan, lanes, moving, detected["range"])
        aims = None
        if config.attitudes:
            aims = lanes.attitude, attitudes_heard(swath, lanes, spin, detected["range"]), dr.asin(tilt)
        places = sounding_places(config, direction, distance, lanes)
        return detected, places, aims, series if config.iq else None

"""Doppler velocity log: velocity over ground from the Doppler shifts of four slanted beams."""

from __future__ import annotations

import math
from itertools import combinations
from typing import TYPE_CHECKING, Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.acoustics.doppler import echo_margin_db, heard_water, janus_beams, velocity_from_beams
from pelagos.acoustics.spreading import to_db
from pelagos.config.rate import Rate
from pelagos.hydro.bed_load import grain_speed, skin_friction
from pelagos.jit import Array
from pelagos.math.so3 import rotate, rotate_back
from pelagos.sensors.mount import sensor_velocity
from pelagos.sensors.noise import Key, normals64
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.schedule import farthest_heard, warn_of_ambiguity
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.conflicts import check_order, quote
from pelagos.sensors.sonar.keys.devices import with_device
from pelagos.sensors.sonar.keys.echo_keys import EchoesConfig, echo_spec, warn_of_idle
from pelagos.sensors.sonar.keys.ping_keys import mounting
from pelagos.sensors.sonar.ping.beam_echoes import BeamEchoes
from pelagos.sensors.sonar.ping.fan import Lanes, Trace
from pelagos.sensors.sonar.ping.medium import Medium
from pelagos.sensors.sonar.ping.pulse_pairs import Pairs
from pelagos.sensors.sonar.ping.sea_state import wind_for
from pelagos.sensors.sonar.ping.sounder import Ping, Sounder, Waters
from pelagos.sensors.sonar.ping.surface_scattering import scattering
from pelagos.world.label import label_number

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

_TYPICAL_DB: Final = -20.0  # backscattering strength at which range_max_m holds: sand at 60 deg grazing
_FAINTEST_DB: Final = 6.0  # signal-to-noise ratio of an echo that is just tracked; assumed
# reach of the rays, of range_max_m: the vehicle may be tilted, and water is tracked above a far bottom
_BEYOND: Final = 1.5
_ABOVE_BED_M: Final = 1.0  # height at which the current that carries grains along is asked for, as usual in the field
_GROUND: Final = label_number("landscape")
_RAYS: Final = 5  # of a beam: its axis and four at the half-power edge


class DvlConfig(EchoesConfig):
    """A four-beam Janus DVL that looks along -z of its frame. Defaults are of the 600 kHz class."""

    USUAL_BINS: ClassVar[int] = 2048  # a speed's error falls with the root of the number of samples

    type: Literal["dvl"] = "dvl"
    rate_hz: Rate = 5.0
    """Pings per second [Hz]."""
    device: str | None = None
    """A device of the catalogue, whose keys count where the scenario gives none."""
    beam_tilt_deg: float = Field(default=30.0, gt=0, lt=60)
    """Angle of the beams from straight down [deg]."""
    beam_azimuth_deg: tuple[float, float, float, float] = (45.0, 135.0, -135.0, -45.0)
    """Directions of the four beams about the vertical, from forward to the left [deg]."""
    beamwidth_deg: float = Field(default=3.0, gt=0, le=20)
    """Half-power width of a beam [deg]."""
    range_min_m: float = Field(default=0.3, ge=0)
    """Blanking distance along the vertical [m]."""
    range_max_m: float = Field(default=90.0, gt=0, le=2000)
    """Altitude at which half of the beams are lost, level and over sand [m]; echoes that come after the next ping, from
    beyond c/(2 `rate_hz`) along a beam, are lost too."""
    frequency_hz: float = Field(default=600e3, ge=200)
    """Frequency [Hz]."""
    noise_mps: float = Field(default=0.003, ge=0)
    """Standard deviation of the speed along one beam in one ping, strong echo, at rest [m/s]."""
    noise_relative: float = Field(default=0.002, ge=0)
    """Standard deviation in parts of the speed along the beam, added in quadrature."""
    scale_error: float = Field(default=0.0, gt=-0.1, lt=0.1)
    """Constant error of scale (0.002 reads 0.2 % too much)."""
    range_noise_relative: float = Field(default=0.002, ge=0)
    """Standard deviation of beam ranges in parts of the range."""
    range_resolution_m: float = Field(default=0.0, ge=0, le=10)
    """Step of the ranges along the beams, of which the altitude is the mean [m]; 0 for none."""
    sound_speed_mps: float | None = Field(default=None, gt=1300, lt=1700)
    """Sound speed that turns shifts into speeds, of ground and water, and times into ranges [m/s]; absent: that of the
    water at the sonar."""
    water_layer_m: float | None = Field(default=None, gt=0)
    """Distance below the sensor of the layer that water track measures, at the time that `sound_speed_mps` gives it,
    from `range_min_m` to `range_max_m` [m]; absent: no water track."""
    bed_grain_mm: float | None = Field(default=None, ge=0.06, le=2)
    """Grain size of a bed (label `landscape`) that the current, as it is 1 m above, carries along under the log: it
    tracks moving grains then, and reads too much upstream [mm]; absent: the bed lies still."""
    ph: float = Field(default=8.1, gt=7, lt=9)
    """Acidity of the water, for absorption."""
    lag_s: float = Field(default=1e-4, gt=0)
    """Time between the two pulses of a ping, for `iq` [s]: speeds beyond c/(4 f lag) along a beam are ambiguous."""
    source_level_db: float = Field(default=217.0, ge=0, le=300)
    """Source level of the echoes [dB re 1 uPa at 1 m]."""  # assumed: that of 600 kHz current profilers

    @model_validator(mode="before")
    @classmethod
    def _device(cls, values: Any) -> Any:
        return with_device(values, cls.model_fields["type"].default)

    @model_validator(mode="after")
    def _distinct(self) -> DvlConfig:
        azimuths = sorted(a % 360 for a in self.beam_azimuth_deg)
        if len(set(azimuths)) < 4:
            raise ValueError("beam_azimuth_deg needs four different directions")
        closest = min(math.degrees(math.acos(min(float(a @ b), 1.0))) for a, b in combinations(self.beams, 2))
        if closest < self.beamwidth_deg:
            raise ValueError(
                f"{quote(self, 'beam_tilt_deg')} and beam_azimuth_deg leave {closest:.2g} deg between two beams, of "
                f"{quote(self, 'beamwidth_deg')}: they would measure the same"
            )
        if self.bed_grain_mm is not None and self.iq:
            raise ValueError("iq has the pulses of a bed that lies still: leave it out, or bed_grain_mm")
        check_order(self)
        if self.water_layer_m is not None and not self.range_min_m <= self.water_layer_m <= self.range_max_m:
            raise ValueError(
                f"{quote(self, 'water_layer_m')} must be between {quote(self, 'range_min_m')} and "
                f"{quote(self, 'range_max_m')}"
            )
        return self

    @property
    def beams(self) -> NDArray[np.float64]:
        """Unit vectors `(4, 3)` of the beams in the sensor frame."""
        azimuths = tuple(math.radians(a) for a in self.beam_azimuth_deg)
        return janus_beams(math.radians(self.beam_tilt_deg), azimuths)


def beam_rays(config: DvlConfig) -> dict[str, NDArray[Any]]:
    """Five rays a beam: the axis and four at the edge of the half-power cone (see `Fan`)."""
    axis = config.beams
    side = np.cross(axis, [0.0, 0.0, 1.0])
    side /= np.linalg.norm(side, axis=1, keepdims=True)
    up = np.cross(side, axis)
    half = math.tan(math.radians(config.beamwidth_deg) / 2)
    rays = np.stack([axis, axis + half * side, axis - half * side, axis + half * up, axis - half * up], axis=1)
    rays /= np.linalg.norm(rays, axis=2, keepdims=True)
    count = 4 * _RAYS
    return {
        "direction": rays.reshape(-1, 3),
        "aside": np.zeros((count, 3)),
        "along": np.repeat(up, _RAYS, axis=0),
        "lower": np.full(count, -half / 2),
        "upper": np.full(count, half / 2),
        "weight": np.full(count, 1.0),
        "beam": np.repeat(np.arange(4), _RAYS),
    }


class Dvl:
    """A Doppler velocity log with bottom lock.

    data: `(m, 3)` float64, velocity over ground of the sensor, in the sensor frame FLU [m/s]; not valid (and NaN)
        without three beams.
    truth: `(m, 3)` the same before noise, with lever arm.
    valid: `(m,)`, bottom lock.
    extras: `ranges` `(m, 4)` along the beams [m], NaN where lost; `beam_velocity` `(m, 4)`, speed along each beam,
        positive towards the bottom [m/s]; `beam_valid` `(m, 4)`; `altitude` `(m,)` [m], mean of the valid ranges times
        the cosine of the tilt; `sigma` `(m, 4)`, standard deviation of each beam's speed [m/s]; `snr` `(m, 4)` of each
        beam's echo [dB]; `label` and `instance` `(m, 4)` of what each beam meets, 0 for nothing.
        With `water_layer_m`: `water_velocity` `(m, 3)`, velocity of the sensor through the water of the layer [m/s],
        NaN where fewer than three beams hear it: beyond the bottom, and, as of an `Adcp`, from the altitude that the
        nearest beam tells, times the cosine of the tilt, on.
        With `water_column_bins`, `iq` or `labels` the echoes of the beams, `(m, 4, bins)` each: `water_column` and
        `water_column_truth` [dB], `water_column_label`, `water_column_instance`, and `iq` complex64 `(m, 4, 2, bins)`,
        before gain, of two pulses a `lag_s` apart, whose phases tell the speed (see `speed_of_pair`).
    tables: `direction` `(4, 3)`, the beams in the sensor frame; `water_column_range` `(bins,)` [m].
    """

    TITLE: ClassVar[str] = "four-beam Doppler velocity log with bottom lock"
    KERNELS: ClassVar[int] = 14
    CASTS: ClassVar[int] = 1
    ERRS: ClassVar[bool] = True
    WAITS: ClassVar[bool] = True
    ALTITUDE: ClassVar[str] = "altitude"
    Config: ClassVar[type[SensorConfig]] = DvlConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Teledyne RD Instruments, Acoustic Doppler Current Profiler: Principles of Operation (2011)",
        "D. S. Zrnic, IEEE Trans. Aerosp. Electron. Syst. 13, 344 (1977), doi 10.1109/TAES.1977.308467: pulse pairs",
        "L. C. van Rijn, J. Hydraul. Eng. 110, 1431 (1984), doi 10.1061/(ASCE)0733-9429(1984)110:10(1431): grains",
        "B. H. Brumley et al., IEEE J. Ocean. Eng. 16, 402 (1991), doi 10.1109/48.90905: error of the Doppler estimate",
        "R. J. Urick, Principles of Underwater Sound, 3rd ed. (1983), Section 8.12: level of bottom echoes",
    )

    def __init__(self, config: DvlConfig, context: SensorContext) -> None:
        self.config = config
        self._context = context
        slant = config.range_max_m / math.cos(math.radians(config.beam_tilt_deg))
        warn_of_ambiguity(config, context.path, slant, device=config.device)
        warn_of_idle(config, context.path)
        wind = wind_for(config.wind_speed_mps, context.ocean, context.path)
        self._mounting = mounting(config)
        self._sounder = Sounder(
            self._mounting, context, beam_rays(config), Waters(config.frequency_hz, config.ph, wind)
        )
        self._program = Program(self._kernel, self._sounder.compile)
        self.tables: dict[str, NDArray[Any]] = {"direction": config.beams}
        self._echoes: BeamEchoes | None = None
        if config.echo_bins > 0:
            slant = 1.0 / math.cos(math.radians(config.beam_tilt_deg))
            spec = echo_spec(config, context, nearest=config.range_min_m * slant, farthest=config.range_max_m * slant)
            pairs = Pairs(config.lag_s, config.noise_mps, config.noise_relative, layer_m=slant, clear_db=None)
            width = math.radians(config.beamwidth_deg)
            self._echoes = BeamEchoes(spec, context, config.beams, width=width, pairs=pairs)
            self.tables["water_column_range"] = self._echoes.ranges

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        extras = self._program(motion, self._context.ocean)
        velocity, truth, valid = (extras.pop(name) for name in ("velocity", "truth", "locked"))
        data = np.where(valid[:, None], velocity, np.nan)
        if self._echoes is not None:
            extras |= self._echoes.extras(motion)
        return Measurement(data, truth, valid, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._sounder.trace(self._kernel, motion, self._context.ocean)

    def _kernel(self, ping: Ping, ocean: Ocean, *, trace: Trace = None) -> Results:
        config, lanes, motion = self.config, ping.lanes, ping.motion
        velocity = sensor_velocity(motion, self._mounting)
        farthest = _BEYOND * config.range_max_m / math.cos(math.radians(config.beam_tilt_deg))
        view = ping.cast(max_range=farthest, smooth=False)
        section = scattering(ping.surfaces, view.hits.material, view.sine)
        ground = rotate_back(dr.gather(jit.Array4f, jit.Array4f(lanes.attitude), view.lane), view.hits.velocity)
        hits = view.hits
        dr.eval(hits.valid, hits.t, hits.label, hits.instance, section, ground)  # one cast for all beams
        beams = [
            beam_echo(dr.width(lanes.position), b, hits.valid, hits.t, section, ground, config.beams[b])
            for b in range(4)
        ]
        first = dr.arange(jit.UInt32, dr.width(lanes.position)) * (4 * _RAYS)
        if config.bed_grain_mm is not None:
            grounds = [dr.gather(jit.UInt32, hits.label, first + b * _RAYS) == _GROUND for b in range(4)]
            beams = [
                (*echo[:3], echo[3] + dr.select(bed, carried_bed(config, lanes, b, echo[1], motion, ocean), 0.0))
                for b, (echo, bed) in enumerate(zip(beams, grounds, strict=True))
            ]
        found = bottom_track(config, beams, velocity, motion, lanes.medium, ping.key, trace)
        for name, met in (("label", hits.label), ("instance", hits.instance)):
            found[name] = [dr.gather(jit.UInt32, met, first + b * _RAYS) for b in range(4)]
        if config.water_layer_m is not None:
            free = [dr.select(seen, distance, dr.inf) for seen, distance, *_ in beams]
            found["water_velocity"] = water_track(config, free, lanes, velocity, motion, ocean, ping.key)
        return found


def beam_echo(
    lanes: int, beam: int, valid: Array, distance: Array, section: Array, ground: Array, axis: NDArray[np.float64]
) -> tuple[Array, Array, Array, Array]:
    """Whether a beam sees something, its mean range [m], mean cross section and the ground's speed along it [m/s]."""
    first = dr.arange(jit.UInt32, lanes) * (4 * _RAYS) + beam * _RAYS
    hits, total, level, speed = jit.Float(0), jit.Float(0), jit.Float(0), jit.Float(0)
    for k in range(_RAYS):
        hit = dr.gather(jit.Bool, valid, first + k)
        seen = dr.select(hit, 1.0, 0.0)
        hits += seen
        total += seen * dr.select(hit, dr.gather(jit.Float, distance, first + k), 0.0)
        level += seen * dr.gather(jit.Float, section, first + k)
        moves = dr.gather(jit.Array3f, ground, first + k)
        speed += seen * (moves[0] * axis[0] + moves[1] * axis[1] + moves[2] * axis[2])
    share = 1.0 / dr.maximum(hits, 1.0)
    return hits > 0.5 * _RAYS, total * share, level * share, jit.Float64(speed * share)


def bottom_track(
    config: DvlConfig, beams: list[tuple[Array, Array, Array, Array]], velocity: Array, motion: Kinematics,
    medium: Medium, key: Key, trace: Trace = None,
) -> dict[str, Any]:  # fmt: skip
    """Results by name, see `Dvl`: velocity, its truth, lock, altitude, and what each beam has found.

    The echo's margin over the weakest that can be tracked sets the loss of a beam (with a slack of 1.5 dB) and the
    noise: the variance of the Doppler estimate grows with 1 + 1/snr.
    """
    vertical = math.cos(math.radians(config.beam_tilt_deg))
    reach = config.range_max_m / vertical
    noise = normals64(key, motion, 12)
    assumed = assumed_over_true(config, medium)
    correction = (1.0 + config.scale_error) * assumed
    ranges, speeds, valid, sigmas, levels = [], [], [], [], []
    heard = farthest_heard(config.rate_hz, medium.sound_speed)
    for b, (seen, distance, section, ground) in enumerate(beams):
        x, y, z = config.beams[b]
        speed = velocity[0] * x + velocity[1] * y + velocity[2] * z - ground
        margin = echo_margin_db(distance, jit.Float(reach), medium.absorption)
        margin += to_db(dr.maximum(section, 1e-9)) - _TYPICAL_DB
        levels.append(jit.Float64(dr.select(seen, margin + _FAINTEST_DB, -dr.inf)))
        snr = dr.exp(0.230258509 * (jit.Float64(margin) + _FAINTEST_DB))
        sigma = dr.sqrt((config.noise_mps**2 + (config.noise_relative * speed) ** 2) * (1.0 + 1.0 / snr))
        tracked = seen & (jit.Float64(margin) + 1.5 * noise[4 + b] > 0.0) & (distance * vertical >= config.range_min_m)
        tracked &= distance <= heard
        speeds.append((speed + sigma * noise[b]) * correction)
        measured = jit.Float64(distance) * assumed * (1.0 + config.range_noise_relative * noise[8 + b])
        if config.range_resolution_m > 0.0:
            measured = dr.round(measured * (1.0 / config.range_resolution_m)) * config.range_resolution_m
        ranges.append(dr.select(tracked, measured, dr.nan))
        valid.append(tracked)
        sigmas.append(sigma)
        if trace is not None:
            trace(f"range of beam {b}", distance, "m")
            trace(f"margin of the echo of beam {b}", margin, "dB")
            trace(f"speed along beam {b}", speed, "m/s")
    data, locked = velocity_from_beams(speeds, valid, config.beams)
    count, total = jit.Float64(0), jit.Float64(0)
    for r, ok in zip(ranges, valid, strict=True):
        count += dr.select(ok, jit.Float64(1), 0.0)
        total += dr.select(ok, r, 0.0)
    altitude = dr.select(count > 0.0, total / dr.maximum(count, 1.0) * vertical, dr.nan)
    return {
        "velocity": data, "truth": velocity, "locked": locked, "ranges": ranges, "beam_velocity": speeds,
        "beam_valid": valid, "sigma": sigmas, "altitude": altitude, "snr": levels,
    }  # fmt: skip


def assumed_over_true(config: DvlConfig, medium: Medium) -> Array:
    """The sound speed that turns shifts into speeds and times into ranges over that of the water; `Float64` by lane."""
    if config.sound_speed_mps is None:
        return jit.Float64(1.0)
    return config.sound_speed_mps / jit.Float64(medium.sound_speed)


def carried_bed(config: DvlConfig, lanes: Lanes, beam: int, distance: Array, motion: Kinematics, ocean: Ocean) -> Array:
    """Speed [m/s] along a beam of the grains that the current carries over the bed, level, where the beam meets it."""
    assert config.bed_grain_mm is not None
    grain, axis = config.bed_grain_mm * 1e-3, jit.Array3f64(*config.beams[beam].tolist())
    place = lanes.position + rotate(lanes.attitude, axis) * jit.Float64(distance)
    water = ocean.current(place + jit.Array3f64(0.0, 0.0, _ABOVE_BED_M), jit.Float64(motion.t_ns) * 1e-9, motion.copy)
    speed = dr.hypot(water.x, water.y)
    grains = grain_speed(skin_friction(speed, _ABOVE_BED_M, grain), grain) / dr.maximum(speed, 1e-9)
    return dr.dot(rotate_back(lanes.attitude, jit.Array3f64(water.x * grains, water.y * grains, 0.0)), axis)


def water_track(
    config: DvlConfig, free: list[Array], lanes: Lanes, velocity: Array, motion: Kinematics, ocean: Ocean, key: Key
) -> Array:
    """Velocity of the sensor through the water of a layer, `Array3f64` in the sensor frame [m/s].

    The echo is taken at the layer's time by the assumed sound speed, as that of an ADCP's cell: it comes from nearer or
    farther with another one. The four beams' errors, as at a strong echo, go through the same least squares as those of
    the bottom. `free`: range along each beam to what it meets, infinite without [m].
    """
    assert config.water_layer_m is not None
    vertical = math.cos(math.radians(config.beam_tilt_deg))
    noise = normals64(key, motion, 16)
    assumed = assumed_over_true(config, lanes.medium)
    reach = config.water_layer_m / vertical / assumed
    t = jit.Float64(motion.t_ns) * 1e-9
    in_time = reach <= jit.Float64(farthest_heard(config.rate_hz, lanes.medium.sound_speed))
    speeds = []
    for b, (x, y, z) in enumerate(config.beams.tolist()):
        place = lanes.position + rotate(lanes.attitude, jit.Array3f64(x, y, z)) * reach
        through = velocity - rotate_back(lanes.attitude, ocean.current(place, t, motion.copy))
        speed = through.x * x + through.y * y + through.z * z
        sigma = dr.sqrt(config.noise_mps**2 + (config.noise_relative * speed) ** 2)
        speeds.append((speed + sigma * noise[12 + b]) * (1.0 + config.scale_error) * assumed)
    if lanes.wet is not None:
        in_time &= lanes.wet
    heard = [ok & in_time for ok in heard_water(free, jit.Float(reach), vertical)]
    data, found = velocity_from_beams(speeds, heard, config.beams)
    return dr.select(found, data, dr.nan)

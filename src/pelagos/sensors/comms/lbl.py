"""A long baseline: ranges to transponders at known places, from travel times through the simulated water."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.acoustics.channel import spectral_level
from pelagos.acoustics.modulation import arrival_time_error
from pelagos.config.strict import Strict
from pelagos.errors import LookupFailed, ScenarioError
from pelagos.ocean.surface_wind import surface_wind
from pelagos.sensors import noise
from pelagos.sensors.comms.link.place import check_in_water
from pelagos.sensors.comms.link.water_paths import Paths, WaterPaths
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext

_FIRST_DB = 10.0  # below the loudest path, down to which a receiver takes a path for the first
_SHIPPING = 0.5


class TransponderConfig(Strict):
    """A transponder at a fixed place, or on another vehicle."""

    position_m: tuple[float, float, float]
    """World x (north), y (west), z (up) [m]; with `agent` in that vehicle's body frame, forward, left, up [m]."""
    agent: str | None = None
    """The vehicle that carries it; at a fixed place where not given."""

    @property
    def q_body_sensor(self) -> tuple[float, float, float, float]:
        """It hears in all directions: turned as its vehicle."""
        return 1.0, 0.0, 0.0, 0.0


class LblConfig(SensorConfig):
    """An interrogator, and the transponders that answer it."""

    type: Literal["lbl"] = "lbl"
    """The sensor's kind."""
    rate_hz: float = Field(default=1.0, gt=0)
    """Rounds of ranges per second [Hz]; must divide the tick rate."""
    transponders: dict[str, TransponderConfig] = Field(min_length=1)
    """Transponders by name."""
    one_way: bool = False
    """Transponders send by clocks that agree: the way counts once; else the vehicle asks and they answer."""
    frequency_hz: float = Field(default=26_000.0, gt=0)
    """Centre of the band [Hz]."""
    bandwidth_hz: float = Field(default=4_000.0, gt=0)
    """Width of the band [Hz]."""
    pulse_s: float = Field(default=0.01, gt=0)
    """Length of a pulse [s]."""
    source_level_db: float = Field(default=188.0, ge=100, le=230)
    """Of interrogator and transponders [dB re 1 uPa at 1 m]."""
    noise_db: float = Field(default=40.0, ge=-50, le=150)
    """Noise of the own vehicle and of the receiver [dB re 1 uPa^2/Hz], besides that of the sea."""
    detection_db: float = Field(default=6.0, ge=-40, le=60)
    """Level over the noise behind the matched filter from which a pulse is noticed [dB]."""
    turnaround_error_s: float = Field(default=2e-5, ge=0)
    """Standard deviation of a transponder's turn-around, or of the difference of two clocks [s]."""
    range_max_m: float = Field(default=10_000.0, gt=0)
    """Longest range [m]."""
    sound_speed_mps: float | None = Field(default=None, ge=1300, le=1700)
    """By which ranges are made of times [m/s]; None: that of the water at the vehicle."""

    @model_validator(mode="after")
    def _band(self) -> LblConfig:
        if self.bandwidth_hz >= 2.0 * self.frequency_hz:
            raise ValueError(
                f"bandwidth_hz {self.bandwidth_hz:g} does not fit around frequency_hz {self.frequency_hz:g}"
            )
        return self


class Lbl:
    """Ranges to transponders.

    Reading: `data` `(n, k)` ranges in the order of the scenario [m], NaN where no pulse is noticed; `truth` straight
    distances [m]. Extras: `travel_time` `(n, k)` one way, without noise [s]; `snr_db` `(n, k)` behind the filter;
    `transponder_position` `(n, k, 3)` where they truly are, NWU [m]. Tables: `transponders` `(k, 3)` NWU [m], NaN for
    those that vehicles carry.
    """

    Config: ClassVar[type[SensorConfig]] = LblConfig
    TITLE: ClassVar[str] = "Long baseline: ranges to transponders at known places"
    KERNELS: ClassVar[int] = 120
    CASTS: ClassVar[int] = 10
    ONE_VEHICLE: ClassVar[bool] = True
    MAY_LACK: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = (
        "P. H. Milne, Underwater Acoustic Positioning Systems, 1983, Chapter 4 (long baselines)",
        "H. L. Van Trees, Detection, Estimation, and Modulation Theory III, 2001, Section 10.2 (error of a time)",
    )

    def __init__(self, config: LblConfig, context: SensorContext) -> None:
        self._config, self._context = config, context
        self._paths = WaterPaths(
            context.scene, context.world, context.ocean, frequency=config.frequency_hz, rays=256, bounces=4
        )
        for name, transponder in config.transponders.items():
            if transponder.agent is None:
                check_in_water(context, name, transponder.position_m)
            else:
                _check_carrier(context, name, transponder.agent)
        self._places = np.array([[np.nan] * 3 if t.agent else t.position_m for t in config.transponders.values()])
        wind = surface_wind(context.ocean)[0]
        sea = float(spectral_level(config.frequency_hz, wind_speed=wind, shipping=_SHIPPING)[0])
        spectral = 10.0 * math.log10(10.0 ** (sea / 10.0) + 10.0 ** (config.noise_db / 10.0))
        self._noise_db = spectral - 10.0 * math.log10(config.pulse_s)  # behind a matched filter: N0 over the pulse
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "time"))

    def sense(self, motion: Kinematics) -> Measurement:
        """Range on every lane of `motion`."""
        c, count = self._config, len(self._places)
        position = np.array(sensor_pose(motion, c)[0]).T
        lanes = len(position)
        t = np.array(motion.t_ns).astype(np.float64) * 1e-9
        copy = np.array(motion.copy).astype(np.int64)
        time, snr, speed = (np.full((lanes, count), np.nan) for _ in range(3))
        places = np.empty((lanes, count, 3))
        for moment in np.unique(t):
            rows = np.flatnonzero(t == moment)
            places[rows] = self._where(copy[rows])
            ends = np.repeat(position[rows], count, axis=0), places[rows].reshape(-1, 3)
            found = self._paths.trace(*ends, float(moment), np.repeat(copy[rows], count),
                                      self._context.own_body[np.repeat(copy[rows], count)])  # fmt: skip
            time[rows], snr[rows] = (v.reshape(len(rows), count) for v in self._first(found, len(ends[0])))
            speed[rows] = found.speed[:, 0].reshape(len(rows), count)
        drawn = np.stack([np.array(v) for v in noise.normals64(self._key, motion, 2 * count)], axis=1)
        error = np.array([[self._error(s) for s in row] for row in snr])
        ways = 1.0 if c.one_way else 2.0
        measured = time + (drawn[:, :count] * error * math.sqrt(ways) + drawn[:, count:] * c.turnaround_error_s) / ways
        ranges = measured * (speed if c.sound_speed_mps is None else c.sound_speed_mps)
        heard = np.isfinite(time) & (snr >= c.detection_db) & (ranges <= c.range_max_m)
        truth = np.linalg.norm(places - position[:, None], axis=-1)
        return Measurement(
            np.where(heard, ranges, np.nan), truth, heard.any(axis=1),
            {"travel_time": time, "snr_db": snr, "transponder_position": places}, {"transponders": self._places},
        )  # fmt: skip

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One round of ranges: (name, values, unit)."""
        found = self.sense(motion)
        return [
            ("travel time", found.extras["travel_time"], "s"), ("snr", found.extras["snr_db"], "dB"),
            ("range", found.data, "m"),
        ]  # fmt: skip

    def _where(self, copy: NDArray[np.int64]) -> NDArray[np.float64]:
        """Transponders as lanes of these copies find them, `(m, k, 3)` NWU [m]."""
        places = np.tile(self._places, (len(copy), 1, 1))
        for k, transponder in enumerate(self._config.transponders.values()):
            if transponder.agent is not None:
                assert self._context.medium is not None
                places[:, k] = self._context.medium.pose_of(transponder.agent, transponder).position[copy]
        return places

    def _first(self, found: Paths, count: int) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Travel time [s] and level over the noise [dB] of the first loud path of each pair; NaN without one."""
        time, snr = np.full(count, np.nan), np.full(count, np.nan)
        a = found.arrivals
        level = self._config.source_level_db - a.loss_db
        for k in np.unique(a.path[~found.blocked]):
            rows = np.flatnonzero((a.path == k) & ~found.blocked)
            loud = rows[level[rows] >= level[rows].max() - _FIRST_DB]
            first = loud[np.argmin(a.delay[loud])]
            time[k], snr[k] = a.delay[first], level[first] - self._noise_db
        return time, snr

    def _error(self, snr_db: float) -> float:
        if not math.isfinite(snr_db):
            return 0.0
        c = self._config
        in_band = 10.0 ** (snr_db / 10.0) / (c.bandwidth_hz * c.pulse_s)
        return arrival_time_error(in_band, c.bandwidth_hz, c.pulse_s)


def _check_carrier(context: SensorContext, name: str, agent: str) -> None:
    """Check who carries a transponder.

    Raises:
        LookupFailed: there is no such vehicle.
        ScenarioError: it is the one that asks; or there are no others, outside of a simulation.
    """
    if context.medium is None:
        raise ScenarioError(f"{name!r} is carried by {agent!r}: it needs a simulation, with that vehicle in it")
    own, _, sensor = str(context.path).partition(".")
    if agent not in context.medium.agents:
        where = f"agents.{own}.sensors.{sensor}.transponders.{name}.agent"
        raise LookupFailed("agent", agent, context.medium.agents, where=where)
    if agent == own:
        raise ScenarioError(f"{name!r} is carried by {agent!r} itself; a vehicle ranges to others")

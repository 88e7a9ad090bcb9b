"""A long baseline: ranges to transponders at known places, from travel times through the simulated water."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.acoustics.modulation import arrival_time_error
from pelagos.config.rate import Rate
from pelagos.sensors import noise
from pelagos.sensors.comms.link.transponders import TransponderConfig, Transponders, pulse_noise_db
from pelagos.sensors.comms.link.water_paths import WaterPaths
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class LblConfig(SensorConfig):
    """An interrogator, and the transponders that answer it."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["lbl"] = "lbl"
    """The sensor's kind."""
    rate_hz: Rate = 1.0
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
        self._transponders = Transponders(config.transponders, context, key="transponders")
        self._noise_db = pulse_noise_db(context.ocean, config.frequency_hz, config.noise_db, config.pulse_s)
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "time"))

    def sense(self, motion: Kinematics) -> Measurement:
        """Range on every lane of `motion`."""
        c, count = self._config, len(self._transponders)
        position = np.array(sensor_pose(motion, c)[0]).T
        t = np.array(motion.t_ns).astype(np.float64) * 1e-9
        first = self._transponders.listen(self._paths, position, t, np.array(motion.copy).astype(np.int64))
        snr = c.source_level_db - first.loss_db - self._noise_db
        drawn = np.stack([np.array(v) for v in noise.normals64(self._key, motion, 2 * count)], axis=1)
        error = np.array([[self._error(s) for s in row] for row in snr])
        ways = 1.0 if c.one_way else 2.0
        measured = (
            first.time + (drawn[:, :count] * error * math.sqrt(ways) + drawn[:, count:] * c.turnaround_error_s) / ways
        )
        ranges = measured * (first.speed if c.sound_speed_mps is None else c.sound_speed_mps)
        heard = np.isfinite(first.time) & (snr >= c.detection_db) & (ranges <= c.range_max_m)
        truth = np.linalg.norm(first.places - position[:, None], axis=-1)
        return Measurement(
            np.where(heard, ranges, np.nan), truth, heard.any(axis=1),
            {"travel_time": first.time, "snr_db": snr, "transponder_position": first.places},
            {"transponders": self._transponders.fixed},
        )  # fmt: skip

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One round of ranges: (name, values, unit)."""
        found = self.sense(motion)
        return [
            ("travel time", found.extras["travel_time"], "s"), ("snr", found.extras["snr_db"], "dB"),
            ("range", found.data, "m"),
        ]  # fmt: skip

    def _error(self, snr_db: float) -> float:
        if not math.isfinite(snr_db):
            return 0.0
        c = self._config
        in_band = 10.0 ** (snr_db / 10.0) / (c.bandwidth_hz * c.pulse_s)
        return arrival_time_error(in_band, c.bandwidth_hz, c.pulse_s)

"""Range and bearing of pingers: on other vehicles or at fixed places, heard through the simulated water."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.config.rate import Rate
from pelagos.math.so3 import rotate_back_np
from pelagos.sensors import noise
from pelagos.sensors.comms.link.transponders import TransponderConfig, Transponders, pulse_noise_db
from pelagos.sensors.comms.link.water_paths import WaterPaths
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class RangeBearingConfig(SensorConfig):
    """A receiver that knows when its targets ping. Errors where not given are those of VRX's pinger receiver."""

    STANDS: ClassVar[str] = "keel"
    type: Literal["range_bearing"] = "range_bearing"
    """The sensor's kind."""
    rate_hz: Rate = 1.0
    """Pings per second [Hz]; must divide the tick rate."""
    targets: dict[str, TransponderConfig] = Field(min_length=1)
    """Pingers by name."""
    range_noise_m: float = Field(default=3.0, ge=0)
    """Standard deviation of the range [m]."""
    azimuth_noise_rad: float = Field(default=0.01, ge=0)
    """Standard deviation of the azimuth [rad]."""
    elevation_noise_rad: float = Field(default=0.01, ge=0)
    """Standard deviation of the elevation [rad]."""
    frequency_hz: float = Field(default=30_000.0, gt=0)
    """Of the pings [Hz]."""
    pulse_s: float = Field(default=0.004, gt=0)
    """Length of a ping [s]."""
    source_level_db: float = Field(default=160.0, ge=50, le=230)
    """Of the pingers [dB re 1 uPa at 1 m]."""
    noise_db: float = Field(default=40.0, ge=-50, le=150)
    """Noise of the own vehicle and of the receiver [dB re 1 uPa^2/Hz], besides that of the sea."""
    detection_db: float = Field(default=6.0, ge=-40, le=60)
    """Level over the noise behind the matched filter from which a ping is noticed [dB]."""
    range_max_m: float = Field(default=1000.0, gt=0)
    """Longest range [m]."""
    sound_speed_mps: float | None = Field(default=None, ge=1300, le=1700)
    """By which ranges are made of times [m/s]; None: that of the water at the receiver."""


class RangeBearing:
    """Range, azimuth and elevation of pingers in the sensor frame.

    The first loud path through the water is measured: refraction bends its direction, a longer way lengthens the range,
    hulls and structures between hide it.

    Reading: `data` `(n, k, 3)` in the order of the scenario: range [m]; azimuth, positive to the left (-pi .. pi), and
    elevation, positive up (-pi/2 .. pi/2), in the sensor frame [rad]; NaN where no ping is noticed. `truth`: the same
    of the straight line. Extras: `travel_time` `(n, k)` without noise [s]; `snr_db` `(n, k)` behind the filter;
    `target_position` `(n, k, 3)` where they truly are, NWU [m].
    """

    Config: ClassVar[type[SensorConfig]] = RangeBearingConfig
    TITLE: ClassVar[str] = "Range and bearing of pingers, at fixed places or on other vehicles"
    KERNELS: ClassVar[int] = 120
    CASTS: ClassVar[int] = 10
    ONE_VEHICLE: ClassVar[bool] = True
    MAY_LACK: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Open Robotics, VRX, vrx_urdf/wamv_gazebo/urdf/components/wamv_pinger.xacro (3 m, 0.01 rad, 0.01 rad)",
        "P. H. Milne, Underwater Acoustic Positioning Systems, 1983, Chapter 5 (range and bearing)",
    )

    def __init__(self, config: RangeBearingConfig, context: SensorContext) -> None:
        self._config = config
        self._paths = WaterPaths(
            context.scene, context.world, context.ocean, frequency=config.frequency_hz, rays=256, bounces=4
        )
        self._targets = Transponders(config.targets, context, key="targets")
        self._noise_db = pulse_noise_db(context.ocean, config.frequency_hz, config.noise_db, config.pulse_s)
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "measurement"))
        self._sigma = np.array([config.range_noise_m, config.azimuth_noise_rad, config.elevation_noise_rad])

    def sense(self, motion: Kinematics) -> Measurement:
        """Range and bearing on every lane of `motion`."""
        c = self._config
        position, attitude = (np.array(v).T for v in sensor_pose(motion, c))
        t = np.array(motion.t_ns).astype(np.float64) * 1e-9
        first = self._targets.listen(self._paths, position, t, np.array(motion.copy).astype(np.int64))
        snr = c.source_level_db - first.loss_db - self._noise_db
        speed = first.speed if c.sound_speed_mps is None else c.sound_speed_mps
        clean = np.concatenate([(speed * first.time)[..., None], _angles(attitude, first.direction)], axis=-1)
        drawn = np.stack([np.array(v) for v in noise.normals64(self._key, motion, clean[0].size)], axis=1)
        measured = clean + drawn.reshape(clean.shape) * self._sigma
        measured[..., 0] = np.maximum(measured[..., 0], 0.0)
        measured[..., 1] = np.mod(measured[..., 1] + math.pi, 2.0 * math.pi) - math.pi
        measured[..., 2] = np.clip(measured[..., 2], -0.5 * math.pi, 0.5 * math.pi)
        heard = (snr >= c.detection_db) & (clean[..., 0] <= c.range_max_m)  # false where no path arrives
        way = first.places - position[:, None]
        straight = np.concatenate([np.linalg.norm(way, axis=-1, keepdims=True), _angles(attitude, way)], axis=-1)
        return Measurement(
            np.where(heard[..., None], measured, np.nan), straight, np.asarray(heard.any(axis=1)),
            {"travel_time": first.time, "snr_db": snr, "target_position": first.places},
        )  # fmt: skip

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping of each target: (name, values, unit)."""
        found = self.sense(motion)
        return [
            ("travel time", found.extras["travel_time"], "s"), ("snr", found.extras["snr_db"], "dB"),
            ("range", found.data[..., 0], "m"), ("azimuth", found.data[..., 1], "rad"),
            ("elevation", found.data[..., 2], "rad"),
        ]  # fmt: skip


def _angles(attitude: NDArray[np.float64], way: NDArray[np.float64]) -> NDArray[np.float64]:
    """`(m, k, 2)` azimuth and elevation [rad] in the sensor frame of ways `(m, k, 3)` in the world's."""
    q = np.repeat(attitude, way.shape[1], axis=0)
    x, y, z = rotate_back_np(q, way.reshape(-1, 3)).T
    return np.stack([np.arctan2(y, x), np.arctan2(z, np.hypot(x, y))], axis=-1).reshape(*way.shape[:2], 2)

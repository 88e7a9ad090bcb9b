"""A LiDAR: points with intensity, in the sensor's frame.

Data and truth are `(m, channels, steps, 4)` float32: x, y, z [m] and intensity 0 .. 1, NaN where a pulse gave no
point. The first axis after the lanes is the ring. `points` lists those that are there as CARLA and ROS do. In truth
nothing is dropped, and range has no noise.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32, uniform32
from pelagos.sensors.laser import Echoes, LaserConfig, echoes, pulses, scan_struct
from pelagos.sensors.noise import opaque_key, stream_key, words32
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.view import Trace


class LidarConfig(LaserConfig):
    """A LiDAR with intensity, dropout and noise."""

    type: Literal["lidar"] = "lidar"
    """The sensor's kind."""
    atmosphere_attenuation_rate: float = Field(default=0.004, ge=0)
    """Intensity falls as exp(-rate d) with the way d in air [1/m]."""
    water_attenuation_rate: float | None = Field(default=None, ge=0)
    """The same under water [1/m]; None: twice the green beam attenuation of the ocean's water type (there and back)."""
    reflectance: bool = False
    """Whether intensity also carries the surface's green albedo and the cosine of incidence, or only the way."""
    dropoff_general_rate: float = Field(default=0.45, ge=0, le=1)
    """Share of points that are dropped at random."""
    dropoff_intensity_limit: float = Field(default=0.8, gt=0, le=1)
    """Intensity above which no point is dropped for its weakness."""
    dropoff_zero_intensity: float = Field(default=0.4, ge=0, le=1)
    """Probability that a point of no intensity is dropped; it falls linearly to the limit."""
    noise_stddev_m: float = Field(default=0.0, ge=0)
    """Standard deviation of range [m]."""


class Lidar:
    """See `LidarConfig`."""

    TITLE: ClassVar[str] = "LiDAR: points with intensity, in air and water, as CARLA defines it"
    Config: ClassVar[type[SensorConfig]] = LidarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Parameters and dropout: CARLA documentation, Sensors reference, LIDAR sensor (release 0.9)",
    )

    def __init__(self, config: LidarConfig, context: SensorContext) -> None:
        self.config, self._context = config, context
        self._scan = scan_struct(config)
        self._own = jit.UInt32(context.own_body)
        self._albedo = jit.Float(np.array(context.world.material_tables().albedo)[1])
        water = context.ocean.water.attenuation[1]
        rate = config.water_attenuation_rate
        self._rates = tuple(dr.opaque(jit.Float, r) for r in (config.atmosphere_attenuation_rate,
                                                              2 * water if rate is None else rate))  # fmt: skip
        self._key = opaque_key(stream_key(context.seed, context.path, "lidar"))
        dr.make_opaque(self._own, self._albedo)
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One sample for every lane."""
        data, truth = (self._cloud(c) for c in self._ping(*self._arguments(motion)))
        return Measurement(data=data, truth=truth)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen sample: (name, values, unit)."""
        found: list[tuple[str, NDArray[Any], str]] = []

        def trace(name: str, values: Array, unit: str) -> None:
            found.append((name, np.array(values), unit))

        scene = self._context.scene
        self._make(scene.static, scene.moving, trace)(*self._arguments(motion))
        return found

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return self._context.scene.tables, self._scan, motion, self._own, self._albedo, self._rates, self._key

    def _cloud(self, points: Array) -> NDArray[np.float32]:
        shape = (-1, self.config.channels, self.config.steps, 4)
        return np.ascontiguousarray(np.array(points).T.reshape(shape), dtype=np.float32)

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., tuple[Array, Array]]:
        config = self.config
        count = config.channels * config.steps

        def sample(
            tables: Any, scan: Any, motion: Kinematics, own: Array, albedo: Array, rates: Any, key: Any
        ) -> tuple[Array, Array]:
            ray = dr.arange(jit.UInt32, dr.width(motion.tick) * count)
            lane = ray // count
            pulse = ray - lane * count
            rays, direction = pulses(scan, lane, pulse, motion, own, config)
            echo = echoes(static, moving, tables, rays, direction, config)
            intensity = echo_intensity(echo, albedo, rates, reflectance=config.reflectance)
            environment, tick = (dr.gather(jit.UInt32, v, lane) for v in (motion.environment, motion.tick))
            words = words32(key, pulse, environment, tick)
            kept = echo.valid & survives(intensity, words, config)
            distance = echo.distance + config.noise_stddev_m * normal_pair32(words[2], words[3])[0]
            if trace is not None:
                trace("range", echo.distance, "m")
                trace("intensity", intensity, "1")
                trace("kept", kept, "")
            return cloud(echo.direction, distance, intensity, kept), cloud(
                echo.direction, echo.distance, intensity, echo.valid
            )

        return sample


def echo_intensity(echo: Echoes, albedo: Array, rates: tuple[Array, Array], *, reflectance: bool) -> Array:
    """exp(-rate d), each medium at its own rate; times albedo and cosine of incidence where the surface counts."""
    intensity = dr.exp(-(rates[0] * echo.in_air + rates[1] * echo.in_water))
    if reflectance:
        intensity *= dr.gather(jit.Float, albedo, echo.material, echo.valid) * echo.incidence
    return intensity


def survives(intensity: Array, words: tuple[Array, Array, Array, Array], config: LidarConfig) -> Array:
    """`Bool`: kept by the general dropout, and by that of weak points: 1 - z (1 - I / limit) of them stay."""
    general = uniform32(words[0]) >= config.dropoff_general_rate
    stay = 1 - config.dropoff_zero_intensity * (1 - intensity / config.dropoff_intensity_limit)
    return general & ((intensity >= config.dropoff_intensity_limit) | (uniform32(words[1]) < stay))


def cloud(direction: Array, distance: Array, value: Array, kept: Array) -> Array:
    """`Array4f` x, y, z, value; NaN where not kept."""
    p = direction * distance
    return dr.select(kept, jit.Array4f(p.x, p.y, p.z, value), dr.nan)


def points(image: NDArray[np.float32]) -> NDArray[np.float32]:
    """`(channels, steps, 4)` of one copy -> its points `(k, 5)`: x, y, z, intensity, ring; ring by ring."""
    ring = np.broadcast_to(np.arange(len(image), dtype=np.float32)[:, None, None], (*image.shape[:2], 1))
    rows = np.concatenate([image, ring], axis=-1).reshape(-1, 5)
    return np.asarray(rows[np.isfinite(rows[:, 0])])

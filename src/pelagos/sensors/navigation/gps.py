"""Satellite navigation: a position, as long as the antenna is above the water."""

from __future__ import annotations

import math
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from pelagos import jit
from pelagos.config.rate import Rate
from pelagos.errors import ScenarioError
from pelagos.ocean.ocean import Ocean
from pelagos.sensors import noise
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.recorded import Program, Results
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class GpsConfig(SensorConfig):
    """A GNSS receiver; figures where not given are those of a single-frequency receiver without corrections.

    Figures: u-blox NEO-M8, datasheet UBX-13003366: 2.5 m circular error probable, 2.1 m a horizontal axis.
    """

    STANDS: ClassVar[str] = "antenna"
    type: Literal["gps"] = "gps"
    """The sensor's kind."""
    rate_hz: Rate = 5.0
    """Samples per second [Hz]; must divide the tick rate."""
    horizontal_std_m: float = Field(default=2.1, ge=0)
    """Standard deviation of the slow error in north and in west (orbits, ionosphere, multipath) [m]."""
    vertical_std_m: float = Field(default=3.5, ge=0)
    """Standard deviation of the slow error in height [m]."""
    correlation_time_s: float = Field(default=300.0, gt=0)
    """Correlation time of the slow error [s]."""
    noise_density: float = Field(default=0.1, ge=0)
    """White noise of each axis, 1.5 times that in height [m/sqrt(Hz)]."""
    antenna_height_m: float = Field(default=0.02, ge=0)
    """How far the antenna must stand out of the water to receive [m]."""


class Gps:
    """Position on Earth of the antenna, where it is out of the water.

    Reading: `data` `(n, 3)` latitude [deg], longitude [deg], height above the mean sea surface [m] (WGS 84; the geoid
    is not modelled); not a number where the antenna is under water, and `valid` says so.
    Extras: `position` `(n, 3)`, the same as world NWU [m]; `position_truth` `(n, 3)`.
    """

    Config: ClassVar[type[SensorConfig]] = GpsConfig
    TITLE: ClassVar[str] = "Satellite positioning, at the surface only"
    KERNELS: ClassVar[int] = 1
    CASTS: ClassVar[int] = 0
    ERRS: ClassVar[bool] = True
    SEES_SCENE: ClassVar[bool] = False
    FIXES: ClassVar[bool] = True
    SOURCES: ClassVar[tuple[str, ...]] = (
        "R. G. Brown and P. Y. C. Hwang, Introduction to Random Signals and Applied Kalman Filtering, 4th ed., 2012, "
        "Section 9.3 (Gauss-Markov errors of satellite ranges)",
        "u-blox, NEO-M8 datasheet, UBX-13003366 (default figures)",
    )

    def __init__(self, config: GpsConfig, context: SensorContext) -> None:
        if context.world.origin is None:
            raise ScenarioError("a gps needs a world with a geographic origin; give the scenario an 'origin'")
        self._config = config
        self._ocean = context.ocean
        self._origin = context.world.origin
        self._key = noise.opaque_key(noise.stream_key(context.seed, context.path, "noise"))
        self._program = Program(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """Read the sensor on every lane of `motion`."""
        found = self._program(motion, self._ocean, self._key)
        position, true, valid = found["position"], found["position_truth"], found["received"]
        geodetic = np.full((2, len(valid), 3), np.nan)
        if valid.any():
            geodetic[:, valid] = self._origin.to_geodetic(np.stack([position[valid], true[valid]]))
        extras = {"position": position, "position_truth": true}
        return Measurement(data=geodetic[0], truth=geodetic[1], valid=valid, extras=extras)

    def _kernel(self, motion: Kinematics, ocean: Ocean, key: noise.Key) -> Results:
        c = self._config
        position, _ = sensor_pose(motion, c)
        surface = ocean.elevation(position[0], position[1], jit.Float64(motion.t_ns) * 1e-9, motion.copy)
        received = position[2] > surface + c.antenna_height_m
        slow = noise.gauss_markov(key, motion, 3, correlation_time=c.correlation_time_s)
        white = noise.normals64(key, motion, 3)
        std = (c.horizontal_std_m, c.horizontal_std_m, c.vertical_std_m)
        white_std = c.noise_density * math.sqrt(c.rate_hz)
        error = [s * a + f * white_std * w for s, a, f, w in zip(std, slow, (1.0, 1.0, 1.5), white, strict=True)]
        measured = [p + e for p, e in zip(position, error, strict=True)]
        return {"position": measured, "position_truth": position, "received": received}

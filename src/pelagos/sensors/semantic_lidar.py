"""A LiDAR that knows what it hits: points with cosine of incidence, object and label; no noise, no dropout.

Data and truth are `(m, channels, steps, 4)` float32: x, y, z [m] in the sensor's frame and the cosine of the angle
between pulse and surface normal, NaN where nothing was hit. Extras: `instance` uint32 and `label` uint8, `(m,
channels, steps)`.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.laser import LaserConfig, echoes, pulses, scan_struct
from pelagos.sensors.lidar import cloud
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.view import Trace
from pelagos.world.label import label_number


class SemanticLidarConfig(LaserConfig):
    """A semantic LiDAR."""

    type: Literal["semantic_lidar"] = "semantic_lidar"
    """The sensor's kind."""


class SemanticLidar:
    """See `SemanticLidarConfig`."""

    TITLE: ClassVar[str] = "semantic LiDAR: points with label, object and incidence, as CARLA defines it"
    Config: ClassVar[type[SensorConfig]] = SemanticLidarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "CARLA documentation, Sensors reference, Semantic LIDAR sensor (release 0.9)",
    )

    def __init__(self, config: SemanticLidarConfig, context: SensorContext) -> None:
        self.config, self._context = config, context
        self._scan = scan_struct(config)
        self._own = jit.UInt32(context.own_body)
        dr.make_opaque(self._own)
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One sample for every lane."""
        found, instance, label = self._ping(*self._arguments(motion))
        shape = (-1, self.config.channels, self.config.steps)
        data = np.ascontiguousarray(np.array(found).T.reshape(*shape, 4), dtype=np.float32)
        extras = {
            "instance": np.array(instance).reshape(shape),
            "label": np.array(label).reshape(shape).astype(np.uint8),
        }
        return Measurement(data=data, truth=data, extras=extras)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen sample: (name, values, unit)."""
        found: list[tuple[str, NDArray[Any], str]] = []

        def trace(name: str, values: Array, unit: str) -> None:
            found.append((name, np.array(values), unit))

        scene = self._context.scene
        self._make(scene.static, scene.moving, trace)(*self._arguments(motion))
        return found

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return self._context.scene.tables, self._scan, motion, self._own

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., tuple[Array, ...]]:
        config = self.config
        count = config.channels * config.steps
        water = label_number("water_plane")

        def sample(tables: Any, scan: Any, motion: Kinematics, own: Array) -> tuple[Array, ...]:
            ray = dr.arange(jit.UInt32, dr.width(motion.tick) * count)
            lane = ray // count
            pulse = ray - lane * count
            rays, direction = pulses(scan, lane, pulse, motion, own, config)
            echo = echoes(static, moving, tables, rays, direction, config)
            label = dr.select(echo.valid, dr.select(echo.instance > 0, echo.label, water), 0)
            if trace is not None:
                trace("range", echo.distance, "m")
                trace("cosine of incidence", echo.incidence, "1")
                trace("label", label, "")
            instance = dr.select(echo.valid, echo.instance, 0)
            return cloud(echo.direction, echo.distance, echo.incidence, echo.valid), instance, label

        return sample

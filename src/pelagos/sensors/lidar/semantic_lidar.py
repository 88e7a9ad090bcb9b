"""A LiDAR that knows what it hits: points with cosine of incidence, object and label; no noise, no dropout.

Data and truth are `(m, channels, steps, 4)` float32: x, y, z [m] in the sensor's frame and the cosine of the angle
between pulse and surface normal, NaN where nothing was hit. Extras: `instance` uint32 and `label` uint8, `(m,
channels, steps)`; `horizontal_angle_rad` `(m,)`, see `lidar`.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.jit import Array
from pelagos.sensors.camera.picture.camera_rays import Trace
from pelagos.sensors.lidar.scan.laser import LaserConfig
from pelagos.sensors.lidar.scan.scanner import Returns, Scanner, cloud, ring_of
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.world.label import label_number


class SemanticLidarConfig(LaserConfig):
    """A semantic LiDAR."""

    type: Literal["semantic_lidar"] = "semantic_lidar"
    """The sensor's kind."""


class SemanticLidar:
    """See `SemanticLidarConfig`."""

    TITLE: ClassVar[str] = "semantic LiDAR: points with label, object and incidence, as CARLA defines it"
    KERNELS: ClassVar[int] = 10
    CASTS: ClassVar[int] = 1
    MAY_LACK: ClassVar[bool] = True
    Config: ClassVar[type[SensorConfig]] = SemanticLidarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "CARLA documentation, Sensors reference, Semantic LIDAR sensor (release 0.9)",
    )

    def __init__(self, config: SemanticLidarConfig, context: SensorContext) -> None:
        self.config = config
        self._scanner = Scanner(config, context, points_known)

    def sense(self, motion: Kinematics) -> Measurement:
        """One sample for every lane."""
        data, instance, label = self._scanner.samples(motion)
        extras = {
            "instance": instance,
            "label": label.astype(np.uint8),
            "horizontal_angle_rad": self._scanner.angle(motion),
        }
        return Measurement(data=data, truth=data, extras=extras)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen sample: (name, values, unit)."""
        return self._scanner.explain(motion)


def points_known(heard: Returns, _: Any, trace: Trace | None) -> tuple[Array, Array, Array]:
    """Points with the cosine of incidence, and their objects and labels."""
    echo = heard.echo
    label = dr.select(echo.valid, dr.select(echo.instance > 0, echo.label, label_number("water_plane")), 0)
    if trace is not None:
        trace("cosine of incidence", echo.incidence, "1")
        trace("label", label, "")
    instance = dr.select(echo.valid, echo.instance, 0)
    return cloud(echo.direction, echo.distance, echo.incidence, echo.valid), instance, label


def points(image: NDArray[np.float32], instance: NDArray[np.uint32], label: NDArray[np.uint8]) -> NDArray[np.void]:
    """The points of one copy, ring by ring, as CARLA's `SemanticLidarMeasurement` lists them, and their ring.

    Args:
        image: `(channels, steps, 4)` of one copy.
        instance, label: `(channels, steps)`, the extras.

    Returns:
        `(k,)` structured: `x`, `y`, `z`, `CosAngle` float32; `ObjIdx`, `ObjTag` uint32; `ring` uint16.
    """
    there, ring = ring_of(image)
    kinds = [(n, np.float32) for n in ("x", "y", "z", "CosAngle")] + [(n, np.uint32) for n in ("ObjIdx", "ObjTag")]
    listed = np.empty(len(ring), dtype=np.dtype([*kinds, ("ring", np.uint16)]))
    for i, name in enumerate(("x", "y", "z", "CosAngle")):
        listed[name] = image[there][:, i]
    listed["ObjIdx"], listed["ObjTag"], listed["ring"] = instance[there], label[there], ring
    return listed

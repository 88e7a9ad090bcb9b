"""A camera of surface directions: the unit normal of what each pixel shows, without error.

Data and truth are `(m, height, width, 3)` float32 in the camera's frame (x forward, y left, z up); zero for water and
sky.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.jit import Array
from pelagos.sensors.camera.picture.camera_rays import Trace, ViewConfig
from pelagos.sensors.camera.picture.hit_camera import HitView, Seen
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class NormalCameraConfig(ViewConfig):
    """A camera of surface normals."""

    type: Literal["normal_camera"] = "normal_camera"
    """The sensor's kind."""
    smooth: bool = True
    """Normals interpolated over smooth surfaces, or of the flat triangles."""


class NormalCamera:
    """See `NormalCameraConfig`."""

    TITLE: ClassVar[str] = "normal camera: direction of the surface that each pixel shows"
    KERNELS: ClassVar[int] = 12
    CASTS: ClassVar[int] = 1
    Config: ClassVar[type[SensorConfig]] = NormalCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: NormalCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._frames = HitView(config, context, normals_seen, smooth=config.smooth)

    def sense(self, motion: Kinematics) -> Measurement:
        """One image of normals for every lane."""
        normals = np.stack(self._frames.images(motion), axis=-1)
        return Measurement(data=normals, truth=normals)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._frames.explain(motion)


def normals_seen(seen: Seen, _: Any, trace: Trace | None) -> tuple[Array, ...]:
    """The three components of each pixel's normal in the sensor frame."""
    normal = dr.select(seen.solid, seen.to_sensor(seen.hits.shading_normal), 0)
    if trace is not None:
        trace("normal", normal, "1")
    return tuple(normal[i] for i in range(3))

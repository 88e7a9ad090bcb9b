"""A camera of instances: which object each pixel shows, without error.

Data and truth are `(m, height, width)` uint32 instance ids, stable over a run; 0 for water and sky. Extras: `label`,
the semantic label of the same pixels, uint8. `annotations.coco` turns both into boxes and masks.
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


class InstanceCameraConfig(ViewConfig):
    """A camera of instance ids."""

    type: Literal["instance_camera"] = "instance_camera"
    """The sensor's kind."""


class InstanceCamera:
    """See `InstanceCameraConfig`."""

    TITLE: ClassVar[str] = "instance camera: which object each pixel shows"
    KERNELS: ClassVar[int] = 12
    CASTS: ClassVar[int] = 1
    Config: ClassVar[type[SensorConfig]] = InstanceCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: InstanceCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._frames = HitView(config, context, instances_seen)

    def sense(self, motion: Kinematics) -> Measurement:
        """One image of ids for every lane."""
        ids, label = self._frames.images(motion)
        return Measurement(data=ids, truth=ids, extras={"label": label.astype(np.uint8)})

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._frames.explain(motion)


def instances_seen(seen: Seen, _: Any, trace: Trace | None) -> tuple[Array, Array]:
    """`UInt32` id and label of each pixel."""
    instance, label = (dr.select(seen.solid, v, 0) for v in (seen.hits.instance, seen.hits.label))
    if trace is not None:
        trace("instance", instance, "")
    return instance, label

"""A camera of labels: what each pixel shows, without error.

Data and truth are `(m, height, width)` uint8 semantic labels: 0 for open water and sky, `water_plane` (9) where the
ray meets the sea surface first. Table `palette` `(256, 3)` uint8: the labels' colours, so that `palette[data]` is a
picture.
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
from pelagos.world.label import label_color, label_number


class SemanticCameraConfig(ViewConfig):
    """A camera of semantic labels."""

    type: Literal["semantic_camera"] = "semantic_camera"
    """The sensor's kind."""


class SemanticCamera:
    """See `SemanticCameraConfig`."""

    TITLE: ClassVar[str] = "semantic camera: label of what each pixel shows"
    KERNELS: ClassVar[int] = 12
    CASTS: ClassVar[int] = 1
    Config: ClassVar[type[SensorConfig]] = SemanticCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = ("Labels: HoloOcean documentation, Semantic labels",)

    def __init__(self, config: SemanticCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._frames = HitView(config, context, labels_seen)
        self._palette = np.array([label_color(n) for n in range(256)], dtype=np.uint8)

    def sense(self, motion: Kinematics) -> Measurement:
        """One label image for every lane."""
        labels = self._frames.images(motion)[0].astype(np.uint8)
        return Measurement(data=labels, truth=labels, tables={"palette": self._palette})

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._frames.explain(motion)


def labels_seen(seen: Seen, _: Any, trace: Trace | None) -> tuple[Array]:
    """`UInt32` label of each pixel."""
    label = dr.select(seen.at_sea, label_number("water_plane"), seen.hits.label)
    if trace is not None:
        trace("label", label, "")
    return (label,)

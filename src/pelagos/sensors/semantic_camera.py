"""A camera of labels: what each pixel shows, without error.

Data and truth are `(m, height, width)` uint8 semantic labels: 0 for open water and sky, `water_plane` (9) where the
ray meets the sea surface first. Table `palette` `(256, 3)` uint8: the labels' colours, so that `palette[data]` is a
picture.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.jit import Array
from pelagos.raycast.caster import cast
from pelagos.sensors.pixels import image_rows, pixels
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.view import Trace, View, ViewConfig, meets_sea_surface, view_rays
from pelagos.world.label import label_color, label_number


class SemanticCameraConfig(ViewConfig):
    """A camera of semantic labels."""

    type: Literal["semantic_camera"] = "semantic_camera"
    """The sensor's kind."""


class SemanticCamera:
    """See `SemanticCameraConfig`."""

    TITLE: ClassVar[str] = "semantic camera: label of what each pixel shows"
    Config: ClassVar[type[SensorConfig]] = SemanticCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = ("Labels: HoloOcean documentation, Semantic labels",)

    def __init__(self, config: SemanticCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._view = View(config, context)
        self._palette = np.array([label_color(n) for n in range(256)], dtype=np.uint8)
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One label image for every lane."""
        labels = self._view.images(self._ping(*self._view.arguments(motion)), np.uint8)
        return Measurement(data=labels, truth=labels, tables={"palette": self._palette})

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._make, self._view.arguments(motion))

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., Array]:
        config, tiling = self.config, self._view.tiling
        water = label_number("water_plane")

        def frame(tables: Any, lens: Any, motion: Kinematics, own: Array) -> Array:
            images = dr.width(motion.tick)
            where = pixels(tiling, images)
            rays = view_rays(lens, where, motion, own, config)
            hits = cast(static, moving, tables, rays)
            label = dr.select(meets_sea_surface(rays, hits), water, hits.label)
            if trace is not None:
                trace("slant range", hits.t, "m")
                trace("label", label, "")
            return image_rows(label, tiling, where, images)

        return frame

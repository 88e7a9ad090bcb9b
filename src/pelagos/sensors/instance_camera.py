"""A camera of instances: which object each pixel shows, without error.

Data and truth are `(m, height, width)` uint32 instance ids, stable over a run; 0 for water and sky. Extras: `label`,
the semantic label of the same pixels, uint8. `annotations.coco` turns both into boxes and masks.
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


class InstanceCameraConfig(ViewConfig):
    """A camera of instance ids."""

    type: Literal["instance_camera"] = "instance_camera"
    """The sensor's kind."""


class InstanceCamera:
    """See `InstanceCameraConfig`."""

    TITLE: ClassVar[str] = "instance camera: which object each pixel shows"
    Config: ClassVar[type[SensorConfig]] = InstanceCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: InstanceCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._view = View(config, context)
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One image of ids for every lane."""
        found, label = self._ping(*self._view.arguments(motion))
        ids = self._view.images(found, np.uint32)
        return Measurement(data=ids, truth=ids, extras={"label": self._view.images(label, np.uint8)})

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._make, self._view.arguments(motion))

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., tuple[Array, ...]]:
        config, tiling = self.config, self._view.tiling

        def frame(tables: Any, lens: Any, motion: Kinematics, own: Array) -> tuple[Array, ...]:
            images = dr.width(motion.tick)
            where = pixels(tiling, images)
            rays = view_rays(lens, where, motion, own, config)
            hits = cast(static, moving, tables, rays)
            solid = hits.valid & ~meets_sea_surface(rays, hits)
            instance, label = dr.select(solid, hits.instance, 0), dr.select(solid, hits.label, 0)
            if trace is not None:
                trace("slant range", hits.t, "m")
                trace("instance", instance, "")
            return tuple(image_rows(v, tiling, where, images) for v in (instance, label))

        return frame

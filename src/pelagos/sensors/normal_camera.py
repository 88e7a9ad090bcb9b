"""A camera of surface directions: the unit normal of what each pixel shows, without error.

Data and truth are `(m, height, width, 3)` float32 in the camera's frame (x forward, y left, z up); zero for water and
sky.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.raycast.caster import cast
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.pixels import image_rows, pixels
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.view import Trace, View, ViewConfig, meets_sea_surface, view_rays


class NormalCameraConfig(ViewConfig):
    """A camera of surface normals."""

    type: Literal["normal_camera"] = "normal_camera"
    """The sensor's kind."""
    smooth: bool = True
    """Normals interpolated over smooth surfaces, or of the flat triangles."""


class NormalCamera:
    """See `NormalCameraConfig`."""

    TITLE: ClassVar[str] = "normal camera: direction of the surface that each pixel shows"
    Config: ClassVar[type[SensorConfig]] = NormalCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = ()

    def __init__(self, config: NormalCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._view = View(config, context)
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One image of normals for every lane."""
        parts = self._ping(*self._view.arguments(motion))
        normals = np.stack([self._view.images(p, np.float32) for p in parts], axis=-1)
        return Measurement(data=normals, truth=normals)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._make, self._view.arguments(motion))

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., tuple[Array, ...]]:
        config, tiling = self.config, self._view.tiling

        def frame(tables: Any, lens: Any, motion: Kinematics, own: Array) -> tuple[Array, ...]:
            images = dr.width(motion.tick)
            where = pixels(tiling, images)
            rays = view_rays(lens, where, motion, own, config)
            hits = cast(static, moving, tables, rays, smooth=config.smooth)
            _, attitude = sensor_pose(motion, config)
            q = jit.Array4f(*(dr.gather(jit.Float, jit.Float(attitude[i]), where.image) for i in range(4)))
            solid = hits.valid & ~meets_sea_surface(rays, hits)
            normal = dr.select(solid, rotate_back(q, hits.shading_normal), 0)
            if trace is not None:
                trace("slant range", hits.t, "m")
                trace("normal", normal, "1")
            return tuple(image_rows(normal[i], tiling, where, images) for i in range(3))

        return frame

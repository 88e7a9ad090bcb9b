"""A camera of motion: how fast what each pixel shows moves across the picture, without error.

Data and truth are `(m, height, width, 2)` float32 [px/s], (right, down), NaN where the pixel shows water or sky.
Instantaneous: the camera's own motion and the surface's, through the derivative of the lens.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate_back
from pelagos.raycast.caster import cast
from pelagos.sensors.mount import sensor_angular_velocity, sensor_pose, sensor_velocity
from pelagos.sensors.pixels import image_rows, pixels
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.view import Trace, View, ViewConfig, meets_sea_surface, pixel_rays, project_points, view_rays

_STEP: Final = 1e-5  # of the unit direction, for the lens's derivative


class OpticalFlowCameraConfig(ViewConfig):
    """A camera of optical flow."""

    type: Literal["optical_flow_camera"] = "optical_flow_camera"
    """The sensor's kind."""
    port: None = None
    """A lens behind a port has no flow in closed form."""


class OpticalFlowCamera:
    """See `OpticalFlowCameraConfig`."""

    TITLE: ClassVar[str] = "optical flow camera: motion of what each pixel shows"
    Config: ClassVar[type[SensorConfig]] = OpticalFlowCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "H. C. Longuet-Higgins and K. Prazdny, Proc. R. Soc. Lond. B 208:385 (1980), doi 10.1098/rspb.1980.0057",
    )

    def __init__(self, config: OpticalFlowCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._view = View(config, context)
        slopes = self._view.tiling.arrange(lens_derivative(config))  # (lanes, 2, 3)
        self._slopes = tuple(jit.Array3f(np.ascontiguousarray(np.nan_to_num(slopes[:, i]).T)) for i in (0, 1))
        dr.make_opaque(self._slopes)
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One flow image for every lane."""
        parts = self._ping(*self._view.arguments(motion), self._slopes)
        flow = np.stack([self._view.images(p, np.float32) for p in parts], axis=-1)
        return Measurement(data=flow, truth=flow)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._make, (*self._view.arguments(motion), self._slopes))

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., tuple[Array, ...]]:
        config, tiling = self.config, self._view.tiling

        def frame(tables: Any, lens: Any, motion: Kinematics, own: Array, slopes: Any) -> tuple[Array, ...]:
            images = dr.width(motion.tick)
            where = pixels(tiling, images)
            rays = view_rays(lens, where, motion, own, config)
            hits = cast(static, moving, tables, rays)
            _, attitude = sensor_pose(motion, config)

            def here(vector: Array) -> Array:
                return dr.gather(jit.Array3f, jit.Array3f(vector), where.image)

            q = jit.Array4f(*(dr.gather(jit.Float, jit.Float(attitude[i]), where.image) for i in range(4)))
            direction = dr.gather(jit.Array3f, lens.direction, where.ray)
            approach = rotate_back(q, hits.velocity) - here(sensor_velocity(motion, config))
            drift = approach / hits.t - dr.cross(here(sensor_angular_velocity(motion, config)), direction)  # [1/s]
            solid = hits.valid & ~meets_sea_surface(rays, hits)
            flow = [dr.select(solid, dr.dot(dr.gather(jit.Array3f, s, where.ray), drift), dr.nan) for s in slopes]
            if trace is not None:
                trace("slant range", hits.t, "m")
                trace("motion over distance", drift, "1/s")
            return tuple(image_rows(f, tiling, where, images) for f in flow)

        return frame


def lens_derivative(config: ViewConfig) -> NDArray[np.float64]:
    """`(height, width, 2, 3)` change of (u, v) [px] with the unit direction, by central differences."""
    _, directions = pixel_rays(config)
    columns = []
    for axis in np.eye(3) * _STEP:
        columns.append(
            (project_points(directions + axis, config) - project_points(directions - axis, config)) / (2 * _STEP)
        )
    return np.stack(columns, axis=-1)

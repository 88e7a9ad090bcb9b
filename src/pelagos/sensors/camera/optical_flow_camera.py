"""A camera of motion: how fast what each pixel shows moves across the picture, without error.

Data and truth are `(m, height, width, 2)` float32 [px/s], (right, down), NaN where the pixel shows water or sky.
Instantaneous: the camera's own motion and the surface's, through the derivative of the lens and its port.
"""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.camera.picture.camera_rays import Trace, ViewConfig, starts_wet
from pelagos.sensors.camera.picture.hit_camera import HitView, Seen
from pelagos.sensors.camera.picture.ray_change import RayChange, ray_change
from pelagos.sensors.mount import sensor_angular_velocity, sensor_velocity
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class OpticalFlowCameraConfig(ViewConfig):
    """A camera of optical flow."""

    type: Literal["optical_flow_camera"] = "optical_flow_camera"
    """The sensor's kind."""


class OpticalFlowCamera:
    """See `OpticalFlowCameraConfig`."""

    TITLE: ClassVar[str] = "optical flow camera: motion of what each pixel shows"
    KERNELS: ClassVar[int] = 18
    CASTS: ClassVar[int] = 1
    MAY_LACK: ClassVar[bool] = True
    Config: ClassVar[type[SensorConfig]] = OpticalFlowCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "H. C. Longuet-Higgins and K. Prazdny, Proc. R. Soc. Lond. B 208:385 (1980), doi 10.1098/rspb.1980.0057",
    )

    def __init__(self, config: OpticalFlowCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._frames = HitView(config, context, self._flow, ray_change(config))

    def sense(self, motion: Kinematics) -> Measurement:
        """One flow image for every lane."""
        flow = np.stack(self._frames.images(motion), axis=-1)
        return Measurement(data=flow, truth=flow)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._frames.explain(motion)

    def _flow(self, seen: Seen, change: RayChange, trace: Trace | None) -> tuple[Array, ...]:
        """Motion of each pixel's surface across the picture, (right, down) [px/s].

        A ray with start s and direction d meets the surface at P = s + t d. What is seen there moves with V in the
        sensor frame and stays in the picture on the ray of another pixel: V = (ds + t dd) . (u', v') + t' d, three
        equations for u', v' and t'.
        """
        velocity, spin = (f(seen.motion, self.config) for f in (sensor_velocity, sensor_angular_velocity))
        place, t, d = seen.direction * seen.hits.t, seen.hits.t, seen.direction
        if seen.lens.start is not None:
            place += dr.gather(jit.Array3f, seen.lens.start, seen.where.ray)
        approach = seen.to_sensor(seen.hits.velocity) - seen.of_image(velocity)
        drift = approach - dr.cross(seen.of_image(spin), place)  # [m/s]
        right, down = _sideways(seen, change, t)
        if trace is not None:
            trace("motion in the sensor frame", drift, "m/s")
        over = dr.cross(down, d)
        whole = dr.rcp(dr.dot(right, over))
        flows = (dr.dot(drift, over) * whole, dr.dot(drift, dr.cross(d, right)) * whole)
        return tuple(dr.select(seen.solid, f, dr.nan) for f in flows)


def _sideways(seen: Seen, change: RayChange, t: Array) -> list[Array]:
    """By how much the rays' places at a distance `t` move from pixel to pixel, rightwards and down [m/px]."""

    def of_ray(table: Array) -> Array:
        return dr.gather(jit.Array3f, table, seen.where.ray)

    turned = [of_ray(v) for v in change.direction]
    if change.dry is not None:
        wet = starts_wet(seen.where, seen.rays.origin, seen.level)
        turned = [dr.select(wet, v, of_ray(a)) for v, a in zip(turned, change.dry, strict=True)]
    moved = [t * v for v in turned]
    if change.start is not None:
        moved = [m + of_ray(s) for m, s in zip(moved, change.start, strict=True)]
    return moved

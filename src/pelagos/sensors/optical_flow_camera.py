"""A camera of motion: how fast what each pixel shows moves across the picture, without error.

Data and truth are `(m, height, width, 2)` float32 [px/s], (right, down), NaN where the pixel shows water or sky.
Instantaneous: the camera's own motion and the surface's, through the derivative of the lens.
"""

from __future__ import annotations

from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.sensors.hit_view import HitView, Seen
from pelagos.sensors.mount import sensor_angular_velocity, sensor_velocity
from pelagos.sensors.pixels import Tiling
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.view import Trace, ViewConfig, pixel_rays, project_points

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
        slopes = Tiling(config.width_px, config.height_px).arrange(lens_derivative(config))  # (lanes, 2, 3)
        made = tuple(jit.Array3f(np.ascontiguousarray(np.nan_to_num(slopes[:, i]).T)) for i in (0, 1))
        dr.make_opaque(made)
        self._frames = HitView(config, context, self._flow, made)

    def sense(self, motion: Kinematics) -> Measurement:
        """One flow image for every lane."""
        flow = np.stack(self._frames.images(motion), axis=-1)
        return Measurement(data=flow, truth=flow)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._frames.explain(motion)

    def _flow(self, seen: Seen, slopes: tuple[Array, Array], trace: Trace | None) -> tuple[Array, ...]:
        """Motion of each pixel's surface across the picture, (right, down) [px/s]."""
        velocity, spin = (f(seen.motion, self.config) for f in (sensor_velocity, sensor_angular_velocity))
        approach = seen.to_sensor(seen.hits.velocity) - seen.of_image(velocity)
        drift = approach / seen.hits.t - dr.cross(seen.of_image(spin), seen.direction)  # [1/s]
        if trace is not None:
            trace("motion over distance", drift, "1/s")
        return tuple(
            dr.select(seen.solid, dr.dot(dr.gather(jit.Array3f, s, seen.where.ray), drift), dr.nan) for s in slopes
        )


def lens_derivative(config: ViewConfig) -> NDArray[np.float64]:
    """`(height, width, 2, 3)` change of (u, v) [px] with the unit direction, by central differences."""
    _, directions = pixel_rays(config)
    columns = []
    for axis in np.eye(3) * _STEP:
        columns.append(
            (project_points(directions + axis, config) - project_points(directions - axis, config)) / (2 * _STEP)
        )
    return np.stack(columns, axis=-1)

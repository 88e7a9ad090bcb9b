"""A depth camera: distance along its axis to the nearest surface, with the noise of stereo or of range.

Data and truth are `(m, height, width)` float32 [m], +inf where nothing stands within `max_range_m` (and in data also
where a measurement failed). Depth is the coordinate along the camera's axis, not the length of the ray.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, ClassVar, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32, uniform32
from pelagos.raycast.caster import cast
from pelagos.sensors.noise import opaque_key, stream_key, words32
from pelagos.sensors.pixels import Pixels, Tiling, image_rows, pixels
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.view import Trace, View, ViewConfig, view_intrinsics, view_rays


class DepthCameraConfig(ViewConfig):
    """A depth camera."""

    type: Literal["depth_camera"] = "depth_camera"
    """The sensor's kind."""
    noise_m: float = Field(default=0.0, ge=0)
    """Standard deviation that does not grow with depth [m]."""
    noise_share: float = Field(default=0.0, ge=0, le=1)
    """Standard deviation over depth."""
    stereo_baseline_m: float | None = Field(default=None, gt=0)
    """Distance between the eyes of a stereo pair [m]; its error grows with the square of depth. None: not stereo."""
    disparity_noise_px: float = Field(default=0.2, ge=0)
    """Standard deviation of stereo matching [px]."""
    dropout: float = Field(default=0.0, ge=0, le=1)
    """Share of pixels without a measurement."""


class DepthCamera:
    """See `DepthCameraConfig`."""

    TITLE: ClassVar[str] = "depth camera: distance along the axis, with range or stereo noise"
    Config: ClassVar[type[SensorConfig]] = DepthCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Stereo error z^2 sigma_d / (f B): R. Szeliski, Computer Vision, 2nd ed. (2022), Section 12.1",
    )

    def __init__(self, config: DepthCameraConfig, context: SensorContext) -> None:
        self.config = config
        self._view = View(config, context)
        self._key = opaque_key(stream_key(context.seed, context.path, "depth"))
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One depth image for every lane."""
        data, truth = self._ping(*self._arguments(motion))
        return Measurement(data=self._view.images(data, np.float32), truth=self._view.images(truth, np.float32))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._make, self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return *self._view.arguments(motion), self._key

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., Any]:
        config, tiling = self.config, self._view.tiling

        def frame(tables: Any, lens: Any, motion: Kinematics, own: Array, key: Any) -> tuple[Array, Array]:
            images = dr.width(motion.tick)
            where = pixels(tiling, images)
            rays = view_rays(lens, where, motion, own, config)
            hits = cast(static, moving, tables, rays)
            axis = dr.gather(jit.Array3f, lens.direction, where.ray).x
            start = 0 if lens.start is None else dr.gather(jit.Array3f, lens.start, where.ray).x
            depth = hits.t * axis + start
            data = measured_depth(depth, where, tiling, config, motion, key)
            if trace is not None:
                trace("slant range", hits.t, "m")
                trace("depth", depth, "m")
                trace("depth with noise", data, "m")
            return tuple(image_rows(d, tiling, where, images) for d in (data, depth))

        return frame


def measured_depth(
    depth: Array, where: Pixels, tiling: Tiling, config: DepthCameraConfig, motion: Kinematics, key: Any
) -> Array:
    """Depth with noise and failures [m]: independent Gaussian errors of range, and of disparity for stereo."""
    index = where.row * tiling.width + where.column
    environment, tick = (dr.gather(jit.UInt32, v, where.image) for v in (motion.environment, motion.tick))
    words = words32(key, index, environment, tick)
    first, second = normal_pair32(words[0], words[1])
    near = dr.select(depth < dr.inf, depth, 0)
    sigma = dr.sqrt(config.noise_m**2 + dr.square(config.noise_share * near))
    noisy = near + sigma * first
    if config.stereo_baseline_m is not None:
        focal = view_intrinsics(config).fx
        disparity = focal * config.stereo_baseline_m / dr.maximum(noisy, 1e-6) + config.disparity_noise_px * second
        noisy = dr.select(disparity > 0, focal * config.stereo_baseline_m / disparity, dr.inf)
    failed = uniform32(words[2]) < config.dropout
    return dr.select((depth < dr.inf) & ~failed, dr.maximum(noisy, 0), dr.inf)

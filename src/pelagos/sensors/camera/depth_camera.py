"""A depth camera: distance along its axis to the nearest surface, with the noise of stereo or of range.

Data and truth are `(m, height, width)` float32 [m], +inf where nothing stands within `max_range_m` (and in data also
where a measurement failed). Depth is the coordinate along the camera's axis, not the length of the ray; the sea surface
is a surface, from both sides. Extras with
`image: true`: `image` and `image_truth`, the colour picture through the same lens, as `camera` gives it, with its
`exposure_s` and `iso`.
"""

from __future__ import annotations

import warnings
from typing import Any, ClassVar, Final, Literal

import drjit as dr
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32, uniform32
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.camera_rays import Trace, ViewConfig, view_intrinsics
from pelagos.sensors.camera.picture.hit_camera import HitView, Seen
from pelagos.sensors.idle_keys import Need, changed, idle, named
from pelagos.sensors.noise import Key, opaque_key, stream_key, words32
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class DepthCameraConfig(CameraConfig):
    """A depth camera; with `image` also a colour camera, which all of `camera`'s keys are for."""

    type: Literal["depth_camera"] = "depth_camera"  # type: ignore[assignment]
    """The sensor's kind."""
    noise_m: float = Field(default=0.0, ge=0)
    """Standard deviation that does not grow with depth [m]."""
    noise_share: float = Field(default=0.0, ge=0, le=1)
    """Standard deviation over depth."""
    stereo_baseline_m: float | None = Field(default=None, gt=0)
    """Distance between the eyes of a stereo pair [m]; its error grows with the square of depth, and what comes out
    beyond `max_range_m` has failed. None: not stereo."""
    disparity_noise_px: float = Field(default=0.2, ge=0)
    """Standard deviation of stereo matching [px]."""
    dropout: float = Field(default=0.0, ge=0, le=1)
    """Share of pixels without a measurement."""
    image: bool = False
    """Whether a colour picture through the same lens comes along."""


_STEREO: Final = Need(("disparity_noise_px",), "stereo_baseline_m")


class DepthCamera:
    """See `DepthCameraConfig`."""

    TITLE: ClassVar[str] = "depth camera: distance along the axis, with range or stereo noise; a picture on request"
    KERNELS: ClassVar[int] = 12
    CASTS: ClassVar[int] = 1
    MAY_LACK: ClassVar[bool] = True
    Config: ClassVar[type[SensorConfig]] = DepthCameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Stereo error z^2 sigma_d / (f B): R. Szeliski, Computer Vision, 2nd ed. (2022), Section 12.1",
    )

    def __init__(self, config: DepthCameraConfig, context: SensorContext) -> None:
        self.config = config
        told = idle(config, (_STEREO,))
        of_picture = changed(config, (k for k in CameraConfig.model_fields if k not in ViewConfig.model_fields))
        if of_picture and not config.image:
            told = f"{named(of_picture)} changes nothing without 'image: true'"
        if told:
            warnings.warn(f"{context.path}: {told}", ValidityWarning, stacklevel=3)
        key = opaque_key(stream_key(context.seed, context.path, "depth"))
        self._frames = HitView(config, context, self._depths, key)
        self._camera = Camera(config, context) if config.image else None

    def sense(self, motion: Kinematics) -> Measurement:
        """One depth image for every lane."""
        data, truth = self._frames.images(motion)
        extras = {}
        if self._camera is not None:
            picture = self._camera.sense(motion)
            extras = {"image": picture.data, "image_truth": picture.truth, **picture.extras}
        return Measurement(data=data, truth=truth, extras=extras)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._frames.explain(motion)

    def _depths(self, seen: Seen, key: Key, trace: Trace | None) -> tuple[Array, Array]:
        """Depth of each pixel with noise and without [m]."""
        start = 0 if seen.lens.start is None else dr.gather(jit.Array3f, seen.lens.start, seen.where.ray).x
        way = dr.select(seen.at_sea, seen.to_sea, seen.hits.t)
        depth = way * seen.direction.x + start
        data = measured_depth(depth, seen, self.config, key)
        if trace is not None:
            trace("depth", depth, "m")
            trace("depth with noise", data, "m")
        return data, depth


def measured_depth(depth: Array, seen: Seen, config: DepthCameraConfig, key: Key) -> Array:
    """Depth with noise and failures [m]: independent Gaussian errors of range, and of disparity for stereo."""
    where, motion = seen.where, seen.motion
    index = where.row * config.width_px + where.column
    environment, tick = (dr.gather(jit.UInt32, v, where.image) for v in (motion.environment, motion.tick))
    words = words32(key, index, environment, tick)
    first, second = normal_pair32(words[0], words[1])
    near = dr.select(depth < dr.inf, depth, 0)
    sigma = dr.sqrt(config.noise_m**2 + dr.square(config.noise_share * near))
    noisy = near + sigma * first
    if config.stereo_baseline_m is not None:
        focal = view_intrinsics(config).fx
        disparity = focal * config.stereo_baseline_m / dr.maximum(noisy, 1e-6) + config.disparity_noise_px * second
        least = focal * config.stereo_baseline_m / config.max_range_m  # that a matcher looks for
        noisy = dr.select(disparity >= least, focal * config.stereo_baseline_m / disparity, dr.inf)
    failed = uniform32(words[2]) < config.dropout
    return dr.select((depth < dr.inf) & ~failed, dr.maximum(noisy, 0), dr.inf)

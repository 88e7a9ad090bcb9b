"""Cameras of depth, labels, normals and motion as sensor_msgs/Image: every pixel as it is, nothing compressed."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.camera import CAMERA_INFO, camera_info
from pelagos.messages.encoding import OPTICAL, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.store import header, make
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.sensors.sensor import Reading

IMAGE: Final = "sensor_msgs/msg/Image"
_SUFFIX: Final = {
    "depth_camera": "depth/image", "semantic_camera": "labels", "instance_camera": "instances",
    "normal_camera": "normals", "optical_flow_camera": "flow",
}  # fmt: skip


def pixels(config: Any, site: Site) -> Encoding:
    """Image and CameraInfo; data `(n, height, width)` or `(n, height, width, c)`. Infinite depths become NaN."""
    frame = site.frame + OPTICAL.suffix
    info = Template(CAMERA_INFO, camera_info(config, frame), STAMP)
    templates: dict[tuple[int, ...], Template] = {}

    def encode(reading: Reading, copy: int) -> tuple[Buffer, Buffer]:
        picture = reading.data[copy]
        if picture.dtype.kind == "f":
            picture = np.where(np.isinf(picture), np.float32(np.nan), picture)
        if picture.shape not in templates:
            templates[picture.shape] = Template(IMAGE, _image(picture, frame), [*STAMP, "data:bytes"])
        time = seconds_nanoseconds(reading.t_ns)
        return templates[picture.shape].encode(*time, picture.tobytes()), info.encode(*time)

    suffix = _SUFFIX.get(config.type, "image")
    return Encoding((Topic(suffix, IMAGE), Topic("camera_info", CAMERA_INFO)), encode, (OPTICAL,))


def encoding_name(picture: NDArray[Any]) -> str:
    """The name that ROS gives the pixels of `(height, width)` or `(height, width, c)`."""
    channels = picture.shape[2] if picture.ndim == 3 else 1
    if channels == 1 and picture.dtype.kind == "u" and picture.dtype.itemsize <= 2:
        return f"mono{8 * picture.dtype.itemsize}"
    kind = {"f": "F", "i": "S", "u": "U" if picture.dtype.itemsize < 4 else "S"}[picture.dtype.kind]
    return f"{8 * picture.dtype.itemsize}{kind}C{channels}"


def _image(picture: NDArray[Any], frame: str) -> Any:
    return make(
        IMAGE,
        header=header(frame),
        height=picture.shape[0],
        width=picture.shape[1],
        encoding=encoding_name(picture),
        is_bigendian=0,
        step=picture.nbytes // picture.shape[0],
        data=np.zeros(picture.nbytes, dtype=np.uint8),
    )

"""Cameras of depth, labels, normals, motion, heat and events as sensor_msgs/Image."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos.messages.camera import CAMERA_INFO, camera_info, picture
from pelagos.messages.encoding import OPTICAL, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.image import IMAGE, ImageMaker
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.sensors.sensor import Reading

_SUFFIX: Final = {
    "depth_camera": "depth/image", "semantic_camera": "labels", "instance_camera": "instances",
    "normal_camera": "normals", "optical_flow_camera": "flow", "thermal_camera": "temperature",
    "event_camera": "events",
}  # fmt: skip


def pixels(config: Any, site: Site) -> Encoding:
    """Image and CameraInfo; data `(n, height, width)` or `(n, height, width, c)`. Infinite depths become NaN."""
    frame = site.frame + OPTICAL.suffix
    info = Template(CAMERA_INFO, camera_info(config, frame), STAMP)
    image = ImageMaker(frame)

    def encode(reading: Reading, copy: int) -> tuple[Buffer, Buffer]:
        values = reading.data[copy]
        if values.dtype.kind == "f":
            values = np.where(np.isinf(values), np.float32(np.nan), values)
        return image.message(values, reading.t_ns), info.encode(*seconds_nanoseconds(reading.t_ns))

    suffix = _SUFFIX.get(config.type, "image")
    return Encoding((Topic(suffix, IMAGE), Topic("camera_info", CAMERA_INFO)), encode, (OPTICAL,))


def depth(config: Any, site: Site) -> Encoding:
    """As `pixels`, and the colour picture where the camera takes one."""
    plain = pixels(config, site)
    if not config.image:
        return plain
    topic, message = picture(config, site.frame + OPTICAL.suffix)

    def encode(reading: Reading, copy: int) -> tuple[Buffer | None, ...]:
        return *plain.encode(reading, copy), message(reading.extras["image"][copy], reading.t_ns)

    return Encoding((*plain.topics, topic), encode, (OPTICAL,))

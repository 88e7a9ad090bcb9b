"""Cameras as ROS 2 messages: a compressed picture and the lens."""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pelagos.messages.encoding import OPTICAL, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.pictures import COMPRESSED_IMAGE, compressed_image, jpeg
from pelagos.messages.store import header, make
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.optics.lens import intrinsics
from pelagos.sensors.sensor import Reading

CAMERA_INFO: Final = "sensor_msgs/msg/CameraInfo"


def camera(config: Any, site: Site) -> Encoding:
    """CompressedImage and CameraInfo in the camera's optical frame; data `(n, height, width, 3)` uint8."""
    frame = site.frame + OPTICAL.suffix
    info = Template(CAMERA_INFO, camera_info(config, frame), STAMP)

    def encode(reading: Reading, copy: int) -> tuple[Buffer, Buffer]:
        picture = jpeg(np.ascontiguousarray(reading.data[copy]))
        return compressed_image(frame, reading.t_ns, picture), info.encode(*seconds_nanoseconds(reading.t_ns))

    topics = (Topic("image_color/compressed", COMPRESSED_IMAGE), Topic("camera_info", CAMERA_INFO))
    return Encoding(topics, encode, (OPTICAL,))


def camera_info(config: Any, frame: str) -> Any:
    """sensor_msgs/CameraInfo of a camera's configuration."""
    lens = intrinsics(config.width_px, config.height_px, math.radians(config.horizontal_fov_deg))
    fx, fy, cx, cy = lens.fx, lens.fy, lens.cx, lens.cy
    roi = make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
    return make(
        CAMERA_INFO,
        header=header(frame),
        height=lens.height,
        width=lens.width,
        distortion_model="plumb_bob",
        d=np.array(config.distortion, dtype=np.float64),
        k=np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1], dtype=np.float64),
        r=np.eye(3).ravel(),
        p=np.array([fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0], dtype=np.float64),
        binning_x=0,
        binning_y=0,
        roi=roi,
    )

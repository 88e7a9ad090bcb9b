"""Cameras as ROS 2 messages: a picture, compressed or as the sensor has it, and the lens."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.encoding import OPTICAL, Encoding, Site, Topic, seconds_nanoseconds
from pelagos.messages.image import IMAGE, ImageMaker
from pelagos.messages.pictures import COMPRESSED_IMAGE, compressed_image, jpeg
from pelagos.messages.store import header, make
from pelagos.messages.template import STAMP, Buffer, Template
from pelagos.sensors.camera.picture.camera_rays import view_intrinsics
from pelagos.sensors.sensor import Reading

CAMERA_INFO: Final = "sensor_msgs/msg/CameraInfo"


def camera(config: Any, site: Site) -> Encoding:
    """A picture (see `picture`) and CameraInfo in the camera's optical frame."""
    frame = site.frame + OPTICAL.suffix
    info = Template(CAMERA_INFO, camera_info(config, frame), STAMP)
    topic, message = picture(config, frame)

    def encode(reading: Reading, copy: int) -> tuple[Buffer, Buffer]:
        time = seconds_nanoseconds(reading.t_ns)
        return message(reading.data[copy], reading.t_ns), info.encode(*time)

    return Encoding((topic, Topic("camera_info", CAMERA_INFO)), encode, (OPTICAL,))


def picture(config: Any, frame: str) -> tuple[Topic, Callable[[NDArray[Any], int], Buffer]]:
    """Topic and encoder (picture, time [ns]) of a colour camera's pictures.

    Colour of 8 bits is compressed (JPEG); all other depths, and raw pictures behind a mosaic, go as they are.
    """
    if config.bits == 8 and config.mosaic == "none":
        return (
            Topic("image_color/compressed", COMPRESSED_IMAGE),
            lambda pixels, t_ns: compressed_image(frame, t_ns, jpeg(np.ascontiguousarray(pixels))),
        )
    size = 8 if config.bits <= 8 else 16
    plain = f"rgb{size}" if config.mosaic == "none" else f"bayer_{config.mosaic}{size}"
    image = ImageMaker(frame, plain)
    topic = Topic("image_color" if config.mosaic == "none" else "image_raw", IMAGE)
    return topic, lambda pixels, t_ns: image.message(pixels, t_ns)


def camera_info(config: Any, frame: str) -> Any:
    """sensor_msgs/CameraInfo of a camera's configuration: of the lens itself, without a port before it."""
    lens = view_intrinsics(config)
    fx, fy, cx, cy = lens.fx, lens.fy, lens.cx, lens.cy
    roi = make("sensor_msgs/msg/RegionOfInterest", x_offset=0, y_offset=0, height=0, width=0, do_rectify=False)
    fisheye = config.lens == "fisheye"
    return make(
        CAMERA_INFO,
        header=header(frame),
        height=lens.height,
        width=lens.width,
        distortion_model="equidistant" if fisheye else "plumb_bob",
        d=np.array(config.distortion[:4] if fisheye else config.distortion, dtype=np.float64),
        k=np.array([fx, 0, cx, 0, fy, cy, 0, 0, 1], dtype=np.float64),
        r=np.eye(3).ravel(),
        p=np.array([fx, 0, cx, 0, 0, fy, cy, 0, 0, 0, 1, 0], dtype=np.float64),
        binning_x=0,
        binning_y=0,
        roi=roi,
    )

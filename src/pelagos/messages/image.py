"""sensor_msgs/Image: every pixel as it is, nothing compressed."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.encoding import seconds_nanoseconds
from pelagos.messages.store import header, make
from pelagos.messages.template import STAMP, Buffer, Template

IMAGE: Final = "sensor_msgs/msg/Image"


class ImageMaker:
    """Messages of pictures that all have the same shape and type.

    Args:
        frame: of the camera.
        encoding: ROS's name of the pixels; by shape and type of the pictures where not given.
    """

    def __init__(self, frame: str, encoding: str | None = None) -> None:
        self._frame, self._encoding = frame, encoding
        self._templates: dict[tuple[int, ...], Template] = {}

    def message(self, picture: NDArray[Any], t_ns: int) -> Buffer:
        """CDR bytes of `(height, width)` or `(height, width, c)`."""
        if picture.shape not in self._templates:
            self._templates[picture.shape] = Template(IMAGE, self._made(picture), [*STAMP, "data:bytes"])
        return self._templates[picture.shape].encode(*seconds_nanoseconds(t_ns), picture.tobytes())

    def _made(self, picture: NDArray[Any]) -> Any:
        return make(
            IMAGE,
            header=header(self._frame),
            height=picture.shape[0],
            width=picture.shape[1],
            encoding=self._encoding or encoding_name(picture),
            is_bigendian=0,
            step=picture.nbytes // picture.shape[0],
            data=np.zeros(picture.nbytes, dtype=np.uint8),
        )


def encoding_name(picture: NDArray[Any]) -> str:
    """The name that ROS gives the pixels of `(height, width)` or `(height, width, c)`."""
    channels = picture.shape[2] if picture.ndim == 3 else 1
    if channels == 1 and picture.dtype.kind == "u" and picture.dtype.itemsize <= 2:
        return f"mono{8 * picture.dtype.itemsize}"
    kind = {"f": "F", "i": "S", "u": "U" if picture.dtype.itemsize < 4 else "S"}[picture.dtype.kind]
    return f"{8 * picture.dtype.itemsize}{kind}C{channels}"

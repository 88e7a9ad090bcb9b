"""Pictures in messages: JPEG, and the header in front of their bytes."""

from __future__ import annotations

import io
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from pelagos.messages.store import header, make, serialize

COMPRESSED_IMAGE: Final = "sensor_msgs/msg/CompressedImage"
JPEG_QUALITY: Final = 90


def jpeg(picture: NDArray[np.uint8], *, quality: int = JPEG_QUALITY) -> bytes:
    """A picture `(height, width)` or `(height, width, 3)` as JPEG; the same picture gives the same bytes."""
    out = io.BytesIO()
    Image.fromarray(picture).save(out, format="JPEG", quality=quality)
    return out.getvalue()


def compressed_image(frame: str, t_ns: int, data: bytes, *, format: str = "jpeg") -> bytes:
    """CDR bytes of sensor_msgs/CompressedImage."""
    message: Any = make(
        COMPRESSED_IMAGE, header=header(frame, t_ns), format=format, data=np.frombuffer(data, dtype=np.uint8)
    )
    return serialize(COMPRESSED_IMAGE, message)

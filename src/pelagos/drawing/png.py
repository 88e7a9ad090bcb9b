"""PNG for pictures with a sensor's noise, and of labels: the fastest that the encoder does, and the smallest of noise.

The search for longer strings that repeat, which takes most of an encoder's time, finds none in noise: run lengths and
Huffman codes are enough.
"""

from __future__ import annotations

import io
import zlib
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from PIL import Image

_FASTEST: Final = 1


def png(picture: NDArray[Any]) -> bytes:
    """A file with a picture `(height, width)` of uint8 or uint16, or `(height, width, 3)` of uint8, red green blue."""
    file = io.BytesIO()
    image = Image.fromarray(np.ascontiguousarray(picture))
    image.save(file, "PNG", compress_level=_FASTEST, compress_type=zlib.Z_RLE)
    return file.getvalue()

"""sensor_msgs/PointCloud2 of NumPy records."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos.messages.store import header, make

POINT_CLOUD: Final = "sensor_msgs/msg/PointCloud2"
_KINDS: Final = {"i1": 1, "u1": 2, "i2": 3, "u2": 4, "i4": 5, "u4": 6, "f4": 7, "f8": 8}  # PointField.INT8 .. FLOAT64


def point_cloud(frame: str, point: np.dtype[Any], count: int) -> Any:
    """A cloud of `count` points of zeros, which may hold NaN later; the fields are those of the dtype."""
    layout = [
        make("sensor_msgs/msg/PointField", name=name, offset=place[1], datatype=_KINDS[place[0].str[1:]], count=1)
        for name, place in (point.fields or {}).items()
    ]
    return make(
        POINT_CLOUD,
        header=header(frame),
        height=1,
        width=count,
        fields=layout,
        is_bigendian=False,
        point_step=point.itemsize,
        row_step=point.itemsize * count,
        data=np.zeros(point.itemsize * count, dtype=np.uint8),
        is_dense=False,
    )

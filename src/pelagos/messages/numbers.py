"""Plain numbers of any sensor, as std_msgs/Float64MultiArray with labelled dimensions."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.messages.encoding import Encoding, Site, Topic
from pelagos.messages.store import make, serialize
from pelagos.sensors.sensor import Reading

MULTI_ARRAY: Final = "std_msgs/msg/Float64MultiArray"


def numbers(config: Any, site: Site) -> Encoding:
    """Encoding of a sensor without a message of its own; dimensions are labelled "axis0", "axis1" ...

    Complex numbers have one axis more, labelled "real, imaginary".
    """

    def encode(reading: Reading, copy: int) -> tuple[bytes]:
        return (multi_array(reading.data[copy]),)

    return Encoding((Topic("", MULTI_ARRAY),), encode)


def multi_array(values: NDArray[Any]) -> bytes:
    """CDR bytes of an array of any shape."""
    is_complex = np.iscomplexobj(values)
    if is_complex:
        values = np.stack([values.real, values.imag], axis=-1)
    shape = values.shape or (1,)
    labels = [f"axis{i}" for i in range(len(shape))]
    if is_complex:
        labels[-1] = "real, imaginary"
    strides = np.cumprod(shape[::-1])[::-1]
    dimensions = [
        make("std_msgs/msg/MultiArrayDimension", label=label, size=int(size), stride=int(stride))
        for label, size, stride in zip(labels, shape, strides, strict=True)
    ]
    layout = make("std_msgs/msg/MultiArrayLayout", dim=dimensions, data_offset=0)
    data = np.ascontiguousarray(values, dtype=np.float64).ravel()
    return serialize(MULTI_ARRAY, make(MULTI_ARRAY, layout=layout, data=data))

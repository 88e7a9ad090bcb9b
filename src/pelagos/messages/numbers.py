"""Plain numbers of any sensor, as std_msgs/Float64MultiArray with labelled dimensions."""

from __future__ import annotations

from collections.abc import Sequence
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


class LabelledRow:
    """Float64MultiArray of one dimension, whose label names its numbers: only these change from message to message.

    Args:
        names: of the numbers, in order.
        units: of each.
    """

    def __init__(self, names: Sequence[str], units: Sequence[str]) -> None:
        self._count = len(names)
        label = ", ".join(f"{name} [{unit or '-'}]" for name, unit in zip(names, units, strict=True))
        self._constant = np.frombuffer(multi_array(np.zeros(self._count), [label]), dtype=np.uint8)

    def rows(self, values: NDArray[np.float64]) -> NDArray[np.uint8]:
        """`(k, size)` bytes of k messages: values `(k, names)`. The numbers are a message's last bytes."""
        out = np.tile(self._constant, (len(values), 1))
        out[:, -8 * self._count :] = np.ascontiguousarray(values, dtype="<f8").view(np.uint8)
        return out


def names_in(label: str) -> tuple[str, ...]:
    """Names of the numbers in a message of `LabelledRow`, from the label of its dimension."""
    return tuple(part.partition(" [")[0] for part in label.split(", "))


def multi_array(values: NDArray[Any], labels: Sequence[str] | None = None) -> bytes:
    """CDR bytes of an array of any shape; `labels` of its dimensions, where they are not "axis0" and so on."""
    is_complex = np.iscomplexobj(values)
    if is_complex:
        values = np.stack([values.real, values.imag], axis=-1)
    shape = values.shape or (1,)
    labels = list(labels or (f"axis{i}" for i in range(len(shape))))
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

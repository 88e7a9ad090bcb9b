"""Readings of a group's members in one message: a row of numbers for each, in the order of the members.

The numbers are those that vary in the members' own messages, under the names that they have there, so that these can be
made of them again, to the byte.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import RecordingError
from pelagos.messages.store import deserialize, header, make
from pelagos.messages.template import STAMP, Template

GROUP: Final = "pelagos_msgs/msg/GroupReadings"
_ARRAYS: Final = ("valid:bytes", "data:bytes")


class GroupTemplate:
    """Encoder of one group's readings of one topic.

    Args:
        frame: of the group's sensor, "auv/imu".
        members: how many.
        fields: numbers of a member's message behind its stamp, "angular_velocity.x:float64".
    """

    def __init__(self, frame: str, members: int, fields: Sequence[str]) -> None:
        count, names = len(fields), ", ".join(field.rpartition(":")[0] for field in fields)
        dimensions = [_dimension("member", members, members * count), _dimension(names, count, count)]
        message = make(
            GROUP,
            header=header(frame),
            valid=np.zeros(members, dtype=bool),
            layout=make("std_msgs/msg/MultiArrayLayout", dim=dimensions, data_offset=0),
            data=np.zeros(members * count),
        )
        self._template = Template(GROUP, message, [*STAMP, *_ARRAYS])

    def rows(self, t_ns: NDArray[np.int64], values: NDArray[np.float64], valid: NDArray[np.bool_]) -> NDArray[np.uint8]:
        """`(k, size)` bytes of k messages: times `(k,)` [ns], numbers `(k, members, m)`, and which are valid."""
        stamps = np.divmod(t_ns, 1_000_000_000)
        found = [
            self._template.encode(s, ns, flags.tobytes(), numbers.tobytes())
            for s, ns, flags, numbers in zip(*(part.tolist() for part in stamps), valid, values, strict=True)
        ]
        return np.frombuffer(b"".join(found), dtype=np.uint8).reshape(len(t_ns), -1)


def group_rows(raw: Sequence[bytes], members: int) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Numbers `(k, members, m)` of k messages of one topic, and which are valid `(k, members)`."""
    first = deserialize(GROUP, raw[0])
    if len(first.valid) != members or any(len(one) != len(raw[0]) for one in raw):
        raise RecordingError(f"messages of type {GROUP} are not for the {members} members that the recording names")
    table = np.frombuffer(b"".join(raw), dtype=np.uint8).reshape(len(raw), -1)
    (valid, _), (data, _) = Template(GROUP, first, _ARRAYS).places
    numbers = np.ascontiguousarray(table[:, data : data + 8 * len(first.data)]).view("<f8")
    flags = np.ascontiguousarray(table[:, valid : valid + members]).view(np.bool_)
    return numbers.reshape(len(raw), members, -1), flags


def _dimension(label: str, size: int, stride: int) -> Any:
    return make("std_msgs/msg/MultiArrayDimension", label=label, size=size, stride=stride)

"""Topics of groups in a recording: as arrays of all members, and as the messages that each member would have had.

What is constant in the members' messages stands in the attachment that `sim/record_together.py` writes.
"""

from __future__ import annotations

import base64
import itertools
import json
import zlib
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any, Final, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import RecordingError
from pelagos.messages.group import group_rows
from pelagos.messages.store import deserialize
from pelagos.messages.template import STAMP, Template

_OF_GROUP: Final = ("group", "message", "members")
Messages: TypeAlias = Callable[[], tuple[NDArray[np.int64], list[bytes]]]


@dataclass(frozen=True)
class GroupTable:
    """Numbers of a group's members in one topic.

    Attributes:
        t_s: `(k,)` times [s].
        members: names, in the order of the rows.
        fields: names of the numbers: fields of the members' own messages, "angular_velocity.x".
        values: `(k, members, fields)`; zero where they are not valid.
        valid: `(k, members)` who has a reading at each time.
    """

    t_s: NDArray[np.float64]
    members: tuple[str, ...]
    fields: tuple[str, ...]
    values: NDArray[np.float64]
    valid: NDArray[np.bool_]


class GroupTopic:
    """One topic of a group.

    Attributes:
        topic: its own, "/auv/imu/data_raw".
        type: of the members' messages.
        members: topics of the members, and what is said of each.

    Args:
        described: as the attachment has it.
        messages: reads times [ns] and messages of its channel.
    """

    def __init__(self, described: Mapping[str, Any], messages: Messages) -> None:
        self.topic: str = described["topic"]
        self.type: str = described["type"]
        self.members: Mapping[str, Mapping[str, str]] = described["members"]
        self._fields: Sequence[str] | None = described["fields"]
        self._sizes: Sequence[int] = described["sizes"]
        self._packed: str = described["constant"]
        self._rows = {topic: i for i, topic in enumerate(self.members)}
        self._read = messages
        self._layouts: dict[tuple[int, int], Template] = {}

    def about(self, member: Mapping[str, str], channel: Mapping[str, str]) -> dict[str, str]:
        """Metadata of a member's channel, of those noted for it and of the group's channel."""
        latched = {} if self._fields is not None else {k: v for k, v in channel.items() if k not in _OF_GROUP}
        return {**member, **latched}

    def count(self, topic: str) -> int:
        """Number of messages of a member."""
        row = self._rows[topic]
        if self._fields is None:
            return int(row < len(self._messages[1]))
        return int(self._table[1][:, row].sum())

    def messages(self, topic: str) -> list[tuple[int, bytes]]:
        """Times [ns] and messages of a member, in the order of time."""
        row, (t_ns, raw) = self._rows[topic], self._messages
        if self._fields is None:
            return [(int(t_ns[row]), raw[row])] if row < len(raw) else []
        values, valid = self._table
        lanes = valid[:, row]
        times, found = t_ns[lanes], self._template(topic).rows(t_ns[lanes], values[lanes, row])
        return list(zip(times.tolist(), map(bytes, found), strict=True))

    def table(self) -> GroupTable:
        """Everything as arrays.

        Raises:
            RecordingError: its messages are no rows of numbers.
        """
        if self._fields is None:
            raise RecordingError(
                f"{self.topic} holds messages of type {self.type}, one a member, and no rows of numbers"
            )
        values, valid = self._table
        names = tuple(field.rpartition(":")[0] for field in self._fields)
        agents = tuple(about["agent"] for about in self.members.values())
        return GroupTable(self._messages[0].astype(np.float64) * 1e-9, agents, names, values, valid)

    @cached_property
    def _messages(self) -> tuple[NDArray[np.int64], list[bytes]]:
        return self._read()

    @cached_property
    def _table(self) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
        """Numbers `(k, members, m)`, and which are valid `(k, members)`."""
        members, raw = len(self.members), self._messages[1]
        if raw:
            return group_rows(raw, members)
        return np.zeros((0, members, len(self._fields or ()))), np.zeros((0, members), dtype=bool)

    @cached_property
    def _constant(self) -> list[bytes]:
        """Messages of the members, whose numbers stand for nothing."""
        joined = zlib.decompress(base64.b64decode(self._packed))
        ends = list(itertools.accumulate(self._sizes))
        return [joined[end - size : end] for size, end in zip(self._sizes, ends, strict=True)]

    def _template(self, topic: str) -> Template:
        """A member's messages; where names are equally long, they differ in the names alone."""
        raw = self._constant[self._rows[topic]]
        kind = len(raw), len(topic)
        if kind not in self._layouts:
            fields = [*STAMP, *(self._fields or ())]
            self._layouts[kind] = Template(self.type, deserialize(self.type, raw), fields)
        return self._layouts[kind].of(raw)


def group_topics(data: bytes, read: Callable[[str], Messages]) -> tuple[list[str], list[GroupTopic]]:
    """Topics as if every member had its own, and the topics of groups, of the attachment; empty where it is no such.

    Args:
        data: the attachment.
        read: reader of the messages of a group's topic.
    """
    try:
        found = json.loads(data)
        return list(found["order"]), [GroupTopic(one, read(one["topic"])) for one in found["streams"]]
    except (ValueError, TypeError, KeyError):
        return [], []

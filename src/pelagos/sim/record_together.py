"""Channels of a recording that hold a whole group: one for each topic of its members, a row of numbers for each member.

The attachment `groups.json` says which topics the members would have, and what is constant in their messages, so that a
reader makes them again, to the byte (`sim/read_together.py`).
"""

from __future__ import annotations

import base64
import json
import zlib
from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.config.swarm import group_of, topic_name
from pelagos.messages.group import GROUP, GroupTemplate
from pelagos.messages.template import STAMP, Template

GROUPS: Final = "groups.json"
_Rows: TypeAlias = tuple[int, NDArray[np.int64], NDArray[np.float64]]


@dataclass
class Stream:
    """One topic of a group.

    Attributes:
        topic: its own, "/auv/imu/data_raw".
        frame: of its messages.
        type: of the members' messages.
        fields: numbers of theirs behind the stamp; None where the channel holds their messages, one after the other.
        about: what is said of its channel.
        members: the topics that they would have, and what is said of each, in order.
        constant: the members' messages, whose numbers stand for nothing where there are fields.
    """

    topic: str
    frame: str
    type: str
    fields: tuple[str, ...] | None
    about: dict[str, str]
    members: dict[str, dict[str, str]] = field(default_factory=dict)
    constant: list[bytes] = field(default_factory=list)
    _kept: list[_Rows] = field(default_factory=list)
    _template: GroupTemplate | None = None

    def add(self, topic: str, about: Mapping[str, str], constant: bytes) -> Lane:
        """Take a member in."""
        self.members[topic] = dict(about)
        self.constant.append(constant)
        return Lane(self, len(self.members) - 1)

    def keep(self, row: int, t_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Keep a member's numbers `(k, m)` at k times until all of them are there."""
        self._kept.append((row, t_ns, values))

    def gathered(self) -> tuple[NDArray[np.int64], NDArray[np.uint8]] | None:
        """Times [ns] and messages of what was kept; None where that is nothing."""
        if not self._kept:
            return None
        assert self.fields is not None
        times = np.unique(np.concatenate([t_ns for _, t_ns, _ in self._kept]))
        values = np.zeros((len(times), len(self.members), len(self.fields)))
        valid = np.zeros(values.shape[:2], dtype=bool)
        for row, t_ns, numbers in self._kept:
            at = slice(None) if len(t_ns) == len(times) else np.searchsorted(times, t_ns)
            values[at, row], valid[at, row] = numbers, True
        self._kept.clear()
        if self._template is None:
            self._template = GroupTemplate(self.frame, len(self.members), self.fields)
        return times, self._template.rows(times, values, valid)

    def metadata(self) -> dict[str, str]:
        """Metadata of its channel."""
        members = " ".join(about["agent"] for about in self.members.values())
        return {**self.about, "message": self.type, "members": members}

    def described(self) -> dict[str, Any]:
        """Everything that a reader needs, as JSON can hold it."""
        constant = self.constant if self.fields is not None else []
        packed = base64.b64encode(zlib.compress(b"".join(constant))).decode()
        return {
            "topic": self.topic, "type": self.type, "fields": self.fields, "members": self.members,
            "sizes": [len(one) for one in constant], "constant": packed,
        }  # fmt: skip


class Door(Protocol):
    """A recorder, as groups need it to declare their channels."""

    def channel(self, topic: str, type_name: str, about: Mapping[str, str]) -> int:
        """Declare a topic."""

    def latch(self, topic: str, type_name: str, messages: Sequence[bytes], about: Mapping[str, str]) -> None:
        """Declare a topic that says its messages once."""

    def attach(self, name: str, data: bytes) -> None:
        """Write a file of JSON within the recording."""


@dataclass(frozen=True)
class Lane:
    """A member's place in a topic of its group."""

    stream: Stream
    row: int

    def keep(self, t_ns: NDArray[np.int64], values: NDArray[np.float64]) -> None:
        """Keep the member's numbers `(k, m)` at k times [ns]."""
        if len(t_ns):
            self.stream.keep(self.row, t_ns, values)


class Together:
    """The topics of groups in one recording.

    Args:
        groups: those whose members are recorded together.
    """

    def __init__(self, groups: Collection[str]) -> None:
        self._groups = groups
        self._streams: dict[str, Stream] = {}
        self._channels: dict[str, int] = {}

    def lane(self, topic: str, frame: str, about: Mapping[str, str], template: Template) -> Lane | None:
        """A member's place in its group's topic.

        Args:
            topic: the member's own.
            frame: of its sensor.
            about: agent, sensor, type and rate.
            template: of its messages.

        Returns:
            None where the agent is recorded alone, or its messages are unlike those of the members before it.
        """
        fields = template.varying[len(STAMP) :]
        stream = self._stream(topic, frame, template.name, fields, about)
        if stream is None or (stream.type, stream.fields) != (template.name, fields):
            return None
        return stream.add(topic, about, template.constant)

    def single(self, topic: str, kind: str, about: Mapping[str, str], message: bytes) -> bool:
        """Take in a member with its only message; False where it is recorded alone."""
        stream = self._stream(topic, "", kind, None, about)
        if stream is not None:
            stream.add(topic, about, message)
        return stream is not None

    def open(self, door: Door, order: Sequence[str]) -> None:
        """Declare the channels of all groups, once the members are known.

        Args:
            door: the recorder's.
            order: topics of the recording as if every member had its own.
        """
        if not self._streams:
            return
        for topic, stream in self._streams.items():
            if stream.fields is not None:
                self._channels[topic] = door.channel(topic, GROUP, stream.metadata())
            else:
                door.latch(topic, stream.type, stream.constant, stream.metadata())
        streams = [stream.described() for stream in self._streams.values()]
        door.attach(GROUPS, json.dumps({"order": list(order), "streams": streams}).encode())

    def gathered(self) -> Iterator[tuple[int, NDArray[np.int64], NDArray[np.uint8]]]:
        """Channel, times [ns] and messages of all that was kept."""
        for topic, number in self._channels.items():
            found = self._streams[topic].gathered()
            if found is not None:
                yield number, *found

    def _stream(
        self, topic: str, frame: str, kind: str, fields: tuple[str, ...] | None, about: Mapping[str, str]
    ) -> Stream | None:
        agent = about["agent"]
        group = group_of(agent)
        if group == agent or group not in self._groups:
            return None
        own, member = f"/{topic_name(agent)}/", f"{topic_name(agent)}/"
        shared = topic.replace(own, f"/{group}/", 1)
        if shared not in self._streams:
            said = {key: value for key, value in about.items() if key != "agent"}
            place = frame.replace(member, f"{group}/", 1)
            self._streams[shared] = Stream(shared, place, kind, fields, {"group": group, **said})
        return self._streams[shared]

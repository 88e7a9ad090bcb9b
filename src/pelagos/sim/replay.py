"""Read a recording back, whole, cut off or damaged, as messages or as tables of numbers."""

from __future__ import annotations

import os
import warnings
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from pelagos.errors import LookupFailed, NoRecording, RecordingError, RecordingWarning
from pelagos.messages.store import Message, deserialize
from pelagos.messages.template import Template
from pelagos.sim.mcap_reader import Damage, RawRecord, Walk, parse, read_chunk, scan_chunk, summary
from pelagos.sim.mcap_writer import CHANNELS, listed_channels
from pelagos.sim.read_together import GroupTable, GroupTopic, group_topics
from pelagos.sim.record_together import GROUPS
from pelagos.sim.recover import Recovered, recover

__all__ = ["Channel", "GroupTable", "Recorded", "Recording", "Recovered", "recover"]

KEEP_BYTES: Final = 16384  # messages up to this size stay in memory


@dataclass(frozen=True)
class Channel:
    """One topic of a recording.

    Attributes:
        topic: "/auv0/imu/data_raw".
        type: message type, "sensor_msgs/msg/Imu".
        about: what the recorder noted: agent, sensor, type, rate_hz.
    """

    topic: str
    type: str
    about: Mapping[str, str]


@dataclass(frozen=True)
class Recorded:
    """One message of a recording."""

    topic: str
    t_ns: int
    type: str
    raw: bytes

    @property
    def message(self) -> Message:
        """The message; its arrays are NumPy arrays."""
        return deserialize(self.type, self.raw)


class _Place(NamedTuple):
    """A large message that stays in the file: its chunk, and its data within."""

    chunk: int
    start: int
    end: int


class Recording:
    """A recording: small messages in memory, still encoded, large ones read when they are asked for.

    Attributes:
        path: the file.
        complete: it was closed; False where the run was killed (everything up to the cut is here).
        metadata: what the recorder noted: seed, dt_ns, versions.
        attachments: files within the file by name.
        channels: by topic; of agents that were recorded together, those that each would have had.
        groups: topics of groups whose members were recorded together.
        damage: places of the file that cannot be read; everything else is here. A `RecordingWarning` names them.

    Raises:
        RecordingError: the file cannot be read, or is no MCAP file.
    """

    def __init__(self, path: str | Path, *, topics: Collection[str] | None = None) -> None:
        self.path = Path(path)
        self.complete = False
        self.metadata: dict[str, str] = {}
        self.attachments: dict[str, bytes] = {}
        self.channels: dict[str, Channel] = {}
        self.groups: dict[str, GroupTopic] = {}
        self._group_of: dict[str, GroupTopic] = {}
        self.damage: list[Damage] = []
        self._messages: dict[str, list[tuple[int, bytes | _Place]]] = {}
        self._size = 0
        self._chunk: tuple[int, memoryview] = (-1, memoryview(b""))
        wanted = set(topics) if topics is not None else None
        self._load(wanted)
        self._take_apart(wanted)

    @property
    def lost(self) -> int | None:
        """Number of messages in damaged places; None where that is not known."""
        counts = [place.messages for place in self.damage]
        return None if None in counts else sum(count or 0 for count in counts)

    def topics(self, suffix: str = "", *, type: str | None = None) -> list[str]:
        """Topics that end in `suffix` and have messages of `type`, in the order of recording."""
        return [
            name for name, c in self.channels.items()
            if name.endswith(suffix) and (type is None or c.type == type) and self.count(name)
        ]  # fmt: skip

    def of_first(self, topic: str) -> bool:
        """True for a topic of the first copy, or of none: of many copies, "/env3/auv0/imu" is of another."""
        alone = self.metadata.get("copies") == "1"  # agents may be named as they like
        return alone or not topic.startswith("/env") or topic.startswith("/env0/")

    def count(self, topic: str) -> int:
        """Number of messages of a topic."""
        if topic in self._group_of and topic not in self._messages:
            return self._group_of[topic].count(topic)
        return len(self._messages.get(topic, ()))

    def messages(self, *topics: str) -> Iterator[Recorded]:
        """Messages of the topics (all if none is named), by topic and then in the order of recording."""
        for topic in topics or tuple(self.channels):
            self._channel(topic)
            for index in range(self.count(topic)):
                yield self.message(topic, index)

    def message(self, topic: str, index: int) -> Recorded:
        """One message of a topic, by its place in the order of recording."""
        t_ns, found = self._list(topic)[index]
        return Recorded(topic, t_ns, self._channel(topic).type, self._raw(found))

    def times(self, topic: str) -> NDArray[np.int64]:
        """`(k,)` simulation time of each message [ns]."""
        return np.array([t_ns for t_ns, _ in self._list(topic)], dtype=np.int64)

    def table(self, topic: str, fields: Sequence[str]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Numbers of all messages of a topic whose messages have one size.

        Args:
            topic: the topic.
            fields: "angular_velocity.x:float64", see `Template`.

        Returns:
            time `(k,)` [s], values `(k, len(fields))`.
        """
        rows = [recorded.raw for recorded in self.messages(topic)]
        kind = self._channel(topic).type
        if not rows:
            return np.zeros(0), np.zeros((0, len(fields)))
        size = len(rows[0])
        if any(len(raw) != size for raw in rows):
            raise RecordingError(f"{self.path}: the messages of {topic} have different sizes")
        raw = np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(len(rows), size)
        values = Template(kind, deserialize(kind, rows[0]), fields).numbers(raw)
        return self.times(topic).astype(np.float64) * 1e-9, values

    def together(self, topic: str) -> GroupTable:
        """Numbers of all members of a group that were recorded together (`record: {groups: together}`).

        Args:
            topic: the group's, "/auv/imu/data_raw".

        Raises:
            LookupFailed: no group has such a topic in this recording.
        """
        if topic not in self.groups:
            raise LookupFailed("topic of a group", topic, self.groups, where=str(self.path))
        return self.groups[topic].table()

    def _repr_html_(self) -> str:
        return str(import_module("pelagos.drawing.notebook").recording_html(self))

    def _channel(self, topic: str) -> Channel:
        if topic not in self.channels:
            raise LookupFailed("topic", topic, self.channels, where=str(self.path))
        return self.channels[topic]

    def _list(self, topic: str) -> list[tuple[int, bytes | _Place]]:
        """Messages of a topic; those of a member of a group are made of the group's when somebody asks for them."""
        if topic in self._group_of and topic not in self._messages:
            self._messages[topic] = list(self._group_of[topic].messages(topic))
        return self._messages.get(topic, [])

    def _raw(self, found: bytes | _Place) -> bytes:
        """A message, from the file where it was not kept."""
        if not isinstance(found, _Place):
            return found
        if self._chunk[0] != found.chunk:
            with self.path.open("rb") as file:
                self._chunk = found.chunk, read_chunk(file, found.chunk, self._size)
        return bytes(self._chunk[1][found.start : found.end])

    def _take_apart(self, wanted: set[str] | None) -> None:
        """Give every member of the groups that were recorded together its own topics, in the order of agents."""
        order, found = group_topics(self.attachments.get(GROUPS, b""), self._reader)
        self.groups = {one.topic: one for one in found if one.topic in self.channels}
        if not self.groups:
            return
        made: dict[str, Channel] = {}
        for one in self.groups.values():
            for topic, about in one.members.items():
                made[topic] = Channel(topic, one.type, one.about(about, self.channels[one.topic].about))
                if wanted is None or topic in wanted:
                    self._group_of[topic] = one
        made |= {topic: channel for topic, channel in self.channels.items() if topic not in self.groups}
        self.channels = {topic: made.pop(topic) for topic in order if topic in made} | made

    def _reader(self, topic: str) -> Callable[[], tuple[NDArray[np.int64], list[bytes]]]:
        """Reader of the times [ns] and messages of a group's topic."""

        def read() -> tuple[NDArray[np.int64], list[bytes]]:
            return self.times(topic), [self._raw(one) for _, one in self._list(topic)]

        return read

    def _load(self, wanted: set[str] | None) -> None:
        lists: dict[int, list[tuple[int, bytes | _Place]]] = {}
        schemas: dict[int, str] = {}

        def declare(record: RawRecord) -> None:
            self._declare(record, wanted, schemas, lists)

        try:
            with self.path.open("rb") as file:
                self._size = os.fstat(file.fileno()).st_size
                self._declare_from_index(summary(file), wanted, schemas, lists)
                walk = Walk(file, self._size, self.damage)
                for record in walk.records():
                    if record.opcode == Opcode.CHUNK:
                        self._collect(record, wanted, lists, declare)
                    else:
                        declare(record)
                self.complete = walk.complete
        except OSError as error:
            raise NoRecording(f"{self.path}: cannot be read: {error.strerror}") from None
        if self.damage:
            places = "".join(f"\n  {place}" for place in self.damage[:10])
            more = f"\n  and {len(self.damage) - 10} more" if len(self.damage) > 10 else ""
            warnings.warn(
                f"{self.path} is damaged; all the rest of it is read:{places}{more}", RecordingWarning, stacklevel=3
            )

    def _collect(
        self,
        record: RawRecord,
        wanted: set[str] | None,
        lists: dict[int, list[tuple[int, bytes | _Place]]],
        declare: Callable[[RawRecord], None],
    ) -> None:
        """Take the messages of a chunk."""
        raw = bytes(record.payload)
        strangers: dict[int, int] = {}  # messages of channels that nothing read so far declares
        try:
            scan_chunk(raw, _collector(raw, record.chunk, lists, strangers if wanted is None else None), declare)
        except RecordingError as error:
            self.damage.append(Damage(record.chunk, record.chunk, str(error)))
        if strangers:
            what = f"messages of channels {sorted(strangers)}, whose declaration is lost"
            self.damage.append(Damage(record.chunk, record.chunk, what, sum(strangers.values())))

    def _declare_from_index(
        self,
        index: Any,
        wanted: set[str] | None,
        schemas: dict[int, str],
        lists: dict[int, list[tuple[int, bytes | _Place]]],
    ) -> None:
        """Take note of what the end of a whole file says: the chunk that said it first may be damaged."""
        if index is not None:
            schemas.update({number: schema.name for number, schema in index.schemas.items()})
            for number, channel in sorted(index.channels.items()):
                found = Channel(channel.topic, schemas.get(channel.schema_id, ""), channel.metadata)
                self._enter(number, found, wanted, lists)

    def _enter(
        self,
        number: int | None,
        channel: Channel,
        wanted: set[str] | None,
        lists: dict[int, list[tuple[int, bytes | _Place]]],
    ) -> None:
        self.channels.setdefault(channel.topic, channel)
        if number is not None and (wanted is None or channel.topic in wanted or "group" in channel.about):
            lists.setdefault(number, self._messages.setdefault(channel.topic, []))

    def _declare(
        self,
        record: RawRecord,
        wanted: set[str] | None,
        schemas: dict[int, str],
        lists: dict[int, list[tuple[int, bytes | _Place]]],
    ) -> None:
        """Take note of a record that is no message."""
        if record.opcode == Opcode.SCHEMA:
            found = parse(record)
            schemas[found.id] = found.name
        elif record.opcode == Opcode.CHANNEL:
            found = parse(record)
            self._enter(found.id, Channel(found.topic, schemas.get(found.schema_id, ""), found.metadata), wanted, lists)
        elif record.opcode == Opcode.METADATA:
            self.metadata.update(parse(record).metadata)
        elif record.opcode == Opcode.ATTACHMENT:
            found = parse(record)
            if found.name == CHANNELS:
                rows = listed_channels(found.data)
                for row in rows:
                    self._enter(row["number"], Channel(row["topic"], row["type"], row["about"]), wanted, lists)
                first = {row["topic"]: self.channels[row["topic"]] for row in rows}
                self.channels = first | self.channels  # in the order in which they were declared
            else:
                self.attachments[found.name] = found.data


def _collector(
    raw: bytes,
    chunk: int,
    lists: dict[int, list[tuple[int, bytes | _Place]]],
    strangers: dict[int, int] | None,
) -> Callable[[int, int, int, int], None]:
    """Keeps the messages of a chunk, or their places, by channel; counts those of unknown channels."""

    def collect(channel: int, t_ns: int, start: int, end: int) -> None:
        kept = lists.get(channel)
        if kept is not None:
            kept.append((t_ns, raw[start:end] if end - start < KEEP_BYTES else _Place(chunk, start, end)))
        elif strangers is not None:
            strangers[channel] = strangers.get(channel, 0) + 1

    return collect

"""Read a recording back, whole or cut off, as messages or as tables of numbers."""

from __future__ import annotations

import os
from collections.abc import Callable, Collection, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, NamedTuple

import numpy as np
from mcap.opcode import Opcode
from numpy.typing import NDArray

from pelagos.errors import LookupFailed, RecordingError
from pelagos.messages.store import Message, deserialize
from pelagos.messages.template import Template
from pelagos.sim.mcap_reader import RawRecord, message_parts, parse, read_chunk, read_records, scan_chunk
from pelagos.sim.mcap_writer import McapWriter

KEEP_BYTES: Final = 16384  # messages up to this size stay in memory
_NUMPY: Final = {"d": "<f8", "f": "<f4", "i": "<i4", "I": "<u4", "H": "<u2", "B": "u1", "b": "i1"}


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
        channels: by topic.

    Raises:
        RecordingError: the file cannot be read, or is no MCAP file.
    """

    def __init__(self, path: str | Path, *, topics: Collection[str] | None = None) -> None:
        self.path = Path(path)
        self.complete = False
        self.metadata: dict[str, str] = {}
        self.attachments: dict[str, bytes] = {}
        self.channels: dict[str, Channel] = {}
        self._messages: dict[str, list[tuple[int, bytes | _Place]]] = {}
        self._chunk: tuple[int, memoryview] = (-1, memoryview(b""))
        self._load(set(topics) if topics is not None else None)

    def topics(self, suffix: str = "", *, type: str | None = None) -> list[str]:
        """Topics that end in `suffix` and have messages of `type`, in the order of recording."""
        return [
            name for name, c in self.channels.items()
            if name.endswith(suffix) and (type is None or c.type == type) and self._messages.get(name)
        ]  # fmt: skip

    def count(self, topic: str) -> int:
        """How many messages a topic has."""
        return len(self._messages.get(topic, ()))

    def messages(self, *topics: str) -> Iterator[Recorded]:
        """Messages of the topics (all if none is named), by topic and then in the order of recording."""
        for topic in topics or tuple(self.channels):
            self._channel(topic)
            for index in range(self.count(topic)):
                yield self.message(topic, index)

    def message(self, topic: str, index: int) -> Recorded:
        """One message of a topic, by its place in the order of recording."""
        t_ns, raw = self._messages[topic][index]
        if isinstance(raw, _Place):
            if self._chunk[0] != raw.chunk:
                with self.path.open("rb") as file:
                    self._chunk = raw.chunk, read_chunk(file, raw.chunk)
            return Recorded(topic, t_ns, self._channel(topic).type, bytes(self._chunk[1][raw.start : raw.end]))
        return Recorded(topic, t_ns, self._channel(topic).type, raw)

    def times(self, topic: str) -> NDArray[np.int64]:
        """`(k,)` simulation time of each message [ns]."""
        return np.array([t_ns for t_ns, _ in self._messages.get(topic, ())], dtype=np.int64)

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
        places = Template(kind, deserialize(kind, rows[0]), fields).places
        raw = np.frombuffer(b"".join(rows), dtype=np.uint8).reshape(len(rows), size)
        values = np.stack([_column(raw, at, _NUMPY[code]) for at, code in places], axis=-1)
        return self.times(topic).astype(np.float64) * 1e-9, values

    def _channel(self, topic: str) -> Channel:
        if topic not in self.channels:
            raise LookupFailed("topic", topic, self.channels, where=str(self.path))
        return self.channels[topic]

    def _load(self, wanted: set[str] | None) -> None:
        lists: dict[int, list[tuple[int, bytes | _Place]]] = {}
        schemas: dict[int, str] = {}

        def declare(record: RawRecord) -> None:
            self._declare(record, wanted, schemas, lists)

        try:
            with self.path.open("rb") as file:
                for record in read_records(file, size=os.fstat(file.fileno()).st_size, whole_chunks=True):
                    if record.opcode == Opcode.CHUNK:
                        raw = bytes(record.payload)
                        scan_chunk(raw, _collector(raw, record.chunk, lists), declare)
                    else:
                        declare(record)
        except OSError as error:
            raise RecordingError(f"{self.path}: cannot be read: {error.strerror}") from None

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
            self.channels.setdefault(found.topic, Channel(found.topic, schemas[found.schema_id], found.metadata))
            if wanted is None or found.topic in wanted:
                lists.setdefault(found.id, self._messages.setdefault(found.topic, []))
        elif record.opcode == Opcode.METADATA:
            self.metadata.update(parse(record).metadata)
        elif record.opcode == Opcode.ATTACHMENT:
            found = parse(record)
            self.attachments[found.name] = found.data
        elif record.opcode == Opcode.FOOTER:
            self.complete = True


def _collector(
    raw: bytes, chunk: int, lists: dict[int, list[tuple[int, bytes | _Place]]]
) -> Callable[[int, int, int, int], None]:
    """Keeps the messages of a chunk, or their places, by channel."""

    def collect(channel: int, t_ns: int, start: int, end: int) -> None:
        kept = lists.get(channel)
        if kept is not None:
            kept.append((t_ns, raw[start:end] if end - start < KEEP_BYTES else _Place(chunk, start, end)))

    return collect


def recover(path: str | Path) -> Path:
    """Give a recording that was cut off its index, with every complete message in it; a whole one stays as it is.

    The file is replaced only by a finished one.

    Raises:
        RecordingError: the file is no MCAP file, or there is no room for the new one.
    """
    path = Path(path)
    fresh = path.with_name(f".{path.name}.recovered")
    try:
        with path.open("rb") as file:
            size = os.fstat(file.fileno()).st_size
            if _is_complete(path):
                return path
            writer = McapWriter(fresh, library="pelagos recover")
            try:
                _copy(read_records(file, size=size), writer)
                writer.close()
            except BaseException:
                fresh.unlink(missing_ok=True)
                raise
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from None
    os.replace(fresh, path)
    return path


def _is_complete(path: Path) -> bool:
    with path.open("rb") as file:
        size = os.fstat(file.fileno()).st_size
        return any(record.opcode == Opcode.FOOTER for record in read_records(file, size=size))


def _copy(records: Iterator[Any], writer: McapWriter) -> None:
    schemas: dict[int, int] = {}
    channels: dict[int, int] = {}
    last = 0
    for record in records:
        if record.opcode == Opcode.MESSAGE:
            number, t_ns, raw = message_parts(record)
            writer.add_message(channels[number], t_ns, raw)
            if t_ns - last > 1_000_000_000:
                writer.flush()
                last = t_ns
        elif record.opcode == Opcode.SCHEMA:
            found = parse(record)
            if found.id not in schemas:
                schemas[found.id] = writer.add_schema(found.name, found.encoding, found.data)
        elif record.opcode == Opcode.CHANNEL:
            found = parse(record)
            if found.id not in channels:
                channels[found.id] = writer.add_channel(
                    found.topic, schemas[found.schema_id], found.message_encoding, found.metadata
                )
        elif record.opcode == Opcode.METADATA:
            found = parse(record)
            writer.add_metadata(found.name, found.metadata)
        elif record.opcode == Opcode.ATTACHMENT:
            found = parse(record)
            writer.add_attachment(found.name, found.media_type, found.data)


def _column(raw: NDArray[np.uint8], offset: int, kind: str) -> NDArray[np.float64]:
    width = np.dtype(kind).itemsize
    return np.ascontiguousarray(raw[:, offset : offset + width]).view(kind)[:, 0].astype(np.float64)

"""A new, whole recording of everything that can be read in one that was cut off or damaged."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, BinaryIO, Final

from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer

from pelagos.errors import CommandError, NoPlace, RecordingError
from pelagos.messages.store import schema
from pelagos.sim.mcap_reader import MESSAGE, Damage, RawRecord, Walk, parse, scan_chunk, summary
from pelagos.sim.mcap_writer import CHANNELS, listed_channels

CHUNK_BYTES: Final = 4 << 20


@dataclass
class Recovered:
    """Result of a recovery.

    Attributes:
        path: the whole recording; the given file itself, where nothing was wrong with it.
        original: the file as it was, under its name or, after a recovery in place, as a backup.
        messages: how many messages `path` holds.
        topics: of how many topics.
        end_ns: simulation time of the last message [ns].
        damage: places of the original that could not be read.
        whole: nothing was wrong, and nothing was written.
    """

    path: Path
    original: Path
    messages: int = 0
    topics: int = 0
    end_ns: int = 0
    damage: list[Damage] = field(default_factory=list)
    whole: bool = False


def recover(path: str | Path, out: str | Path | None = None, *, in_place: bool = False) -> Recovered:
    """Write everything that can be read in a recording into a new one with an index; the original stays as it is.

    Args:
        path: a recording that was cut off or damaged. One with which nothing is wrong is not copied.
        out: the new file, which must not exist; "mission.recovered.mcap" beside "mission.mcap" where not given.
        in_place: give the new file the name of the old one, which is kept as "mission.mcap.backup".

    Raises:
        NoPlace: something stands where the new file or the backup is to be, or there is no such folder.
        RecordingError: the file is no MCAP file, or there is no room.
    """
    path = Path(path)
    if in_place and out is not None:
        raise CommandError("give either a file to write, or in_place, not both")
    target = Path(out) if out is not None else path.with_name(f"{path.stem}.recovered{path.suffix}")
    backup = path.with_name(f"{path.name}.backup")
    fresh = target.with_name(f".{target.name}.new")
    try:
        with path.open("rb") as file:
            found = Recovered(path, path)
            size = os.fstat(file.fileno()).st_size
            walk = Walk(file, size, found.damage)
            for _ in walk.records():
                pass
            if walk.complete and not found.damage:
                return _counted(found, file)
            _require_free(backup if in_place else target)
            try:
                with fresh.open("wb") as new:
                    _copy(Walk(file, size), new, found)
                    new.flush()
                    os.fsync(new.fileno())
            except BaseException:
                fresh.unlink(missing_ok=True)
                raise
        if in_place:
            os.rename(path, backup)
            found.original, target = backup, path
        os.rename(fresh, target)
    except OSError as error:
        raise RecordingError(f"{error.filename or path}: {error.strerror}") from None
    found.path = target
    return found


def _require_free(path: Path) -> None:
    if path.exists():
        raise NoPlace(f"{path} exists already; move it away, or name another file")
    if not path.parent.is_dir():
        raise NoPlace(f"{path} cannot be written: there is no folder {path.parent}")


def _counted(found: Recovered, file: BinaryIO) -> Recovered:
    """The figures of a whole file."""
    index = summary(file)
    found.whole = True
    if index is not None and index.statistics is not None:
        found.messages, found.topics = index.statistics.message_count, index.statistics.channel_count
        found.end_ns = index.statistics.message_end_time
    return found


def _copy(walk: Walk, new: BinaryIO, found: Recovered) -> None:
    writer = Writer(new, chunk_size=CHUNK_BYTES, compression=CompressionType.LZ4, enable_data_crcs=True)
    writer.start(profile="ros2", library="pelagos recover")
    copy = _Copy(writer, found)
    index = summary(walk.file)
    if index is not None:  # of a whole file with a damaged chunk, which may have been the one that declares channels
        for schema in index.schemas.values():
            copy.add_schema(schema)
        for channel in index.channels.values():
            copy.add_channel(channel)
    for record in walk.records():
        if record.opcode == Opcode.CHUNK:
            raw = bytes(record.payload)
            try:
                scan_chunk(raw, copy.message_of(raw), copy.record)
            except RecordingError as error:
                found.damage.append(Damage(record.chunk, record.chunk, str(error)))
        else:
            copy.record(record)
    writer.finish()
    found.topics = len(copy.channels)


class _Copy:
    """Records of one file on their way into another, where schemas and channels have other numbers."""

    def __init__(self, writer: Writer, found: Recovered) -> None:
        self._writer = writer
        self._found = found
        self._schemas: dict[int, int] = {0: 0}
        self.channels: dict[int, int] = {}
        self._strangers: set[int] = set()  # channels without a declaration that were told of

    def add_schema(self, found: Any) -> None:
        """Declare a schema, once."""
        if found.id not in self._schemas:
            self._schemas[found.id] = self._writer.register_schema(found.name, found.encoding, found.data)

    def add_channel(self, found: Any) -> None:
        """Declare a channel, once."""
        if found.id not in self.channels and found.schema_id in self._schemas:
            self.channels[found.id] = self._writer.register_channel(
                found.topic, found.message_encoding, self._schemas[found.schema_id], found.metadata
            )

    def message_of(self, raw: bytes) -> Callable[[int, int, int, int], None]:
        """Copier of the messages of a chunk."""
        add, channels, found, strangers = self._writer.add_message, self.channels, self._found, self._strangers

        def message(channel: int, t_ns: int, start: int, end: int) -> None:
            _, _, _, sequence, _, publish = MESSAGE.unpack_from(raw, start - MESSAGE.size)
            if channel in channels:
                add(channels[channel], t_ns, raw[start:end], publish, sequence)
                found.messages += 1
                found.end_ns = max(found.end_ns, t_ns)
            elif channel not in strangers:
                strangers.add(channel)
                found.damage.append(Damage(0, 0, f"channel {channel}, whose declaration is lost"))

        return message

    def record(self, record: RawRecord) -> None:
        """Copy a record that is no message in a chunk."""
        if record.opcode == Opcode.SCHEMA:
            self.add_schema(parse(record))
        elif record.opcode == Opcode.CHANNEL:
            self.add_channel(parse(record))
        elif record.opcode == Opcode.METADATA:
            found = parse(record)
            self._writer.add_metadata(found.name, found.metadata)
        elif record.opcode == Opcode.ATTACHMENT:
            found = parse(record)
            if found.name == CHANNELS:
                self._listed(found.data)
            self._writer.add_attachment(found.create_time, found.log_time, found.name, found.media_type, found.data)
        elif record.opcode == Opcode.MESSAGE:  # outside of chunks, as others write them
            raw = MESSAGE.pack(0, 0, 0, 0, 0, 0)[:9] + bytes(record.payload)
            (channel, t_ns) = MESSAGE.unpack_from(raw)[2], MESSAGE.unpack_from(raw)[4]
            self.message_of(raw)(channel, t_ns, MESSAGE.size, len(raw))

    def _listed(self, data: bytes) -> None:
        """Declare what the chunk would have declared that cannot be read."""
        for row in listed_channels(data):
            if row["number"] is not None and row["number"] not in self.channels:
                number = self._writer.register_schema(row["type"], "ros2msg", schema(row["type"]))
                self.channels[row["number"]] = self._writer.register_channel(row["topic"], "cdr", number, row["about"])

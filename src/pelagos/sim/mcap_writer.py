"""The MCAP container, written so that whatever ends the process loses at most the chunk in progress.

Every chunk goes to the operating system in one piece when it ends; nothing is ever rewritten. A file that was cut off
has no index, and everything up to its last complete record can be read in order.
Format: https://mcap.dev/spec (version 0). Records other than messages are made by the `mcap` package.
"""

from __future__ import annotations

import os
import struct
import zlib
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import lz4.frame
import numpy as np
from mcap import records as mcap
from mcap.data_stream import RecordBuilder
from mcap.opcode import Opcode
from numpy.typing import NDArray

from pelagos.errors import RecordingError

MAGIC: Final = b"\x89MCAP0\r\n"
MESSAGE: Final = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
MESSAGE_HEAD: Final = 22  # bytes of a message record before its data
_MESSAGE_FIELDS: Final = [
    ("opcode", "u1"), ("length", "<u8"), ("channel", "<u2"), ("sequence", "<u4"), ("log_time", "<u8"),
    ("publish_time", "<u8"),
]  # fmt: skip
RECORD: Final = struct.Struct("<BQ")
CHUNK_BYTES: Final = 4 << 20


@cache
def _message(size: int) -> np.dtype[Any]:
    """A message record with `size` bytes of data."""
    return np.dtype([*_MESSAGE_FIELDS, ("data", "u1", (size,))])


@dataclass
class _Summary:
    """What the end of the file lists."""

    schemas: list[mcap.Schema]
    channels: list[mcap.Channel]
    chunks: list[mcap.ChunkIndex]
    attachments: list[mcap.AttachmentIndex]
    metadata: list[mcap.MetadataIndex]
    counts: dict[int, int]


class McapWriter:
    """Writes one file. A file that already stands at `path` stays until the first chunk is written.

    Raises:
        RecordingError: the file cannot be written. What was flushed before stays readable.
    """

    def __init__(self, path: Path, *, library: str) -> None:
        self.path = path
        self._new = path.with_name(f".{path.name}.new") if path.exists() else path
        try:
            self._fd = os.open(self._new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC, 0o666)
        except OSError as error:
            raise RecordingError(f"{path}: cannot be written: {error.strerror}") from None
        self._published = self._new == path
        self._offset = 0
        self._open = True
        self._summary = _Summary([], [], [], [], [], {})
        self._buffer = bytearray()
        self._index: dict[int, list[int]] = {}
        self._first = self._last = 0
        self._start, self._end = (1 << 64) - 1, 0
        self._write(MAGIC + _bytes(mcap.Header(profile="ros2", library=library)))

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Declare a message type; the id is for `add_channel`."""
        schema = mcap.Schema(id=len(self._summary.schemas) + 1, name=name, encoding=encoding, data=data)
        self._summary.schemas.append(schema)
        self._buffer += _bytes(schema)
        return int(schema.id)

    def add_channel(self, topic: str, schema_id: int, encoding: str, metadata: Mapping[str, str]) -> int:
        """Declare a topic; the id is for `add_message`."""
        number = len(self._summary.channels) + 1
        channel = mcap.Channel(
            id=number, topic=topic, message_encoding=encoding, metadata=dict(metadata), schema_id=schema_id
        )
        self._summary.channels.append(channel)
        self._summary.counts[number] = 0
        self._buffer += _bytes(channel)
        return number

    def add_message(self, channel: int, t_ns: int, data: bytes | bytearray | memoryview) -> None:
        """Append one message with simulation time `t_ns` [ns] to the chunk in progress."""
        buffer, index = self._buffer, self._index
        if index:
            self._first = min(t_ns, self._first)
            self._last = max(t_ns, self._last)
        else:
            self._first = self._last = t_ns
        entries = index.get(channel)
        if entries is None:
            entries = index[channel] = []
        entries.append(t_ns)
        entries.append(len(buffer))
        sequence = self._summary.counts[channel] = self._summary.counts[channel] + 1
        buffer += MESSAGE.pack(Opcode.MESSAGE, MESSAGE_HEAD + len(data), channel, sequence, t_ns, t_ns)
        buffer += data
        if len(buffer) > CHUNK_BYTES:
            self.flush()

    def add_messages(self, channel: int, t_ns: NDArray[np.int64], rows: NDArray[np.uint8]) -> None:
        """Append k messages of one size to the chunk in progress: times `(k,)`, not falling, and bytes `(k, size)`."""
        count, size = rows.shape
        if count == 0:
            return
        first, last = int(t_ns[0]), int(t_ns[-1])
        self._first, self._last = (min(first, self._first), max(last, self._last)) if self._index else (first, last)
        records = np.empty(count, dtype=_message(size))
        start = self._summary.counts[channel] + 1
        records["opcode"], records["length"], records["channel"] = Opcode.MESSAGE, MESSAGE_HEAD + size, channel
        records["sequence"] = np.arange(start, start + count)
        records["log_time"] = records["publish_time"] = t_ns
        records["data"] = rows
        entries = np.empty((count, 2), dtype=np.int64)
        entries[:, 0], entries[:, 1] = t_ns, len(self._buffer) + records.itemsize * np.arange(count)
        self._index.setdefault(channel, []).extend(entries.ravel().tolist())
        self._summary.counts[channel] += count
        self._buffer += records.tobytes()
        if len(self._buffer) > CHUNK_BYTES:
            self.flush()

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of key-value pairs."""
        self.flush()
        record = _bytes(mcap.Metadata(name=name, metadata=dict(values)))
        self._summary.metadata.append(mcap.MetadataIndex(offset=self._offset, length=len(record), name=name))
        self._write(record)

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write a file within the file."""
        self.flush()
        record = _bytes(mcap.Attachment(create_time=0, log_time=0, name=name, media_type=media_type, data=data))
        self._summary.attachments.append(
            mcap.AttachmentIndex(
                offset=self._offset, length=len(record), log_time=0, create_time=0, data_size=len(data), name=name,
                media_type=media_type,
            )
        )  # fmt: skip
        self._write(record)

    def flush(self) -> None:
        """End the chunk in progress: the operating system has everything added until now."""
        if not self._index:
            return
        raw = bytes(self._buffer)
        packed = lz4.frame.compress(raw)
        chunk = _bytes(
            mcap.Chunk(
                compression="lz4", data=packed, message_start_time=self._first, message_end_time=self._last,
                uncompressed_crc=zlib.crc32(raw), uncompressed_size=len(raw),
            )
        )  # fmt: skip
        indices, places, at = [], {}, self._offset + len(chunk)
        for channel, entries in self._index.items():
            head = RECORD.pack(Opcode.MESSAGE_INDEX, 6 + 8 * len(entries)) + struct.pack(
                "<HI", channel, 8 * len(entries)
            )
            record = head + struct.pack(f"<{len(entries)}Q", *entries)
            places[channel] = at
            at += len(record)
            indices.append(record)
        index_bytes = b"".join(indices)
        start = self._offset
        self._write(chunk + index_bytes)
        self._start, self._end = min(self._start, self._first), max(self._end, self._last)
        self._summary.chunks.append(
            mcap.ChunkIndex(
                message_start_time=self._first, message_end_time=self._last, chunk_start_offset=start,
                chunk_length=len(chunk), message_index_offsets=places, message_index_length=len(index_bytes),
                compression="lz4", compressed_size=len(packed), uncompressed_size=len(raw),
            )
        )  # fmt: skip
        self._buffer = bytearray()
        self._index = {}
        self._publish()

    def close(self) -> None:
        """Flush, and write the index that lets readers seek."""
        if not self._open:
            return
        self.flush()
        try:
            self._write(_summary_bytes(self._summary, self._offset, self._start if self._end else 0, self._end))
        finally:
            self._abandon()
        self._publish()

    def _publish(self) -> None:
        if not self._published:
            os.replace(self._new, self.path)
            self._published = True

    def _abandon(self) -> None:
        if self._open:
            self._open = False
            os.close(self._fd)

    def _write(self, data: bytes) -> None:
        """All of `data`, or an error and a file that ends where it ended before."""
        if not self._open:
            raise RecordingError(f"{self.path}: the recording was closed")
        view = memoryview(data)
        try:
            while view:
                view = view[os.write(self._fd, view) :]
        except OSError as error:
            os.ftruncate(self._fd, self._offset)
            self._abandon()
            if self._summary.chunks:
                kept = f"; it is readable up to simulation time {self._end / 1e9:.3f} s"
            else:
                self._new.unlink(missing_ok=True)
                kept = "; nothing was recorded"
            raise RecordingError(f"{self.path}: cannot write the recording: {error.strerror}{kept}") from None
        self._offset += len(data)


def _bytes(record: Any) -> bytes:
    builder = RecordBuilder()
    record.write(builder)
    return bytes(builder.end())


def _summary_bytes(summary: _Summary, offset: int, start: int, end: int) -> bytes:
    """Data end, summary section, footer and closing magic."""
    data_end = _bytes(mcap.DataEnd(0))
    begin = offset + len(data_end)
    statistics = mcap.Statistics(
        attachment_count=len(summary.attachments), channel_count=len(summary.channels),
        channel_message_counts=summary.counts, chunk_count=len(summary.chunks),
        message_count=sum(summary.counts.values()), metadata_count=len(summary.metadata),
        message_start_time=start, message_end_time=end, schema_count=len(summary.schemas),
    )  # fmt: skip
    groups: list[tuple[Opcode, list[Any]]] = [
        (Opcode.SCHEMA, list(summary.schemas)),
        (Opcode.CHANNEL, list(summary.channels)),
        (Opcode.STATISTICS, [statistics]),
        (Opcode.CHUNK_INDEX, list(summary.chunks)),
        (Opcode.ATTACHMENT_INDEX, list(summary.attachments)),
        (Opcode.METADATA_INDEX, list(summary.metadata)),
    ]
    body = b""
    offsets = b""
    for opcode, group in groups:
        if group:
            piece = b"".join(_bytes(record) for record in group)
            offsets += _bytes(
                mcap.SummaryOffset(group_opcode=opcode, group_start=begin + len(body), group_length=len(piece))
            )
            body += piece
    footer = RECORD.pack(Opcode.FOOTER, 20) + struct.pack("<QQ", begin, begin + len(body))
    crc = zlib.crc32(body + offsets + footer)
    return data_end + body + offsets + footer + struct.pack("<I", crc) + MAGIC

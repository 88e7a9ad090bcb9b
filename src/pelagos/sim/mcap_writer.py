"""The MCAP container, written so that whatever ends the process loses at most the chunk in progress.

Chunks, indexes and checksums are made by the `foxglove` package (mcap-rust; 0.8 us a message). It goes back to the head
of a chunk when it ends one, and hides what the file system answers, so it writes into memory (`_Tail`): every chunk
goes to the operating system from here, in one piece, when whole, and nothing in the file is ever rewritten. A file
that was cut off has no index, and everything up to its last complete record can be read in order.
Format: https://mcap.dev/spec (version 0).
"""

from __future__ import annotations

import io
import json
import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Final

import foxglove
import numpy as np
from foxglove.mcap import MCAPCompression, MCAPWriteOptions
from numpy.typing import NDArray

from pelagos.errors import RecordingError
from pelagos.files import give_name, refuse_other_than_file

CHUNK_BYTES: Final = 4 << 20
CHANNELS: Final = "channels.json"
"""Attachment behind chunks in which channels begin: what the numbers mean, should that chunk be damaged."""
LISTINGS: Final = 8  # such attachments at most, beside the one at the end


class McapWriter:
    """Writes one file. A file that already stands at `path` stays until the first chunk is written.

    Raises:
        RecordingError: the file cannot be written, or is not what was written any more: another process cut or removed
            it. What was flushed before stays readable.
    """

    def __init__(self, path: Path, *, library: str) -> None:
        self.path = path
        self._new = path.with_name(f".{path.name}.new") if path.exists() else path
        try:
            refuse_other_than_file(path)
            self._fd = os.open(self._new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | getattr(os, "O_BINARY", 0), 0o666)
        except OSError as error:
            raise RecordingError(f"{path}: cannot be written: {error.strerror}") from None
        self._published = self._new == path
        self._open = True
        self._tail = _Tail()
        self._context = foxglove.Context()
        options = MCAPWriteOptions(
            compression=MCAPCompression.Lz4, profile="ros2", chunk_size=None, calculate_data_section_crc=True
        )
        self._mcap: Any = foxglove.open_mcap(self._tail, context=self._context, writer_options=options)
        self._mcap.write_metadata("writer", {"library": library})
        self._schemas: list[foxglove.Schema] = []
        self._channels: list[foxglove.Channel] = []
        self._about: list[dict[str, Any]] = []
        self._numbers: dict[int, int] = {}  # in the file, channels are numbered in the order of their first messages
        self._listed = self._listings = 0
        self._waiting = 0  # bytes in the chunk in progress
        self._end_ns = 0
        self._pending_ns = 0
        self._chunks = 0
        self._write()

    def add_schema(self, name: str, encoding: str, data: bytes) -> int:
        """Declare a message type; the id is for `add_channel`."""
        self._schemas.append(foxglove.Schema(name=name, encoding=encoding, data=data))
        return len(self._schemas)

    def add_channel(self, topic: str, schema_id: int, encoding: str, metadata: Mapping[str, str]) -> int:
        """Declare a topic; the id is for `add_message`."""
        schema = self._schemas[schema_id - 1]
        self._channels.append(
            foxglove.Channel(
                topic, message_encoding=encoding, schema=schema, metadata=dict(metadata), context=self._context
            )
        )
        self._about.append({"topic": topic, "type": schema.name, "about": dict(metadata)})
        return len(self._channels)

    def add_message(self, channel: int, t_ns: int, data: bytes | bytearray | memoryview) -> None:
        """Append one message with simulation time `t_ns` [ns] to the chunk in progress."""
        self._expect(channel, len(data), t_ns)
        self._channels[channel - 1].log(data if isinstance(data, bytes) else bytes(data), log_time=t_ns)
        if self._waiting > CHUNK_BYTES:
            self.flush()

    def add_messages(self, channel: int, t_ns: NDArray[np.int64], rows: NDArray[np.uint8]) -> None:
        """Append k messages of one size to the chunk in progress: times `(k,)`, not falling, and bytes `(k, size)`."""
        count, size = rows.shape
        if count == 0:
            return
        self._expect(channel, count * size, int(t_ns[-1]))
        log, data, at = self._channels[channel - 1].base.log, rows.tobytes(), 0  # bytes: nothing to encode
        for t in t_ns.tolist():
            log(data[at : at + size], t)
            at += size
        if self._waiting > CHUNK_BYTES:
            self.flush()

    def add_metadata(self, name: str, values: Mapping[str, str]) -> None:
        """Write a record of key-value pairs."""
        self.flush()
        self._mcap.write_metadata(name, dict(values))
        self._write()

    def add_attachment(self, name: str, media_type: str, data: bytes) -> None:
        """Write a file within the file."""
        self.flush()
        self._attach(name, media_type, data)
        self._write()

    def flush(self) -> None:
        """End the chunk in progress: the operating system has everything added until now."""
        if not self._waiting:
            return
        self._refuse_closed()
        self._check_place()
        self._mcap.flush()
        self._waiting = 0
        if self._listed < len(self._numbers) and self._listings < LISTINGS:
            self._list_channels()
        self._write()
        self._chunks += 1
        self._end_ns = max(self._end_ns, self._pending_ns)
        self._publish()

    def sync(self) -> None:
        """Flush, and wait until the disk has it all."""
        self.flush()
        self._refuse_closed()
        os.fsync(self._fd)

    def rename(self, path: Path) -> None:
        """Give the file another name, in place of the file that has it."""
        self._refuse_closed()
        try:
            give_name(self.path, path)
        except OSError as error:
            raise RecordingError(f"{path}: cannot be replaced: {error.strerror}") from None
        self.path = self._new = path

    def close(self) -> None:
        """Flush, and write the index that lets readers seek."""
        if not self._open:
            return
        self.flush()
        if self._listed < len(self._numbers) or not self._chunks:
            self._list_channels()
        try:
            self._mcap.close()
            self._write()
        finally:
            self._abandon()
        self._publish()

    def _list_channels(self) -> None:
        """Say what the channels are, those without messages too."""
        self._listed = len(self._numbers)
        self._listings += 1
        rows = [{"number": self._numbers.get(i), **about} for i, about in enumerate(self._about, 1)]
        self._attach(CHANNELS, "application/json", json.dumps(rows).encode())

    def _attach(self, name: str, media_type: str, data: bytes) -> None:
        self._mcap.attach(log_time=0, create_time=0, name=name, media_type=media_type, data=data)

    def _expect(self, channel: int, size: int, t_ns: int) -> None:
        """Take note of messages that come."""
        self._refuse_closed()
        if channel not in self._numbers:
            self._numbers[channel] = len(self._numbers) + 1
        self._waiting += size + 1
        self._pending_ns = max(self._pending_ns, t_ns)

    def _refuse_closed(self) -> None:
        if not self._open:
            raise RecordingError(f"{self.path}: the recording was closed")

    def _check_place(self) -> None:
        """See that the file is still there, and as long as it was left."""
        try:
            stands, named = os.fstat(self._fd), os.stat(self._new if not self._published else self.path)
            gone = (named.st_ino, named.st_dev) != (stands.st_ino, stands.st_dev)
        except OSError:
            gone = True
        if gone:
            self._abandon()
            raise RecordingError(f"{self.path}: the recording, or its folder, was removed or replaced during the run")
        if stands.st_size != self._tail.base:
            self._abandon()
            raise RecordingError(
                f"{self.path}: another process changed the recording: it has {stands.st_size} bytes, "
                f"{self._tail.base} were written"
            )

    def _publish(self) -> None:
        if not self._published:
            give_name(self._new, self.path)
            self._published = True

    def _abandon(self) -> None:
        if self._open:
            self._open = False
            os.close(self._fd)
            self._mcap.close()  # into memory, where it stays; left open, it would try when it is collected

    def _write(self) -> None:
        """All that is in memory, or an error and a file that ends where it ended before."""
        self._refuse_closed()
        view = memoryview(self._tail.taken())
        length = self._tail.base - len(view)
        try:
            while view:
                view = view[os.write(self._fd, view) :]
        except OSError as error:
            os.ftruncate(self._fd, length)
            self._abandon()
            if self._chunks:
                kept = f"; it is readable up to simulation time {self._end_ns / 1e9:.3f} s"
            else:
                self._new.unlink(missing_ok=True)
                kept = "; nothing was recorded"
            raise RecordingError(f"{self.path}: cannot write the recording: {error.strerror}{kept}") from None


def listed_channels(data: bytes) -> list[dict[str, Any]]:
    """Channels of the attachment `CHANNELS`: number, topic, type, about; nothing where it is somebody else's."""
    try:
        rows = json.loads(data)
        return [row for row in rows if isinstance(row, dict) and {"number", "topic", "type", "about"} <= row.keys()]
    except (ValueError, TypeError):
        return []


class _Tail(io.RawIOBase):
    """The end of a file that grows: what was not handed to the operating system yet.

    Attributes:
        base: where in the file the tail begins.
    """

    def __init__(self) -> None:
        self.base = 0
        self._bytes = io.BytesIO()

    def write(self, data: Any) -> int:
        """Put bytes at the current place."""
        return self._bytes.write(data)

    def seek(self, offset: int, whence: int = io.SEEK_SET) -> int:
        """Move to a place in the tail; positions are those of the file."""
        if whence == io.SEEK_SET:
            return self.base + self._bytes.seek(offset - self.base)
        return self.base + self._bytes.seek(offset, whence)

    def tell(self) -> int:
        """The current place in the file."""
        return self.base + self._bytes.tell()

    def taken(self) -> bytes:
        """The tail, which is empty then."""
        data = self._bytes.getvalue()
        self.base += len(data)
        self._bytes = io.BytesIO()
        return data

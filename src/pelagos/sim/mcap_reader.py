"""Reading the MCAP container, whole or cut off: everything up to the last complete record.

Format: https://mcap.dev/spec (version 0).
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable, Iterator
from io import BytesIO
from typing import Any, BinaryIO, NamedTuple

import lz4.frame
from mcap import records as mcap
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode

from pelagos.errors import RecordingError
from pelagos.sim.mcap_writer import MAGIC, MESSAGE, MESSAGE_HEAD, RECORD


class RawRecord(NamedTuple):
    """One record as it stands in a file or chunk.

    Attributes:
        opcode: its kind.
        payload: its bytes.
        chunk: where in the file its chunk begins; -1 outside chunks.
        start: where in the unpacked chunk its payload begins.
    """

    opcode: int
    payload: memoryview
    chunk: int = -1
    start: int = 0


def read_records(file: BinaryIO, *, size: int, whole_chunks: bool = False) -> Iterator[RawRecord]:
    """All complete records outside and inside chunks, in order; ends quietly where the file was cut off.

    Args:
        file: open for reading, at its start.
        size: of the file.
        whole_chunks: give every chunk as one record, unpacked, instead of what is in it.

    Raises:
        RecordingError: the file is no MCAP file.
    """
    if file.read(len(MAGIC)) != MAGIC:
        raise RecordingError(f"{file.name}: is not an MCAP recording")
    at = len(MAGIC)
    while at + RECORD.size <= size:
        begin = at
        opcode, length = RECORD.unpack(file.read(RECORD.size))
        at += RECORD.size + length
        if at > size:
            return
        payload = memoryview(file.read(length))
        if opcode == Opcode.CHUNK:
            raw = _chunk_data(payload, file.name)
            if raw is None:
                return
            if whole_chunks:
                yield RawRecord(opcode, raw, begin)
            else:
                yield from _inner_records(raw, begin)
        else:
            yield RawRecord(opcode, payload)
            if opcode == Opcode.FOOTER:
                return


def parse(record: RawRecord) -> Any:
    """Schema, channel, metadata, attachment, statistics or message index of a record."""
    kinds = {
        Opcode.HEADER: mcap.Header, Opcode.SCHEMA: mcap.Schema, Opcode.CHANNEL: mcap.Channel,
        Opcode.METADATA: mcap.Metadata, Opcode.ATTACHMENT: mcap.Attachment,
    }  # fmt: skip
    return kinds[Opcode(record.opcode)].read(ReadDataStream(BytesIO(record.payload)))


def message_parts(record: RawRecord) -> tuple[int, int, memoryview]:
    """Channel id, log time [ns] and data of a message record."""
    channel, _, log_time, _ = struct.unpack_from("<HIQQ", record.payload)
    return channel, log_time, record.payload[MESSAGE_HEAD:]


def _chunk_data(payload: memoryview, name: str) -> memoryview | None:
    """The records of a chunk; None where its bytes are damaged."""
    chunk = mcap.Chunk.read(ReadDataStream(BytesIO(payload)))
    if chunk.compression not in ("", "lz4"):
        raise RecordingError(f"{name}: its chunks are compressed with {chunk.compression!r}; lz4 or none can be read")
    try:
        raw = lz4.frame.decompress(chunk.data) if chunk.compression else chunk.data
    except RuntimeError:
        return None
    if chunk.uncompressed_crc and zlib.crc32(raw) != chunk.uncompressed_crc:
        return None
    return memoryview(raw)


def read_chunk(file: BinaryIO, begin: int) -> memoryview:
    """The unpacked records of the chunk that begins at byte `begin`, known to be whole."""
    file.seek(begin)
    _, length = RECORD.unpack(file.read(RECORD.size))
    raw = _chunk_data(memoryview(file.read(length)), file.name)
    assert raw is not None, "a chunk that was read before"
    return raw


def scan_chunk(
    raw: bytes, on_message: Callable[[int, int, int, int], None], on_record: Callable[[RawRecord], None]
) -> None:
    """Walk through an unpacked chunk quickly.

    Args:
        raw: the chunk's records.
        on_message: called with channel, log time [ns], and where in `raw` the message's data begins and ends.
        on_record: called with every other record.
    """
    at, size, unpack = 0, len(raw), MESSAGE.unpack_from
    while at + RECORD.size <= size:
        opcode = raw[at]
        if opcode == Opcode.MESSAGE:
            _, length, channel, _, t_ns, _ = unpack(raw, at)
            end = at + RECORD.size + length
            on_message(channel, t_ns, at + MESSAGE.size, end)
        else:
            _, length = RECORD.unpack_from(raw, at)
            end = at + RECORD.size + length
            on_record(RawRecord(opcode, memoryview(raw)[at + RECORD.size : end]))
        at = end


def _inner_records(raw: memoryview, chunk: int) -> Iterator[RawRecord]:
    at = 0
    while at + RECORD.size <= len(raw):
        opcode, length = RECORD.unpack_from(raw, at)
        at += RECORD.size
        yield RawRecord(opcode, raw[at : at + length], chunk, at)
        at += length

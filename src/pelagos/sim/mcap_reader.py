"""Reading the MCAP container, whole, cut off or damaged: every chunk whose checksum holds, and a list of what was not.

Records are parsed by the `mcap` package. Its readers end at the first damaged byte, so the walk from record to record,
which goes on behind one, is here; and so is the walk through the messages of a chunk (0.9 us a message; the package
makes an object of each, 3 us). Format: https://mcap.dev/spec (version 0).
"""

from __future__ import annotations

import os
import re
import struct
import zlib
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from io import BytesIO
from typing import Any, BinaryIO, Final, NamedTuple, cast

import lz4.frame
import zstandard
from mcap import records as mcap
from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import SeekingReader

from pelagos.errors import NoRecording, RecordingError

MAGIC: Final = b"\x89MCAP0\r\n"
RECORD: Final = struct.Struct("<BQ")
MESSAGE: Final = struct.Struct("<BQHIQQ")  # opcode, length, channel, sequence, log time, publish time
MESSAGE_HEAD: Final = 22  # bytes of a message record before its data
_CHUNK: Final = struct.Struct("<QQQII")  # first and last time, size, checksum, length of the compression's name
_FOOTER: Final = struct.Struct("<BQQQI")  # opcode, length, where index and its groups begin, checksum of both
_NAMED: Final = re.compile(rb"\x03\0\0\0lz4|\x04\0\0\0zstd|\0\0\0\0")
_STEP: Final = 1 << 20
MAX_CHUNK: Final = 1 << 30  # [bytes] unpacked; beyond it is damage, or a trap
_PARSERS: Final[dict[int, Any]] = {
    Opcode.HEADER: mcap.Header, Opcode.FOOTER: mcap.Footer, Opcode.SCHEMA: mcap.Schema, Opcode.CHANNEL: mcap.Channel,
    Opcode.MESSAGE_INDEX: mcap.MessageIndex, Opcode.CHUNK_INDEX: mcap.ChunkIndex, Opcode.ATTACHMENT: mcap.Attachment,
    Opcode.ATTACHMENT_INDEX: mcap.AttachmentIndex, Opcode.STATISTICS: mcap.Statistics,
    Opcode.METADATA: mcap.Metadata, Opcode.METADATA_INDEX: mcap.MetadataIndex,
    Opcode.SUMMARY_OFFSET: mcap.SummaryOffset, Opcode.DATA_END: mcap.DataEnd,
}  # fmt: skip
_PARSE_ERRORS: Final = (McapError, ValueError, struct.error, EOFError, IndexError, KeyError, OverflowError, MemoryError)


class RawRecord(NamedTuple):
    """One record as it stands in a file or chunk; a chunk's bytes are unpacked.

    Attributes:
        opcode: its kind.
        payload: its bytes.
        chunk: where in the file its chunk begins; -1 outside chunks.
    """

    opcode: int
    payload: memoryview
    chunk: int = -1


@dataclass
class Damage:
    """Bytes of a recording that cannot be read.

    Attributes:
        begin, end: where in the file.
        what: what is wrong with them.
        messages: how many were in them; None where that is not known.
        t_ns: simulation times between which they lie [ns], where known.
    """

    begin: int
    end: int
    what: str
    messages: int | None = None
    t_ns: tuple[int, int] | None = None

    def __str__(self) -> str:
        lost = "" if self.messages == 0 else f", {self.messages or 'an unknown number of'} messages"
        when = "" if self.t_ns is None else f" from {self.t_ns[0] / 1e9:.3f} to {self.t_ns[1] / 1e9:.3f} s"
        return f"bytes {self.begin} to {self.end}: {self.what}{lost}{when}"


@dataclass
class Walk:
    """The records of a file outside of chunks, and whole chunks, in order, with a list of what could not be read.

    Attributes:
        file: open for reading.
        size: of the file [bytes].
        damage: filled during the walk.
        complete: the footer was met.
    """

    file: BinaryIO
    size: int
    damage: list[Damage] = field(default_factory=list)
    complete: bool = False
    _crc: int = 0

    def records(self) -> Iterator[RawRecord]:
        """Every record that can be read.

        Raises:
            RecordingError: the file is no MCAP file.
        """
        self._begin()
        at, unread = len(MAGIC), cast(Damage | None, None)
        while at + RECORD.size <= self.size:
            self.file.seek(at)
            head = self.file.read(RECORD.size)
            opcode, length = RECORD.unpack(head)
            end = at + RECORD.size + length
            record = self._record(at, opcode, end)
            if record is None:
                begin = self._next_chunk(at)
                if begin is None:
                    self._end(at)
                    return
                if begin > at:
                    self._note(Damage(at, begin, "no record begins here"))
                    at = begin
                    continue
                record, end = self._chunk(at), self._chunk_end(at) or self.size
                if head[0] != Opcode.CHUNK or length != end - at - RECORD.size:
                    self._note(Damage(at, at + RECORD.size, "the head of a chunk, which was read all the same", 0))
            self._crc = zlib.crc32(self._bytes(at, end), self._crc) if opcode != Opcode.DATA_END else self._crc
            at = end
            if isinstance(record, Damage):
                self._note(record)
                unread = record
            elif record.opcode == Opcode.MESSAGE_INDEX:
                if unread is not None:  # the index of a chunk that cannot be read says what was in it
                    unread.messages = (unread.messages or 0) + (length - 6) // 16
            else:
                unread = None
                yield record
                if record.opcode == Opcode.DATA_END:
                    self._check_data(parse(record).data_section_crc, at)
                if record.opcode == Opcode.FOOTER:
                    self.complete = True
                    self._check_index(parse(record), end)
                    return

    def _begin(self) -> None:
        self.file.seek(0)
        first = self.file.read(len(MAGIC))
        wrong = sum(a != b for a, b in zip(first, MAGIC, strict=False)) + len(MAGIC) - len(first)
        if wrong > 1:
            raise NoRecording(f"{self.file.name}: is not an MCAP recording")
        if wrong:
            self._note(Damage(0, len(MAGIC), "the mark of MCAP files", 0))
        self._crc = zlib.crc32(first)

    def _end(self, at: int) -> None:
        """The rest holds no chunk: the file was cut off there, or its index is damaged."""
        if self._bytes(max(at, self.size - len(MAGIC)), self.size) == MAGIC:
            self._note(Damage(at, self.size, "the index", 0))

    def _note(self, damage: Damage) -> None:
        self.damage.append(damage)

    def _check_data(self, crc: int, end: int) -> None:
        if crc and crc != self._crc and not self.damage:
            self._note(Damage(0, end, "a byte outside of the chunks is not the one that was written", 0))

    def _check_index(self, footer: Any, end: int) -> None:
        index = self._bytes(footer.summary_start, end - 4) if 0 < footer.summary_start < end else b""
        if footer.summary_crc and zlib.crc32(index) != footer.summary_crc:
            self._note(Damage(footer.summary_start, end, "the index", 0))
        if self._bytes(end, self.size) != MAGIC:
            self._note(Damage(end, self.size, "the closing mark of MCAP files", 0))

    def _bytes(self, begin: int, end: int) -> bytes:
        self.file.seek(begin)
        return self.file.read(end - begin)

    def _record(self, at: int, opcode: int, end: int) -> RawRecord | Damage | None:
        """The record at `at`, known to be sound; what is wrong with it; None where no record can be told."""
        if end > self.size:
            return None
        if opcode == Opcode.CHUNK:
            return self._chunk(at) if self._chunk_end(at) == end else None
        payload = memoryview(self._bytes(at + RECORD.size, end))
        if opcode == Opcode.MESSAGE:
            return RawRecord(opcode, payload) if len(payload) >= MESSAGE_HEAD else None
        if opcode >= 0x80:  # private records, which others may write
            return RawRecord(opcode, payload)
        if opcode not in _PARSERS:
            return None
        if opcode == Opcode.MESSAGE_INDEX:
            whole = len(payload) >= 6 and struct.unpack_from("<I", payload, 2)[0] == len(payload) - 6
            return RawRecord(opcode, payload) if whole else None
        stream = ReadDataStream(BytesIO(payload))
        try:
            _PARSERS[opcode].read(stream)
        except _PARSE_ERRORS:
            return None if self._next_chunk(at) == at else Damage(at, end, f"{Opcode(opcode).name.lower()} record", 0)
        if stream.count != len(payload):
            return None
        if opcode == Opcode.ATTACHMENT and not _sound_attachment(payload):
            return Damage(at, end, "an attachment's checksum does not agree", 0)
        return RawRecord(opcode, payload)

    def _chunk_end(self, at: int) -> int | None:
        """End of the chunk that begins at `at`, as its own fields say; None where there is none."""
        head = self._bytes(at + RECORD.size, at + RECORD.size + _CHUNK.size + 16)
        if at < len(MAGIC) or len(head) < _CHUNK.size + 8:
            return None
        first, last, size, _, name = _CHUNK.unpack_from(head)
        if name > 4 or first > last or size > MAX_CHUNK or len(head) < _CHUNK.size + name + 8:
            return None
        (stored,) = struct.unpack_from("<Q", head, _CHUNK.size + name)
        end = at + RECORD.size + _CHUNK.size + name + 8 + stored
        return end if end <= self.size else None

    def _chunk(self, at: int) -> RawRecord | Damage:
        end = self._chunk_end(at)
        assert end is not None
        payload = self._bytes(at + RECORD.size, end)
        first, last, size, crc, name = _CHUNK.unpack_from(payload)
        compression = payload[_CHUNK.size : _CHUNK.size + name].decode("latin-1")
        try:
            raw = _unpacked(payload[_CHUNK.size + name + 8 :], compression, size)
        except (RuntimeError, ValueError, zstandard.ZstdError) as error:
            return Damage(at, end, f"a chunk cannot be unpacked ({error})", t_ns=(first, last))
        if crc and zlib.crc32(raw) != crc:
            return Damage(at, end, "a chunk's checksum does not agree", t_ns=(first, last))
        return RawRecord(Opcode.CHUNK, memoryview(raw), at)

    def _next_chunk(self, at: int) -> int | None:
        """Beginning of the next chunk, at `at` or behind; None where there is none."""
        before = RECORD.size + _CHUNK.size - 4
        place = at + before
        while place < self.size:
            block = self._bytes(place, place + _STEP + 8)
            for found in _NAMED.finditer(block):
                begin = place + found.start() - before
                end = self._chunk_end(begin)
                if end is not None and self._plausible(begin, found[0] != b"\0\0\0\0"):
                    return begin
            place += _STEP
        return None

    def _plausible(self, begin: int, named: bool) -> bool:
        opcode, length = RECORD.unpack(self._bytes(begin, begin + RECORD.size))
        agrees = begin + RECORD.size + length == self._chunk_end(begin)
        return agrees and opcode == Opcode.CHUNK if not named else agrees or isinstance(self._chunk(begin), RawRecord)


def _unpacked(data: bytes, compression: str, size: int) -> bytes:
    """The records of a chunk, never more than it says.

    Raises:
        ValueError: they have another size; RuntimeError or ZstdError: they cannot be unpacked.
    """
    if data[:4] == b"\x04\x22\x4d\x18":
        raw = lz4.frame.LZ4FrameDecompressor().decompress(data, max_length=size + 1)
    elif data[:4] == b"\x28\xb5\x2f\xfd":
        raw = zstandard.ZstdDecompressor().decompressobj().decompress(data) if size < MAX_CHUNK else b""
    elif compression == "":
        raw = data
    else:
        raise ValueError(f"its compression is {compression!r}")
    if len(raw) != size:
        raise ValueError(f"it holds not the {size} bytes that it says")
    return bytes(raw)


def _sound_attachment(payload: memoryview) -> bool:
    (crc,) = struct.unpack_from("<I", payload, len(payload) - 4)
    return not crc or zlib.crc32(payload[:-4]) == crc


def parse(record: RawRecord) -> Any:
    """A record that is no message, as the `mcap` package understands it.

    Raises:
        RecordingError: it cannot be understood.
    """
    try:
        return _PARSERS[record.opcode].read(ReadDataStream(BytesIO(record.payload)))
    except _PARSE_ERRORS as error:
        raise RecordingError(f"a record of kind {record.opcode} cannot be understood: {error}") from None


def summary(file: BinaryIO) -> Any:
    """Schemas, channels and statistics that stand at the end of a whole file; None where none are, or damaged ones."""
    try:
        end = file.seek(-len(MAGIC) - 4, os.SEEK_END)
        file.seek(end + 4 - _FOOTER.size)
        _, _, begin, _, crc = _FOOTER.unpack(file.read(_FOOTER.size))
        file.seek(begin)
        if crc and zlib.crc32(file.read(max(end - begin, 0))) != crc:
            return None
        file.seek(0)
        return SeekingReader(file, validate_crcs=True).get_summary()
    except (*_PARSE_ERRORS, OSError):
        return None


def read_chunk(file: BinaryIO, begin: int, size: int) -> memoryview:
    """The unpacked records of the chunk that begins at byte `begin`, known to be whole."""
    record = Walk(file, size)._chunk(begin)
    if isinstance(record, Damage):
        raise RecordingError(f"{file.name}: was changed while it was read: {record}")
    return record.payload


def scan_chunk(
    raw: bytes, on_message: Callable[[int, int, int, int], None], on_record: Callable[[RawRecord], None]
) -> None:
    """Walk through an unpacked chunk quickly.

    Args:
        raw: the chunk's records.
        on_message: called with channel, log time [ns], and where in `raw` the message's data begins and ends.
        on_record: called with every other record.

    Raises:
        RecordingError: the records do not fill the chunk.
    """
    at, size, unpack = 0, len(raw), MESSAGE.unpack_from
    while at < size:
        if at + RECORD.size > size:
            raise RecordingError("a chunk ends within a record")
        opcode, length = RECORD.unpack_from(raw, at)
        end = at + RECORD.size + length
        if end > size or (opcode == Opcode.MESSAGE and length < MESSAGE_HEAD):
            raise RecordingError("a chunk ends within a record")
        if opcode == Opcode.MESSAGE:
            _, _, channel, _, t_ns, _ = unpack(raw, at)
            on_message(channel, t_ns, at + MESSAGE.size, end)
        elif opcode in (Opcode.SCHEMA, Opcode.CHANNEL):
            on_record(RawRecord(opcode, memoryview(raw)[at + RECORD.size : end]))
        at = end

"""Places of damaged and foreign recordings: where reading goes on, what is counted as lost, what a recovery copies."""

from __future__ import annotations

import io
import os
import re
import struct
from pathlib import Path
from typing import Any

import lz4.frame
import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import CompressionType, Writer
from test_record_refusals import HEAD, chunk, foreign, message

from pelagos.errors import NoPlace, NoRecording, RecordingError, RecordingWarning
from pelagos.sim import mcap_reader, mcap_writer
from pelagos.sim.mcap_reader import MAGIC, RECORD, Damage, Walk, summary
from pelagos.sim.mcap_writer import McapWriter
from pelagos.sim.read_together import GroupTopic
from pelagos.sim.replay import Recording, recover


def record(opcode: int, payload: bytes) -> bytes:
    return RECORD.pack(opcode, len(payload)) + payload


def index(channel: int, count: int) -> bytes:
    return record(Opcode.MESSAGE_INDEX, struct.pack("<HI", channel, 16 * count) + bytes(16 * count))


def packed(records: bytes, size: int, *, first: int = 0, last: int = 9, crc: int = 0, name: bytes = b"lz4") -> bytes:
    data = lz4.frame.compress(records)
    head = HEAD.pack(first, last, size, crc, len(name)) + name + struct.pack("<Q", len(data))
    return record(Opcode.CHUNK, head + data)


def times(path: Path, told: str | None = None) -> list[int]:
    if told is None:
        return Recording(path).times("/it").tolist()
    with pytest.warns(RecordingWarning, match=re.escape(told)):
        return Recording(path).times("/it").tolist()


@pytest.mark.parametrize(
    ("lost", "span", "expected"),
    [
        (None, None, "bytes 7 to 19: torn, an unknown number of messages"),
        (0, None, "bytes 7 to 19: torn"),
        (3, (1_500_000_000, 22_250_000_000), "bytes 7 to 19: torn, 3 messages from 1.500 to 22.250 s"),
    ],
)
def test_damage_in_words(lost: int | None, span: tuple[int, int] | None, expected: str) -> None:
    assert str(Damage(7, 19, "torn", lost, span)) == expected


def test_the_messages_of_a_chunk_that_is_lost_are_those_of_its_indexes(tmp_path: Path) -> None:
    """Of the chunk before them alone; a chunk without any leaves the number open."""
    bad, good = chunk(message(1, 7, b"{}"), compression=b"zip4"), chunk(message(1, 8, b"{}"))
    path = foreign(tmp_path / "a.mcap", bad, index(1, 3), index(2, 2), good, index(1, 1), bad, index(1, 4))
    with pytest.warns(RecordingWarning) as told:
        found = Recording(path)
    assert (str(told[0].message).count("\n"), "more" in str(told[0].message)) == (2, False)
    assert ([d.messages for d in found.damage], found.lost) == ([5, 4], 9)
    assert found.times("/it").tolist() == [5, 8]
    path = foreign(tmp_path / "b.mcap", *[bad] * 11, good, bad, index(1, 4))
    with pytest.warns(RecordingWarning, match=r"\n  and 2 more$") as told:
        found = Recording(path)
    assert (len(found.damage), found.lost) == (12, None)
    assert str(told[0].message).count("\n") == 11


def test_reading_goes_on_at_the_next_chunk_wherever_it_begins(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Blocks of 64 bytes are looked through, here; a name of a compression may lie across two of them."""
    monkeypatch.setattr(mcap_reader, "_STEP", 64)
    one = message(1, 7, b"{}")
    for pad in range(1, 68, 3):
        for inner in (chunk(one), packed(one, len(one))):
            path = foreign(tmp_path / "a.mcap", b"\x7f" + b"x" * pad, inner)
            assert times(path, "no record begins here") == [5, 7]


def test_a_chunk_is_as_long_and_as_late_as_it_says(tmp_path: Path) -> None:
    one = message(1, 7, b"{}")
    for at, (inner, told) in enumerate(
        [
            (packed(one, len(one)), None),
            (packed(one, len(one) - 1), f"it holds not the {len(one) - 1} bytes that it says"),
            (packed(one, len(one) + 1), f"it holds not the {len(one) + 1} bytes that it says"),
            (packed(one, len(one), crc=5), "a chunk's checksum does not agree"),
            (packed(one, len(one), first=9, last=9), None),
            (packed(one, len(one), first=10, last=9), "no record begins here"),
            (packed(one, len(one), name=b"lz4xx"), "no record begins here"),
        ]
    ):
        path = foreign(tmp_path / f"{at}.mcap", inner, chunk(message(1, 8, b"{}")))
        assert times(path, told) == [5, *([7] if told is None else []), 8]


def test_a_file_begins_with_its_mark_but_for_one_byte(tmp_path: Path) -> None:
    path = foreign(tmp_path / "a.mcap", cut=0)
    whole = path.read_bytes()
    path.write_bytes(b"\x88" + whole[1:])
    assert times(path, "bytes 0 to 8: the mark of MCAP files") == [5]
    for other in (b"\x88N" + whole[2:], MAGIC[:6]):
        path.write_bytes(other)
        with pytest.raises(NoRecording, match="is not an MCAP recording"):
            Recording(path)


def written(path: Path, *, crc: bool = True) -> bytes:
    """A whole file of somebody else's, with two topics of one type, an attachment, and times that fall."""
    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.LZ4, enable_data_crcs=crc, enable_crcs=crc)
    writer.start()
    schema = writer.register_schema("it", "jsonschema", b"{}")
    channels = [writer.register_channel(topic, "json", schema, {"who": topic}) for topic in ("/it", "/that", "/none")]
    writer.add_attachment(create_time=111, log_time=222, name="notes", media_type="text/plain", data=b"remember")
    writer.add_metadata("about", {"colour": "green"})
    for k, t_ns in enumerate((400, 900, 700)):
        writer.add_message(channels[k % 2], log_time=t_ns, publish_time=1000 + k, data=b"{%d}" % k, sequence=50 + k)
    writer.finish()
    path.write_bytes(file.getvalue())
    return file.getvalue()


def test_a_recovery_copies_numbers_times_and_attachments(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    whole = written(path)
    found = recover(path)
    assert (found.whole, found.path, found.messages, found.topics, found.end_ns) == (True, path, 3, 3, 900)
    path.write_bytes(whole[:-10])
    (tmp_path / "a.recovered.mcap").write_bytes(b"of another day")
    found = recover(path, in_place=True)
    backup = tmp_path / "a.mcap.backup"
    assert (found.whole, found.messages, found.topics, found.end_ns) == (False, 3, 3, 900)
    assert (found.path, found.original, backup.read_bytes()) == (path, backup, whole[:-10])
    with path.open("rb") as file:
        reader = make_reader(file)
        rows = [(c.topic, m.log_time, m.publish_time, m.sequence, m.data) for _, c, m in reader.iter_messages()]
        (attachment,) = reader.iter_attachments()
        channels = reader.get_summary().channels.values()  # type: ignore[union-attr]
    assert sorted(rows, key=lambda row: row[3]) == [
        ("/it", 400, 1000, 50, b"{0}"), ("/that", 900, 1001, 51, b"{1}"), ("/it", 700, 1002, 52, b"{2}"),
    ]  # fmt: skip
    assert (attachment.create_time, attachment.log_time, attachment.name) == (111, 222, "notes")
    assert (attachment.media_type, attachment.data) == ("text/plain", b"remember")
    assert {c.topic: c.metadata for c in channels} == {t: {"who": t} for t in ("/it", "/that", "/none")}
    assert Recording(path).metadata == {"colour": "green"}
    backup.write_bytes(whole[:-10])
    with pytest.raises(NoPlace, match=r"a\.recovered\.mcap exists already"):
        recover(backup, tmp_path / "a.recovered.mcap")
    with pytest.raises(NoPlace, match=r"there is no folder .*none"):
        recover(backup, tmp_path / "none" / "b.mcap")


@pytest.mark.parametrize("crc", [True, False])
def test_a_changed_byte_outside_of_chunks_is_told_where_there_are_checksums(crc: bool, tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    whole = written(path, crc=crc)
    assert (not Recording(path).damage, Recording(path).attachments) == (True, {"notes": b"remember"})
    for word, told in ((b"remember", "an attachment's checksum does not agree"), (b"green", "a byte outside of the")):
        path.write_bytes(whole.replace(word, word[::-1], 1))
        known = crc or word == b"remember"  # attachments always have one
        if known:
            with pytest.warns(RecordingWarning, match=told):
                found = Recording(path)
            assert ([told in d.what for d in found.damage], found.lost) == ([True], 0)
        else:
            found = Recording(path)
            assert not found.damage
        assert found.attachments == ({} if word == b"remember" else {"notes": b"remember"})
        assert sorted(found.times("/it")) == [400, 700]
    path.write_bytes(whole)
    with path.open("rb") as file:
        assert summary(file).statistics.message_count == 3
    path.write_bytes(whole.replace(b"/that", b"/thot"))  # in the index, too
    with path.open("rb") as file:
        assert (summary(file) is None) == crc


def test_the_only_messages_of_members_whose_topic_was_cut(tmp_path: Path) -> None:
    described = {"topic": "/auv/plan", "type": "it", "fields": None, "sizes": [], "constant": "",
                 "members": {f"/auv_{i}/plan": {"agent": f"auv[{i}]"} for i in range(3)}}  # fmt: skip
    topic = GroupTopic(described, lambda: (np.array([7, 8]), [b"zero", b"one"]))
    assert [topic.count(f"/auv_{i}/plan") for i in range(3)] == [1, 1, 0]
    assert [topic.messages(f"/auv_{i}/plan") for i in range(3)] == [[(7, b"zero")], [(8, b"one")], []]
    said = {"group": "auv", "message": "it", "members": "auv[0] auv[1]", "qos": "latched"}
    assert topic.about({"agent": "auv[1]"}, said) == {"agent": "auv[1]", "qos": "latched"}


def writer_of(path: Path) -> tuple[McapWriter, int]:
    made = McapWriter(path, library="it")
    return made, made.add_channel("/it", made.add_schema("std_msgs/msg/String", "ros2msg", b"string data"), "cdr", {})


def test_a_chunk_ends_where_it_is_full(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Counted with a byte for each message, so that empty ones do not wait for ever."""
    monkeypatch.setattr(mcap_writer, "CHUNK_BYTES", 30)
    made, number = writer_of(tmp_path / "a.mcap")
    for t_ns in range(31):  # the last ends it
        made.add_message(number, t_ns, b"")
    made.add_messages(number, np.array([40, 41, 42]), np.zeros((3, 10), np.uint8))  # these too
    made.add_messages(number, np.array([50, 51]), np.zeros((2, 14), np.uint8))
    made.add_message(number, 60, b"")
    made.close()
    with (tmp_path / "a.mcap").open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes  # type: ignore[union-attr]
    assert [(c.message_start_time, c.message_end_time) for c in chunks] == [(0, 30), (40, 42), (50, 60)]


def test_a_disk_that_is_full_keeps_what_was_written(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The time told is the latest of the chunks that are whole, and the file ends with the last of them."""
    path, there = tmp_path / "a.mcap", os.write
    made, number = writer_of(path)
    for times in ((2_000_000_000, 7_500_000_000, 3_000_000_000), (4_000_000_000,)):
        for t_ns in times:
            made.add_message(number, t_ns, b"full")
        made.flush()
    length = path.stat().st_size
    made.add_message(number, 9_000_000_000, b"more")

    def short(fd: int, data: Any) -> int:
        if len(data) > 20:
            return there(fd, data[:20])
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(mcap_writer.os, "write", short)
    with pytest.raises(
        RecordingError, match=r"No space left on device; it is readable up to simulation time 7\.500 s$"
    ):
        made.flush()
    assert path.stat().st_size == length
    assert Recording(path).times("/it").tolist() == [2e9, 7.5e9, 3e9, 4e9]
    with pytest.raises(RecordingError, match="the recording was closed"):
        made.add_message(number, 1, b"")
    with pytest.raises(RecordingError, match=r"; nothing was recorded$"):
        writer_of(tmp_path / "b.mcap")
    assert not (tmp_path / "b.mcap").exists()


def test_channels_without_messages_are_listed_at_the_end(tmp_path: Path) -> None:
    """In the order in which they were declared, with and without messages before."""
    for name in ("with", "without"):
        made, number = writer_of(tmp_path / name)
        schema = made.add_schema("std_msgs/msg/Empty", "ros2msg", b"")
        others = [made.add_channel(f"/{k}", schema, "cdr", {"k": k}) for k in "ba"]
        if name == "with":
            made.add_message(others[1], 1, b"\0\1\0\0")
            made.flush()
            made.add_message(number, 2, b"")
        made.close()
        found = Recording(tmp_path / name)
        assert list(found.channels) == ["/it", "/b", "/a"]
        assert (found.channels["/a"].type, found.channels["/b"].about) == ("std_msgs/msg/Empty", {"k": "b"})
        assert [found.count(topic) for topic in found.channels] == ([1, 0, 1] if name == "with" else [0, 0, 0])
    path = tmp_path / "with"
    assert listings(path) == 2  # behind each chunk that has new ones
    with path.open("rb") as file:
        first = make_reader(file).get_summary().chunk_indexes[0]  # type: ignore[union-attr]
    raw = bytearray(path.read_bytes()[:-10])  # the index is lost, and the chunk that declares one of them
    raw[first.chunk_start_offset + first.chunk_length - 3] ^= 1
    path.write_bytes(raw)
    with pytest.warns(RecordingWarning):
        found = Recording(path)
    assert [(topic, found.count(topic)) for topic in found.channels] == [("/it", 1), ("/b", 0), ("/a", 0)]


def listings(path: Path) -> int:
    with path.open("rb") as file:
        return sum(r.opcode == Opcode.ATTACHMENT for r in Walk(file, path.stat().st_size).records())


def test_channels_are_listed_eight_times_and_at_the_end(tmp_path: Path) -> None:
    made, _ = writer_of(tmp_path / "a.mcap")
    schema = made.add_schema("std_msgs/msg/Empty", "ros2msg", b"")
    numbers = [made.add_channel(f"/{k}", schema, "cdr", {}) for k in range(11)]
    for k, number in enumerate(numbers):
        for t_ns in (2 * k, 2 * k + 1):  # the second has nothing new
            made.add_message(number, t_ns, b"")
            made.flush()
        assert listings(tmp_path / "a.mcap") == min(k + 1, 8)
    made.close()
    assert listings(tmp_path / "a.mcap") == 9

"""Odd, foreign and vanished recordings and checkpoints: what each reader says of them, and keeps."""

from __future__ import annotations

import io
import re
import struct
import zlib
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from mcap.opcode import Opcode
from mcap.writer import CompressionType, Writer
from test_record_file import recorder, write

import pelagos.sim.resume as resuming
from pelagos.errors import CommandError, NoRecording, RecordingError, RecordingWarning
from pelagos.messages.group import GroupTemplate, group_rows
from pelagos.sim import plain
from pelagos.sim import recover as recovering
from pelagos.sim.checkpoint import Checkpoint
from pelagos.sim.mcap_reader import MESSAGE, RECORD, RawRecord, Walk, parse, read_chunk, scan_chunk
from pelagos.sim.mcap_writer import McapWriter, listed_channels
from pelagos.sim.replay import Recording, recover
from pelagos.sim.resume import last_checkpoint

HEAD = struct.Struct("<QQQII")  # of a chunk, as the MCAP specification has it


def message(channel: int, t_ns: int, data: bytes, *, length: int | None = None) -> bytes:
    return MESSAGE.pack(Opcode.MESSAGE, 22 + len(data) if length is None else length, channel, 0, t_ns, t_ns) + data


def chunk(records: bytes, *, compression: bytes = b"", size: int | None = None) -> bytes:
    """A chunk record, whose checksum holds whatever is in it."""
    head = HEAD.pack(0, 9, len(records) if size is None else size, zlib.crc32(records), len(compression))
    body = head + compression + struct.pack("<Q", len(records)) + records
    return RECORD.pack(Opcode.CHUNK, len(body)) + body


def foreign(path: Path, *inner: bytes, cut: int = 10) -> Path:
    """A file with one channel, number 1, of a program that is not ours, with raw records before its end."""
    file = io.BytesIO()
    writer = Writer(file, compression=CompressionType.NONE, enable_data_crcs=False)
    writer.start()
    one = writer.register_channel("/it", "json", writer.register_schema("it", "jsonschema", b"{}"))
    writer.add_message(one, log_time=5, publish_time=5, data=b"{}")
    writer._Writer__finalize_chunk()
    file.write(b"".join(inner))
    writer.finish()
    path.write_bytes(file.getvalue()[: -cut or None])
    return path


@pytest.mark.parametrize(
    ("records", "told"),
    [
        (message(1, 7, b"{}") + b"\x05\x00", "a chunk ends within a record"),
        (message(1, 7, b"{}")[:-1], "a chunk ends within a record"),
        (message(1, 7, b"", length=21)[:-1], "a chunk ends within a record"),
    ],
)
def test_a_chunk_whose_checksum_holds_but_whose_records_do_not_is_told(
    records: bytes, told: str, tmp_path: Path
) -> None:
    with pytest.raises(RecordingError, match=told):
        scan_chunk(records, lambda *_: None, lambda _: None)
    path = foreign(tmp_path / "a.mcap", chunk(records))
    with pytest.warns(RecordingWarning, match=told):
        found = Recording(path)
    assert found.times("/it").tolist() == [5, *([7] if records[-2:] == b"\x05\x00" else [])]
    assert any(told in d.what for d in recover(path, tmp_path / "b.mcap").damage)


def test_records_that_fill_a_chunk_to_its_last_byte_are_read() -> None:
    """A message without data, which ends the chunk, and records that nobody needs."""
    heard: list[Any] = []
    others = RECORD.pack(Opcode.METADATA, 0) + RECORD.pack(Opcode.CHANNEL, 1) + b"x"
    raw = message(1, 7, b"{}") + others + message(2, 8, b"")
    scan_chunk(raw, lambda c, t, a, b: heard.append((c, t, raw[a:b])), lambda r: heard.append(bytes(r.payload)))
    assert heard == [(1, 7, b"{}"), b"x", (2, 8, b"")]


def test_messages_of_undeclared_channels_are_counted(tmp_path: Path) -> None:
    """By channel, unless some topics alone are asked for, where the others' declarations are not looked at."""
    path = foreign(tmp_path / "a.mcap", chunk(message(9, 7, b"{}") + message(1, 8, b"{}") + message(9, 8, b"{}")))
    with pytest.warns(RecordingWarning, match=re.escape("messages of channels [9], whose declaration is lost")):
        found = Recording(path)
    assert (found.lost, found.times("/it").tolist()) == (2, [5, 8])
    assert not Recording(path, topics=["/it"]).damage


@pytest.mark.parametrize(
    ("inner", "told", "times"),
    [
        (RECORD.pack(0x80, 3) + b"abc", None, [5]),
        (RECORD.pack(0x7F, 3) + b"abc", "no record begins here", [5]),
        (RECORD.pack(Opcode.METADATA, 9) + b"\0" * 9, "no record begins here", [5]),
        (chunk(message(1, 7, b"{}"), compression=b"zip4"), "its compression is 'zip4'", [5]),
        (chunk(message(1, 7, b"{}"), size=32), "it holds not the 32 bytes that it says", [5]),
        (chunk(message(1, 7, b"{}")), None, [5, 7]),
    ],
)
def test_records_of_others_are_passed_over_and_damaged_ones_told(
    inner: bytes, told: str | None, times: list[int], tmp_path: Path
) -> None:
    """With a chunk behind them, so that reading goes on there."""
    path = foreign(tmp_path / "a.mcap", inner, chunk(message(1, 8, b"{}")), cut=0)
    with path.open("rb") as file:
        walk = Walk(file, path.stat().st_size)
        assert len(list(walk.records())) > 5
    assert [told in d.what for d in walk.damage] == ([] if told is None else [True])
    if told is None:
        assert Recording(path).times("/it").tolist() == [*times, 8]
    else:
        with pytest.warns(RecordingWarning, match=re.escape(told)):
            assert Recording(path).times("/it").tolist() == [*times, 8]


def test_a_changed_byte_of_the_index_costs_no_message(tmp_path: Path) -> None:
    """In a name there, which the checksum of the index tells; and in its footer's head, behind which none is found."""
    path = foreign(tmp_path / "a.mcap", cut=0)
    whole = path.read_bytes()
    for place, bit in ((whole.rindex(b"/it") + 1, 0x01), (whole.rindex(bytes([Opcode.FOOTER]) + b"\x14"), 0x60)):
        path.write_bytes(whole[:place] + bytes([whole[place] ^ bit]) + whole[place + 1 :])
        with pytest.warns(RecordingWarning, match="the index"):
            found = Recording(path)
        assert ([d.what for d in found.damage], found.lost) == (["the index"], 0)
        assert found.times("/it").tolist() == [5]


def test_a_chunk_that_changes_while_it_is_read_is_told(tmp_path: Path) -> None:
    path = foreign(tmp_path / "a.mcap", chunk(message(1, 7, b"large")))
    begin = path.read_bytes().rindex(chunk(message(1, 7, b"large")))
    with path.open("rb") as file:
        assert bytes(read_chunk(file, begin, path.stat().st_size))[-5:] == b"large"
    path.write_bytes(path.read_bytes().replace(b"large", b"lorge"))
    told = r"a\.mcap: was changed while it was read: .*checksum"
    with path.open("rb") as file, pytest.raises(RecordingError, match=told):
        read_chunk(file, begin, path.stat().st_size)
    with pytest.raises(RecordingError, match="a record of kind 3 cannot be understood"):
        parse(RawRecord(Opcode.SCHEMA, memoryview(b"\x01")))


@pytest.mark.parametrize("data", [b"not JSON", b"5", b"null", b"\xff"])
def test_a_list_of_channels_of_somebody_else_is_none(data: bytes) -> None:
    assert listed_channels(data) == []
    row = {"number": 1, "topic": "/a", "type": "b", "about": {}}
    assert listed_channels(b'[{"number": 2}, 7, {"number": 1, "topic": "/a", "type": "b", "about": {}}]') == [row]


def test_no_messages_at_once_are_nothing(tmp_path: Path) -> None:
    writer = McapWriter(tmp_path / "a.mcap", library="it")
    number = writer.add_channel("/it", writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data"), "cdr", {})
    writer.add_messages(number, np.zeros(0, np.int64), np.zeros((0, 4), np.uint8))
    writer.close()
    found = Recording(tmp_path / "a.mcap")
    assert found.count("/it") == 0
    times, values = found.table("/it", ["a", "b", "c"])
    assert (times.shape, values.shape) == ((0,), (0, 3))


def test_messages_of_different_sizes_make_no_table(tmp_path: Path) -> None:
    writer = McapWriter(tmp_path / "a.mcap", library="it")
    number = writer.add_channel("/it", writer.add_schema("std_msgs/msg/String", "ros2msg", b"string data"), "cdr", {})
    for text in (b"\0\1\0\0abcd", b"\0\1\0\0abcdefgh"):
        writer.add_message(number, len(text), text)
    writer.close()
    with pytest.raises(RecordingError, match=r"a\.mcap: the messages of /it have different sizes"):
        Recording(tmp_path / "a.mcap").table("/it", ["data"])


def test_what_cannot_be_opened_is_no_recording(tmp_path: Path) -> None:
    with pytest.raises(NoRecording, match="cannot be read: Is a directory"):
        Recording(tmp_path)


@pytest.mark.parametrize("in_place", [False, True])
def test_a_recovery_that_fails_leaves_nothing_new(
    in_place: bool, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = foreign(tmp_path / "a.mcap")
    before = path.read_bytes()
    with pytest.raises(CommandError, match="give either a file to write, or in_place, not both"):
        recover(path, tmp_path / "b.mcap", in_place=True)

    def full(*_: Any) -> None:
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(recovering, "_copy", full)
    with pytest.raises(RecordingError, match=r"a\.mcap: No space left on device"):
        recover(path, in_place=in_place)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {"a.mcap": before}


def test_a_folder_without_a_checkpoint_has_none_to_go_on_from(tmp_path: Path) -> None:
    """The reason is that of the newest; an older one is taken where the newest cannot be read."""
    told = re.escape(f"{tmp_path} holds no checkpoint to go on from: {tmp_path / resuming.NEWEST}")
    with pytest.raises(RecordingError, match=told):
        last_checkpoint(tmp_path)
    old = Checkpoint("name: it\n", 3, 2, 5, 7_000, {"stepper": {}, "bodies": {}, "sensors": {}})
    old.save(tmp_path / resuming.PREVIOUS)
    plain.write(tmp_path / resuming.NEWEST, {"format": "of tomorrow", "seed": 3})
    assert last_checkpoint(tmp_path) == old
    for other in ({"format": "of tomorrow"}, {"seed": 3}, [1, 2]):
        plain.write(tmp_path / resuming.NEWEST, other)
        with pytest.raises(RecordingError, match=re.escape(f"{resuming.NEWEST} is no checkpoint of this version")):
            Checkpoint.load(tmp_path / resuming.NEWEST)


@pytest.mark.parametrize(
    ("kind", "told"),
    [
        ("os:stat_result", "os:stat_result is not of this package"),
        ("pelagosx.sim.bodies:Body", "pelagosx.sim.bodies:Body is not of this package"),
        ("pelagos.sim.checkpoint:take", "pelagos.sim.checkpoint:take is no dataclass"),
        ("pelagos.sim.observed:Observed", "pelagos.sim.observed:Observed is no dataclass"),
    ],
)
def test_a_file_of_plain_values_names_dataclasses_of_ours_alone(kind: str, told: str) -> None:
    with pytest.raises(ValueError, match=told):
        plain._built({plain._KIND: "dataclass", "type": kind, "fields": {}}, {})


def test_what_is_no_plain_value_is_not_written(tmp_path: Path) -> None:
    with pytest.raises(TypeError, match="set is no plain value"):
        plain.write(tmp_path / "a.npz", {"a": [1, {2}]})


def test_messages_of_a_group_of_other_members_are_told() -> None:
    rows, flags = [], np.array([[True, False, True]])
    for members in (3, 2):
        made = GroupTemplate("auv/heat", members, ["a:float64", "b:float64"])
        values = np.arange(2.0 * members).reshape(1, members, 2)
        rows.append(made.rows(np.array([7]), values, flags[:, :members])[0].tobytes())
    values, valid = group_rows(rows[:1], 3)
    assert (values.tolist(), valid.tolist()) == ([[[0, 1], [2, 3], [4, 5]]], [[True, False, True]])
    for raw, members in ((rows[:1], 2), (rows, 3)):
        with pytest.raises(RecordingError, match=f"are not for the {members} members that the recording names"):
            group_rows(raw, members)


class Standing:
    """As much of a simulation as a resumed recording needs."""

    time_ns = 50_000_000
    model = SimpleNamespace(agents={})


@pytest.fixture
def resume(monkeypatch: pytest.MonkeyPatch) -> Callable[[Path], Any]:
    monkeypatch.setattr(resuming, "open_recorder", lambda path, sim: recorder(path))
    return lambda path: resuming.resumed_recorder(path, Standing())


def test_a_damaged_recording_goes_on_and_is_told_of(resume: Any, tmp_path: Path) -> None:
    path = tmp_path / "run.mcap"
    with recorder(path) as r:
        for begin in (0, 40, 80):
            write(r, range(begin, begin + 40))
            r.flush()
    raw = bytearray(path.read_bytes())
    times = Recording(path).times("/auv0/truth")
    raw[len(raw) // 8] ^= 0x10
    path.write_bytes(raw)
    with pytest.warns(RecordingWarning, match=r"run\.mcap is damaged, .*; the new recording lacks it"):
        resume(path).close()
    kept = Recording(path).times("/auv0/truth")
    assert kept.tolist() == [t for t in times if 40_000_000 <= t <= 50_000_000]


def test_a_recording_that_cannot_go_on_stands_as_it_was(
    resume: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = tmp_path / "run.mcap"
    with pytest.raises(RecordingError, match=r"run\.mcap: cannot be read: No such file"):
        resume(path)
    assert not list(tmp_path.iterdir())
    with recorder(path) as r:
        write(r, range(30))
    before = path.read_bytes()

    def refuse(*_: Any) -> None:
        raise OSError(13, "Permission denied")

    monkeypatch.setattr("pelagos.sim.mcap_writer.give_name", refuse)
    with pytest.raises(RecordingError, match=r"run\.mcap: cannot be replaced: Permission denied"):
        resume(path)
    assert {p.name: p.read_bytes() for p in tmp_path.iterdir()} == {"run.mcap": before}


def test_a_checkpoint_that_cannot_be_kept_is_told(tmp_path: Path) -> None:
    """Where the name of the one before is taken by a folder."""

    class Sim:
        def checkpoint(self) -> Checkpoint:
            return Checkpoint("name: it\n", 3, 2, 5, 7_000, {})

    class Synced:
        def sync(self) -> None: ...

    for _ in range(2):
        resuming.keep(Sim(), Synced(), tmp_path)
    assert {p.name for p in tmp_path.iterdir()} == {resuming.NEWEST, resuming.PREVIOUS}
    (tmp_path / resuming.PREVIOUS).unlink()
    (tmp_path / resuming.PREVIOUS).mkdir()
    with pytest.raises(RecordingError, match=re.escape(f"{resuming.NEWEST}: cannot be written: ")):
        resuming.keep(Sim(), Synced(), tmp_path)

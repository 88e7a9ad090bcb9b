"""Damaged recordings: every chunk whose checksum holds is read, what was lost is counted, and originals stay."""

from __future__ import annotations

import io
import random
from pathlib import Path
from typing import TypeAlias

import pytest
from mcap.reader import make_reader
from mcap.records import Chunk, Message
from mcap.stream_reader import StreamReader, breakup_chunk
from mcap.writer import Writer
from test_record_file import DT_NS, recorder, write

from pelagos.errors import RecordingError, RecordingWarning
from pelagos.sim.replay import Recording, recover

Messages: TypeAlias = set[tuple[str, int, bytes]]


@pytest.fixture(scope="module")
def original(tmp_path_factory: pytest.TempPathFactory) -> bytes:
    path = tmp_path_factory.mktemp("whole") / "run.mcap"
    with recorder(path) as r:
        for begin in range(0, 2400, 100):  # 24 chunks
            write(r, range(begin, begin + 100))
            r.flush()
    return path.read_bytes()


def chunks(raw: bytes) -> dict[tuple[int, int], int]:
    """Where chunks begin and end, and how many messages they hold, as the `mcap` package sees it."""
    summary = make_reader(io.BytesIO(raw)).get_summary()
    assert summary is not None
    places = [(c.chunk_start_offset, c.chunk_start_offset + c.chunk_length) for c in summary.chunk_indexes]
    records = [r for r in StreamReader(io.BytesIO(raw), emit_chunks=True).records if isinstance(r, Chunk)]
    return {p: sum(isinstance(m, Message) for m in breakup_chunk(r)) for p, r in zip(places, records, strict=True)}


def messages(recording: Recording) -> Messages:
    return {(m.topic, m.t_ns, m.raw) for m in recording.messages()}


def read(path: Path, *, damaged: bool) -> Recording:
    if not damaged:
        return Recording(path)
    with pytest.warns(RecordingWarning, match="is damaged; all the rest of it is read"):
        return Recording(path)


def test_one_flipped_bit_costs_its_chunk_and_the_original_stays(original: bytes, tmp_path: Path) -> None:
    places = [place for place, count in chunks(original).items() if count == 300]
    raw = bytearray(original)
    raw[sum(places[3]) // 2] ^= 0x10
    path = tmp_path / "mission.mcap"
    path.write_bytes(raw)
    found = read(path, damaged=True)
    (damage,) = found.damage
    assert (damage.begin, damage.end, damage.messages) == (*places[3], 300)  # three topics of 100 ticks
    assert damage.t_ns is not None
    assert damage.t_ns[1] - damage.t_ns[0] == 99 * DT_NS
    assert (found.lost, found.complete) == (300, True)
    assert sum(found.count(topic) for topic in found.channels) == 7201 - 300
    done = recover(path)
    assert (done.messages, [str(d) for d in done.damage]) == (6901, [str(damage)])
    assert path.read_bytes() == bytes(raw)
    assert messages(Recording(done.path)) == messages(found)


def test_in_place_keeps_a_backup_and_nothing_is_overwritten(original: bytes, tmp_path: Path) -> None:
    path, cut = tmp_path / "mission.mcap", original[: len(original) // 2]
    path.write_bytes(cut)
    done = recover(path, in_place=True)
    assert (done.path, done.original) == (path, tmp_path / "mission.mcap.backup")
    assert done.original.read_bytes() == cut
    assert Recording(path).complete
    path.write_bytes(cut)
    with pytest.raises(RecordingError, match=r"backup exists already"):
        recover(path, in_place=True)
    assert path.read_bytes() == cut
    (tmp_path / "other.mcap").write_bytes(b"mine")
    with pytest.raises(RecordingError, match=r"other.mcap exists already"):
        recover(path, tmp_path / "other.mcap")
    assert sorted(p.name for p in tmp_path.iterdir()) == ["mission.mcap", "mission.mcap.backup", "other.mcap"]


@pytest.mark.parametrize("cut", [False, True])
def test_messages_are_known_without_the_chunk_that_declares_them(original: bytes, tmp_path: Path, cut: bool) -> None:
    places, counts = list(chunks(original)), list(chunks(original).values())
    raw = bytearray(original[: places[20][0]] if cut else original)
    raw[sum(places[0]) // 2] ^= 1
    raw[sum(places[1]) // 2] ^= 1
    path = tmp_path / "mission.mcap"
    path.write_bytes(raw)
    with pytest.warns(RecordingWarning):
        found = Recording(path)
    kept = sum(counts[2:20]) if cut else sum(counts[2:])
    assert sum(found.count(topic) for topic in found.channels) == kept
    assert recover(path).messages == kept


def check_flip(
    original: bytes, path: Path, at: int, bit: int, places: dict[tuple[int, int], int], whole: Messages
) -> None:
    """One flipped bit: what is whole is read, the loss is counted, and the original stays."""
    raw = bytearray(original)
    raw[at] ^= 1 << bit
    path.write_bytes(raw)
    found = read(path, damaged=True)
    got = messages(found)
    assert got <= whole
    hit = [p for p in places if p[0] <= at < p[1]]
    assert len(got) == len(whole) or hit, f"byte {at} lies in no chunk"
    assert len(whole) - len(got) in (0, *(places[p] for p in hit)), f"byte {at}, bit {bit}"
    assert found.lost in (len(whole) - len(got), None)
    done = recover(path, path.with_name(f"{at}_{bit}.mcap"))
    assert path.read_bytes() == bytes(raw)
    new = Recording(done.path)
    done.path.unlink()
    assert new.complete
    assert messages(new) == got, f"byte {at}, bit {bit}"


def flips(original: bytes, tmp_path: Path, count: int) -> None:
    path = tmp_path / "run.mcap"
    path.write_bytes(original)
    whole, places = messages(Recording(path)), chunks(original)
    end = len(original)
    draw = random.Random(5)
    heads = [begin + k for begin, _ in list(places)[2:5] for k in range(0, 50, 7)]
    for k in range(count):
        at = heads[k] if k < min(len(heads), count // 2) else draw.randrange(end)
        check_flip(original, path, at, draw.randrange(8), places, whole)


def test_flipped_bits(original: bytes, tmp_path: Path) -> None:
    flips(original, tmp_path, 14)


@pytest.mark.slow
def test_a_thousand_flipped_bits(original: bytes, tmp_path: Path) -> None:
    flips(original, tmp_path, 1000)


@pytest.mark.parametrize("chunked", [False, True])
def test_a_channel_without_a_declaration_is_told_of_once(tmp_path: Path, *, chunked: bool) -> None:
    path = tmp_path / "others.mcap"
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=chunked, chunk_size=40)
        writer.start()
        for k in range(5):
            writer.add_message(7, log_time=k, publish_time=k, data=b"with nobody's schema", sequence=k)
        writer.finish()
    path.write_bytes(path.read_bytes()[:-10])  # a file without its end
    damage = recover(path, tmp_path / "mended.mcap").damage
    assert [d.what for d in damage if "channel 7" in d.what] == ["channel 7, whose declaration is lost"]


def test_messages_outside_of_chunks_keep_their_times(tmp_path: Path) -> None:
    path, mended = tmp_path / "others.mcap", tmp_path / "mended.mcap"
    with path.open("wb") as file:
        writer = Writer(file, use_chunking=False)
        writer.start()
        channel = writer.register_channel("/it", "json", writer.register_schema("it", "jsonschema", b"{}"))
        for k in range(3):
            writer.add_message(channel, log_time=100 + 7 * k, publish_time=900 - k, data=b"{}", sequence=40 + k)
        writer.finish()
    path.write_bytes(path.read_bytes()[:-10])  # a file without its end
    assert recover(path, mended).end_ns == 114
    with mended.open("rb") as file:
        found = [(m.log_time, m.publish_time, m.sequence) for _, _, m in make_reader(file).iter_messages()]
    assert found == [(100, 900, 40), (107, 899, 41), (114, 898, 42)]


def test_a_recording_that_another_process_cuts_ends_at_once(tmp_path: Path) -> None:
    path = tmp_path / "a.mcap"
    r = recorder(path)
    write(r, range(600))
    with path.open("r+b") as file:
        file.truncate(1000)
    with pytest.raises(RecordingError, match="another process changed the recording: it has 1000 bytes"):
        write(r, range(600, 1200))


def test_a_folder_that_vanishes_ends_the_recording_at_once(tmp_path: Path) -> None:
    path = tmp_path / "results" / "a.mcap"
    path.parent.mkdir()
    r = recorder(path)
    write(r, range(600))
    path.unlink()
    path.parent.rmdir()
    with pytest.raises(RecordingError, match="the recording, or its folder, was removed or replaced"):
        write(r, range(600, 1200))

"""Files take the place of files alone: a rename onto a device would take the device away."""

from __future__ import annotations

import errno
import os
import re
from pathlib import Path

import pytest

import pelagos as pl
from pelagos.bridges.rosbag import write_rosbag
from pelagos.cli.main import main
from pelagos.files import give_name, whole, write_whole


@pytest.fixture
def pipe(tmp_path):
    """A pipe, which a rename replaces as it would a device."""
    if not hasattr(os, "mkfifo"):
        pytest.skip("no named pipes on this system")
    path = tmp_path / "pipe"
    os.mkfifo(path)
    return path


def test_a_file_takes_a_files_name_and_no_others(tmp_path, pipe):
    fresh, old, folder = tmp_path / "fresh", tmp_path / "old", tmp_path / "folder"
    old.write_text("old")
    folder.mkdir()
    fresh.write_text("new")
    give_name(fresh, old)
    assert old.read_text() == "new"
    assert not fresh.exists()
    for path, what in ((pipe, "a device or a pipe"), (folder, "a folder")):
        with pytest.raises(FileExistsError, match=f"is {what}, not a file"):
            give_name(old, path)
    assert pipe.is_fifo()
    assert old.read_text() == "new"


def test_a_full_disk_leaves_the_old_text_and_is_told_with_the_name(tmp_path, monkeypatch):
    path = tmp_path / "stats.json"
    write_whole(path, "whole")

    def full(self, text, encoding):
        with self.open("w", encoding=encoding) as file:
            file.write(text[:2])
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(Path, "write_text", full)
    with pytest.raises(OSError, match=re.escape(f"No space left on device: '{path}'")):
        write_whole(path, "another")
    assert [p.name for p in tmp_path.iterdir()] == ["stats.json"]
    assert path.read_text() == "whole"


def test_a_file_that_fails_in_the_middle_leaves_the_old_one_and_errors_of_others_keep_their_names(tmp_path):
    path, other = tmp_path / "film.mp4", tmp_path / "absent.mcap"
    path.write_bytes(b"old")

    def half(raised):
        with whole(path) as fresh:
            fresh.write_bytes(b"half")
            assert (fresh.parent, fresh.suffix) == (path.parent, path.suffix)
            raise raised

    for raised, told in (
        (OSError(errno.ENOSPC, "No space left on device"), str(path)),
        (FileNotFoundError(errno.ENOENT, "No such file or directory", str(other)), str(other)),
    ):
        with pytest.raises(OSError, match=re.escape(raised.strerror)) as caught:
            half(raised)
        assert (caught.value.errno, caught.value.filename) == (raised.errno, told)
    with pytest.raises(ZeroDivisionError):
        half(ZeroDivisionError())
    assert [p.name for p in tmp_path.iterdir()] == ["film.mp4"]
    assert path.read_bytes() == b"old"
    with whole(path) as fresh:
        fresh.write_bytes(b"new")
    assert path.read_bytes() == b"new"
    assert [p.name for p in tmp_path.iterdir()] == ["film.mp4"]


@pytest.mark.usefixtures("small_pictures")
@pytest.mark.parametrize("target", ["sheet.png", "world.glb", "page.html", "world.npz", "statistics.json"])
def test_a_world_that_finds_no_room_leaves_nothing(tmp_path, monkeypatch, capsys, target):
    def give(fresh, path):  # pictures of a sheet and a page lie in a folder of their own first, which has room
        if path.name == target:
            raise OSError(errno.ENOSPC, "No space left on device")
        fresh.rename(path)

    monkeypatch.setattr("pelagos.files.give_name", give)
    scenario = tmp_path / "pond.yaml"
    scenario.write_text("world: {type: flat, depth_m: 7.5}\nagents: {}\n")
    with pytest.raises(SystemExit) as end:
        main(["world", str(scenario), "--out", str(tmp_path / target), "--samples", "1"])
    assert end.value.code == 1
    assert f"error: {tmp_path / target}: No space left on device" in capsys.readouterr().err.replace("\n", "")
    assert [p.name for p in tmp_path.iterdir()] == ["pond.yaml"]


def test_a_bag_that_finds_no_room_leaves_no_folder(tmp_path, monkeypatch):
    writer = pytest.importorskip("rosbags.rosbag2").Writer
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 20}, "agents": {"a": {"vehicle": "remus100"}}})
    with sim.recording(tmp_path / "run.mcap"):
        sim.run(0.5)

    def full(self, *message):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr(writer, "write", full)
    with pytest.raises(OSError, match=re.escape(f"No space left on device: '{tmp_path / 'bag'}'")):
        write_rosbag(tmp_path / "run.mcap", tmp_path / "bag")
    assert [p.name for p in tmp_path.iterdir()] == ["run.mcap"]


def test_recordings_and_checkpoints_leave_a_pipe_where_it_is(pipe):
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 20}, "agents": {"a": {"vehicle": "remus100"}}})
    with pytest.raises(pl.RecordingError, match=re.escape(f"{pipe}: cannot be written: is a device or a pipe")):
        sim.recording(pipe).__enter__()
    sim.step()
    with pytest.raises(pl.RecordingError, match="is a device or a pipe, not a file"):
        sim.checkpoint().save(pipe)
    assert pipe.is_fifo()
    assert not list(pipe.parent.glob("*.part")) + list(pipe.parent.glob(".*"))

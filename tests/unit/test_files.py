"""Files take the place of files alone: a rename onto a device would take the device away."""

from __future__ import annotations

import errno
import os
import re
from pathlib import Path

import pytest

import pelagos as pl
from pelagos.files import give_name, write_whole


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


def test_recordings_and_checkpoints_leave_a_pipe_where_it_is(pipe):
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 20}, "agents": {"a": {"vehicle": "remus100"}}})
    with pytest.raises(pl.RecordingError, match=re.escape(f"{pipe}: cannot be written: is a device or a pipe")):
        sim.recording(pipe).__enter__()
    sim.step()
    with pytest.raises(pl.RecordingError, match="is a device or a pipe, not a file"):
        sim.checkpoint().save(pipe)
    assert pipe.is_fifo()
    assert not list(pipe.parent.glob("*.part")) + list(pipe.parent.glob(".*"))

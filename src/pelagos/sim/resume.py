"""A run that goes on where another process left it: the last checkpoint, and a recording that goes on as one."""

from __future__ import annotations

import os
import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Final

from mcap.opcode import Opcode

from pelagos.errors import RecordingError, RecordingWarning
from pelagos.sim.checkpoint import Checkpoint
from pelagos.sim.mcap_reader import RawRecord, Walk, parse, scan_chunk
from pelagos.sim.mcap_writer import CHANNELS, listed_channels
from pelagos.sim.record import Recorder
from pelagos.sim.run_log import of_the_next_step, open_recorder

if TYPE_CHECKING:
    from pelagos.sim.simulation import Simulation

NEWEST: Final = "checkpoint.npz"
PREVIOUS: Final = "checkpoint.previous.npz"


def keep(sim: Simulation, recorder: Recorder, folder: Path) -> None:
    """Put everything that was recorded on the disk, and then a checkpoint beside it; the one before stays too.

    Raises:
        RecordingError: either cannot be written.
    """
    recorder.sync()
    fresh, newest = folder / "checkpoint.new.npz", folder / NEWEST
    sim.checkpoint().save(fresh)
    try:
        with fresh.open("rb+") as file:
            os.fsync(file.fileno())
        if newest.exists():
            newest.replace(folder / PREVIOUS)
        fresh.replace(newest)
    except OSError as error:
        raise RecordingError(f"{newest}: cannot be written: {error.strerror}") from None


def last_checkpoint(folder: Path) -> Checkpoint:
    """The newest checkpoint in a folder of results that can be read.

    Raises:
        RecordingError: there is none.
    """
    problems = []
    for name in (NEWEST, PREVIOUS):
        try:
            return Checkpoint.load(folder / name)
        except RecordingError as error:
            problems.append(str(error))
    raise RecordingError(f"{folder} holds no checkpoint to go on from: {problems[0]}")


def resumed_recorder(path: Path, sim: Simulation) -> Recorder:
    """A recorder at `path` that holds what the recording there has up to the simulation's time, and goes on.

    What the step from that time on writes down at its beginning, as commands, belongs to what comes.

    The old file stands until the new one holds all of that.

    Raises:
        RecordingError: the old file cannot be read, or the new one not written.
    """
    fresh = path.with_name(f".{path.name}.resumed")
    fresh.unlink(missing_ok=True)
    recorder = open_recorder(fresh, sim)
    try:
        _take_over(path, recorder, sim.time_ns, of_the_next_step(recorder, sim))
        recorder.sync()
        recorder.rename(path)
    except BaseException:
        recorder.close()
        fresh.unlink(missing_ok=True)
        raise
    return recorder


def _take_over(path: Path, recorder: Recorder, until_ns: int, later: set[int]) -> None:
    """Copy what was up to a time, on the channels `later` what was before it."""
    channels: dict[int, int] = {}

    def declare(number: int, topic: str) -> None:
        found = recorder.number(topic)
        if found is not None and topic not in recorder.latched:  # those stand at the beginning of the new file
            channels[number] = found

    def on_record(record: RawRecord) -> None:
        if record.opcode == Opcode.CHANNEL:
            found = parse(record)
            declare(found.id, found.topic)

    try:
        with path.open("rb") as file:
            walk = Walk(file, os.fstat(file.fileno()).st_size)
            for record in walk.records():
                if record.opcode == Opcode.CHUNK:
                    raw = bytes(record.payload)

                    def on_message(channel: int, t_ns: int, start: int, end: int, raw: bytes = raw) -> None:
                        to = channels.get(channel)
                        if to is not None and (t_ns < until_ns or (t_ns == until_ns and to not in later)):
                            recorder.copy(to, t_ns, raw[start:end])

                    scan_chunk(raw, on_message, on_record)
                elif record.opcode == Opcode.ATTACHMENT:
                    found = parse(record)
                    for row in listed_channels(found.data) if found.name == CHANNELS else []:
                        if row["number"] is not None:
                            declare(row["number"], row["topic"])
                else:
                    on_record(record)
    except OSError as error:
        raise RecordingError(f"{path}: cannot be read: {error.strerror}") from None
    for damage in walk.damage:
        warnings.warn(f"{path} is damaged, {damage}; the new recording lacks it", RecordingWarning, stacklevel=3)

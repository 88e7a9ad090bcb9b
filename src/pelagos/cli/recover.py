"""`pelagos recover`: a whole recording from one that was cut off or damaged."""

from __future__ import annotations

from pathlib import Path

from pelagos.cli.console import err, out, shown
from pelagos.errors import NoRecording


def recover_file(path: Path, target: Path | None, *, in_place: bool) -> int:
    """Write the new file and say what is in it, and what is not.

    Returns:
        The exit code: 0, or 1 where a part of the recording could not be read.

    Raises:
        NoRecording: there is no such file, or it is no recording.
        RecordingError: the new file cannot be written.
    """
    from pelagos.sim.replay import recover

    if not path.is_file():
        raise NoRecording(f"{path}: {'is no file' if path.exists() else 'there is no such file'}")
    found = recover(path, target, in_place=in_place)
    what = f"{found.messages} messages of {found.topics} topics, up to {found.end_ns * 1e-9:.2f} s"
    if found.whole:
        unwritten = f"; {shown(target)} was not written" if target is not None else ""
        out.print(f"{shown(found.path)} was whole already: {what}{unwritten}", markup=False)
        return 0
    out.print(f"{shown(found.path)} has everything that could be read: {what}", markup=False)
    out.print(f"{shown(found.original)} is the recording as it was", markup=False)
    for place in found.damage:
        err.print(f"{'lost' if place.messages != 0 else 'no message lost'}: {place}", markup=False, soft_wrap=True)
    return 1 if any(place.messages != 0 for place in found.damage) else 0

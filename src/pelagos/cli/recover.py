"""`pelagos recover`: an index for a recording that was cut off."""

from __future__ import annotations

from pathlib import Path

from pelagos.cli.console import out, shown
from pelagos.errors import RecordingError


def recover_file(path: Path) -> None:
    """Mend the file in place and say what is in it.

    Raises:
        RecordingError: there is no such file, or it is no recording.
    """
    from pelagos.sim.replay import Recording, recover

    if not path.is_file():
        raise RecordingError(f"{path}: there is no such file")
    before = path.stat().st_size
    mended = recover(path)
    recording = Recording(mended)
    messages = sum(recording.count(topic) for topic in recording.channels)
    last_s = max((m.t_ns for m in recording.messages()), default=0) * 1e-9
    state = "was whole already" if mended.stat().st_size == before else "has its index again"
    out.print(
        f"{shown(mended)} {state}: {messages} messages of {len(recording.channels)} topics, up to {last_s:.2f} s",
        markup=False,
    )

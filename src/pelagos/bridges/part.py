"""Part of a recording that is played or copied: some of its topics, between two times."""

from __future__ import annotations

import heapq
import json
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from pelagos.bridges.tap import Channel, Message
from pelagos.errors import InputError
from pelagos.sim.record import LATCHED_KEY, LEGEND
from pelagos.sim.replay import Recorded, Recording


class Part:
    """Messages of a recording, in order of time.

    Attributes:
        channels: topics by number.
        legend: the table of labels as JSON text; empty where the recording has none.
        first_ns: the beginning: the first message that is not latched, for a recording may begin at any time of a run.

    Args:
        path: a recording, whole or cut off, or a rosbag2 folder.
        start_s, end_s: between which times, in simulation time [s].
        only: beginnings of the topics; all where empty.

    Raises:
        InputError: the part cannot be.
        RecordingError: there is no such recording.
    """

    def __init__(
        self, path: str | Path, *, start_s: float = 0.0, end_s: float = float("inf"), only: Sequence[str] = ()
    ) -> None:
        if not 0 <= start_s < end_s:
            raise InputError(f"--from {start_s:g} and --to {end_s:g} hold no time between them")
        self._recording = recording = Recording(file_of(path))
        wanted = tuple(only)
        topics = [t for t in recording.topics() if not wanted or t.startswith(wanted)]
        if not topics:
            raise InputError(f"{path}: no topic begins with {', '.join(wanted)}" if wanted else f"{path}: no messages")
        self.channels = {
            number: Channel(number, topic, found.type, found.about, latched(found.about))
            for number, (topic, found) in enumerate(((t, recording.channels[t]) for t in topics), start=1)
        }
        legend = recording.attachments.get(LEGEND)
        self.legend = "" if legend is None else json.dumps(json.loads(legend))
        times = [recording.times(c.topic) for c in self.channels.values() if not c.latched]
        spans = [(int(t[0]), int(t[-1])) for t in times if len(t)]
        first, last = (min(s[0] for s in spans), max(s[1] for s in spans)) if spans else (0, 0)
        if start_s * 1e9 > last or end_s * 1e9 < first:
            raise InputError(f"{path}: recorded from {first * 1e-9:g} to {last * 1e-9:g} s; nothing is in this part")
        self.first_ns, self._end_s = max(round(start_s * 1e9), first), end_s

    def messages(self) -> Iterator[Message]:
        """All of them; what was latched before the part is said at its beginning."""
        numbers = {channel.topic: number for number, channel in self.channels.items()}
        for recorded in in_time(self._recording, list(numbers)):
            if recorded.t_ns * 1e-9 > self._end_s:
                return
            number = numbers[recorded.topic]
            if recorded.t_ns >= self.first_ns or self.channels[number].latched:
                yield Message(max(recorded.t_ns, self.first_ns), number, recorded.raw)


def latched(about: Mapping[str, str]) -> bool:
    """Whether late joiners want a topic's last message."""
    return "transient_local" in about.get(LATCHED_KEY, "")


def in_time(recording: Recording, topics: Sequence[str]) -> Iterator[Recorded]:
    """Messages of several topics in order of time."""
    return heapq.merge(*(recording.messages(topic) for topic in topics), key=lambda recorded: recorded.t_ns)


def file_of(path: str | Path) -> Path:
    """The recording that is meant: a file, or the one in a rosbag2 folder.

    Raises:
        InputError: a folder with no recording, several, or a bag in another format.
    """
    folder = Path(path)
    if not folder.is_dir():
        return folder
    files = sorted(folder.glob("*.mcap"))
    if (folder / "metadata.yaml").is_file() and len(files) == 1:
        return files[0]
    if files:
        raise InputError(f"{path}: this is a folder; give one of its recordings: {', '.join(map(str, files))}")
    if any(folder.glob("*.db3")):
        raise InputError(f"{path}: this bag is in SQLite; `ros2 bag convert` makes one in MCAP, which can be played")
    raise InputError(f"{path}: this folder holds no recording (.mcap)")

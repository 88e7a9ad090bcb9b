"""Playing a recording out again: the recorded bytes, at their own times, through the doors of a run."""

from __future__ import annotations

import heapq
import time
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from pelagos.bridges.door import TopicDoor
from pelagos.bridges.tap import Channel, Message, Tap
from pelagos.bridges.transport import Transport
from pelagos.errors import InputError
from pelagos.sim.record import LATCHED_KEY, LEGEND
from pelagos.sim.replay import Recorded, Recording

SLICE_NS: Final = 10_000_000
"""Messages of so much simulated time leave together [ns]."""


@dataclass(frozen=True)
class _Present:
    """Time and tick [ns], all that a door asks a simulation for."""

    time_ns: int
    dt_ns: int = SLICE_NS


class Playback:
    """One recording and the transports that it is played to.

    Attributes:
        topics: that are played.

    Args:
        path: the recording, whole or cut off.
        rate: how many times as fast as the clock on the wall; 0 as fast as it goes.
        start_s, end_s: which part, in simulation time [s].
        only: beginnings of the topics that are played; all where empty.

    Raises:
        InputError: the rate or the part cannot be.
        RecordingError: there is no such recording.
    """

    def __init__(
        self,
        path: str | Path,
        *,
        rate: float = 1.0,
        start_s: float = 0.0,
        end_s: float = float("inf"),
        only: Sequence[str] = (),
    ) -> None:
        if not (rate >= 0 and rate < float("inf")):
            raise InputError(f"--rate is how many times as fast as the clock, 0 or more, not {rate:g}")
        if not 0 <= start_s < end_s:
            raise InputError(f"--from {start_s:g} and --to {end_s:g} hold no time between them")
        self._recording = Recording(path)
        self._rate, self._start_ns, self._end_s = rate, round(start_s * 1e9), end_s
        self._doors: list[TopicDoor] = []
        self._tap = Tap()
        wanted = tuple(only)
        self.topics = [t for t in self._recording.topics() if not wanted or t.startswith(wanted)]
        if not self.topics:
            raise InputError(f"{path}: no topic begins with {', '.join(wanted)}" if wanted else f"{path}: no messages")
        self._numbers: dict[str, int] = {}
        for number, topic in enumerate(self.topics, start=1):
            found = self._recording.channels[topic]
            self._numbers[topic] = number
            self._tap.channels[number] = Channel(number, topic, found.type, found.about, _latched(found.about))
        if LEGEND in self._recording.attachments:
            self._tap.attachments[LEGEND] = self._recording.attachments[LEGEND]

    def add(self, transport: Transport, *, clock: bool = True) -> None:
        """Play to a transport too."""
        self._doors.append(TopicDoor(transport, clock=clock))

    def play(self, progress: Callable[[float], None] | None = None) -> int:
        """Play it once; the number of messages. Latched ones are said at the beginning, whatever the part."""
        present: Any = _Present(0)
        for door in self._doors:
            door.open(present, self._tap)
        began, sent = time.perf_counter(), 0
        slice_: list[Message] = []
        until = self._start_ns
        for recorded in in_time(self._recording, self.topics):
            t_ns = recorded.t_ns
            if t_ns * 1e-9 > self._end_s:
                break
            latched = self._tap.channels[self._numbers[recorded.topic]].latched
            if t_ns < self._start_ns and not latched:
                continue
            at = max(t_ns, self._start_ns)
            if at > until and slice_:
                self._send(slice_, until, began)
                sent, slice_ = sent + len(slice_), []
                if progress is not None:
                    progress(until * 1e-9)
            until = max(until, at - at % SLICE_NS + SLICE_NS) if at > until else until
            slice_.append(Message(at, self._numbers[recorded.topic], recorded.raw))
        self._send(slice_, until, began)
        return sent + len(slice_)

    def close(self) -> Counter[str]:
        """Close the transports; what was dropped, by reason."""
        found: Counter[str] = Counter()
        for door in self._doors:
            found.update({f"{door.name}: {reason}": count for reason, count in door.report().items()})
            door.close()
        return found

    def _send(self, messages: list[Message], until_ns: int, began: float) -> None:
        if self._rate and messages:
            due = began + (messages[0].t_ns - self._start_ns) * 1e-9 / self._rate
            time.sleep(max(0.0, due - time.perf_counter()))
        present: Any = _Present(min(until_ns, messages[-1].t_ns) if messages else until_ns)
        for door in self._doors:
            door.send(present, messages)


def _latched(about: Mapping[str, str]) -> bool:
    """Whether late joiners want a topic's last message."""
    return "transient_local" in about.get(LATCHED_KEY, "")


def in_time(recording: Recording, topics: Sequence[str]) -> Iterator[Recorded]:
    """Messages of several topics in order of time."""
    return heapq.merge(*(recording.messages(topic) for topic in topics), key=lambda recorded: recorded.t_ns)


def write_rosbag(recording: str | Path, folder: str | Path) -> int:
    """A recording as a rosbag2 folder (MCAP, metadata version 9) for `ros2 bag`; the number of messages.

    Raises:
        InputError: the folder exists.
        RecordingError: there is no such recording.
    """
    from rosbags.interfaces import Qos, QosDurability, QosHistory, QosLiveliness, QosReliability, QosTime
    from rosbags.rosbag2 import StoragePlugin, Writer

    from pelagos.messages.store import typestore

    if Path(folder).exists():
        raise InputError(f"{folder}: exists already; give another folder")
    source, count = Recording(recording), 0
    never = QosTime(0, 0)
    latched = Qos(
        QosHistory.KEEP_LAST, 1, QosReliability.RELIABLE, QosDurability.TRANSIENT_LOCAL, never, never,
        QosLiveliness.SYSTEM_DEFAULT, never, False,
    )  # fmt: skip
    with Writer(Path(folder), version=9, storage_plugin=StoragePlugin.MCAP) as bag:
        connections = {
            topic: bag.add_connection(
                topic,
                found.type,
                typestore=typestore(),
                offered_qos_profiles=[latched] if _latched(found.about) else [],
            )
            for topic, found in ((t, source.channels[t]) for t in source.topics())
        }
        for recorded in in_time(source, source.topics()):
            bag.write(connections[recorded.topic], recorded.t_ns, recorded.raw)
            count += 1
    return count

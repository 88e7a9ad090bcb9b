"""Playing a recording out again: the recorded bytes, at their own times, through the doors of a run."""

from __future__ import annotations

import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Final

from pelagos.bridges.door import TopicDoor
from pelagos.bridges.part import Part
from pelagos.bridges.tap import Message, Tap
from pelagos.bridges.transport import Stage
from pelagos.errors import InputError
from pelagos.sim.record import LEGEND

SLICE_NS: Final = 10_000_000
"""Messages of so much simulated time leave together [ns]."""
PATIENCE_S: Final = 2.0
"""Time for which readers that do not read are waited for [s]."""
QUIET_S: Final = 0.3
"""Time without a further reader after which all who are there are taken to be found [s]."""
LOOK_S: Final = 0.02
"""Time between two looks for readers [s]."""


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
        part: what is played.
        rate: how many times as fast as the clock on the wall; 0 as fast as it goes.

    Raises:
        InputError: the rate cannot be.
    """

    def __init__(self, part: Part, *, rate: float = 1.0) -> None:
        if not (rate >= 0 and rate < float("inf")):
            raise InputError(f"--rate is how many times as fast as the clock, 0 or more, not {rate:g}")
        self._part, self._rate = part, rate
        self._doors: list[tuple[TopicDoor, Stage]] = []
        self._tap = Tap()
        self.topics = [channel.topic for channel in part.channels.values()]
        self._tap.channels.update(part.channels)
        if part.legend:
            self._tap.attachments[LEGEND] = part.legend.encode()

    def add(self, stage: Stage, *, clock: bool = True) -> None:
        """Play to a transport too."""
        self._doors.append((TopicDoor(stage, clock=clock), stage))

    def wait(self, most_s: float) -> int:
        """Announce the topics, and wait until somebody reads them: a subscriber that is there gets all of it.

        Finding one another takes a while, and each topic is found by itself: it waits until no further reader comes.

        Args:
            most_s: give up after this wall-clock time [s].

        Returns:
            Readers at the end; 0: nobody listens.
        """
        self._open()
        known, since = 0, time.monotonic()
        end = since + most_s
        while time.monotonic() < end:
            found = sum(stage.readers() for _, stage in self._doors)
            if found != known:
                known, since = found, time.monotonic()
            elif known and time.monotonic() - since > QUIET_S:
                break
            time.sleep(LOOK_S)
        return known

    def play(self, progress: Callable[[float], None] | None = None) -> int:
        """Play it once; the number of messages. Latched ones are said at the beginning, whatever the part."""
        self._open()
        began, sent = time.perf_counter(), 0
        slice_: list[Message] = []
        until = self._part.first_ns
        for message in self._part.messages():
            at = message.t_ns
            if at > until:
                if slice_:
                    self._send(slice_, until, began)
                    sent, slice_ = sent + len(slice_), []
                    if progress is not None:
                        progress(until * 1e-9)
                until = at - at % SLICE_NS + SLICE_NS
            slice_.append(message)
        self._send(slice_, until, began)
        for door, stage in self._doors:
            door.drain(PATIENCE_S)
            stage.settle(PATIENCE_S)
        return sent + len(slice_)

    def close(self) -> Counter[str]:
        """Close the transports; what was dropped, by reason."""
        found: Counter[str] = Counter()
        for door, _ in self._doors:
            found.update({f"{door.name}: {reason}": count for reason, count in door.report().items()})
            door.close()
        return found

    def _open(self) -> None:
        present: Any = _Present(0)
        for door, _ in self._doors:
            door.open(present, self._tap)

    def _send(self, messages: list[Message], until_ns: int, began: float) -> None:
        if self._rate and messages:
            due = began + (messages[0].t_ns - self._part.first_ns) * 1e-9 / self._rate
            time.sleep(max(0.0, due - time.perf_counter()))
        present: Any = _Present(min(until_ns, messages[-1].t_ns) if messages else until_ns)
        for door, _ in self._doors:
            door.send(present, messages)
            if not self._rate:
                door.drain(PATIENCE_S)

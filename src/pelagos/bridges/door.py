"""`Door`: one way in and out of a run; and the door of transports that carry messages in CDR."""

from __future__ import annotations

import json
import time
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Final, Protocol

from pelagos.bridges.outbox import Outbox
from pelagos.bridges.tap import STRING, Channel, Message, Tap, text_message
from pelagos.bridges.transport import CLOCK, LATCHED, Qos, Transport, Write
from pelagos.messages.store import make, serialize, stamp
from pelagos.sim.record import LEGEND
from pelagos.sim.simulation import Simulation

CLOCK_TOPIC: Final = "/clock"
CLOCK_TYPE: Final = "rosgraph_msgs/msg/Clock"
CLOCK_HZ: Final = 100.0
BLOCK_S: Final = 1.0
"""A queue takes what a topic says in so much simulated time: without `realtime` half of it leaves in one go [s]."""
LABELS: Final = "/labels"
_LOOK_S: Final = 0.002  # between two looks at a queue
_LARGE: Final = ("sensor_msgs/msg/Image", "sensor_msgs/msg/PointCloud2", "marine_acoustic_msgs/msg/")


class Door(Protocol):
    """Door to a peer as `Exchange` drives it; called by the thread that steps, and never waits for a peer."""

    name: str

    def open(self, sim: Simulation, tap: Tap) -> None:
        """A run begins: tick 0 has not been told yet."""
        ...

    def send(self, sim: Simulation, messages: Sequence[Message]) -> None:
        """A boundary of steps: what was said since the last one, in order of time."""
        ...

    def report(self) -> Mapping[str, int]:
        """Errors, counted, by reason."""
        ...

    def close(self) -> None:
        """No run follows."""
        ...


class Driver(Protocol):
    """Pace of a run, set from outside: an autopilot that shares a clock with the simulation.

    Attributes:
        rate_hz: boundaries in a simulated second at which it meets the simulation; None for every tick.
    """

    name: str
    rate_hz: float | None

    def answer(self, sim: Simulation) -> None:
        """Say what is measured now."""
        ...

    def wait(self, sim: Simulation) -> None:
        """Wait for the next outputs, until the run is stopped."""
        ...

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        ...

    def close(self) -> None:
        """See `Door`."""
        ...


class TopicDoor:
    """Sends every topic of a run, and the clock, over a `Transport`.

    Args:
        transport: what carries them.
        clock: publish /clock.
        only: beginnings of the topics to send; all where empty.
        skip: topics that are not sent.
    """

    def __init__(
        self, transport: Transport, *, clock: bool = True, only: Sequence[str] = (), skip: Sequence[str] = ()
    ) -> None:
        self.name = transport.name
        self.transport = transport
        self.sent = 0
        self._only, self._skip = tuple(only), frozenset(skip)
        self._with_clock = clock
        self._writes: dict[int, Write] = {}
        self._by_topic: dict[str, Write] = {}
        self._outbox = Outbox(transport.name) if transport.blocks else None
        self._clock: Write | None = None
        self._next_clock_ns = 0
        self._clock_ns = round(1e9 / CLOCK_HZ)

    def open(self, sim: Simulation, tap: Tap) -> None:
        """See `Door`; at a second run, topics that stand already are used again."""
        self._writes.clear()
        if self._with_clock:
            self._clock = self._write(CLOCK_TOPIC, CLOCK_TYPE, CLOCK)
            self._clock_ns = max(round(1e9 / CLOCK_HZ), sim.dt_ns)
            self._next_clock_ns = 0
        for channel in tap.channels.values():
            self._add(channel)
        if LEGEND in tap.attachments and self._wanted(LABELS):
            table = json.dumps(json.loads(tap.attachments[LEGEND]))
            self._write(LABELS, STRING, LATCHED)(text_message(table), 0)

    def send(self, sim: Simulation, messages: Sequence[Message]) -> None:
        """See `Door`: the clock goes ahead of what was measured at its time."""
        writes = self._writes
        for t_ns, channel, data in messages:
            if t_ns >= self._next_clock_ns:
                self._tick(t_ns)
            write = writes.get(channel)
            if write is not None:
                write(data, t_ns)
                self.sent += 1
        if messages and sim.time_ns >= self._next_clock_ns:  # without, sensors wait to be read: the clock waits too
            self._tick(sim.time_ns)

    def drain(self, wait_s: float) -> None:
        """Wait until the transport has taken what was sent; for those who are in no hurry. At most so long."""
        end = time.monotonic() + wait_s
        while self._outbox is not None and self._outbox.waiting and time.monotonic() < end:
            time.sleep(_LOOK_S)

    def report(self) -> Mapping[str, int]:
        """See `Door`."""
        found: Counter[str] = Counter()
        if self._outbox is not None:
            found.update({f"{topic}: dropped": k for topic, k in self._outbox.dropped.items()})
            found.update(self._outbox.failed)
        found.update(self.transport.troubles)
        return found

    def close(self) -> None:
        """See `Door`."""
        if self._outbox is not None:
            self._outbox.close()
        self.transport.close()

    def _wanted(self, topic: str) -> bool:
        return topic not in self._skip and (not self._only or topic.startswith(self._only))

    def _add(self, channel: Channel) -> None:
        if self._wanted(channel.topic):
            rate_hz = float(channel.about.get("rate_hz", CLOCK_HZ))
            self._writes[channel.number] = self._write(channel.topic, channel.type, qos_of(channel), rate_hz)

    def _write(self, topic: str, type_name: str, qos: Qos, rate_hz: float = CLOCK_HZ) -> Write:
        if topic not in self._by_topic:
            write = self.transport.advertise(topic, type_name, qos=qos)
            if self._outbox is not None:
                write = self._outbox.lane(topic, write, max(qos.depth, round(rate_hz * BLOCK_S)))
            self._by_topic[topic] = write
        return self._by_topic[topic]

    def _tick(self, t_ns: int) -> None:
        """The clock, at its own rate up to `t_ns`."""
        if self._clock is None:
            self._next_clock_ns = 1 << 62
            return
        at = t_ns - t_ns % self._clock_ns
        if at >= self._next_clock_ns:
            self._clock(clock_message(at), at)
            self._next_clock_ns = at + self._clock_ns


def clock_message(t_ns: int) -> bytes:
    """CDR bytes of rosgraph_msgs/Clock."""
    return serialize(CLOCK_TYPE, make(CLOCK_TYPE, clock=stamp(t_ns)))


def qos_of(channel: Channel) -> Qos:
    """Quality of service of a run's topic: fast ones keep more for a reader that lags, large ones less."""
    if channel.latched:
        return LATCHED
    if channel.topic == "/tf":
        return Qos(depth=100)
    if channel.type.startswith(_LARGE):
        return Qos(depth=5, large=True)
    rate = float(channel.about.get("rate_hz", 50.0))
    return Qos(depth=max(10, round(rate)))

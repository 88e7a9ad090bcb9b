"""A door of topics on its own: when it tells the time, what it leaves out, how long its queues are, a second run."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from types import SimpleNamespace
from typing import Any

import pytest

from pelagos.bridges.door import TopicDoor
from pelagos.bridges.tap import Message, Tap
from pelagos.bridges.transport import MemoryTransport, Qos, Write
from pelagos.messages.store import deserialize
from pelagos.sim.record import LATCHED_KEY, LEGEND

MS = 1_000_000
TEXT = "std_msgs/msg/String"


def at(ms: int, tick_ms: int = 5) -> Any:
    """A simulation, of which a door sees the time and the tick."""
    return SimpleNamespace(time_ns=ms * MS, dt_ns=tick_ms * MS)


def order_of(transport: MemoryTransport) -> list[tuple[float, str]]:
    return [(t_ns / MS, topic) for t_ns, topic in transport.order]


@pytest.mark.parametrize(
    ("tick_ms", "times", "end", "clock"),
    [
        (5, (0, 4, 12, 25, 31, 40), 60, {0: 0, 12: 10, 25: 20, 31: 30, 40: 40, 60: 60}),
        (40, (0, 40, 80, 95, 125), 125, {0: 0, 40: 40, 80: 80, 125: 120}),
    ],
)
def test_the_clock_goes_ahead_at_100_hz_or_at_every_tick(
    tick_ms: int, times: Sequence[int], end: int, clock: dict[int, int]
) -> None:
    """`clock` has the time that is told before what was measured then; the last is that of the boundary."""
    transport, tap = MemoryTransport(), Tap()
    number = tap.declare("/a", TEXT)
    door = TopicDoor(transport)
    door.open(at(0, tick_ms), tap)
    door.send(at(end, tick_ms), [Message(t * MS, number, b"x") for t in times])
    expected: list[tuple[int, str]] = []
    for t in times:
        expected += [(clock[t], "/clock")] if t in clock else []
        expected.append((t, "/a"))
    expected += [] if end in times else [(clock[end], "/clock")]
    assert order_of(transport) == expected
    assert door.sent == len(times)
    last = deserialize("rosgraph_msgs/msg/Clock", transport.written["/clock"][-1][1]).clock
    assert (last.sec, last.nanosec) == (0, max(clock.values()) * MS)
    door.send(at(end + 500, tick_ms), ())  # what was measured since waits to be read, and so does the clock
    assert len(transport.order) == len(expected)


def test_without_a_clock_none_is_announced() -> None:
    transport, tap = MemoryTransport(), Tap()
    number = tap.declare("/a", TEXT)
    door = TopicDoor(transport, clock=False)
    door.open(at(0), tap)
    door.send(at(70), [Message(t * MS, number, b"x") for t in (0, 30, 70)])
    assert order_of(transport) == [(0, "/a"), (30, "/a"), (70, "/a")]
    assert list(transport.types) == ["/a"]


def test_a_second_run_has_its_own_channels_and_its_time_begins_anew() -> None:
    transport, first, second = MemoryTransport(), Tap(), Tap()
    announced: list[str] = []
    advertise = transport.advertise

    def counted(topic: str, type_name: str, *, qos: Qos) -> Write:
        announced.append(topic)
        return advertise(topic, type_name, qos=qos)

    transport.advertise = counted  # type: ignore[method-assign]
    door = TopicDoor(transport, only=("/a",))
    numbers = [first.declare("/a/x", TEXT), first.declare("/b/y", TEXT)]
    swapped = [second.declare("/b/y", TEXT), second.declare("/a/x", TEXT)]
    assert numbers == swapped
    for tap, words in ((first, (b"yes", b"no")), (second, (b"no", b"again"))):
        door.open(at(0), tap)
        door.send(at(17), [Message((7 + n) * MS, n, raw) for n, raw in zip(numbers, words, strict=True)])
    a, b = numbers
    assert transport.written["/a/x"] == [((7 + a) * MS, b"yes"), ((7 + b) * MS, b"again")]
    assert "/b/y" not in transport.written
    assert [t for t, topic in order_of(transport) if topic == "/clock"] == [0, 10, 0, 10]
    assert announced == ["/clock", "/a/x"]


@pytest.mark.parametrize(
    ("only", "skip", "told"),
    [
        ((), (), True),
        (("/labels",), (), True),
        (("/lab", "/b"), (), True),
        (("/a",), (), False),
        ((), ("/labels",), False),
    ],
)
def test_the_table_of_labels_is_said_at_once_where_it_is_wanted(
    only: Sequence[str], skip: Sequence[str], told: bool
) -> None:
    transport, tap = MemoryTransport(), Tap()
    tap.add_attachment(LEGEND, "application/json", b'{\n "3": "rock"}')
    TopicDoor(transport, only=only, skip=skip).open(at(0), tap)
    said = [(t, deserialize(TEXT, raw).data) for t, raw in transport.written.get("/labels", [])]
    assert said == ([(0, '{"3": "rock"}')] if told else [])


class Queues:
    """An outbox that keeps what it is asked for."""

    def __init__(self) -> None:
        self.depths: dict[str, int] = {}
        self.waiting = 0
        self.dropped, self.failed = Counter({"/imu": 3}), Counter({"/eye: OSError": 2})

    def lane(self, topic: str, write: Write, depth: int) -> Write:
        self.depths[topic] = depth
        return write


def queued(transport: MemoryTransport) -> tuple[Any, Queues]:
    door: Any = TopicDoor(transport)
    door._outbox = Queues()
    return door, door._outbox


def test_queues_take_what_a_topic_says_in_a_second() -> None:
    """A reader that lags is kept as many; large messages are few, late joiners of what is latched want the last."""
    transport, tap, asked = MemoryTransport(), Tap(), dict[str, Qos]()
    advertise = transport.advertise

    def kept(topic: str, type_name: str, *, qos: Qos) -> Write:
        asked[topic] = qos
        return advertise(topic, type_name, qos=qos)

    transport.advertise = kept  # type: ignore[method-assign]
    door, queues = queued(transport)
    for topic, kind, about in (
        ("/imu", "sensor_msgs/msg/Imu", {"rate_hz": "250"}), ("/slow", TEXT, {"rate_hz": "4"}), ("/other", TEXT, {}),
        ("/tf", "tf2_msgs/msg/TFMessage", {}), ("/eye", "sensor_msgs/msg/Image", {"rate_hz": "30"}),
        ("/cloud", "sensor_msgs/msg/PointCloud2", {"rate_hz": "2"}),
        ("/still", TEXT, {LATCHED_KEY: "transient_local", "rate_hz": "1"}),
    ):  # fmt: skip
        tap.declare(topic, kind, about)
    door.open(at(0), tap)
    assert {topic: (qos.depth, qos.latched, qos.large) for topic, qos in asked.items()} == {
        "/clock": (1, False, False), "/imu": (250, False, False), "/slow": (10, False, False),
        "/other": (50, False, False), "/tf": (100, False, False), "/eye": (5, False, True),
        "/cloud": (5, False, True), "/still": (1, True, False),
    }  # fmt: skip
    assert queues.depths == {
        "/clock": 100, "/imu": 250, "/slow": 10, "/other": 100, "/tf": 100, "/eye": 30, "/cloud": 5, "/still": 1,
    }  # fmt: skip


def test_a_report_has_what_was_dropped_what_failed_and_what_the_transport_says() -> None:
    transport = MemoryTransport()
    transport.troubles["late"] = 4
    door, _ = queued(transport)
    assert dict(door.report()) == {"/imu: dropped": 3, "/eye: OSError": 2, "late": 4}


@pytest.mark.parametrize(("messages", "took"), [(3, 0.006), (900, 0.5)])
def test_a_door_drains_until_nothing_waits_or_the_time_is_over(
    messages: int, took: float, monkeypatch: pytest.MonkeyPatch
) -> None:
    """By a clock of its own, of which a look takes 2 ms, in which a message goes out."""
    door, queues = queued(MemoryTransport())
    now, queues.waiting = [70.0], messages

    def sleep(seconds: float) -> None:
        now[0] += seconds
        queues.waiting -= 1

    monkeypatch.setattr("pelagos.bridges.door.time", SimpleNamespace(monotonic=lambda: now[0], sleep=sleep))
    door.drain(0.5)
    assert now[0] - 70.0 == pytest.approx(took, abs=2.1e-3)
    assert (queues.waiting == 0) == (messages == 3)

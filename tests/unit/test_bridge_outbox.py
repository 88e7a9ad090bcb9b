"""Queues of a transport that may wait: the order of topics, whose message is dropped, and what is left at the end."""

from __future__ import annotations

import threading
import time
from collections import Counter
from typing import Any

from pelagos.bridges.outbox import Outbox


class Slow:
    """Writes one at a time, each when it is let."""

    def __init__(self) -> None:
        self.let, self.begun = threading.Semaphore(0), threading.Event()
        self.written: list[tuple[str, bytes, int]] = []

    def topic(self, name: str) -> Any:
        def write(raw: bytes, t_ns: int) -> None:
            self.begun.set()
            self.let.acquire()
            self.written.append((name, raw, t_ns))

        return write


def test_topics_take_turns_as_they_came_and_a_full_one_drops_its_own_oldest() -> None:
    troubles: Counter[str] = Counter()
    slow, outbox = Slow(), Outbox("test", troubles=troubles)
    a, b = outbox.lane("/a", slow.topic("a"), 2), outbox.lane("/b", slow.topic("b"), 3)
    a(b"first", 1)
    assert slow.begun.wait(10)  # out of its queue, on its way
    for put, raw, t_ns in (
        (b, b"x", 2), (b, b"y", 3), (a, b"old", 4), (a, b"newer", 5), (a, b"newest", 6), (b, b"z", 7)
    ):  # fmt: skip
        put(raw, t_ns)
    assert (outbox.waiting, outbox.dropped) == (5, {"/a": 1})
    for _ in range(6):
        slow.let.release()
    outbox.close(10.0)
    assert slow.written == [
        ("a", b"first", 1), ("b", b"x", 2), ("b", b"y", 3), ("a", b"newer", 5), ("a", b"newest", 6), ("b", b"z", 7)
    ]  # fmt: skip
    assert (outbox.dropped, dict(troubles), outbox.failed) == ({"/a": 1}, {"/a: dropped": 1}, {})


def test_what_nobody_took_at_the_end_is_counted_and_not_waited_for() -> None:
    slow, outbox = Slow(), Outbox("test")
    a, b = outbox.lane("/a", slow.topic("a"), 5), outbox.lane("/b", slow.topic("b"), 5)
    a(b"on its way", 0)
    assert slow.begun.wait(10)
    for k in range(4):
        a(b"x", k)
    b(b"y", 9)
    begun = time.monotonic()
    outbox.close(0.05)
    assert 0.05 <= time.monotonic() - begun < 5.0
    assert (outbox.waiting, outbox.dropped) == (0, {"/a": 4, "/b": 1})
    slow.let.release()


def test_one_that_fails_holds_up_no_other() -> None:
    """A reason is told by its topic and kind, and counted."""
    outbox, written = Outbox("test"), list[int]()

    def broken(raw: bytes, t_ns: int) -> None:
        raise ValueError("no route" + "!" * 500)

    bad, good = outbox.lane("/bad", broken, 9), outbox.lane("/good", lambda raw, t_ns: written.append(t_ns), 9)
    for k in range(3):
        bad(b"", k)
        good(b"", k)
    outbox.close(10.0)
    ((reason, count),) = outbox.failed.items()
    assert (written, count, reason[:25], len(reason)) == ([0, 1, 2], 3, "/bad: ValueError: no rout", 200)

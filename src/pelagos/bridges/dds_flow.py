"""Large messages over DDS: some go out, and then their readers take them before more follow."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, Final

from pelagos.bridges.transport import Buffer, Write

WINDOW: Final = 2_000_000
"""Bytes that go out before readers are waited for: about what their sockets hold (4 MiB at most, where Linux allows it,
of which the kernel takes half for its own bookkeeping); what is beyond would be lost on the way, and sent again."""
WAITING: Final = 32
"""Messages of one topic that may wait; then the oldest is dropped and counted."""
PATIENCE_NS: Final = 250_000_000
"""Time for readers [ns]: one that lost a datagram asks for it again after 100 ms, by its library's default."""
LOOK_NS: Final = 20_000_000
"""The same for a reader that was too slow when it was last waited for [ns]: it may have stopped."""
RETRY_S: Final = 1.0
"""Time for which nobody is waited for, once a reader was too slow [s]."""


class Flow:
    """A write that waits for readers; for a thread that nobody else depends on.

    A writer that keeps the last `depth` messages drops what a reader has not had yet when more come.

    Args:
        writer: cyclonedds's.
        send: writes one message.
        depth: messages that the writer keeps.
        clock: seconds.
    """

    def __init__(self, writer: Any, send: Write, depth: int, *, clock: Callable[[], float] = time.monotonic) -> None:
        self._writer, self._send, self._depth = writer, send, depth
        self._open = self._bytes = 0
        self._hurry_until = -math.inf
        self._patience_ns = PATIENCE_NS
        self._clock = clock

    def write(self, cdr: Buffer, t_ns: int) -> None:
        """See `Write`."""
        self._send(cdr, t_ns)
        self._open += 1
        self._bytes += memoryview(cdr).nbytes
        if self._open < self._depth and self._bytes < WINDOW:
            return
        self._open = self._bytes = 0
        if self._clock() < self._hurry_until:
            return
        if acknowledged(self._writer, self._patience_ns):
            self._patience_ns = PATIENCE_NS
        else:
            self._patience_ns = LOOK_NS
            self._hurry_until = self._clock() + RETRY_S


def acknowledged(writer: Any, wait_ns: int) -> bool:
    """Wait until every reader has all that was written, at most so long; other threads run meanwhile.

    By the library's private call: in cyclonedds 11.0.1 the public one ends in an AttributeError where time runs out.
    """
    return bool(writer._wait_for_acks(writer._ref, wait_ns) == 0)

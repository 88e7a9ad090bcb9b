"""Large messages over DDS: as many as a writer keeps go out, and then its readers take them before more follow."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any, Final

from pelagos.bridges.transport import Buffer, Write

WAITING: Final = 32
"""Messages of one topic that may wait; then the oldest is dropped and counted."""
PATIENCE_NS: Final = 50_000_000
"""How long readers may take for what a writer keeps [ns]: a stopped one is not waited for longer."""
RETRY_S: Final = 1.0
"""Time for which nobody is waited for, once a reader was too slow [s]."""


class Flow:
    """A write that waits for readers; for a thread that nobody else depends on.

    A writer that keeps the last `depth` messages drops what a reader has not had yet when more come. The library's
    `wait_for_acks` says when all have it, and lets other threads run meanwhile.

    Args:
        writer: cyclonedds's.
        send: writes one message.
        depth: messages that the writer keeps.
        clock: seconds.
    """

    def __init__(self, writer: Any, send: Write, depth: int, *, clock: Callable[[], float] = time.monotonic) -> None:
        self._writer, self._send, self._depth = writer, send, depth
        self._open = 0
        self._hurry_until = -math.inf
        self._clock = clock

    def write(self, cdr: Buffer, t_ns: int) -> None:
        """See `Write`."""
        self._send(cdr, t_ns)
        self._open += 1
        if self._open < self._depth:
            return
        self._open = 0
        if self._clock() < self._hurry_until:
            return
        if not self._writer.wait_for_acks(PATIENCE_NS):
            self._hurry_until = self._clock() + RETRY_S

"""A bounded queue for each topic and one thread that empties them, for transports whose writes may wait for a peer."""

from __future__ import annotations

import threading
from collections import Counter, deque

from pelagos.bridges.transport import Buffer, Write


class Outbox:
    """Writes in a thread of its own; a topic whose queue is full loses its oldest message.

    Attributes:
        dropped: lost messages by topic.
        failed: messages that the transport refused, by reason.

    Args:
        name: of the thread.
        troubles: also counts what is dropped, where given.
    """

    def __init__(self, name: str, *, troubles: Counter[str] | None = None) -> None:
        self._troubles = Counter[str]() if troubles is None else troubles
        self.dropped: Counter[str] = Counter()
        self.failed: Counter[str] = Counter()
        self._queues: dict[str, deque[tuple[Buffer, int]]] = {}
        self._order: deque[tuple[str, Write]] = deque()
        self._change = threading.Condition()
        self._open = True
        self._thread = threading.Thread(target=self._work, name=f"pelagos-{name}", daemon=True)
        self._thread.start()

    def lane(self, topic: str, write: Write, depth: int) -> Write:
        """A write that returns at once."""
        queue = self._queues.setdefault(topic, deque())

        def put(cdr: Buffer, t_ns: int) -> None:
            with self._change:
                if len(queue) >= depth:
                    queue.popleft()
                    self._drop(topic, 1)
                else:
                    self._order.append((topic, write))
                queue.append((cdr, t_ns))
                self._change.notify()

        return put

    @property
    def waiting(self) -> int:
        """Number of messages that wait."""
        return len(self._order)

    def close(self, wait_s: float = 1.0) -> None:
        """Write what waits, for at most `wait_s`; then leave it."""
        with self._change:
            self._open = False
            self._change.notify()
        self._thread.join(timeout=wait_s)
        with self._change:
            for topic, queue in self._queues.items():
                if queue:
                    self._drop(topic, len(queue))
                queue.clear()
            self._order.clear()

    def _drop(self, topic: str, count: int) -> None:
        self.dropped[topic] += count
        self._troubles[f"{topic}: dropped"] += count

    def _work(self) -> None:
        while True:
            with self._change:
                while not self._order:
                    if not self._open:
                        return
                    self._change.wait()
                topic, write = self._order.popleft()
                cdr, t_ns = self._queues[topic].popleft()
            try:
                write(cdr, t_ns)
            except Exception as error:  # a peer's trouble is counted, and never reaches the simulation
                self.failed[f"{topic}: {type(error).__name__}: {error}"[:200]] += 1

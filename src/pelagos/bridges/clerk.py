"""`Clerk`: answers the requests of one service; one that takes long holds up no other service and no command."""

from __future__ import annotations

import threading
from collections import Counter, deque
from collections.abc import Callable
from typing import Final

MOST: Final = 100
"""Requests to one service that wait; what comes beyond is dropped and counted."""


class Clerk:
    """A thread that the first request starts.

    Args:
        name: of the service.
        troubles: counts requests that were dropped, and those that could not be answered.
    """

    def __init__(self, name: str, troubles: Counter[str]) -> None:
        self._name, self._troubles = name, troubles
        self._waiting: deque[Callable[[], None]] = deque()
        self._change = threading.Condition()
        self._open = True
        self._thread: threading.Thread | None = None

    def ask(self, answer: Callable[[], None]) -> None:
        """Have a request answered; returns at once."""
        with self._change:
            if len(self._waiting) >= MOST:
                self._troubles[f"{self._name}: more than {MOST} requests wait"] += 1
                return
            self._waiting.append(answer)
            self._change.notify()
            if self._thread is None:
                self._thread = threading.Thread(target=self._work, name=f"pelagos-{self._name}", daemon=True)
                self._thread.start()

    def close(self) -> None:
        """Answer nothing more; an answer that is on its way is not waited for."""
        with self._change:
            self._open = False
            self._waiting.clear()
            self._change.notify()

    def _work(self) -> None:
        while True:
            with self._change:
                while self._open and not self._waiting:
                    self._change.wait()
                if not self._open:
                    return
                answer = self._waiting.popleft()
            try:
                answer()
            except Exception as error:  # bytes from a network; the next request may be a good one
                self._troubles[f"requests without an answer ({type(error).__name__})"] += 1

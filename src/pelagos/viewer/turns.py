"""Short turns at the interpreter, while a view's threads take part in it."""

from __future__ import annotations

import sys
from typing import Final

TURN_S: Final = 0.0002
"""Time that a thread which has the interpreter may keep it while another waits [s]; Python's own 5 ms are longer than
most calls of the device, each of which gives the interpreter up and asks for it again: with them a view's work of
16 ms costs the thread that steps 30 ms, with these about as much as it is."""


class ShortTurns:
    """While it is open, threads take turns of `TURN_S` at most."""

    def __init__(self) -> None:
        self._was: float | None = None

    def open(self) -> None:
        """From now on."""
        self._was = sys.getswitchinterval()
        sys.setswitchinterval(min(self._was, TURN_S))

    def close(self) -> None:
        """As it was before."""
        if self._was is not None:
            sys.setswitchinterval(self._was)
            self._was = None

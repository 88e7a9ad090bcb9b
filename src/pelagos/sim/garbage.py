"""Cyclic garbage of a simulation that other threads have a part in: the thread that steps alone collects it.

Python collects in whichever thread makes an object, and what it lets go of may be an array of the device. That takes
the device's lock, which the thread that steps may have while it waits for the interpreter's: both would wait for ever.
"""

from __future__ import annotations

import gc
import time
from typing import Final

EVERY_S: Final = 0.1
"""Wall-clock time between two collections, at least."""
_SOME: Final = 10  # collections between two of the middle generation
_FULL: Final = 600  # and of all


class StepperCollects:
    """While it is open, cyclic garbage is collected by `collect` alone."""

    def __init__(self) -> None:
        self._was = False
        self._count = 0
        self._at = 0.0

    def open(self) -> None:
        """From now on."""
        self._was = gc.isenabled()
        gc.disable()

    def collect(self) -> None:
        """Collect, if it is time; called by the thread that steps."""
        now = time.monotonic()
        if now - self._at < EVERY_S:
            return
        self._at = now
        self._count += 1
        gc.collect(2 if self._count % _FULL == 0 else int(self._count % _SOME == 0))

    def close(self) -> None:
        """As it was before."""
        if self._was:
            gc.enable()

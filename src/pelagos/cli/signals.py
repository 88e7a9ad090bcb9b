"""Signals that ask a command to end: Ctrl-C, SIGTERM and SIGHUP end a run in order, however often they come."""

from __future__ import annotations

import os
import signal
import sys
import threading
import time
from collections.abc import Callable
from types import FrameType, TracebackType
from typing import Any, Final, Self

NAMES: Final = ("SIGINT", "SIGTERM", "SIGHUP", "SIGBREAK")  # those that the system has
PATIENCE: Final = 5  # signals that are answered in words; the next one ends the process
SIGNAL_CODE: Final = 128  # exit code of a process that a signal ended, less the signal's number

_OF_A_RUN: Final = "ending the run", "the run is being ended: index, report and statistics are on their way"


def leave_at_once() -> None:
    """From now on a signal ends this process on the spot: nothing has been written yet that could be lost.

    A KeyboardInterrupt would be raised within whatever runs: where native code has called back, as imports and the
    recording of kernels do, that can end in `std::terminate`.
    """
    for number in _numbers():
        if signal.getsignal(number) is not signal.SIG_IGN:  # as nohup asks
            signal.signal(number, _leave)


def _leave(number: int, frame: FrameType | None) -> None:
    os._exit(SIGNAL_CODE + number)


def _numbers() -> set[int]:
    return {getattr(signal, name) for name in NAMES if hasattr(signal, name)}


class Stopping:
    """Takes signals within a `with` block of the main thread.

    While nothing runs, the first signal raises KeyboardInterrupt, or ends the process after `leave_at_once`. From
    `guard` on it calls what `guard` was given, and all that follow say that the end is on its way: index, report and
    statistics are written.

    Args:
        max_wall_s: the command may take this long.
        words: what Ctrl-C is answered with, the first time and after it.

    Attributes:
        signal: the first that came, None so far.
        overdue: the wall-clock time that the command may take is over.
    """

    def __init__(self, *, max_wall_s: float | None = None, words: tuple[str, str] = _OF_A_RUN) -> None:
        self.signal: int | None = None
        self.overdue = False
        self._words = words
        self._stop: Callable[[], object] | None = None
        self._count = 0
        self._ends = None if max_wall_s is None else time.monotonic() + max_wall_s
        self._timer: threading.Timer | None = None
        self._before: dict[int, Any] = {}

    @property
    def asked(self) -> bool:
        """The command is to end."""
        return self.signal is not None or self.overdue

    @property
    def exit_code(self) -> int:
        """0, or that of a process which the signal ended: 130 for Ctrl-C, 143 for SIGTERM, 129 for SIGHUP."""
        return 0 if self.signal is None else SIGNAL_CODE + self.signal

    def guard(self, stop: Callable[[], object]) -> None:
        """From now on, end by calling `stop`; at once, where the time is over."""
        self._stop = stop
        if self._ends is not None:
            self._timer = threading.Timer(max(self._ends - time.monotonic(), 0.0), self._time_over)
            self._timer.daemon = True
            self._timer.start()

    def _time_over(self) -> None:
        self.overdue = True
        if self._stop is not None:
            self._stop()

    def _take(self, number: int, frame: FrameType | None) -> None:
        self._count += 1
        first, self.signal = self.signal is None, number if self.signal is None else self.signal
        if self._stop is None and self._before.get(number) is _leave:
            _leave(number, frame)
        if self._stop is None or self._count > PATIENCE:
            raise KeyboardInterrupt
        self._stop()
        if number == signal.SIGINT:  # others come from programs
            sys.stderr.write(f"\n{self._words[not first]}\n")

    def __enter__(self) -> Self:
        if threading.current_thread() is threading.main_thread():
            for number in _numbers():
                if signal.getsignal(number) is not signal.SIG_IGN:  # as nohup asks
                    self._before[number] = signal.signal(number, self._take)
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._timer is not None:
            self._timer.cancel()
        for number, handler in self._before.items():
            signal.signal(number, handler)


def interrupted(error: BaseException | None) -> bool:
    """Ctrl-C is behind an error: Dr.Jit turns what is raised while it records a kernel into an error of its own."""
    seen: set[int] = set()
    while error is not None and id(error) not in seen:
        if isinstance(error, KeyboardInterrupt) or "KeyboardInterrupt" in str(error):
            return True
        seen.add(id(error))
        error = error.__cause__ or error.__context__
    return False

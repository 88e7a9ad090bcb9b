"""Keeping to the clock on the wall, and how well that was done."""

from __future__ import annotations

import time
from typing import Final

import numpy as np

SPIN_S: Final = 0.0005
"""The end of a wait is spent looking at the clock: a sleep alone comes late by up to this much [s]."""
LOST_S: Final = 0.25
"""A run that lags by more than this begins to count anew, instead of hurrying after the clock [s]."""


def next_ns(now_ns: int, rate_hz: float) -> int:
    """First multiple of a rate's period after a time [ns]: the rate is kept in the mean where boundaries miss it."""
    period = round(1e9 / rate_hz)
    return now_ns - now_ns % period + period


class Pace:
    """Waits at boundaries of steps.

    Attributes:
        factor: how many times as fast as the clock; 0 does not wait at all.
        late: how late each boundary was [s].
        lost_s: time by which the run fell behind the clock for good [s].
    """

    def __init__(self, factor: float) -> None:
        self.factor = factor
        self.late: list[float] = []
        self.lost_s = 0.0
        self._from = (0, time.perf_counter())

    def restart(self, t_ns: int) -> None:
        """Count from now."""
        self._from = (t_ns, time.perf_counter())

    def keep(self, t_ns: int) -> None:
        """Wait until simulation time `t_ns` is due."""
        if not self.factor:
            return
        start_ns, start = self._from
        due = start + (t_ns - start_ns) * 1e-9 / self.factor
        ahead = due - time.perf_counter()
        if ahead > SPIN_S:
            time.sleep(ahead - SPIN_S)
        while time.perf_counter() < due:
            pass
        late = time.perf_counter() - due
        if late > LOST_S:
            self.lost_s += late
            self.restart(t_ns)
        self.late.append(late)

    def jitter_ms(self) -> tuple[float, float, float]:
        """Median, 99th percentile and greatest lateness of a boundary [ms]."""
        if not self.late:
            return 0.0, 0.0, 0.0
        p50, p99, worst = np.percentile(np.array(self.late), [50, 99, 100]) * 1e3
        return float(p50), float(p99), float(worst)

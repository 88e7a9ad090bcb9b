"""Time is a whole number of nanoseconds, and advances by whole ticks."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cached_property


@dataclass(frozen=True)
class Clock:
    """The tick of a run.

    Attributes:
        tick_rate_hz: ticks per second [Hz].
        dt_ns: one tick [ns].
    """

    tick_rate_hz: float

    @cached_property
    def dt_ns(self) -> int:
        """One tick [ns], rounded to a whole nanosecond (a rate such as 30 Hz has no exact one)."""
        return round(1e9 / self.tick_rate_hz)

    def ticks(self, seconds: float) -> int:
        """The number of ticks that cover `seconds`."""
        return math.ceil(round(seconds * 1e9) / self.dt_ns)

    def period(self, rate_hz: float) -> int:
        """Ticks between two samples at `rate_hz`, which is known to divide the tick rate."""
        return max(1, round(self.tick_rate_hz / rate_hz))


def next_multiple(tick: int, periods: Iterable[int], last: int) -> int:
    """The first tick after `tick`, at most `last`, at which one of `periods` falls due."""
    return min([last, *((tick // p + 1) * p for p in periods)])

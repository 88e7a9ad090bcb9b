"""Timing of one call."""

from __future__ import annotations

import time
from collections.abc import Callable


def seconds(call: Callable[[], object], *, at_least_s: float = 1.0, warm_up: int = 3) -> float:
    """The median wall-clock time of a call [s], measured over at least `at_least_s` and five calls."""
    (found,) = seconds_in_turns(call, at_least_s=at_least_s, warm_up=warm_up)
    return found


def seconds_in_turns(*calls: Callable[[], object], at_least_s: float = 1.0, warm_up: int = 3) -> list[float]:
    """The same of several calls that take turns, so that what slows the machine for a while slows all of them."""
    for _ in range(warm_up):
        for call in calls:
            call()
    times: list[list[float]] = [[] for _ in calls]
    while min(map(sum, times)) < at_least_s or len(times[0]) < 5:
        for call, took in zip(calls, times, strict=True):
            start = time.perf_counter()
            call()
            took.append(time.perf_counter() - start)
    return [sorted(took)[len(took) // 2] for took in times]

"""How long one call takes."""

from __future__ import annotations

import time
from collections.abc import Callable


def seconds(call: Callable[[], object], *, at_least_s: float = 1.0, warm_up: int = 3) -> float:
    """The median wall-clock time of a call [s], measured over at least `at_least_s` and five calls."""
    for _ in range(warm_up):
        call()
    times: list[float] = []
    while sum(times) < at_least_s or len(times) < 5:
        start = time.perf_counter()
        call()
        times.append(time.perf_counter() - start)
    return sorted(times)[len(times) // 2]

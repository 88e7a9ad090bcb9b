"""Wall-clock time by part of the step loop."""

from __future__ import annotations

import time
from dataclasses import dataclass, field


@dataclass
class Timings:
    """Wall-clock seconds and number of calls, by part of the loop."""

    seconds: dict[str, float] = field(default_factory=dict)
    calls: dict[str, int] = field(default_factory=dict)

    def add(self, part: str, start: float) -> None:
        """Count the time since `start`."""
        self.seconds[part] = self.seconds.get(part, 0.0) + time.perf_counter() - start
        self.calls[part] = self.calls.get(part, 0) + 1

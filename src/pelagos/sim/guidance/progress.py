"""Progress of every copy in its mission: arrays, one row a lane."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final, Self

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats

MEMORY: Final = 6


@dataclass
class Progress:
    """Rows of lanes.

    Attributes:
        task: `(n,)` number of the present task; the count of tasks when all are done.
        since_s: `(n,)` when it began [s].
        start: `(n, 3)` where it began, NWU [m].
        heading: `(n,)` compass heading then [rad].
        depth: `(n,)` the last depth set-point [m]; not a number before the first.
        memory: `(n, MEMORY)` what the task keeps; 0 when it begins.
    """

    task: NDArray[np.int64]
    since_s: Floats
    start: Floats
    heading: Floats
    depth: Floats
    memory: Floats

    @classmethod
    def begin(cls, aboard: Aboard) -> Self:
        """At the first task."""
        n = len(aboard)
        return cls(
            task=np.zeros(n, dtype=np.int64),
            since_s=np.full(n, aboard.t_s),
            start=aboard.own.position.copy(),
            heading=aboard.own.heading.copy(),
            depth=np.full(n, np.nan),
            memory=np.zeros((n, MEMORY)),
        )

    def take(self, lanes: NDArray[np.intp]) -> Progress:
        """Some lanes, as a copy."""
        return Progress(
            self.task[lanes], self.since_s[lanes], self.start[lanes], self.heading[lanes], self.depth[lanes],
            self.memory[lanes],
        )  # fmt: skip

    def move(self, lanes: NDArray[np.intp], to: NDArray[np.int64], aboard: Aboard) -> None:
        """Begin other tasks; `aboard`: of all lanes."""
        self.task[lanes] = to
        self.since_s[lanes] = aboard.t_s
        self.start[lanes] = aboard.own.position[lanes]
        self.heading[lanes] = aboard.own.heading[lanes]
        self.memory[lanes] = 0.0

    def copy(self) -> Progress:
        """A copy that shares nothing."""
        return self.take(np.arange(len(self.task)))

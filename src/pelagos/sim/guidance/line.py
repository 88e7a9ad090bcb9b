"""The task of following a line to its end."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.task import Common, blank


@dataclass(frozen=True)
class Line:
    """Attributes: end, start: (x, y) [m], start None: from where the task begins; acceptance_m: done within this of the
    end, or past it; exact: only within it, at the level's depth too, where the vehicle stops; again: the distance
    counts the depth, and a vehicle that passed the end without having been within goes back by so many tasks.
    """

    end: tuple[float, float]
    start: tuple[float, float] | None = None
    acceptance_m: float = 3.0
    exact: bool = False
    again: int = 0
    common: Common = field(default_factory=Common)

    def _ends(self, progress: Progress) -> tuple[Floats, Floats]:
        zero = np.zeros((len(progress.start), 2))
        return progress.start[:, :2] if self.start is None else zero + self.start, zero + self.end

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        start, end = self._ends(progress)
        along = end - start
        length = np.hypot(along[:, 0], along[:, 1])
        left = end - aboard.xy
        to_go = (left[:, 0] * along[:, 0] + left[:, 1] * along[:, 1]) / np.where(length > 0, length, 1.0)
        distance = np.hypot(left[:, 0], left[:, 1])
        if self.again and self.common.level.depth_m is not None:
            distance = np.hypot(distance, aboard.depth - self.common.level.depth_m)
        near = distance < self.acceptance_m
        past = to_go < 0.0
        if self.exact or self.again:
            near &= self.common.level.reached(aboard, max(self.acceptance_m, 0.2))
        if self.exact:
            return near.astype(np.int64)
        if self.again:
            return np.where(near, 1, np.where(past, -self.again, 0)).astype(np.int64)
        return np.asarray(near | past, dtype=np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.path[:] = Path.LINE
        goal.start, goal.end = self._ends(progress)
        goal.stops[:] = self.exact
        return goal

"""Tasks that pass time: hold a course, keep a station, drift, wait for a fix."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.task import Common, blank
from pelagos.sim.guidance.vertical import SURFACED_DEPTH_M

FIXES: Final = 3  # a position is taken as fixed after this many


@dataclass(frozen=True)
class Hold:
    """Heading and depth as they are, for a time [s]."""

    seconds: float
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        return (aboard.t_s - progress.since_s >= self.seconds).astype(np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.path[:] = Path.COURSE
        goal.course = progress.heading.copy()
        goal.end = progress.start[:, :2].copy()
        return goal


@dataclass(frozen=True)
class GpsFix:
    """Wait at the surface for `FIXES` fixes, at most so long [s]; rises: a vehicle that has sunk, as a neutral one does
    that comes to rest with its back dry, drives up again; memory: fixes.
    """

    seconds: float
    rises: bool = False
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        progress.memory[:, 0] += aboard.fixed
        late = aboard.t_s - progress.since_s >= self.seconds
        return ((progress.memory[:, 0] >= FIXES) | late).astype(np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.path[:] = Path.COURSE
        goal.course = progress.heading.copy()
        goal.end = progress.start[:, :2].copy()
        goal.speed = np.where(self.rises & (aboard.depth > SURFACED_DEPTH_M), goal.speed, 0.0)
        return goal


@dataclass(frozen=True)
class Station:
    """Stay at (x, y) [m], or where the task began, for a time [s]; radius_m: of the circle of those who cannot stop."""

    seconds: float | None
    point: tuple[float, float] | None = None
    radius_m: float | None = None
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        return _over(self.seconds, aboard, progress)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.start = progress.start[:, :2].copy()
        goal.end = goal.start.copy() if self.point is None else np.zeros((len(aboard), 2)) + self.point
        goal.face = np.where(np.isnan(goal.face), progress.heading, goal.face)
        if self.radius_m is not None:
            goal.radius[:] = self.radius_m
        return goal


@dataclass(frozen=True)
class Drift:
    """No way of one's own, for a time [s]."""

    seconds: float | None
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        return _over(self.seconds, aboard, progress)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.path[:] = Path.DRIFT
        goal.course = progress.heading.copy()
        goal.face = progress.heading.copy()
        goal.speed[:] = 0.0
        return goal


def _over(seconds: float | None, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
    """Whether a time is over."""
    limit = np.inf if seconds is None else seconds
    return (aboard.t_s - progress.since_s >= limit).astype(np.int64)

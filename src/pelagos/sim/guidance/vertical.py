"""Tasks up and down: a dive, coming up, the yo-yo of a profile, landing."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.task import Common, blank

LEVEL_TOLERANCE_M: Final = 1.0  # a dive is over within this of its depth
SURFACED_DEPTH_M: Final = 0.35
TURN_TOLERANCE_M: Final = 0.5  # a profile turns when this near to its depth
LANDED_S: Final = 3.0  # a vehicle that sinks slower than a quarter of what it wants to for this long has landed


@dataclass(frozen=True)
class Dive:
    """To a level at the present heading; `surface`: until the vehicle is at the surface."""

    surface: bool = False
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        if self.surface:
            return (aboard.depth < SURFACED_DEPTH_M).astype(np.int64)
        return self.common.level.reached(aboard, LEVEL_TOLERANCE_M).astype(np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.path[:] = Path.COURSE
        goal.course = progress.heading.copy()
        goal.end = progress.start[:, :2].copy()
        return goal


@dataclass(frozen=True)
class Profile:
    """Between two depths [m], `cycles` times, at a heading [rad] or towards a point (x, y) [m]; memory: 1 while going
    up, cycles done.
    """

    upper_m: float
    lower_m: float
    cycles: int | None = None
    heading_rad: float | None = None
    point: tuple[float, float] | None = None
    acceptance_m: float = 10.0
    glide_rad: float = 0.44
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        up = progress.memory[:, 0] > 0
        at_bottom = ~up & (aboard.depth > self.lower_m - TURN_TOLERANCE_M)
        at_top = up & (aboard.depth < self.upper_m + TURN_TOLERANCE_M)
        progress.memory[:, 0] = np.where(at_bottom, 1.0, np.where(at_top, 0.0, progress.memory[:, 0]))
        progress.memory[:, 1] += at_top
        done = np.zeros(len(aboard), dtype=bool)
        if self.cycles is not None:
            done |= progress.memory[:, 1] >= self.cycles
        if self.point is not None:
            done |= np.hypot(*(np.array(self.point) - aboard.xy).T) < self.acceptance_m
        return done.astype(np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        if self.point is None:
            goal.path[:] = Path.COURSE
            goal.course = (
                progress.heading.copy() if self.heading_rad is None else np.full(len(aboard), self.heading_rad)
            )
            goal.end = progress.start[:, :2].copy()
        else:
            goal.path[:] = Path.LINE
            goal.start = progress.start[:, :2].copy()
            goal.end[:] = self.point
        goal.depth = np.where(progress.memory[:, 0] > 0, self.upper_m, self.lower_m)
        goal.upper[:] = self.upper_m
        goal.glide[:] = self.glide_rad
        return goal


@dataclass(frozen=True)
class Land:
    """Down at a speed [m/s] until something holds the vehicle; memory: since when it has been held [s]."""

    point: tuple[float, float] | None
    sink_mps: float
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        begun = aboard.t_s - progress.since_s > LANDED_S
        held = begun & (-aboard.own.velocity[:, 2] < 0.25 * self.sink_mps)
        progress.memory[:, 0] = np.where(held, progress.memory[:, 0] + aboard.dt_s, 0.0)
        return (progress.memory[:, 0] > LANDED_S).astype(np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.end = progress.start[:, :2].copy() if self.point is None else np.zeros((len(aboard), 2)) + self.point
        goal.face = progress.heading.copy()
        goal.depth = aboard.depth + 5.0 * self.sink_mps  # always below
        goal.sink[:] = self.sink_mps
        return goal

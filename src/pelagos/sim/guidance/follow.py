"""Tasks that follow something that is not known beforehand: another vehicle, a wall."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats, ahead, wrapped
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.task import Common, blank

CATCH_UP_PER_S: Final = 0.15  # speed beyond the other's by distance behind the place to keep
MOVING_MPS: Final = 0.15  # another vehicle that is slower has no course
AHEAD_M: Final = 50.0  # length of the line along which a moving vehicle is followed
WALL_TIME_S: Final = 4.0  # the wall's direction is known as the mean over this
STEEPEST_RAD: Final = 0.7  # largest angle at which a wall is approached


@dataclass(frozen=True)
class FollowAgent:
    """Keep a place (ahead, left, up) [m] beside another agent, for a time [s]; of a squad a place a lane `(m, 3)`."""

    agent: str
    offset_m: tuple[float, float, float] | Floats
    seconds: float | None
    top_mps: float
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        limit = np.inf if self.seconds is None else self.seconds
        return (aboard.t_s - progress.since_s >= limit).astype(np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`: its place where it lies still, and a line along its way where it moves."""
        goal = blank(self.common, aboard)
        other = aboard.others[self.agent]
        forward, left = ahead(other.heading), ahead(other.heading - np.pi / 2)
        along_it, beside_it, above_it = np.broadcast_to(self.offset_m, (len(aboard), 3)).T[..., None]
        place = other.position[:, :2] + along_it * forward + beside_it * left
        way = other.velocity[:, :2]
        speed = np.hypot(way[:, 0], way[:, 1])
        moving = speed > MOVING_MPS
        along = np.where(moving[:, None], way, forward) / np.where(moving, speed, 1.0)[:, None]
        behind = ((place - aboard.xy) * along).sum(axis=1)
        goal.path = np.where(moving, Path.LINE, Path.POINT)
        goal.start = np.where(moving[:, None], place - AHEAD_M * along, aboard.xy)
        goal.end = np.where(moving[:, None], place + AHEAD_M * along, place)
        goal.speed = np.where(
            moving, np.clip(speed + CATCH_UP_PER_S * behind, 0.05, self.top_mps), self.common.speed_mps
        )
        goal.stops = ~moving
        goal.face = np.where(np.isnan(goal.face), other.heading, goal.face)
        if self.common.level.depth_m is None and self.common.level.altitude_m is None:
            goal.depth = -other.position[:, 2] - above_it[:, 0]
        return goal


@dataclass(frozen=True)
class FollowWall:
    """Along a wall that a ranging sensor sees abeam, at a distance [m]; side: 1 to port, -1 to starboard.

    The wall's direction follows from how the range changes on the way. Memory: 1 once that is known, the direction
    [rad], the last range [m].
    """

    key: str
    side: float
    distance_m: float
    seconds: float | None
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        self._look(aboard, progress)
        limit = np.inf if self.seconds is None else self.seconds
        return (aboard.t_s - progress.since_s >= limit).astype(np.int64)

    def _look(self, aboard: Aboard, progress: Progress) -> None:
        memory, distance = progress.memory, aboard.readings[self.key][:, 0]
        seen = np.isfinite(distance)
        first = memory[:, 0] == 0
        way = aboard.own.velocity[:, :2]
        speed = np.hypot(way[:, 0], way[:, 1])
        course = np.where(speed > MOVING_MPS, np.arctan2(-way[:, 1], way[:, 0]), aboard.own.heading)
        rate = np.where(seen & ~first & (memory[:, 2] > 0), (distance - memory[:, 2]) / aboard.dt_s, 0.0)
        apart = np.arcsin(np.clip(rate / np.maximum(speed, MOVING_MPS), -0.9, 0.9))
        wall = course - self.side * apart
        share = np.where(seen & (memory[:, 2] > 0), aboard.dt_s / WALL_TIME_S, 0.0)
        memory[:, 1] = np.where(first, progress.heading, wrapped(memory[:, 1] + share * wrapped(wall - memory[:, 1])))
        memory[:, 0] = 1.0
        memory[:, 2] = np.where(seen, distance, 0.0)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        distance = np.where(progress.memory[:, 2] > 0, progress.memory[:, 2], self.distance_m + 2.0)
        lean = np.clip((distance - self.distance_m) / max(self.distance_m, 2.0), -STEEPEST_RAD, STEEPEST_RAD)
        goal.course = progress.memory[:, 1] - self.side * lean
        goal.path[:] = Path.LINE
        goal.start = aboard.xy.copy()
        goal.end = aboard.xy + AHEAD_M * ahead(goal.course)
        goal.face = np.where(np.isnan(goal.face), progress.memory[:, 1], goal.face)
        goal.stops[:] = False
        return goal

"""A task: the elementary part of a mission, one and the same for all copies."""

from __future__ import annotations

from collections.abc import Hashable, Sequence
from dataclasses import dataclass, field, fields, replace
from typing import Final, Protocol

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats
from pelagos.sim.guidance.goal import Goal
from pelagos.sim.guidance.progress import Progress


@dataclass(frozen=True)
class Level:
    """The vertical part of a task: a depth (negative: a height), an altitude, or neither: the depth as it is.

    Attributes:
        depth_m: below the mean sea surface [m].
        altitude_m: above the seabed [m].
    """

    depth_m: float | None = None
    altitude_m: float | None = None

    def reached(self, aboard: Aboard, tolerance_m: float) -> NDArray[np.bool_]:
        """`(m,)` whether vehicles are there."""
        if self.altitude_m is not None:
            return np.abs(aboard.altitude - self.altitude_m) < tolerance_m
        if self.depth_m is None:
            return np.ones(len(aboard), dtype=bool)
        return np.abs(aboard.depth - self.depth_m) < tolerance_m


@dataclass(frozen=True)
class Limit:
    """A reading that ends a leg, see `config.mission.Until`; key: of `Aboard.readings`."""

    key: str
    component: int
    above: float | None
    below: float | None

    def met(self, aboard: Aboard) -> NDArray[np.bool_]:
        """`(m,)` whether the reading is beyond the limit."""
        values = aboard.readings[self.key]
        value = values[:, self.component] if self.component < values.shape[1] else np.full(len(values), np.nan)
        over = np.zeros(len(value), dtype=bool)
        with np.errstate(invalid="ignore"):
            if self.above is not None:
                over |= value > self.above
            if self.below is not None:
                over |= value < self.below
        return over


@dataclass(frozen=True)
class Common:
    """Parts that every task has.

    Attributes:
        level: depth or altitude.
        speed_mps: set-point of speed [m/s].
        face_rad: compass heading of those who turn on the spot [rad]; None: along the way.
        face_point: (x, y) [m] that they look at instead.
        until: a reading that ends the leg.
    """

    level: Level = field(default_factory=Level)
    speed_mps: float = 1.5
    face_rad: float | None = None
    face_point: tuple[float, float] | None = None
    until: Limit | None = None

    def facing(self, aboard: Aboard) -> Floats:
        """`(m,)` heading to look at [rad]; not a number: along the way."""
        if self.face_point is not None:
            to = np.array(self.face_point) - aboard.xy
            return np.asarray(np.arctan2(-to[:, 1], to[:, 0]))
        return np.full(len(aboard), np.nan if self.face_rad is None else self.face_rad)


class Task(Protocol):
    """An elementary task; both functions take rows of the lanes that are at it."""

    @property
    def common(self) -> Common:
        """Level, speed, where to look, what ends it."""
        ...

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """`(m,)` how many tasks on (1 done, 0 not yet, -1 back); may write `progress.memory`."""
        ...

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """Present goal; the depth is set by the mission, from the task's level, where the goal's is NaN."""
        ...


PLACES: Final = ("end", "start", "point", "center", "offset_m")
"""Keys of tasks that are places [m]; of a squad's tasks a row a lane, `(m, 2)`, of an offset `(m, 3)`."""
FOLLOWED: Final = "agent"
"""Key of a task that follows another agent; of a squad's tasks it stands for the one of each member."""


def shape(task: Task) -> Hashable:
    """A task but for its places and whom it follows: equal for tasks that may be put together."""
    values = {f.name: getattr(task, f.name) for f in fields(task)}  # type: ignore[arg-type]
    own = (*PLACES, FOLLOWED)
    return type(task), tuple((key, value is None if key in own else value) for key, value in values.items())


def together(tasks: Sequence[Task], n: int) -> Task:
    """A task for the lanes of several agents, n each, whose tasks are of one shape."""
    own = {key: [getattr(task, key) for task in tasks] for key in PLACES if getattr(tasks[0], key, None) is not None}
    rows = {key: np.repeat(np.array(places, dtype=np.float64), n, axis=0) for key, places in own.items()}
    return replace(tasks[0], **rows)  # type: ignore[type-var]


def taken(task: Task, lanes: NDArray[np.intp]) -> Task:
    """A task for some of its lanes."""
    own = {key: getattr(task, key, None) for key in PLACES}
    own = {key: place[lanes] for key, place in own.items() if isinstance(place, np.ndarray)}
    return replace(task, **own) if own else task  # type: ignore[type-var]


def blank(common: Common, aboard: Aboard) -> Goal:
    """A goal with the common part filled in, whose depth follows the level."""
    goal = Goal.stay(aboard)
    goal.speed.fill(common.speed_mps)
    if common.face_rad is not None or common.face_point is not None:
        goal.face = common.facing(aboard)
    goal.depth.fill(np.nan)
    return goal

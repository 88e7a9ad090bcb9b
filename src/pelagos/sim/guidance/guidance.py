"""Flies a mission: every copy of a fleet at its own task, all lanes at one task in one call."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats, within, wrapped
from pelagos.sim.guidance.follow import FollowAgent
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.steering.steering import Channels, Steering
from pelagos.sim.guidance.task import Level, Task, taken

DEPTH_RATE_PER_S: Final = 0.25  # how fast altitude hold closes an error, up to
DEPTH_RATE_MPS: Final = 0.35  # steepest set-point ramp in altitude hold
MIN_DEPTH_M: Final = 0.5  # altitude hold never asks to come nearer to the surface


@dataclass(frozen=True)
class Step:
    """A task, and the number of the first task behind its leg, where `until` leads."""

    task: Task
    behind: int


class Guidance:
    """The mission of one agent in every copy; `command` is asked at a fixed rate.

    Attributes:
        steps: the mission.
        progress: where each copy stands.
        followed: names of the agents that a task follows.
        begun: `(n,)` when the mission began [s].
        ended: `(n, tasks)` when each task ended [s], for the last time; not a number: it has not.
    """

    def __init__(self, steps: Sequence[Step], steering: Steering, names: Sequence[str], aboard: Aboard) -> None:
        self.steps = list(steps)
        self.progress = Progress.begin(aboard)
        self.followed = tuple({step.task.agent: None for step in steps if isinstance(step.task, FollowAgent)})
        self._steering = steering
        self._names = tuple(names)
        self._entered = np.full(len(aboard), -1)
        self.begun = np.full(len(aboard), aboard.t_s)
        self.ended = np.full((len(aboard), len(self.steps)), np.nan)

    @property
    def done(self) -> bool:
        """Every copy has finished."""
        return bool((self.progress.task >= len(self.steps)).all())

    def memory(self) -> dict[str, Any]:
        """State of the mission: arrays."""
        kept = {"entered": self._entered, "begun": self.begun, "ended": self.ended}
        return {"progress": vars(self.progress), **kept, "steering": self._steering.memory()}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        self.progress = Progress(**memory["progress"])
        self._entered, self.begun, self.ended = memory["entered"], memory["begun"], memory["ended"]
        self._steering.recall(memory["steering"])

    def command(self, aboard: Aboard, truth: Aboard | None = None) -> Floats:
        """`(n, k)` set-points of the control mode.

        Args:
            aboard: what the vehicle knows.
            truth: the true motion, where it is another one: control laws work with that, so that set-points are shifted
                by the error of navigation, as if the laws had worked with the estimate.
        """
        self._advance(aboard)
        goal = self._goal(aboard)
        entered = self.progress.task != self._entered
        self._entered = self.progress.task.copy()
        channels = self._steering.command(goal, aboard, entered)
        if truth is not None:
            channels = shifted(channels, aboard, truth)
        return np.array([channels[name] for name in self._names]).T

    def _advance(self, aboard: Aboard) -> None:
        """Tasks that are over give way to the next ones."""
        p = self.progress
        for k in range(int(p.task.min()), len(self.steps)):
            lanes = np.flatnonzero(p.task == k)
            if not len(lanes):
                if (p.task < k).all():
                    return
                continue
            whole = len(lanes) == len(p.task)
            mine, seen = (p, aboard) if whole else (p.take(lanes), aboard.take(lanes))
            task = self.steps[k].task if whole else taken(self.steps[k].task, lanes)
            to = k + task.moves(seen, mine)
            if not whole:
                p.memory[lanes] = mine.memory
            if task.common.until is not None:
                to = np.where(task.common.until.met(seen), self.steps[k].behind, to)
            moved = to != k
            if moved.any():
                self.ended[lanes[moved], k] = aboard.t_s
                p.move(lanes[moved], np.maximum(to, 0)[moved], aboard)
            elif whole:
                return

    def _goal(self, aboard: Aboard) -> Goal:
        """Goal of every copy."""
        p = self.progress
        present = set(p.task.tolist())
        if len(present) == 1:  # one copy, or all together
            return self._wanted(present.pop(), aboard, p, None)
        goal = Goal.stay(aboard)
        for k in sorted(present):
            lanes = np.flatnonzero(p.task == k)
            mine = p.take(lanes)
            goal.put(lanes, self._wanted(k, aboard.take(lanes), mine, lanes))
            p.depth[lanes] = mine.depth
        return goal

    def _wanted(self, k: int, aboard: Aboard, progress: Progress, lanes: NDArray[np.intp] | None) -> Goal:
        """Wish of task k for the `lanes` that are at it, None: all; keeps the depth."""
        if k >= len(self.steps):
            return _over(aboard, progress)
        task = self.steps[k].task if lanes is None else taken(self.steps[k].task, lanes)
        wanted = task.goal(aboard, progress)
        follows = np.isnan(wanted.depth)
        if follows.any():
            level = level_depth(task.common.level, progress.depth, aboard)
            wanted.depth = level if follows.all() else np.where(follows, level, wanted.depth)
        progress.depth = wanted.depth
        return wanted


def level_depth(level: Level, before: Floats, aboard: Aboard) -> Floats:
    """Depth set-point [m]: the level's, that before, or in altitude hold a ramp towards the depth that gives it."""
    if level.depth_m is not None and level.altitude_m is None:
        return np.full(len(aboard), level.depth_m)
    depth = aboard.depth
    last = np.where(np.isnan(before), depth, before)
    if level.altitude_m is None:
        return last
    wanted = depth + aboard.altitude - level.altitude_m
    rate = within(DEPTH_RATE_PER_S * (wanted - last), DEPTH_RATE_MPS)
    return np.maximum(MIN_DEPTH_M, last + rate * aboard.dt_s)


def _over(aboard: Aboard, progress: Progress) -> Goal:
    """Behind the last task: see `Path.OVER`."""
    goal = Goal.stay(aboard)
    goal.path[:] = Path.OVER
    goal.start, goal.end = progress.start[:, :2].copy(), progress.start[:, :2].copy()
    goal.course, goal.face = progress.heading.copy(), progress.heading.copy()
    goal.depth = np.where(np.isnan(progress.depth), aboard.depth, progress.depth)
    return goal


def shifted(channels: Channels, aboard: Aboard, truth: Aboard) -> Channels:
    """Set-points for control laws that work with the true motion, as if they had worked with the estimated one."""
    error = truth.own.position - aboard.own.position
    turned = wrapped(truth.own.heading - aboard.own.heading)
    found = dict(channels)
    for i, name in enumerate(("x", "y", "z")):
        if name in found:
            found[name] = found[name] + error[:, i]
    for name in ("depth", "upper_depth"):
        if name in found:
            found[name] = found[name] - error[:, 2]
    if "height" in found:
        found["height"] = found["height"] + error[:, 2]
    if "heading" in found:
        found["heading"] = found["heading"] + turned
    if "yaw" in found:
        found["yaw"] = found["yaw"] - turned
    return found

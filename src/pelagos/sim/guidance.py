"""Flies a mission: turns legs into set-points of depth, heading and speed, for every copy of a fleet on its own.

Straight lines are followed by lookahead-based line of sight (Fossen 2021, Section 12.4: heading = path angle minus
atan(cross-track error / lookahead)). Altitude is held by moving the depth set-point with the measured altitude.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.state import AgentState

LOOKAHEAD_LENGTHS: Final = 12.0  # hull lengths; of a torpedo AUV about its turning radius
DEPTH_RATE_PER_S: Final = 0.25  # how fast altitude hold closes an error, up to
DEPTH_RATE_MPS: Final = 0.35  # steepest set-point ramp in altitude hold
MIN_DEPTH_M: Final = 0.5  # altitude hold never asks to come nearer to the surface
SURFACED_DEPTH_M: Final = 0.35


@dataclass(frozen=True)
class Task:
    """One elementary task of a mission.

    Attributes:
        kind: "transit" follows the line `start -> end` (start None: from where the vehicle is), "dive", "surface",
            "fix", "hold".
        end: (x, y) NWU [m].
        start: (x, y) NWU [m] or None.
        depth_m, altitude_m: vertical set-point, one of the two.
        speed_mps: set-point of speed.
        acceptance_m: distance to `end` (or past it) at which the task is done.
        seconds: duration of "hold", time-out of "fix".
    """

    kind: str
    end: tuple[float, float] = (0.0, 0.0)
    start: tuple[float, float] | None = None
    depth_m: float | None = None
    altitude_m: float | None = None
    speed_mps: float = 1.5
    acceptance_m: float = 3.0
    seconds: float = 60.0


def plan(legs: Sequence[Any]) -> list[Task]:
    """Legs of a scenario -> tasks."""
    tasks: list[Task] = []
    for leg in legs:
        common: dict[str, Any] = {
            "depth_m": getattr(leg, "depth_m", None),
            "altitude_m": getattr(leg, "altitude_m", None),
        }
        if getattr(leg, "speed_mps", None) is not None:
            common["speed_mps"] = leg.speed_mps
        if leg.type == "waypoints":
            tasks += _transits([(float(x), float(y)) for x, y in leg.points], acceptance_m=leg.acceptance_m, **common)
        elif leg.type == "lawnmower":
            tasks += _lines(lawnmower(leg), acceptance_m=leg.acceptance_m, **common)
        elif leg.type == "hold":
            tasks.append(Task("hold", seconds=leg.seconds, **common))
        elif leg.type == "gps_fix":
            tasks.append(Task("fix", seconds=leg.timeout_s, **{**common, "depth_m": 0.0}))
        elif leg.type == "surface":
            tasks.append(Task("surface", **{**common, "depth_m": 0.0}))
        else:
            assert leg.type == "dive"
            tasks.append(Task("dive", **common))
    return tasks


def lawnmower(leg: Any) -> list[tuple[tuple[float, float], tuple[float, float]]]:
    """The survey lines (start, end) of a lawn-mower leg, in order; the pattern grows to starboard of the first line."""
    heading = math.radians(leg.heading_deg)
    ahead = np.array([math.cos(heading), -math.sin(heading)])  # NWU: compass heading turns from x towards -y
    right = np.array([-math.sin(heading), -math.cos(heading)])
    corner = np.asarray(leg.corner, dtype=float)
    lines = []
    for k in range(math.floor(leg.width_m / leg.spacing_m + 1e-9) + 1):
        a = corner + k * leg.spacing_m * right
        b = a + leg.length_m * ahead
        start, end = (a, b) if k % 2 == 0 else (b, a)
        lines.append(((float(start[0]), float(start[1])), (float(end[0]), float(end[1]))))
    return lines


def _transits(points: list[tuple[float, float]], **common: Any) -> list[Task]:
    starts: list[tuple[float, float] | None] = [None, *points[:-1]]
    return [Task("transit", end=end, start=start, **common) for start, end in zip(starts, points, strict=True)]


def _lines(lines: list[tuple[tuple[float, float], tuple[float, float]]], **common: Any) -> list[Task]:
    """A transit to the first line's start, then along every line; turns happen while the next line is picked up."""
    first = Task("transit", end=lines[0][0], **common)
    return [first, *(Task("transit", end=end, start=start, **common) for start, end in lines)]


@dataclass
class Progress:
    """Where one copy stands in its mission."""

    task: int = 0
    since_s: float = 0.0
    start: tuple[float, float] | None = None
    heading: float = 0.0
    depth: float | None = None
    fixes: int = 0


@dataclass
class Guidance:
    """The mission of one agent in every copy; `command` is asked at a fixed rate.

    Attributes:
        tasks: the mission.
        progress: by copy.
        dt_s: time between two calls [s].
        lookahead_m: how far ahead on its line a vehicle aims [m].
    """

    tasks: list[Task]
    progress: list[Progress]
    dt_s: float
    lookahead_m: float

    @classmethod
    def start(cls, tasks: list[Task], state: AgentState, *, dt_s: float, length_m: float) -> Guidance:
        """At the beginning of the mission of a vehicle of a certain length [m]."""
        n = len(state.position)
        return cls(
            tasks, [Progress(heading=-float(state.euler[i, 2])) for i in range(n)], dt_s, LOOKAHEAD_LENGTHS * length_m
        )

    @property
    def done(self) -> bool:
        """Every copy has finished."""
        return all(p.task >= len(self.tasks) for p in self.progress)

    def command(
        self, state: AgentState, altitude: NDArray[np.float64], gps: NDArray[np.bool_], t_s: float
    ) -> NDArray[np.float64]:
        """`(n, 3)` depth [m], compass heading [rad], speed [m/s].

        Args:
            state: the vehicle's state.
            altitude: `(n,)` last measured height above the seabed [m]; infinite where none was measured.
            gps: `(n,)` a position fix arrived since the last call.
            t_s: time [s].
        """
        rows = [self._one(i, state, float(altitude[i]), bool(gps[i]), t_s) for i in range(len(self.progress))]
        return np.array(rows)

    def _one(self, i: int, state: AgentState, altitude: float, fix: bool, t_s: float) -> tuple[float, float, float]:
        p = self.progress[i]
        position = state.position[i]
        x, y, depth = float(position[0]), float(position[1]), -float(position[2])
        while p.task < len(self.tasks) and self._finished(p, self.tasks[p.task], x, y, depth, altitude, fix, t_s):
            p.task, p.since_s, p.start = p.task + 1, t_s, (x, y)
        if p.task >= len(self.tasks):
            return 0.0, p.heading, 0.0
        task = self.tasks[p.task]
        if task.kind == "transit":
            p.heading = _line_of_sight(task.start or p.start or (x, y), task.end, x, y, self.lookahead_m)
        p.depth = self._depth(p, task, depth, altitude)
        return p.depth, p.heading, 0.0 if task.kind == "fix" else task.speed_mps

    def _finished(
        self, p: Progress, task: Task, x: float, y: float, depth: float, altitude: float, fix: bool, t_s: float
    ) -> bool:
        if p.start is None:
            p.start = (x, y)
        if task.kind == "transit":
            start = task.start or p.start
            along = (task.end[0] - start[0], task.end[1] - start[1])
            length = math.hypot(*along) or 1.0
            to_go = ((task.end[0] - x) * along[0] + (task.end[1] - y) * along[1]) / length
            near = math.hypot(task.end[0] - x, task.end[1] - y) < task.acceptance_m
            return near or to_go < 0.0
        if task.kind == "hold":
            return t_s - p.since_s >= task.seconds
        if task.kind == "fix":
            p.fixes = p.fixes + 1 if fix else p.fixes
            return p.fixes >= 3 or t_s - p.since_s >= task.seconds
        if task.kind == "surface":
            return depth < SURFACED_DEPTH_M
        error = depth - task.depth_m if task.depth_m is not None else altitude - (task.altitude_m or 0.0)
        return abs(error) < 1.0

    def _depth(self, p: Progress, task: Task, depth: float, altitude: float) -> float:
        if task.altitude_m is None:
            return task.depth_m if task.depth_m is not None else (p.depth if p.depth is not None else depth)
        wanted = depth + altitude - task.altitude_m
        before = p.depth if p.depth is not None else depth
        rate = min(max(DEPTH_RATE_PER_S * (wanted - before), -DEPTH_RATE_MPS), DEPTH_RATE_MPS)
        return max(MIN_DEPTH_M, before + rate * self.dt_s)


def _line_of_sight(
    start: tuple[float, float], end: tuple[float, float], x: float, y: float, lookahead_m: float
) -> float:
    """Compass heading [rad] that leads onto the line from start to end."""
    dx, dy = end[0] - start[0], end[1] - start[1]
    if math.hypot(dx, dy) < 1e-6:
        dx, dy = end[0] - x, end[1] - y
        return math.atan2(-dy, dx)
    course = math.atan2(-dy, dx)  # compass: clockwise from north, and y points west
    to_starboard = -math.sin(course) * (x - start[0]) - math.cos(course) * (y - start[1])
    return course - math.atan2(to_starboard, lookahead_m)

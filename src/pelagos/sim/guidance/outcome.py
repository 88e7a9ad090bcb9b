"""Outcome of a mission, leg by leg: when each ended, and how near to its way the vehicle truly was."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.guidance import Step
from pelagos.sim.guidance.line import Line
from pelagos.sim.guidance.orbit import Orbit, on_circle
from pelagos.sim.guidance.task import Task
from pelagos.sim.guidance.wait import GpsFix, Station

Floats = NDArray[np.float64]

PICKED_UP: Final = 0.5  # share of a line on which a vehicle comes onto it
ROUND: Final = 0.25  # the same of a turn round a circle


@dataclass(frozen=True)
class Track:
    """The true way of one copy: time `(k,)` [s], position `(k, 3)` NWU [m]."""

    t_s: Floats
    position: Floats

    def between(self, since_s: float, until_s: float) -> Floats:
        """`(m, 3)` positions from one time to another."""
        return self.position[(self.t_s >= since_s) & (self.t_s <= until_s)]


@dataclass(frozen=True)
class LegOutcome:
    """One leg.

    Attributes:
        kind: its `type`.
        began_s: when [s]; None: it has not.
        ended_s: when [s]; None: it has not.
        off_m: largest distance from its way [m]: from its lines' second halves (from its points, where it has no line),
            from its circle after a quarter turn, or from where it was to stay; None: it has not ended, or has none.
        late: it ended because its time was over (a fix that did not come).
    """

    kind: str
    began_s: float | None
    ended_s: float | None
    off_m: float | None
    late: bool = False


@dataclass(frozen=True)
class Flown:
    """A mission of one copy, as guidance leaves it.

    Attributes:
        steps: the mission.
        kinds: `type` of each leg.
        begun_s: when it began [s].
        ended_s: `(tasks,)` when each task ended [s]; not a number: it has not, or was left out.
        task: number of the present task; the count of tasks when all are done.
        stops: the vehicle can stay at a place.
    """

    steps: Sequence[Step]
    kinds: Sequence[str]
    begun_s: float
    ended_s: Floats
    task: int
    stops: bool


def outcomes(flown: Flown, track: Track) -> list[LegOutcome]:
    """Outcome of every leg, in order."""
    found: list[LegOutcome] = []
    first, since = 0, flown.begun_s
    for kind in flown.kinds:
        behind = flown.steps[first].behind
        if flown.task < behind:
            found.append(LegOutcome(kind, since if flown.task >= first else None, None, None))
        else:
            tasks, times = [step.task for step in flown.steps[first:behind]], flown.ended_s[first:behind]
            end = float(np.nanmax(times))
            late = isinstance(tasks[0], GpsFix) and end - since >= tasks[0].seconds
            found.append(LegOutcome(kind, since, end, _off(tasks, times, since, track, flown.stops), late))
            since = end
        first = behind
    return found


def _off(tasks: Sequence[Task], times: Floats, since: float, track: Track, stops: bool) -> float | None:
    """Largest distance from the way of a leg, see `LegOutcome`."""
    along: list[float] = []
    ends: list[float] = []
    for task, until in zip(tasks, times.tolist(), strict=True):
        way = track.between(since, until)
        if not len(way):
            continue
        since = until
        if isinstance(task, Line):
            ends.append(_from_end(task, way))
            if task.start is not None and not task.again:
                along.append(_from_line(np.array(task.start), np.array(task.end), way[:, :2]))
        elif isinstance(task, Orbit):
            along.append(_from_circle(task, way[:, :2]))
        elif isinstance(task, Station) and stops:
            place = way[0, :2] if task.point is None else np.array(task.point)
            along.append(float(np.hypot(*(way[len(way) // 2 :, :2] - place).T).max()))
    if tasks and isinstance(tasks[-1], Line) and tasks[-1].again:
        along = ends[-1:]
    return max(along or ends, default=None)


def _from_end(line: Line, way: Floats) -> float:
    """Least distance from a line's end, in space where it counts the depth."""
    off = np.hypot(*(way[:, :2] - np.array(line.end)).T)
    if line.again and line.common.level.depth_m is not None:
        off = np.hypot(off, way[:, 2] + line.common.level.depth_m)
    return float(off.min())


def _from_line(start: Floats, end: Floats, way: Floats) -> float:
    """Largest distance across a line, from where it is picked up on."""
    length = float(np.hypot(*(end - start)))
    ahead = (end - start) / max(length, 1e-9)
    run, across = (way - start) @ ahead, (way - start) @ np.array([-ahead[1], ahead[0]])
    return float(np.abs(across[(run > PICKED_UP * length) & (run < length)]).max(initial=0.0))


def _from_circle(orbit: Orbit, way: Floats) -> float:
    """Largest distance from a circle, from a share of the way round after it is reached on."""
    out = way - np.array(orbit.center)
    off = np.abs(np.hypot(*out.T) - orbit.radius_m)
    reached = np.flatnonzero(off < on_circle(orbit.radius_m))
    if not len(reached):
        return float(off.min())
    turned = np.unwrap(np.arctan2(out[:, 1], out[:, 0])[reached[0] :])
    settled = np.abs(turned - turned[0]) >= 2 * np.pi * ROUND * min(orbit.turns, 1.0)
    return float(off[reached[0] :][settled].max(initial=0.0))

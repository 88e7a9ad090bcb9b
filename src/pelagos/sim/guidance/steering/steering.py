"""The contract of a steering, and the way back onto lines and circles.

Lines and circles are followed by lookahead-based line of sight (Fossen 2021, Section 12.4: course = path angle minus
atan(cross-track error / lookahead)). The heading is the course less the crab angle that the vehicle sees itself have,
filtered: what a cross-track integral would find, without its wind-up (ibid., Section 12.5).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Protocol, TypeAlias

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats, bearing, within, wrapped
from pelagos.sim.guidance.goal import Goal, Path

Channels: TypeAlias = dict[str, Floats]

CRAB_TIME_S: Final = 5.0  # the crab angle is known as the mean over this: waves pass
CRAB_LIMIT_RAD: Final = 1.0
LEAD_LOOKAHEADS: Final = 1.2  # ways on which the set-point's lead grows by what the heading lags
LEAD_LIMIT_RAD: Final = 0.6
UNDER_WAY: Final = 0.4  # a crab angle is looked at from this share of the wanted speed on


class Steering(Protocol):
    """Turns goals into set-points; keeps arrays of all lanes."""

    def command(self, goal: Goal, aboard: Aboard, entered: NDArray[np.bool_]) -> Channels:
        """`(n,)` set-points by name; entered: lanes that have just begun another task."""
        ...

    def memory(self) -> dict[str, Floats]:
        """Memory of the steering."""
        ...

    def recall(self, memory: Mapping[str, Floats]) -> None:
        """Keep that instead."""
        ...


def line_course(start: Floats, end: Floats, position: Floats, lookahead_m: Floats | float) -> Floats:
    """Compass course [rad] that leads onto the lines from `start` to `end`, all `(m, 2)` x, y [m]."""
    along, off = end - start, position - start
    point = np.hypot(along[:, 0], along[:, 1]) < 1e-6
    if point.any():
        along = np.where(point[:, None], end - position, along)
    course = bearing(along)
    to_starboard = -np.sin(course) * off[:, 0] - np.cos(course) * off[:, 1]
    return course - np.where(point, 0.0, np.arctan2(to_starboard, lookahead_m))


def circle_course(
    center: Floats, radius: Floats, turn: Floats, position: Floats, lookahead_m: Floats | float
) -> Floats:
    """Compass course [rad] that leads onto circles, turn 1: clockwise from above."""
    out = position - center
    outside = np.hypot(out[:, 0], out[:, 1]) - radius
    ahead_m = np.minimum(lookahead_m, np.maximum(radius, 1e-3))
    return bearing(out) + turn * (np.pi / 2 + np.arctan2(outside, ahead_m))


@dataclass
class Crab:
    """Angle from heading to course over ground [rad], filtered."""

    angle: Floats

    def see(self, aboard: Aboard, speed: Floats) -> Floats:
        """The angle now; speed: wanted [m/s]."""
        way = aboard.own.velocity[:, :2]
        fast = np.hypot(way[:, 0], way[:, 1]) > UNDER_WAY * np.maximum(speed, 1e-3)
        seen = within(wrapped(bearing(way) - aboard.own.heading), CRAB_LIMIT_RAD)
        moving = fast & (speed > 0)
        share = 1 - np.exp(-aboard.dt_s / CRAB_TIME_S)
        self.angle = np.where(moving, self.angle + share * (seen - self.angle), self.angle * (1 - share))
        return self.angle


@dataclass
class Lead:
    """Angle that the heading's set-point is ahead of the heading to have on a circle [rad]: the integral of what a
    heading that turns evenly lags behind its set-point.
    """

    angle: Floats

    def turning(
        self, wanted: Floats, on_circle: NDArray[np.bool_], aboard: Aboard, lookahead_m: Floats | float
    ) -> Floats:
        """Set-points that give the `wanted` headings [rad]; those that are not on a circle stay."""
        if not on_circle.any():
            self.angle = np.zeros_like(self.angle)
            return wanted
        way = aboard.own.velocity[:, :2]
        share = aboard.dt_s * np.hypot(way[:, 0], way[:, 1]) / (LEAD_LOOKAHEADS * lookahead_m)
        lag = wrapped(wanted - aboard.own.heading)
        steady = on_circle & (np.abs(lag) < LEAD_LIMIT_RAD)  # not while it comes onto the circle
        grown = self.angle + np.where(steady, share * lag, 0.0)
        self.angle = np.where(on_circle, within(grown, LEAD_LIMIT_RAD), 0.0)
        return np.where(on_circle, wanted + self.angle, wanted)


def course_to(goal: Goal, aboard: Aboard, lookahead_m: Floats | float, radius_m: float) -> Floats:
    """Course [rad] of vehicles that steer by heading: lines, circles, and circles around points to stay at."""
    paths = set(goal.path.tolist())
    course = goal.course
    if Path.LINE in paths:
        course = np.where(goal.path == Path.LINE, line_course(goal.start, goal.end, aboard.xy, lookahead_m), course)
    if Path.CIRCLE in paths or Path.POINT in paths:
        radius = np.where(np.isnan(goal.radius), radius_m, goal.radius)
        around = circle_course(goal.end, radius, goal.turn, aboard.xy, lookahead_m)
        course = np.where((goal.path == Path.CIRCLE) | (goal.path == Path.POINT), around, course)
    return course

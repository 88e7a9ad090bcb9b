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

FAR: Final = 0.5  # distance in lookaheads over which a vehicle begins to aim nearer ahead
CRAB_TIME_S: Final = 5.0  # the crab angle is known as the mean over this: waves pass
CRAB_LIMIT_RAD: Final = 1.0
LEARNING_S: Final = 6.0  # time in which the lag of headings is learned
SLOW_TURN_RAD_S: Final = 0.02  # turns slower than this teach little
LEAD_LIMIT_RAD: Final = 0.8
LAG_LIMIT_RAD: Final = 1.0
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


def line_course(
    start: Floats, end: Floats, position: Floats, lookahead_m: Floats | float, nearest: float = 1.0
) -> Floats:
    """Compass course [rad] that leads onto the lines from `start` to `end`, all `(m, 2)` x, y [m].

    Far from its line a vehicle aims nearer ahead, down to a share `nearest` of the lookahead, and so comes back sooner:
    Delta = Delta_min + (Delta_max - Delta_min) exp(-|y_e| / e), after A. M. Lekkas and T. I. Fossen, A time-varying
    lookahead distance guidance law for path following, IFAC Proc. Vol. 45-27 (2012).
    """
    along, off = end - start, position - start
    point = np.hypot(along[:, 0], along[:, 1]) < 1e-6
    if point.any():
        along = np.where(point[:, None], end - position, along)
    course = bearing(along)
    to_starboard = -np.sin(course) * off[:, 0] - np.cos(course) * off[:, 1]
    if nearest < 1.0:
        lookahead_m = lookahead_m * (nearest + (1 - nearest) * np.exp(-np.abs(to_starboard) / (FAR * lookahead_m)))
    return course - np.where(point, 0.0, np.arctan2(to_starboard, lookahead_m))


def circle_course(
    center: Floats, radius: Floats, turn: Floats, position: Floats, lookahead_m: Floats | float
) -> Floats:
    """Compass course [rad] that leads onto circles, turn 1: clockwise from above."""
    out = position - center
    outside = np.hypot(out[:, 0], out[:, 1]) - radius
    ahead_m = np.minimum(lookahead_m, np.maximum(radius, 1e-3))
    return bearing(out) + turn * (np.pi / 2 + np.arctan2(outside, ahead_m))


def circle_rate(
    center: Floats, radius: Floats, turn: Floats, position: Floats, velocity: Floats, lookahead_m: Floats | float
) -> Floats:
    """Rate at which the course of `circle_course` turns as a vehicle goes on at a velocity, `(m, 2)` [rad/s]."""
    out = position - center
    far = np.maximum(np.hypot(out[:, 0], out[:, 1]), 1e-3)
    outwards = (out * velocity).sum(axis=1) / far
    around = (out[:, 1] * velocity[:, 0] - out[:, 0] * velocity[:, 1]) / far**2  # clockwise from above
    ahead_m = np.minimum(lookahead_m, np.maximum(radius, 1e-3))
    return np.asarray(around + turn * outwards * ahead_m / (ahead_m**2 + (far - radius) ** 2))


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
    """Time by which headings lag behind set-points that turn evenly [s], learned by least mean squares on circles."""

    lag_s: Floats

    def turning(
        self, wanted: Floats, goal: Goal, aboard: Aboard, lookahead_m: Floats | float, radius_m: float
    ) -> Floats:
        """Set-points that give the `wanted` headings [rad] on circles; those of other paths stay."""
        on_circle = (goal.path == Path.CIRCLE) | (goal.path == Path.POINT)
        if not on_circle.any():
            return wanted
        radius = np.where(np.isnan(goal.radius), radius_m, goal.radius)
        rate = circle_rate(goal.end, radius, goal.turn, aboard.xy, aboard.own.velocity[:, :2], lookahead_m)
        rate = np.where(on_circle, rate, 0.0)
        lead = within(self.lag_s * rate, LEAD_LIMIT_RAD)
        lag = wrapped(wanted + lead - aboard.own.heading)
        steady = on_circle & (np.abs(lag) < LAG_LIMIT_RAD)  # not while it turns towards the circle
        error = np.where(steady, lag - self.lag_s * rate, 0.0)
        share = aboard.dt_s / LEARNING_S * rate / (rate * rate + SLOW_TURN_RAD_S**2)
        self.lag_s = np.maximum(self.lag_s + share * error, 0.0)
        return np.where(on_circle, wanted + lead, wanted)


def course_to(goal: Goal, aboard: Aboard, lookahead_m: Floats | float, radius_m: float, nearest: float = 1.0) -> Floats:
    """Course [rad] of vehicles that steer by heading: lines, circles, and circles around points to stay at.

    nearest: see `line_course`.
    """
    paths = set(goal.path.tolist())
    course = goal.course
    if Path.LINE in paths:
        along = line_course(goal.start, goal.end, aboard.xy, lookahead_m, nearest)
        course = np.where(goal.path == Path.LINE, along, course)
    if Path.CIRCLE in paths or Path.POINT in paths:
        radius = np.where(np.isnan(goal.radius), radius_m, goal.radius)
        around = circle_course(goal.end, radius, goal.turn, aboard.xy, lookahead_m)
        course = np.where((goal.path == Path.CIRCLE) | (goal.path == Path.POINT), around, course)
    return course

"""Steering of vehicles that move any way they like: a reference point runs along the path, and they follow it.

The point gains and loses speed gently, waits for a vehicle that lags, and comes with its velocity, which the control
law feeds forward; the law's integral takes care of what pushes across (Fossen 2021, Section 12.3: path following by a
virtual target).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats, bearing, wrapped
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.steering.steering import Channels

AIM_M: Final = 0.5  # the point is drawn onto its line over about this length
SINK_MPS: Final = 0.3  # vertical speed where the goal names none
TURN_RAD_S: Final = 0.5  # how fast the heading's set-point turns
CATCH_UP_MPS: Final = 0.2  # least speed of the point where a goal asks for none: to come back to its place


@dataclass
class Hover:
    """Attributes: gain_mps2: how fast the point gains and loses speed; lead_m: how far it runs ahead before it waits;
    level: whether roll and pitch are set-points; point: `(n, 3)` x, y, depth; speed, heading: `(n,)` of the point.
    """

    gain_mps2: float
    lead_m: float
    point: Floats = field(default_factory=lambda: np.zeros((0, 3)))
    speed: Floats = field(default_factory=lambda: np.zeros(0))
    heading: Floats = field(default_factory=lambda: np.zeros(0))

    def command(self, goal: Goal, aboard: Aboard, entered: NDArray[np.bool_]) -> Channels:
        """See `Steering.command`."""
        here = np.concatenate([aboard.xy, aboard.depth[:, None]], axis=1)
        if not len(self.speed):
            self.point, self.speed, self.heading = here.copy(), np.zeros(len(here)), aboard.own.heading.copy()
        new = np.isnan(self.speed)  # copies that have begun anew
        if new.any():
            self.point = np.where(new[:, None], here, self.point)
            self.speed = np.where(new, 0.0, self.speed)
            self.heading = np.where(new, aboard.own.heading, self.heading)
        adrift = goal.path == Path.DRIFT
        lost = adrift | (entered & (np.hypot(*(self.point - here)[:, :2].T) > 2 * self.lead_m))
        self.point[:, :2] = np.where(lost[:, None], here[:, :2], self.point[:, :2])
        to, room = _way(goal, self.point[:, :2])
        velocity = self._run(to, room, goal, here, aboard.dt_s)
        sink = self._sink(goal, here, aboard.dt_s)
        face = self._face(goal, velocity, aboard.dt_s)
        zero = np.zeros(len(here))
        return {
            "x": self.point[:, 0], "y": self.point[:, 1], "z": -self.point[:, 2], "roll": zero, "pitch": zero,
            "yaw": -face, "x_speed": velocity[:, 0], "y_speed": velocity[:, 1], "z_speed": -sink,
            "drive": np.where(adrift, 0.0, 1.0),
        }  # fmt: skip

    def memory(self) -> dict[str, Floats]:
        """See `Steering.memory`."""
        return {"point": self.point, "speed": self.speed, "heading": self.heading}

    def recall(self, memory: Mapping[str, Floats]) -> None:
        """See `Steering.recall`."""
        self.point, self.speed, self.heading = (memory[k] for k in ("point", "speed", "heading"))

    def _run(self, to: Floats, room: Floats, goal: Goal, here: Floats, dt_s: float) -> Floats:
        """Moves the point on its way; its velocity `(n, 2)` [m/s]."""
        asked = np.where(goal.speed > 0, goal.speed, CATCH_UP_MPS)
        asked = np.where(goal.path == Path.DRIFT, 0.0, asked)
        behind = np.hypot(*(self.point - here)[:, :2].T)
        asked = asked * np.clip(2.0 - behind / self.lead_m, 0.0, 1.0)
        brake = np.sqrt(2 * self.gain_mps2 * room)
        asked = np.minimum(asked, brake)
        most = self.speed + self.gain_mps2 * dt_s
        self.speed = np.minimum(np.maximum(asked, self.speed - 2 * self.gain_mps2 * dt_s), most)
        left = np.hypot(*(goal.end - self.point[:, :2]).T)  # a point that is at a line's end waits there
        self.speed = np.minimum(self.speed, np.where(goal.path == Path.LINE, left, room) / dt_s)
        velocity = self.speed[:, None] * to
        self.point[:, :2] += dt_s * velocity
        return np.asarray(velocity)

    def _sink(self, goal: Goal, here: Floats, dt_s: float) -> Floats:
        """Moves the point down; its speed [m/s]."""
        fastest = np.where(np.isnan(goal.sink), SINK_MPS, goal.sink)
        to_go = goal.depth - self.point[:, 2]
        rate = np.sign(to_go) * np.minimum(fastest, np.sqrt(self.gain_mps2 * np.abs(to_go)))
        rate = np.clip(rate, -np.abs(to_go) / dt_s, np.abs(to_go) / dt_s)
        ahead_m = (self.point[:, 2] - here[:, 2]) * np.sign(rate)
        rate = rate * np.clip(2.0 - ahead_m / self.lead_m, 0.0, 1.0)
        self.point[:, 2] += dt_s * rate
        return np.asarray(rate)

    def _face(self, goal: Goal, velocity: Floats, dt_s: float) -> Floats:
        """Turns the heading's set-point [rad] to the goal's, or along the way."""
        along = np.where(self.speed > 0.05, bearing(velocity), self.heading)
        wanted = np.where(np.isnan(goal.face), along, goal.face)
        step = np.clip(wrapped(wanted - self.heading), -TURN_RAD_S * dt_s, TURN_RAD_S * dt_s)
        self.heading = np.asarray(wrapped(self.heading + step))
        return self.heading


def _way(goal: Goal, point: Floats) -> tuple[Floats, Floats]:
    """Direction `(n, 2)` in which the point moves, and the way left to where it stops [m] (infinite: it does not)."""
    along = goal.end - goal.start
    length = np.hypot(along[:, 0], along[:, 1])
    unit = along / np.where(length > 0, length, 1.0)[:, None]
    run = np.clip(((point - goal.start) * unit).sum(axis=1) + AIM_M, 0.0, length)
    on_line = goal.start + run[:, None] * unit
    out = point - goal.end
    radius = np.maximum(np.where(np.isnan(goal.radius), 1.0, goal.radius), 1e-3)
    lead = np.minimum(AIM_M, 0.2 * radius)
    angle = np.arctan2(out[:, 1], out[:, 0]) - goal.turn * lead / radius
    on_circle = goal.end + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    aim = np.where((goal.path == Path.LINE)[:, None], on_line, goal.end)
    aim = np.where((goal.path == Path.CIRCLE)[:, None], on_circle, aim)
    to = aim - point
    distance = np.hypot(to[:, 0], to[:, 1])
    left = np.where(goal.path == Path.LINE, np.hypot(*(goal.end - point).T), distance)
    endless = (goal.path == Path.CIRCLE) | ((goal.path == Path.LINE) & ~goal.stops)
    room = np.where(endless, np.where(left > 1e-9, np.inf, 0.0), left)
    return to / np.where(distance > 1e-9, distance, 1.0)[:, None], room

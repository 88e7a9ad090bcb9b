"""Steering of surface craft that can stop: two thrusters, heading and speed.

At a point, a craft goes through the water as fast as the distance asks for and the current takes away, and so lies with
its bow against the current.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats, ahead, bearing, wrapped
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.steering.steering import Channels, Crab, Lead, course_to

APPROACH_PER_S: Final = 0.15  # speed by distance from the point where a craft is to stop
CURRENT_TIME_S: Final = 10.0  # the current is known as the mean over this: waves pass
STILL_MPS: Final = 0.08  # a craft that is to go slower than this keeps its heading, and backs where it must
TURN_RAD_S: Final = 0.1  # a craft slows down on circles that would ask for a faster turn
BEATS: Final = 2.0  # but goes this many times as fast as the current
SLOWEST: Final = 0.25  # share of the lookahead that is left at low speed


@dataclass
class Surface:
    """lookahead_m: see `line_course`, at cruise_mps, shorter at less; length_m: of the hull; held: heading kept near a
    point [rad]; current: seen, world x, y `(n, 2)` [m/s]; asked: the last speed through the water [m/s].
    """

    lookahead_m: float
    length_m: float
    cruise_mps: float
    crab: Crab
    lead: Lead
    held: Floats = field(default_factory=lambda: np.zeros(0))
    current: Floats = field(default_factory=lambda: np.zeros((0, 2)))
    asked: Floats = field(default_factory=lambda: np.zeros(0))

    def command(self, goal: Goal, aboard: Aboard, entered: NDArray[np.bool_]) -> Channels:
        """See `Steering.command`."""
        if not len(self.held):
            n = len(aboard)
            self.held, self.current, self.asked = aboard.own.heading.copy(), np.zeros((n, 2)), np.zeros(n)
        new = np.isnan(self.held)  # copies that have begun anew
        if new.any():
            self.held = np.where(new, aboard.own.heading, self.held)
            self.current, self.asked = np.where(new[:, None], 0.0, self.current), np.where(new, 0.0, self.asked)
        self._see(aboard)
        to = goal.end - aboard.xy
        past = ((goal.end - goal.start) * to).sum(axis=1) <= 0
        stay = (goal.path == Path.POINT) | (goal.path == Path.OVER) | ((goal.path == Path.LINE) & goal.stops & past)
        to_go = np.maximum(APPROACH_PER_S * np.hypot(to[:, 0], to[:, 1]), 0.2)
        speed = np.where((goal.path == Path.LINE) & goal.stops, np.minimum(goal.speed, to_go), goal.speed)
        speed = np.where(goal.path == Path.DRIFT, 0.0, speed)
        speed = np.where(goal.path == Path.CIRCLE, np.minimum(speed, self._bend(to, goal)), speed)
        steered = (goal.path == Path.LINE) | (goal.path == Path.CIRCLE)
        crab = np.where(steered, self.crab.see(aboard, speed), 0.0)
        lookahead = np.clip(goal.speed / self.cruise_mps, SLOWEST, 1.0) * self.lookahead_m
        wanted = course_to(goal, aboard, lookahead, self.length_m) - crab
        heading = self.lead.turning(wanted, goal, aboard, lookahead, self.length_m)
        if stay.any():
            fastest = np.where(goal.speed > 0, goal.speed, self.cruise_mps)
            toward, slow = self._keep(to, fastest, aboard, stay)
            heading, speed = np.where(stay, toward, heading), np.where(stay, slow, speed)
        self.asked = speed
        return {"heading": heading, "speed": speed}

    def _bend(self, to: Floats, goal: Goal) -> Floats:
        """Largest speed on a circle and on the way to it [m/s]."""
        turning = TURN_RAD_S * np.maximum(goal.radius, np.hypot(to[:, 0], to[:, 1]))
        return np.maximum(turning, BEATS * np.hypot(self.current[:, 0], self.current[:, 1]))

    def _see(self, aboard: Aboard) -> None:
        """The current: what is left of the way over ground."""
        seen = aboard.own.velocity[:, :2] - self.asked[:, None] * ahead(aboard.own.heading)
        self.current = self.current + (1 - np.exp(-aboard.dt_s / CURRENT_TIME_S)) * (seen - self.current)

    def _keep(self, to: Floats, fastest: Floats, aboard: Aboard, stay: NDArray[np.bool_]) -> tuple[Floats, Floats]:
        """Heading [rad] and speed through the water [m/s] that lead to a point and keep there; for those that stay."""
        distance = np.hypot(to[:, 0], to[:, 1])
        pull = np.minimum(APPROACH_PER_S, fastest / np.maximum(distance, 1e-9))
        way = pull[:, None] * to - self.current
        fast = np.hypot(way[:, 0], way[:, 1])
        self.held = np.where(stay & (fast > STILL_MPS), bearing(way), self.held)
        along = fast * np.cos(wrapped(bearing(way) - aboard.own.heading))
        return self.held, np.clip(along, np.where(fast > STILL_MPS, 0.0, -fastest), fastest)

    def memory(self) -> dict[str, Floats]:
        """See `Steering.memory`."""
        angles = {"crab": self.crab.angle, "lead": self.lead.lag_s, "held": self.held}
        return {**angles, "current": self.current, "asked": self.asked}

    def recall(self, memory: Mapping[str, Floats]) -> None:
        """See `Steering.recall`."""
        self.crab.angle, self.lead.lag_s, self.held = (memory[name] for name in ("crab", "lead", "held"))
        self.current, self.asked = memory["current"], memory["asked"]

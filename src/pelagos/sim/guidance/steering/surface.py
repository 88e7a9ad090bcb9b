"""Steering of surface craft that can stop: two thrusters, heading and speed."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats, bearing, wrapped
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.steering.steering import Channels, Crab, course_to

APPROACH_PER_S: Final = 0.25  # speed by distance from the point where a craft is to stop
NEAR_LENGTHS: Final = 1.5  # a craft this near to its point keeps its heading, and backs where it must


@dataclass
class Surface:
    """lookahead_m: see `line_course`; length_m: of the hull; held: heading kept near a point [rad]."""

    lookahead_m: float
    length_m: float
    crab: Crab
    held: Floats = field(default_factory=lambda: np.zeros(0))

    def command(self, goal: Goal, aboard: Aboard, entered: NDArray[np.bool_]) -> Channels:
        """See `Steering.command`."""
        if not len(self.held):
            self.held = aboard.own.heading.copy()
        stay = (goal.path == Path.POINT) | (goal.path == Path.OVER)
        to = goal.end - aboard.xy
        distance, direction = np.hypot(to[:, 0], to[:, 1]), bearing(to)
        near = distance < NEAR_LENGTHS * self.length_m
        self.held = np.where(stay & near, self.held, direction)
        apart = wrapped(direction - aboard.own.heading)
        fastest = np.where(goal.speed > 0, goal.speed, 1.0)
        back = np.where(near, -0.5 * fastest, 0.0)
        approach = np.clip(APPROACH_PER_S * distance * np.cos(apart), back, fastest)
        stops = (goal.path == Path.LINE) & goal.stops
        to_go = np.maximum(APPROACH_PER_S * distance, 0.2)
        speed = np.where(stops, np.minimum(goal.speed, to_go), goal.speed)
        speed = np.where(stay, approach, np.where(goal.path == Path.DRIFT, 0.0, speed))
        steered = (goal.path == Path.LINE) | (goal.path == Path.CIRCLE)
        crab = np.where(steered, self.crab.see(aboard, speed), 0.0)
        heading = course_to(goal, aboard, self.lookahead_m, self.length_m) - crab
        return {"heading": np.where(stay, self.held, heading), "speed": speed}

    def memory(self) -> dict[str, Floats]:
        """See `Steering.memory`."""
        return {"crab": self.crab.angle, "held": self.held}

    def recall(self, memory: Mapping[str, Floats]) -> None:
        """See `Steering.recall`."""
        self.crab.angle, self.held = memory["crab"], memory["held"]

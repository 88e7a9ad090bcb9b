"""The task of circling a place."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, bearing, wrapped
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.task import Common, blank

BAND: Final = 0.25  # of the radius, and
BAND_M: Final = 1.0  # besides


def on_circle(radius_m: float) -> float:
    """Distance within which a vehicle counts as on a circle [m]."""
    return BAND * radius_m + BAND_M


@dataclass(frozen=True)
class Orbit:
    """Around (x, y) [m] at a radius [m], so many turns, 1 clockwise or -1; memory: 1 while on the circle, the last
    bearing from the centre [rad], and the angle turned on the circle [rad].
    """

    center: tuple[float, float]
    radius_m: float
    turns: float
    turn: float
    inwards: bool = False
    common: Common = field(default_factory=Common)

    def moves(self, aboard: Aboard, progress: Progress) -> NDArray[np.int64]:
        """See `Task.moves`."""
        out = aboard.xy - np.array(self.center)
        angle = bearing(out)
        on = progress.memory[:, 0] > 0
        swept = np.where(on, self.turn * wrapped(angle - progress.memory[:, 1]), 0.0)
        progress.memory[:, 2] += swept
        progress.memory[:, 0] = np.abs(np.hypot(out[:, 0], out[:, 1]) - self.radius_m) < on_circle(self.radius_m)
        progress.memory[:, 1] = angle
        return (progress.memory[:, 2] >= 2 * np.pi * self.turns).astype(np.int64)

    def goal(self, aboard: Aboard, progress: Progress) -> Goal:
        """See `Task.goal`."""
        goal = blank(self.common, aboard)
        goal.path[:] = Path.CIRCLE
        goal.end[:] = self.center
        goal.radius[:] = self.radius_m
        goal.turn[:] = self.turn
        goal.stops[:] = False
        if self.inwards:
            goal.face = bearing(np.array(self.center) - aboard.xy)
        return goal

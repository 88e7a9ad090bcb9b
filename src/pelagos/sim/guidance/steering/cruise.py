"""Steering of vehicles that need way on to steer: torpedo-shaped AUVs, ships, gliders, aeroplanes."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.aboard import Aboard, Floats
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.steering.steering import Channels, Crab, Lead, course_to

GLIDE_RAD: Final = 0.44  # 25 degrees
UPPER_DEPTH_M: Final = 3.0  # of a glider on a leg that says only how deep
NEAREST: Final = 0.5  # share of the lookahead that is left far from a line
AFLOAT_M: Final = -5.0  # a glider that is told to turn here stays at the surface

Kind = Literal["torpedo", "ship", "glider", "airplane"]


@dataclass
class Cruise:
    """kind: of vehicle; lookahead_m: see `line_course`; radius_m: of circles about points where it cannot stop;
    cruise_mps: speed where it circles without another.
    """

    kind: Kind
    lookahead_m: float
    radius_m: float
    cruise_mps: float
    crab: Crab
    lead: Lead

    def command(self, goal: Goal, aboard: Aboard, entered: NDArray[np.bool_]) -> Channels:
        """See `Steering.command`."""
        over = goal.path == Path.OVER
        if self.kind in ("airplane", "ship"):  # neither can stop
            goal.path = np.where(over, Path.POINT, goal.path)
            over = np.zeros_like(over)
        idle = over | (goal.path == Path.DRIFT)
        speed = np.where(idle, 0.0, goal.speed)
        if self.kind == "airplane":
            speed = np.where(speed > 0, speed, self.cruise_mps)
        crab = np.where((goal.path == Path.COURSE) | idle, 0.0, self.crab.see(aboard, speed))
        wanted = course_to(goal, aboard, self.lookahead_m, self.radius_m, NEAREST) - crab
        heading = self.lead.turning(wanted, goal, aboard, self.lookahead_m, self.radius_m)
        depth = np.where(over, 0.0, goal.depth)
        if self.kind == "torpedo":
            return {"depth": depth, "heading": heading, "speed": speed}
        if self.kind == "airplane":
            return {"height": -goal.depth, "heading": heading, "airspeed": speed}
        if self.kind == "ship":
            return {"heading": heading}
        afloat = idle | (depth <= 0)
        upper = np.where(np.isnan(goal.upper), np.minimum(UPPER_DEPTH_M, 0.5 * depth), goal.upper)
        return {
            "upper_depth": np.where(afloat, AFLOAT_M - 1, upper),
            "depth": np.where(
                afloat, AFLOAT_M, np.where(np.isnan(goal.upper), depth, np.maximum(depth, goal.upper + 1))
            ),
            "glide_pitch": np.where(np.isnan(goal.glide), GLIDE_RAD, goal.glide),
            "heading": heading,
        }

    def memory(self) -> dict[str, Floats]:
        """See `Steering.memory`."""
        return {"crab": self.crab.angle, "lead": self.lead.lag_s}

    def recall(self, memory: Mapping[str, Floats]) -> None:
        """See `Steering.recall`."""
        self.crab.angle, self.lead.lag_s = memory["crab"], memory["lead"]

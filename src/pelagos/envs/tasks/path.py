"""Keep to a line on the map while the water sets across it."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.draws import Draws
from pelagos.envs.task import Outcome, Start, Task
from pelagos.envs.view import View, wrapped
from pelagos.jit import Array
from pelagos.math.so3 import from_euler


class PathInCurrent(Task):
    """A REMUS 100 follows a winding line northwards in a current that it is not told of, by course and speed.

    The line is west = a sin(2 pi north / length), a and length drawn each episode. Actions are the course against the
    line's own direction, up to 90 degrees, and the speed from 0.8 to 1.8 m/s, for the vehicle's own autopilot. The
    reward of a step is the way along the line [m], less the distance from it [m] times 0.2; beyond 20 m the episode
    ends.
    """

    vehicle: str | Mapping[str, Any] = "remus100"
    control = "depth_heading_speed"
    actions = 2
    rate_hz = 2.0
    tick_rate_hz = 50.0
    seconds = 120.0
    observations = (
        "off_line_m", "line_sine", "line_cosine", "line_ahead_sine", "line_ahead_cosine", "surge_mps", "sway_mps",
        "yaw_rate", "ground_along_mps", "ground_across_mps",
    )  # fmt: skip

    def __init__(self, *, current_mps: float = 0.6, amplitude_m: float = 15.0) -> None:
        self.current_mps, self.amplitude_m = current_mps, amplitude_m

    def draw(self, random: Draws) -> Start:
        """Up to 10 m beside the line at its beginning, course north within 45 degrees, 1.5 m/s."""
        way, speed = random.uniform(-math.pi, math.pi), self.current_mps * dr.sqrt(random.uniform())
        memory = {
            "amplitude": random.uniform(-self.amplitude_m, self.amplitude_m),
            "wave_number": 2.0 * math.pi / random.uniform(80.0, 160.0),
            "before": 0.0,
        }
        yaw = random.uniform(-math.pi / 4, math.pi / 4)
        return Start(
            [0.0, random.uniform(-10.0, 10.0), -10.0], [*from_euler(0.0, 0.0, yaw)], [1.5, 0.0, 0.0],
            memory=memory, current=[speed * dr.cos(way), speed * dr.sin(way), 0.0],
        )  # fmt: skip

    def command(self, action: list[Array], now: View) -> list[Array]:
        """Depth, compass heading and speed for the autopilot."""
        course = self._line(now)[1] + 0.5 * math.pi * action[0]
        return [10.0, -course, 1.3 + 0.5 * action[1]]

    def observe(self, now: View, random: Draws) -> list[Array]:
        """The line from the vehicle, now and 10 m ahead, and how it moves over ground."""
        off, along = self._line(now)
        turn, later = wrapped(along - now.yaw), wrapped(self._line(now, 10.0)[1] - now.yaw)
        (s, c), (s2, c2) = dr.sincos(turn), dr.sincos(later)
        u, v = now.velocity[0], now.velocity[1]
        return [off, s, c, s2, c2, u, v, now.angular_velocity[2], u * c + v * s, v * c - u * s]

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """See the class."""
        off, along = self._line(now)
        moved = (now.position[0] - now.memory["before"]) / dr.cos(along)
        lost = dr.abs(off) > 20.0
        reward = moved - 0.2 * dr.abs(off) - dr.select(lost, 20.0, 0.0)
        return Outcome(reward, lost, memory={"before": now.position[0]}, metrics={"off_line_m": dr.abs(off)})

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: the line's course, turned towards it by the distance and by the drift over ground."""
        course = -np.arctan(seen[:, 0] / 8.0) - 1.0 * seen[:, 9]
        return np.stack([np.clip(course / (0.5 * np.pi), -1, 1), np.full(len(seen), 0.6)], axis=1).astype(np.float32)

    def _line(self, now: View, ahead: float = 0.0) -> tuple[Array, Array]:
        """Distance west of the line [m], and its direction, from north to west [rad]."""
        a, k = now.memory["amplitude"], now.memory["wave_number"]
        x = now.position[0] + ahead
        slope = a * k * dr.cos(k * x)
        return (now.position[1] - a * dr.sin(k * x)) / dr.sqrt(1 + slope * slope), dr.atan(slope)

"""Come to a pose and stay there."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.draws import Draws
from pelagos.envs.scripted import throttles
from pelagos.envs.task import Outcome, Start, Task
from pelagos.envs.tasks.rov import NAME, rov
from pelagos.envs.view import View, minus, norm, wrapped
from pelagos.jit import Array
from pelagos.math.so3 import from_euler


class Hover(Task):
    """A BlueROV2 Heavy comes to a point with the bow north, and stays there in a current, by its eight thrusters.

    It begins within 2 m in each direction at any heading. The reward of a step is 1 at the pose and falls with distance
    [m] and heading error, less what the thrusters take; beyond 6 m the episode ends.
    """

    vehicle: str | Mapping[str, Any] = rov()
    control = "actuators"
    seconds = 10.0
    observations = (
        "ahead_m", "left_m", "above_m", "sine", "cosine", "tilt_x", "tilt_y", "tilt_z", "surge_mps", "sway_mps",
        "heave_mps", "roll_rate", "pitch_rate", "yaw_rate",
    )  # fmt: skip

    def __init__(self, *, reach_m: float = 2.0, current_mps: float = 0.2, depth_m: float = 10.0) -> None:
        self.reach_m, self.current_mps, self.depth_m = reach_m, current_mps, depth_m
        self.goal = (0.0, 0.0, -depth_m)

    def draw(self, random: Draws) -> Start:
        """Anywhere near, turned any way, at rest, in a horizontal current from any side."""
        r, c = self.reach_m, self.current_mps
        x, y, z = random.box((-r, -r, -r), (r, r, r))
        attitude = [
            *from_euler(random.uniform(-0.2, 0.2), random.uniform(-0.2, 0.2), random.uniform(-math.pi, math.pi))
        ]
        speed, way = c * dr.sqrt(random.uniform()), random.uniform(-math.pi, math.pi)
        current = [speed * dr.cos(way), speed * dr.sin(way), 0.0]
        return Start([x, y, z - self.depth_m], attitude, current=current)

    def observe(self, now: View, random: Draws) -> list[Array]:
        """The goal from the body, heading, which way is up, and velocities."""
        sine, cosine = dr.sincos(now.yaw)
        tilt = now.to_body([0.0, 0.0, 1.0])
        return [*now.to_body(self._away(now)), sine, cosine, *tilt, *now.velocity, *now.angular_velocity]

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """See the class."""
        distance, turn = norm(self._away(now)), dr.abs(wrapped(now.yaw))
        still = norm(now.velocity) + 0.5 * norm(now.angular_velocity)
        effort = sum(a * a for a in action) / len(action)
        pose = dr.exp(-distance) * (0.6 + 0.25 * dr.exp(-4.0 * distance) + 0.15 * dr.exp(-2.0 * turn))
        reward = pose - 0.05 * still - 0.05 * effort
        return Outcome(reward, distance > 6.0, metrics={"distance_m": distance, "heading_error_rad": turn})

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: a spring and a damper to the pose."""
        s = seen.astype(np.float64)
        force = 40.0 * np.clip(s[:, 0:3], -1.5, 1.5) - 60.0 * s[:, 8:11]
        turn = np.arctan2(s[:, 3], s[:, 4])
        moment = np.stack([-6.0 * s[:, 6], 6.0 * s[:, 5], -4.0 * turn], axis=1) - 3.0 * s[:, 11:14]
        return throttles(NAME, force, moment)

    def _away(self, now: View) -> list[Array]:
        return minus([*self.goal], now.position)

"""Go to a point, by way of the shortest time."""

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
from pelagos.envs.view import View, minus, norm
from pelagos.jit import Array
from pelagos.math.so3 import from_euler


class Waypoint(Task):
    """A BlueROV2 Heavy goes to a point up to 8 m away in a current, by its eight thrusters.

    The reward of a step is the way [m] that it came nearer, less 0.02 for the time and what the thrusters take; within
    0.3 m of the point the episode ends with a further 5.
    """

    vehicle: str | Mapping[str, Any] = rov()
    control = "actuators"
    seconds = 20.0
    observations = (
        "ahead_m", "left_m", "above_m", "tilt_x", "tilt_y", "tilt_z", "surge_mps", "sway_mps", "heave_mps",
        "roll_rate", "pitch_rate", "yaw_rate",
    )  # fmt: skip

    def __init__(self, *, reach_m: float = 8.0, current_mps: float = 0.3, depth_m: float = 20.0) -> None:
        self.reach_m, self.current_mps, self.depth_m = reach_m, current_mps, depth_m

    def draw(self, random: Draws) -> Start:
        """A goal in any direction, between a quarter of the reach and all of it."""
        away = random.uniform(0.25 * self.reach_m, self.reach_m)
        goal = [away * c for c in random.direction()]
        speed, way = self.current_mps * dr.sqrt(random.uniform()), random.uniform(-math.pi, math.pi)
        goal[2] = goal[2] - self.depth_m
        memory = dict(zip(("goal_x", "goal_y", "goal_z"), goal, strict=True)) | {"before": away}
        attitude = [*from_euler(0.0, 0.0, random.uniform(-math.pi, math.pi))]
        current = [speed * dr.cos(way), speed * dr.sin(way), 0.0]
        return Start([0.0, 0.0, -self.depth_m], attitude, memory=memory, current=current)

    def observe(self, now: View, random: Draws) -> list[Array]:
        """The goal from the body, which way is up, and velocities."""
        tilt = now.to_body([0.0, 0.0, 1.0])
        return [*now.to_body(_away(now)), *tilt, *now.velocity, *now.angular_velocity]

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """See the class."""
        distance = norm(_away(now))
        there = distance < 0.3
        effort = sum(a * a for a in action) / len(action)
        reward = now.memory["before"] - distance - 0.02 - 0.01 * effort + dr.select(there, 5.0, 0.0)
        metrics = {"distance_m": distance, "success": dr.select(there, 1.0, 0.0)}
        return Outcome(reward, there, memory={"before": distance}, metrics=metrics)

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: a force towards the goal, against the velocity; upright, no turning."""
        s = seen.astype(np.float64)
        way = s[:, 0:3] * np.minimum(1.0, 2.0 / np.linalg.norm(s[:, 0:3], axis=1, keepdims=True))
        force = 60.0 * way - 60.0 * s[:, 6:9]
        moment = 6.0 * np.stack([-s[:, 4], s[:, 3], np.zeros(len(s))], axis=1) - 3.0 * s[:, 9:12]
        return throttles(NAME, force, moment)


def _away(now: View) -> list[Array]:
    return minus([now.memory["goal_x"], now.memory["goal_y"], now.memory["goal_z"]], now.position)

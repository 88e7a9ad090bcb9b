"""Cross a gyre with little energy."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.draws import Draws
from pelagos.envs.task import Outcome, Start, Task
from pelagos.envs.view import View
from pelagos.jit import Array
from pelagos.math.so3 import from_euler

_RADIUS_M = 800.0
_DRAG_W = (
    25.0  # of propulsion at 1 m/s through the water, assumed of a REMUS 100: power goes with the cube of the speed
)
_HOTEL_W = 10.0  # assumed


class GyreTransect(Task):
    """A REMUS 100 crosses a gyre of 800 m radius, whose water turns once in 2 h (0.7 m/s at its edge), to a goal.

    Start and goal lie opposite each other at 700 m from the centre. Actions are the course, +-180 degrees of north, and
    the speed through the water from 0.5 to 1.9 m/s, every 10 s. The reward of a step is the way that it came nearer, in
    hundreds of metres, less the energy that it took, in tens of kJ; within 50 m of the goal the episode ends with 5.
    """

    vehicle: str | Mapping[str, Any] = "remus100"
    control = "depth_heading_speed"
    actions = 3
    rate_hz = 0.1
    tick_rate_hz = 10.0
    seconds = 3000.0
    ocean: Mapping[str, Any] = {"currents": [{"type": "gyre", "radius_m": _RADIUS_M, "period_s": 7200.0}]}
    observations = (
        "goal_north_km", "goal_west_km", "north_km", "west_km", "current_north_mps", "current_west_mps", "surge_mps",
        "time",
    )  # fmt: skip

    def draw(self, random: Draws) -> Start:
        """On a circle of 700 m, bow to the goal on its other side."""
        way = random.uniform(-math.pi, math.pi)
        x, y = 700.0 * dr.cos(way), 700.0 * dr.sin(way)
        memory = {"goal_x": -x, "goal_y": -y, "goal_z": -20.0, "before": 1400.0, "energy": 0.0}
        yaw = way + math.pi
        return Start([x, y, -20.0], [*from_euler(0.0, 0.0, yaw)], [1.2, 0.0, 0.0], memory=memory)

    def command(self, action: list[Array], now: View) -> list[Array]:
        """Depth, compass heading of the direction (first two numbers), speed through the water."""
        course = dr.atan2(action[1], action[0] + 1e-9)
        return [20.0, -course, 1.2 + 0.7 * action[2]]

    def observe(self, now: View, random: Draws) -> list[Array]:
        """Goal and place, the current here, own speed, and the share of the time that has passed."""
        north, west = self._away(now)
        x, y, _ = now.position
        current = now.current
        return [
            north / 1000, west / 1000, x / 1000, y / 1000, current[0], current[1], now.velocity[0],
            now.t / self.seconds,
        ]  # fmt: skip

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """See the class."""
        north, west = self._away(now)
        distance = dr.sqrt(north * north + west * west)
        speed = 1.2 + 0.7 * action[2]
        took = (_DRAG_W * speed * speed * speed + _HOTEL_W) / self.rate_hz * 1e-3  # kJ
        there = distance < 50.0
        reward = 0.01 * (now.memory["before"] - distance) - 0.1 * took + dr.select(there, 5.0, 0.0)
        energy = now.memory["energy"] + took
        metrics = {"distance_m": distance, "energy_kj": energy, "success": dr.select(there, 1.0, 0.0)}
        return Outcome(reward, there, memory={"before": distance, "energy": energy}, metrics=metrics)

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: straight to the goal over ground at 1.2 m/s, the current steered against."""
        goal = seen[:, 0:2] / np.maximum(np.linalg.norm(seen[:, 0:2], axis=1, keepdims=True), 1e-6)
        across = np.stack([-goal[:, 1], goal[:, 0]], axis=1)
        drift = np.clip((seen[:, 4:6] * across).sum(axis=1, keepdims=True) / 1.2, -0.95, 0.95)
        way = np.sqrt(1 - drift**2) * goal - drift * across
        return np.concatenate([way, np.zeros((len(seen), 1))], axis=1).astype(np.float32)

    def _away(self, now: View) -> tuple[Array, Array]:
        return now.memory["goal_x"] - now.position[0], now.memory["goal_y"] - now.position[1]

"""Hold a boat's place among waves."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.draws import Draws
from pelagos.envs.task import Outcome, Sea, Start, Task
from pelagos.envs.view import View, minus, wrapped
from pelagos.jit import Array
from pelagos.math.so3 import from_euler

_MOMENTS_S = 3600.0  # of the sea, at which episodes may begin


class StationKeeping(Task):
    """An Otter holds its place and heading in waves of 0.3 m and a current, by its two propellers.

    The reward of a step is 1 at the pose and falls with distance and heading error, less what the propellers take;
    beyond 20 m the episode ends.
    """

    vehicle: str | Mapping[str, Any] = "otter"
    control = "actuators"
    rate_hz = 10.0
    tick_rate_hz = 50.0
    seconds = 40.0
    ocean: Mapping[str, Any] = {
        "waves": {"type": "jonswap", "significant_height_m": 0.3, "peak_period_s": 4.0, "towards_deg": 30.0}
    }
    observations = (
        "ahead_m", "left_m", "heading_sine", "heading_cosine", "roll_rad", "pitch_rad", "surge_mps", "sway_mps",
        "yaw_rate", "left_propeller", "right_propeller",
    )  # fmt: skip

    def __init__(self, *, reach_m: float = 5.0, current_mps: float = 0.3) -> None:
        self.reach_m, self.current_mps = reach_m, current_mps
        self.goal = (0.0, 0.0, 0.0)

    def draw(self, random: Draws) -> Start:
        """Anywhere near, any heading, at rest; waves from anywhere."""
        x, y = random.box((-self.reach_m,) * 2, (self.reach_m,) * 2)
        yaw, way = random.uniform(-math.pi, math.pi), random.uniform(-math.pi, math.pi)
        speed = self.current_mps * dr.sqrt(random.uniform())
        current = [speed * dr.cos(way), speed * dr.sin(way), 0.0]
        sea = Sea(turn_rad=random.uniform(-math.pi, math.pi), moment_s=random.uniform(0.0, _MOMENTS_S))
        attitude = [*from_euler(0.0, 0.0, yaw)]
        return Start([x, y, 0.0], attitude, memory={"yaw": way + math.pi}, current=current, sea=sea)

    def command(self, action: list[Array], now: View) -> list[Array]:
        """Both propellers' speeds [rad/s]."""
        return [100.0 * a for a in action]

    def observe(self, now: View, random: Draws) -> list[Array]:
        """The place from the boat, the heading to hold (into the current), attitude, velocities, propellers."""
        away, turn = self._away(now), wrapped(now.memory["yaw"] - now.yaw)
        up = now.to_body([0.0, 0.0, 1.0])
        pitch = dr.asin(dr.clip(-now.forward[2], -1.0, 1.0))
        return [
            *away, dr.sin(turn), dr.cos(turn), dr.atan2(up[1], up[2]), pitch, *now.velocity[:2],
            now.angular_velocity[2], *(0.01 * a for a in now.actuators[:2]),
        ]  # fmt: skip

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """See the class."""
        ahead, left = self._away(now)
        distance, turn = dr.sqrt(ahead * ahead + left * left), dr.abs(wrapped(now.memory["yaw"] - now.yaw))
        effort = sum(a * a for a in action) / len(action)
        reward = dr.exp(-0.5 * distance) * (0.7 + 0.3 * dr.exp(-2.0 * turn)) - 0.05 * effort
        metrics = {"distance_m": distance, "heading_error_rad": turn}
        return Outcome(reward, distance > 20.0, metrics=metrics)

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: far off, the bow to the place and ahead; near it, the heading and the way along it."""
        ahead, left = seen[:, 0], seen[:, 1]
        distance, bearing = np.hypot(ahead, left), np.arctan2(left, ahead)
        back = np.abs(bearing) > np.pi / 2
        bearing = np.where(back, np.arctan2(-left, -ahead), bearing)
        far = distance > 1.5
        turn = np.where(far, bearing, np.arctan2(seen[:, 2], seen[:, 3]) + np.clip(0.5 * left, -0.5, 0.5))
        push = np.clip(np.where(far, np.where(back, -0.5, 0.5) * np.cos(bearing), 0.4 * ahead), -0.6, 0.6)
        push = push - 0.4 * seen[:, 6] * ~far
        steer = np.clip(0.5 * turn - 0.5 * seen[:, 8], -0.4, 0.4)
        made = np.clip(np.stack([push - steer, push + steer], axis=1), -1.0, 1.0)
        return np.asarray(made, dtype=np.float32)

    def _away(self, now: View) -> list[Array]:
        """The place from the boat, along its heading and to its left [m]."""
        north, west, _ = minus([0.0, 0.0, 0.0], now.position)
        s, c = dr.sincos(now.yaw)
        return [c * north + s * west, c * west - s * north]

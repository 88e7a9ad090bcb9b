"""Steer a torpedo: depth and heading under rudder and stern plane."""

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

_FIN_RAD = math.radians(15.0)


class DepthHeading(Task):
    """A REMUS 100 under way at 1200 rpm takes another depth and another heading, by rudder and stern plane.

    Goals are up to 5 m and 90 degrees away, in a current. The reward of a step is 1 at both and falls with the errors,
    less what the fins move; above 1 m of depth, or where it stands on its nose or tail, the episode ends.
    """

    vehicle: str | Mapping[str, Any] = "remus100"
    control = "actuators"
    actions = 2
    rate_hz = 10.0
    tick_rate_hz = 50.0
    seconds = 30.0
    observations = (
        "depth_error_m", "heading_sine", "heading_cosine", "roll_rad", "pitch_rad", "surge_mps", "sway_mps",
        "heave_mps", "roll_rate", "pitch_rate", "yaw_rate", "rudder", "stern_plane",
    )  # fmt: skip

    def __init__(self, *, depth_change_m: float = 5.0, turn_deg: float = 90.0, current_mps: float = 0.3) -> None:
        self.depth_change_m, self.turn_rad, self.current_mps = depth_change_m, math.radians(turn_deg), current_mps

    def draw(self, random: Draws) -> Start:
        """At 20 m, any heading, 1.2 m/s."""
        yaw, way = random.uniform(-math.pi, math.pi), random.uniform(-math.pi, math.pi)
        current = [self.current_mps * dr.cos(way), self.current_mps * dr.sin(way), 0.0]
        memory = {
            "depth": 20.0 + random.uniform(-self.depth_change_m, self.depth_change_m),
            "yaw": yaw + random.uniform(-self.turn_rad, self.turn_rad),
        }
        return Start([0.0, 0.0, -20.0], [*from_euler(0.0, 0.0, yaw)], [1.2, 0.0, 0.0], memory=memory, current=current)

    def command(self, action: list[Array], now: View) -> list[Array]:
        """Fins to 15 degrees, and a steady propeller."""
        return [_FIN_RAD * action[0], _FIN_RAD * action[1], 1200.0]

    def observe(self, now: View, random: Draws) -> list[Array]:
        """Errors, attitude, velocities and where the fins stand."""
        depth, turn = self._errors(now)
        up = now.to_body([0.0, 0.0, 1.0])
        pitch = dr.asin(dr.clip(-now.forward[2], -1.0, 1.0))
        fins = [a / _FIN_RAD for a in now.actuators[:2]]
        return [
            depth, dr.sin(turn), dr.cos(turn), dr.atan2(up[1], up[2]), pitch, *now.velocity, *now.angular_velocity,
            *fins,
        ]  # fmt: skip

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """See the class."""
        depth, turn = self._errors(now)
        fins = sum(a * a for a in action)
        reward = 0.5 * dr.exp(-dr.abs(depth)) + 0.5 * dr.exp(-2.0 * dr.abs(turn)) - 0.05 * fins
        out = (now.position[2] > -1.0) | (dr.abs(now.forward[2]) > math.sin(math.radians(75.0)))
        metrics = {"depth_error_m": dr.abs(depth), "heading_error_rad": dr.abs(turn)}
        return Outcome(reward - dr.select(out, 10.0, 0.0), out, metrics=metrics)

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: depth by pitch and stern plane, heading by rudder, both with rate feedback."""
        depth, sine, cosine, pitch = seen[:, 0], seen[:, 1], seen[:, 2], seen[:, 4]
        turn = np.arctan2(sine, cosine)
        rudder = -2.0 * turn + 2.0 * seen[:, 10]
        wanted = np.clip(0.15 * depth, -0.35, 0.35)  # bow down to go deeper
        plane = 3.0 * (wanted - pitch) - 2.0 * seen[:, 9]
        return np.asarray(np.clip(np.stack([rudder, plane], axis=1), -1.0, 1.0), dtype=np.float32)

    def _errors(self, now: View) -> tuple[Array, Array]:
        return now.memory["depth"] + now.position[2], wrapped(now.memory["yaw"] - now.yaw)

"""Come home into a dock."""

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
from pelagos.envs.view import View, norm, wrapped
from pelagos.jit import Array
from pelagos.math.so3 import from_euler


class Docking(Task):
    """A BlueROV2 Heavy enters a funnel that opens to the south, in a current across it, and rests at its end.

    The funnel's end is the origin at `depth_m`, its axis goes south, and it widens by 0.5 m for each metre. It is
    docked within 0.15 m of the end, with the bow north within 10 degrees, below 0.2 m/s: +10. Outside the funnel, less
    than 1 m south of its end or beyond it, the episode ends with -5; farther off than 12 m, too. The reward of a step
    is the way that it came nearer to a point ahead on the axis, less 0.02 for the time and what the thrusters take.
    """

    vehicle: str | Mapping[str, Any] = rov()
    control = "actuators"
    seconds = 30.0
    observations = (
        "north_m", "west_m", "up_m", "sine", "cosine", "tilt_x", "tilt_y", "tilt_z", "surge_mps", "sway_mps",
        "heave_mps", "roll_rate", "pitch_rate", "yaw_rate",
    )  # fmt: skip

    def __init__(self, *, current_mps: float = 0.2, depth_m: float = 20.0) -> None:
        self.current_mps, self.depth_m = current_mps, depth_m
        self.goal = (0.0, 0.0, -depth_m)

    def draw(self, random: Draws) -> Start:
        """3 to 8 m south of the dock, up to 2 m beside the axis, any heading within 60 degrees."""
        x, y, z = random.box((-8.0, -2.0, -1.5), (-3.0, 2.0, 1.5))
        attitude = [*from_euler(0.0, 0.0, random.uniform(-math.pi / 3, math.pi / 3))]
        across = random.uniform(-self.current_mps, self.current_mps)
        return Start([x, y, z - self.depth_m], attitude, memory={"before": _cost(x, y, z)}, current=[0.0, across, 0.0])

    def observe(self, now: View, random: Draws) -> list[Array]:
        """Place seen from the dock, heading, direction of up, and velocities."""
        sine, cosine = dr.sincos(now.yaw)
        tilt = now.to_body([0.0, 0.0, 1.0])
        return [*self._place(now), sine, cosine, *tilt, *now.velocity, *now.angular_velocity]

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """See the class."""
        x, y, z = self._place(now)
        aside, turn, speed = dr.sqrt(y * y + z * z), dr.abs(wrapped(now.yaw)), norm(now.velocity)
        distance = norm([x, y, z])
        docked = (distance < 0.15) & (turn < math.radians(10.0)) & (speed < 0.2)
        struck = ((x > -1.0) & (aside > 0.2 - 0.5 * dr.minimum(x, 0.0))) | (x > 0.2)
        lost = distance > 12.0
        cost = _cost(x, y, z)
        effort = sum(a * a for a in action) / len(action)
        reward = now.memory["before"] - cost - 0.02 - 0.01 * effort - 0.02 * turn
        reward = reward + dr.select(docked, 10.0, dr.select(struck | lost, -5.0, 0.0))
        metrics = {"distance_m": distance, "success": dr.select(docked, 1.0, 0.0)}
        return Outcome(reward, docked | struck | lost, memory={"before": cost}, metrics=metrics)

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: first onto the axis with the bow north, then along it, slower the farther from the axis."""
        s = seen.astype(np.float64)
        x, y, z = s[:, 0], s[:, 1], s[:, 2]
        aside = np.hypot(y, z)
        ahead = np.clip(-x, 0.0, 0.6) * np.clip(1.5 - 2.0 * aside, 0.0, 1.0)
        ahead = np.where((x > -1.5) & (aside > 0.4), -0.4, ahead)
        sine, cosine = s[:, 3], s[:, 4]
        north, west, up = ahead, np.clip(-y, -0.6, 0.6), np.clip(-z, -0.6, 0.6)
        body = np.stack([cosine * north + sine * west, cosine * west - sine * north, up], axis=1)
        force = 90.0 * (body - s[:, 8:11])
        moment = np.stack([-6.0 * s[:, 6], 6.0 * s[:, 5], -4.0 * np.arctan2(sine, cosine)], axis=1) - 3.0 * s[:, 11:14]
        return throttles(NAME, force, moment)

    def _place(self, now: View) -> tuple[Array, Array, Array]:
        return now.position[0], now.position[1], now.position[2] + self.depth_m


def _cost(x: Array, y: Array, z: Array) -> Array:
    """Remaining way [m], its part across the axis twice."""
    return dr.sqrt(x * x + 4.0 * (y * y + z * z))

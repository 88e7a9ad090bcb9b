"""Hover as MarineGym defines it, for comparison."""

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
from pelagos.math.so3 import from_euler, rotate_back_np

_GOAL_M = -10.0  # depth of the goal here; there it is 2 m above a floor, in water without a surface
_FLOOR_M = 1.8  # below the goal an episode ends


class MarineGymHover(Task):
    """A BlueROV2 Heavy comes to a point and a heading that is drawn, as in MarineGym's task Hover.

    Starts, observation, reward, weights (0.1 for effort, 0 for smoothness, scale 1.2) and ends follow its source (Chu
    et al., arXiv 2503.09203; `envs/single/hover.py` and `cfg/task/HoverRand.yaml`). The vehicle is Pelagos' own with
    the parameters of Wu 2018, as there; time step 16 ms, assumed. Effort is the sum of the throttles' sizes.
    """

    vehicle: str | Mapping[str, Any] = rov("wu_2018")
    control = "actuators"
    rate_hz = 62.5
    tick_rate_hz = 62.5
    seconds = 3.2  # 200 steps
    observations = (
        "goal_x", "goal_y", "goal_z", "q_w", "q_x", "q_y", "q_z", "v_x", "v_y", "v_z", "w_x", "w_y", "w_z",
        "heading_x", "heading_y", "heading_z", "up_x", "up_y", "up_z", *(f"throttle_{i}" for i in range(8)),
        "goal_heading_x", "goal_heading_y", "goal_heading_z", *(f"time_{i}" for i in range(4)),
    )  # fmt: skip

    def __init__(self) -> None:
        self.goal = (0.0, 0.0, _GOAL_M)

    def draw(self, random: Draws) -> Start:
        """Within 2.5 m horizontally and 0.5 m vertically, 0.2 pi of roll and pitch, any heading and goal heading."""
        x, y, z = random.box((-2.5, -2.5, -0.5), (2.5, 2.5, 0.5))
        roll, pitch = random.box((-0.2 * math.pi,) * 2, (0.2 * math.pi,) * 2)
        attitude = [*from_euler(roll, pitch, random.uniform(0.0, 2 * math.pi))]
        return Start([x, y, z + _GOAL_M], attitude, memory={"heading": random.uniform(0.0, 2 * math.pi)})

    def observe(self, now: View, random: Draws) -> list[Array]:
        """Everything in world axes."""
        sign = now.to_world(now.angular_velocity)
        time = [now.t / self.seconds] * 4
        away, turned = self._errors(now)
        return [
            *away, *now.attitude, *now.ground_velocity, *sign, *now.forward, *now.up, *now.actuators, *turned, *time,
        ]  # fmt: skip

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """Pose, uprightness, spin and effort."""
        away, turned = self._errors(now)
        distance = norm([*away, *turned])
        pose = 0.5 / (1.0 + (1.2 * distance) ** 2)
        upright = ((now.up[2] + 1.0) / 2.0) ** 2
        spin = 1.0 / (1.0 + now.to_world(now.angular_velocity)[2] ** 4)
        effort = 0.1 * dr.exp(-sum(dr.abs(a) for a in action))
        low = now.position[2] < _GOAL_M - _FLOOR_M
        return Outcome(
            pose + pose * (upright + spin) + effort, low | (distance > 4.0), metrics={"distance_m": norm(away)}
        )

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: a spring and a damper to the pose, upright."""
        s = seen.astype(np.float64)
        world = s[:, 0:3], s[:, 7:10], s[:, 10:13], s[:, 27:30] + s[:, 13:16], np.tile([0.0, 0.0, 1.0], (len(s), 1))
        away, speed, spin, wanted, up = (rotate_back_np(s[:, 3:7], v) for v in world)
        turn = np.arctan2(wanted[:, 1], wanted[:, 0])
        force = 80.0 * np.clip(away, -2.0, 2.0) - 40.0 * speed
        moment = np.stack([-16.0 * up[:, 1], 16.0 * up[:, 0], 12.0 * turn], axis=1) - 3.0 * spin
        return throttles(NAME, force, moment)

    def _errors(self, now: View) -> tuple[list[Array], list[Array]]:
        """To the goal [m], and from the bow's direction to the one asked for."""
        s, c = dr.sincos(now.memory["heading"])
        return minus([*self.goal], now.position), minus([c, s, 0.0], now.forward)

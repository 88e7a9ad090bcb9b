"""Hover as OceanScale defines it, for comparison."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.draws import Draws
from pelagos.envs.scripted import mixer
from pelagos.envs.task import Outcome, Start, Task
from pelagos.envs.tasks.rov import NAME, rov
from pelagos.envs.view import View, minus, norm
from pelagos.hydro.algebra import cross
from pelagos.jit import Array
from pelagos.math.so3 import from_euler, rotate_back_np
from pelagos.vehicles.vehicle import Vehicle

_GOAL_M = -10.0  # depth of the goal here; there it is at 1.5 m, in water without a surface
_OUT_M = 5.0
_NOISE = 0.02  # standard deviation of every number that is seen, whatever its unit
_SCALES = (0.5, 1.0), (0.3, 0.5), (0.2, 1.0)  # weight and scale of distance [m], of the twist [m/s, rad/s], of effort


class OceanScaleHover(Task):
    """A BlueROV2 Heavy keeps a point, as in OceanScale's `ROVEnv` with its defaults, the one that its benchmark steps.

    Starts, observation with its noise, action, reward, limit (1000 steps of 1/240 s, one tick each) and end follow its
    source (robotlearning123/isaac-auv-env, `oceanscale/rov_env.py`, May 2026; no current, no randomisation). An action
    is a wrench, shared among the thrusters by the pseudo-inverse; throttles beyond 1 are cut one by one. `turn` and
    `tilt` are its two "heading errors", 2 atan2(q_z, q_w) and 2 asin(q_y q_w - q_x q_z).

    Assumed, or unlike it: the vehicle, its thrusters (there 51.5 N either way) and their lag of 0.1 s are Pelagos'
    own, the first from the same publication (von Benzon 2022), in its fresh water, with an inertia that is no
    sphere's; velocities are the body's, as its documentation says; a copy beyond 5 m ends its episode here, while
    there it begins anew without a flag, with the reward of 0 that it has here too. `force_z` and the moments are all
    that moves the rigid body, without the added mass: there the last step's, before its integration.
    """

    vehicle: str | Mapping[str, Any] = rov()
    control = "actuators"
    actions = 6
    rate_hz = 240.0
    tick_rate_hz = 240.0
    seconds = 1000 / 240
    observations = (
        "goal_x", "goal_y", "goal_z", "q_x", "q_y", "q_z", "q_w", "surge_mps", "sway_mps", "heave_mps", "roll_rate",
        "pitch_rate", "yaw_rate", "above_m", "turn", "tilt", *(f"action_{i}" for i in range(6)), "force_z", "moment_x",
        "moment_y", "moment_z",
    )  # fmt: skip

    def __init__(self) -> None:
        self.goal = (0.0, 0.0, _GOAL_M)

    def draw(self, random: Draws) -> Start:
        """Within 0.5 m in each direction and 0.5 rad of heading, level, at rest."""
        x, y, z = random.box((-0.5, -0.5, -0.5), (0.5, 0.5, 0.5))
        attitude = [*from_euler(0.0, 0.0, random.uniform(-0.5, 0.5))]
        return Start([x, y, z + _GOAL_M], attitude, memory={f"action_{i}": 0.0 for i in range(6)})

    def command(self, action: list[Array], now: View) -> list[Array]:
        """Throttles: their squares are the shares of the largest thrust that a wrench asks for."""
        shares = [dr.clip(sum(m * a for m, a in zip(row, action, strict=True)), -1.0, 1.0) for row in _sharing()]
        return [dr.sign(u) * dr.sqrt(dr.abs(u)) for u in shares]

    def observe(self, now: View, random: Draws) -> list[Array]:
        """Everything with noise of 0.02."""
        away, (w, x, y, z) = minus([*self.goal], now.position), now.attitude
        angles = [2 * dr.atan2(z, w), 2 * dr.asin(dr.clip(y * w - x * z, -1.0, 1.0))]
        before = [now.memory[f"action_{i}"] for i in range(6)]
        twist = [*now.velocity, *now.angular_velocity]
        seen = [*away, x, y, z, w, *twist, away[2], *angles, *before, *_wrench(now)]
        return [number + random.normal(0.0, _NOISE) for number in seen]

    def reward(self, now: View, action: list[Array]) -> Outcome:
        """Nearness, stillness and little effort, each exp(-size / scale)."""
        distance = norm(minus([*self.goal], now.position))
        sizes = distance, norm([*now.velocity, *now.angular_velocity]), norm(action)
        parts = [weight * dr.exp(-size / scale) for (weight, scale), size in zip(_SCALES, sizes, strict=True)]
        out = distance > _OUT_M
        memory = {f"action_{i}": a for i, a in enumerate(action)}
        return Outcome(dr.select(out, 0.0, sum(parts)), out, memory, {"distance_m": distance})

    def script(self, seen: NDArray[np.float32]) -> NDArray[np.float32]:
        """The baseline: a spring and a damper to the point, weak as effort counts."""
        s = seen.astype(np.float64)
        attitude = s[:, [6, 3, 4, 5]]
        attitude /= np.linalg.norm(attitude, axis=1, keepdims=True)
        force = 1.2 * rotate_back_np(attitude, s[:, 0:3]) - 0.6 * s[:, 7:10]
        return np.concatenate([force, -0.03 * s[:, 10:13]], axis=1).clip(-1, 1).astype(np.float32)


@cache
def _sharing() -> list[list[float]]:
    """Share of its largest thrust that each thruster gives to a unit of each axis of a wrench, FLU."""
    mix, _ = mixer(NAME)
    return [[float(m) for m in row] for row in mix * np.array([1.0, -1.0, -1.0, 1.0, -1.0, -1.0])]


@cache
def _rigid() -> list[float]:
    """Mass [kg] three times, and moments of inertia about the axes [kg m^2]; the origin is the centre of gravity."""
    rigid = Vehicle.from_catalogue(NAME).model.inertia.rigid
    return [float(rigid[i][i]) for i in range(6)]


def _wrench(now: View) -> list[Array]:
    """Upward force [N] and moments [N m] on the rigid body, in the body's axes, from how it accelerates."""
    (_, _, mass, *inertia), v, turn = _rigid(), now.velocity, now.angular_velocity
    spin = [i * w for i, w in zip(inertia, turn, strict=True)]
    moments = [i * a + c for i, a, c in zip(inertia, now.angular_acceleration, cross(turn, spin), strict=True)]
    return [mass * (now.acceleration[2] + cross(turn, v)[2]), *moments]

"""Several vehicles in one sea as a PettingZoo `ParallelEnv`: keep a formation by ranges to each other."""

from __future__ import annotations

import math
from typing import Any, Final

import gymnasium
import numpy as np
from numpy.typing import NDArray
from pettingzoo import ParallelEnv

from pelagos.envs.tasks.rov import rov
from pelagos.errors import CommandError
from pelagos.math.so3 import rotate_back_np
from pelagos.sim.seed import seed_of
from pelagos.sim.simulation import Simulation

_DEPTH_M: Final = 10.0
_RATE_HZ: Final = 5.0
_RANGE_NOISE_M: Final = 0.05  # standard deviation, assumed of acoustic ranging at short range
_LOST_M: Final = 12.0


class FormationEnv(ParallelEnv[str, Any, Any]):  # type: ignore[misc]
    """BlueROV2 Heavies on a ring, evenly, around a point that moves north; each knows ranges to the others.

    An action is surge, sway (0.5 m/s each) and the rate of turn (0.5 rad/s), -1 .. 1. Seen by each: the ring's middle
    from its body (2) [m], velocities ahead and to the left [m/s], sine and cosine of the heading, and the range to
    every other vehicle in order, with noise of 5 cm [m]. The reward of a step, one for all, is 1 less the mean error of
    the ring's radius and of the ranges that an even ring has [m]. Farther than 12 m from the middle ends it for all.

    Attributes:
        sim: the simulation.
    """

    metadata: dict[str, Any] = {"name": "pelagos_formation_v0", "render_modes": []}  # noqa: RUF012

    def __init__(
        self, vehicles: int = 3, *, radius_m: float = 3.0, speed_mps: float = 0.1, seconds: float = 60.0
    ) -> None:
        """So many vehicles on a ring of `radius_m` whose middle moves at `speed_mps`, for `seconds`.

        Raises:
            CommandError: too few or too many.
        """
        if not 2 <= vehicles <= 50:
            raise CommandError(f"a formation has 2 to 50 vehicles, not {vehicles}")
        self.possible_agents = [f"rov{i}" for i in range(vehicles)]
        self.agents: list[str] = []
        self.radius_m, self.speed_mps, self._limit = radius_m, speed_mps, round(seconds * _RATE_HZ)
        side = [2 * radius_m * math.sin(math.pi * k / vehicles) for k in range(1, vehicles)]
        self._even = np.sort(np.array(side))
        box, far = gymnasium.spaces.Box, np.float32(1e3)
        self._seen = {a: box(-far, far, (6 + vehicles - 1,), np.float32) for a in self.possible_agents}
        self._acts = {a: box(np.float32(-1), np.float32(1), (3,), np.float32) for a in self.possible_agents}
        self.sim = Simulation.load(self._scenario())
        self._random = np.random.default_rng(0)
        self._seed, self._episode, self._step = 0, -1, 0

    def observation_space(self, agent: str) -> gymnasium.Space[Any]:
        """Of one vehicle."""
        return self._seen[agent]

    def action_space(self, agent: str) -> gymnasium.Space[Any]:
        """Of one vehicle."""
        return self._acts[agent]

    def reset(
        self, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[dict[str, Any], dict[str, Any]]:
        """The next episode, or number 0 of a seed: places near the ring, any heading; there are no options.

        PettingZoo asks environments to take options that they do not know.
        """
        if seed is not None:
            self._seed, self._episode = seed_of(seed), -1
        self._episode += 1
        self._random = np.random.default_rng([self._seed, self._episode])
        self.agents, self._step = list(self.possible_agents), 0
        state = {}
        for i, name in enumerate(self.agents):
            way, yaw = 2 * math.pi * i / len(self.agents), self._random.uniform(-math.pi, math.pi)
            away = self.radius_m + self._random.uniform(0.0, 1.5)
            state[name] = {
                "position": [away * math.cos(way), away * math.sin(way), -_DEPTH_M],
                "attitude": [math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)],
            }
        self.sim.reset(seed=self._seed, episode=self._episode, state=state)
        return self._observed(), {name: {} for name in self.agents}

    def step(self, actions: dict[str, Any]) -> tuple[dict[str, Any], ...]:
        """One decision of all: observations, rewards, terminations, truncations, infos."""
        if set(actions) != set(self.agents):
            raise CommandError(f"actions are those of {', '.join(self.agents) or 'nobody'}; given {', '.join(actions)}")
        commands = {}
        for name, given in actions.items():
            a = np.clip(np.asarray(given, dtype=np.float64), -1.0, 1.0) * 0.5
            commands[name] = np.array([a[0], a[1], 0.0, a[2]])
        self.sim.step(commands, ticks=round(1e9 / (_RATE_HZ * self.sim.dt_ns)))
        self._step += 1
        away = np.linalg.norm(self._places() - self._middle(), axis=1)
        ring = float(np.abs(away - self.radius_m).mean())
        even = float(np.abs(np.sort(self._ranges(), axis=1) - self._even).mean())
        lost, late = bool((away > _LOST_M).any()), self._step >= self._limit
        seen, told = self._observed(), {"ring_error_m": ring, "range_error_m": even}
        names = self.agents
        if lost or late:
            self.agents = []
        return (
            {n: seen[n] for n in names}, dict.fromkeys(names, 1.0 - ring - even), dict.fromkeys(names, lost),
            dict.fromkeys(names, late and not lost), {n: dict(told) for n in names},
        )  # fmt: skip

    def script(self, seen: dict[str, NDArray[np.float32]]) -> dict[str, NDArray[np.float32]]:
        """The baseline: each goes to its own place on the ring, which it knows by its number."""
        acts = {}
        for name, s in seen.items():
            way = 2 * math.pi * self.possible_agents.index(name) / len(self.possible_agents)
            north, west = self.radius_m * math.cos(way), self.radius_m * math.sin(way)
            sine, cosine = float(s[4]), float(s[5])
            goal = s[0:2] + np.array([cosine * north + sine * west, cosine * west - sine * north])
            acts[name] = np.clip(np.array([goal[0] + 0.2 * cosine, goal[1] - 0.2 * sine, 0.0]), -1, 1).astype(
                np.float32
            )
        return acts

    def _scenario(self) -> dict[str, Any]:
        n = len(self.possible_agents)
        agents = {}
        for i, name in enumerate(self.possible_agents):
            way = 2 * math.pi * i / n
            place = [self.radius_m * math.cos(way), self.radius_m * math.sin(way), -_DEPTH_M]
            agents[name] = {"vehicle": rov(), "control": "velocity", "start": {"position_m": place}}
        return {"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 40.0}, "agents": agents}

    def _middle(self) -> NDArray[np.float64]:
        return np.array([self.speed_mps * self._step / _RATE_HZ, 0.0, -_DEPTH_M])

    def _places(self) -> NDArray[np.float64]:
        return np.array([self.sim.state[name].position[0] for name in self.possible_agents])

    def _ranges(self) -> NDArray[np.float64]:
        """From each to the others `(m, m - 1)` [m]."""
        p, n = self._places(), len(self.possible_agents)
        found = np.linalg.norm(p[:, None] - p[None], axis=2)
        return np.asarray(found[~np.eye(n, dtype=bool)].reshape(n, n - 1))

    def _observed(self) -> dict[str, NDArray[np.float32]]:
        ranges, middle, found = self._ranges(), self._middle(), {}
        ranges = ranges + self._random.normal(0.0, _RANGE_NOISE_M, ranges.shape)
        for i, name in enumerate(self.possible_agents):
            s = self.sim.state[name]
            away = rotate_back_np(s.attitude, (middle - s.position[0])[None])[0]
            yaw = float(s.euler[0, 2])
            numbers = [*away[:2], *s.velocity[0, :2], math.sin(yaw), math.cos(yaw), *ranges[i]]
            found[name] = np.array(numbers, dtype=np.float32)
        return found

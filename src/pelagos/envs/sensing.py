"""Environments with sensors in the loop: copies of a scenario, whose sonars and cameras answer in one call for all.

Where `FleetEnv` compiles a task with the physics into one kernel and sees the true state, `SensingEnv` steps a
`Simulation`: the world, its sensors with their noise, and contact. Its tasks are written in NumPy.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

import gymnasium
import numpy as np
from gymnasium.vector import VectorEnv
from gymnasium.vector.utils import batch_space
from numpy.typing import NDArray

from pelagos.envs.fleet import MODES
from pelagos.envs.program import Autoreset
from pelagos.errors import CommandError, LookupFailed
from pelagos.sim.lives import Observations
from pelagos.sim.seed import seed_of
from pelagos.sim.simulation import Simulation


@dataclass
class Judgement:
    """reward `(n,)`, terminated `(n,)`, and metrics `(n,)` by name."""

    reward: NDArray[np.float64]
    terminated: NDArray[np.bool_]
    metrics: dict[str, NDArray[np.float64]] = field(default_factory=dict)


class SensingTask(Protocol):
    """Task for a vehicle with sensors. A class that names this one as its base has these defaults.

    Attributes:
        agent: whose actions they are.
        actions: how many numbers between -1 and 1 an action has.
        rate_hz: of decisions; the scenario's ticks are a multiple of it, and its sensors read at it.
        seconds: an episode lasts at most [s].
        space: of one copy's observation, a `gymnasium.spaces.Dict`.
    """

    agent: str = "auv0"
    actions: int
    rate_hz: float = 5.0
    seconds: float = 60.0
    space: gymnasium.spaces.Dict

    def scenario(self) -> Mapping[str, Any]:
        """Scenario of the task."""
        ...

    def start(self, random: np.random.Generator, sim: Simulation) -> dict[str, Any]:
        """Beginning of one copy's episode: `position` (3), `attitude` (4) ..., as `Simulation.reset` has them.

        `sim` is there to be asked about the world, not to be changed.
        """
        ...

    def command(self, actions: NDArray[np.float64], sim: Simulation) -> NDArray[np.float64]:
        """Set-points `(n, k)` in the agent's control mode for actions `(n, m)`."""
        ...

    def observe(self, sim: Simulation, readings: Mapping[str, Any]) -> dict[str, NDArray[Any]]:
        """Observation of the policy, arrays `(n, ...)` by the names of `space`, from the agent's readings."""
        ...

    def judge(self, sim: Simulation, actions: NDArray[np.float64], began: NDArray[np.bool_]) -> Judgement:
        """Outcome of the step that led here; `began` `(n,)` says whose first step it was."""
        ...


class SensingEnv(VectorEnv[Any, Any, Any]):
    """`n` copies of a task with sensors.

    Observations are a dictionary of arrays `(n, ...)`; otherwise as `FleetEnv`: `info` has the metrics, `final_obs`
    with `_final_obs`, `final_info`, and `not_finite` where a copy's state broke.

    Attributes:
        sim: the simulation.
    """

    def __init__(
        self, task: SensingTask, n: int = 1, *, seed: int = 0, environment: int = 0, autoreset: Autoreset = "same_step"
    ) -> None:
        """Build the scenario for `n` copies; see `FleetEnv` for the arguments.

        Raises:
            CommandError, LookupFailed: an argument that cannot be.
        """
        if autoreset not in MODES:
            raise LookupFailed("autoreset mode", str(autoreset), MODES)
        self.task, self._seed, self._first = task, seed_of(seed), seed_of(environment)
        self.sim = Simulation.load(dict(task.scenario()), n=n, seed=self._seed, environment=self._first)
        if task.agent not in self.sim.model.agents:
            raise LookupFailed("agent", task.agent, self.sim.model.agents, where=type(task).__name__)
        self.num_envs, self.autoreset = n, autoreset
        self.autoreset_mode = MODES[autoreset]
        self.metadata = {"autoreset_mode": self.autoreset_mode, "render_modes": []}
        ticks = 1e9 / (task.rate_hz * self.sim.dt_ns)
        if abs(ticks - round(ticks)) > 1e-6:
            raise CommandError(f"{type(task).__name__}: rate_hz {task.rate_hz:g} is no whole number of ticks")
        self._ticks, self._limit = round(ticks), max(1, round(task.seconds * task.rate_hz))
        box = gymnasium.spaces.Box(np.float32(-1), np.float32(1), (task.actions,), np.float32)
        self.single_action_space, self.single_observation_space = box, task.space
        self.action_space, self.observation_space = batch_space(box, n), batch_space(task.space, n)
        self._step: NDArray[np.int64] = np.zeros(n, dtype=np.int64)
        self._episode: NDArray[np.int64] = np.full(n, -1, dtype=np.int64)
        self._over = np.zeros(n, dtype=bool)
        self.not_finite = 0

    @property
    def first_environment(self) -> int:
        """Index of the first copy."""
        return self._first

    @property
    def state(self) -> dict[str, NDArray[np.float64]]:
        """The agent's true states, as `FleetEnv.state` has them."""
        now = self.sim.state[self.task.agent]
        return {name: getattr(now, name) for name in ("position", "attitude", "velocity", "angular_velocity")}

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """As `FleetEnv.reset`."""
        options = dict(options or {})
        mask = options.pop("reset_mask", None)
        if options:
            raise LookupFailed("option of reset", next(iter(options)), ["reset_mask"])
        if mask is not None:
            where = np.asarray(mask)
            fits = where.dtype == np.bool_ and where.shape == (self.num_envs,) and where.any()
            if not fits or seed is not None or (self._episode < 0).any():
                raise CommandError(
                    f"reset_mask is ({self.num_envs},) bool with a True, after a first reset, and without a seed"
                )
            return self._begin(where), {}
        if seed is not None:
            super().reset(seed=seed)
            self._seed = seed_of(seed)
        if seed is not None or (self._episode < 0).any():
            self._episode[:] = -1
            self.sim.reset(seed=self._seed)
        return self._begin(np.ones(self.num_envs, dtype=bool)), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """One decision of all copies: observations, rewards, terminated, truncated, info."""
        if (self._episode < 0).any():
            raise CommandError("the first call is reset()")
        given = np.asarray(actions, dtype=np.float64)
        if given.shape != (self.num_envs, self.task.actions):
            raise CommandError(f"actions have shape ({self.num_envs}, {self.task.actions}); given {given.shape}")
        if not np.isfinite(given).all():
            bad = np.flatnonzero(~np.isfinite(given).all(axis=1))
            raise CommandError(f"actions are finite numbers; those of copy {bad[0]} are {given[bad[0]].tolist()}")
        given = np.clip(given, -1.0, 1.0)
        anew = self._over & (self.autoreset == "next_step")
        readings = self.sim.step({self.task.agent: self.task.command(given, self.sim)}, ticks=self._ticks)
        judged = self.task.judge(self.sim, given, self._step == 0)
        self._step += 1
        broken = self.sim.ended
        reward = np.where(broken, 0.0, judged.reward).astype(np.float32)
        if not np.isfinite(reward).all():
            first = int(np.flatnonzero(~np.isfinite(reward))[0])
            raise CommandError(f"{type(self.task).__name__}.judge gives copy {first} a reward of {reward[first]}")
        terminated = judged.terminated | broken
        truncated = ~terminated & (self._step >= self._limit)
        seen = self.task.observe(self.sim, readings[self.task.agent])
        info: dict[str, Any] = {k: v.astype(np.float32) for k, v in judged.metrics.items()}
        if anew.any():
            reward[anew], terminated[anew], truncated[anew] = 0.0, False, False
            seen = _mixed(anew, self._begin(anew), seen)
        done = terminated | truncated
        if (broken & ~anew).any():
            info["not_finite"] = broken & ~anew
            self.not_finite += int(info["not_finite"].sum())
        self._over = done
        if done.any() and self.autoreset == "same_step":
            info |= {"final_obs": seen, "_final_obs": done, "final_info": dict(info), "_final_info": done}
            seen = _mixed(done, self._begin(done), seen)
        return seen, reward, terminated, truncated, info

    def _begin(self, where: NDArray[np.bool_]) -> dict[str, NDArray[Any]]:
        """The next episode of some copies; the observations of all."""
        self._episode[where] += 1
        self._step[where] = 0
        self._over = self._over & ~where
        starts = [
            self.task.start(np.random.default_rng([self._seed, self._first + int(i), int(self._episode[i])]), self.sim)
            for i in np.flatnonzero(where)
        ]
        state = {key: np.array([start[key] for start in starts]) for key in starts[0]}
        readings: Observations = self.sim.reset(where=where, state={self.task.agent: state})
        return self.task.observe(self.sim, readings[self.task.agent])


def measured(
    readings: Mapping[str, Any], sensor: str, n: int, count: int, *, otherwise: float = 0.0
) -> NDArray[np.float64]:
    """`(n, count)` the first numbers of a sensor's reading; `otherwise` in copies that it does not reach.

    A sensor that has nothing to say in any copy is absent from the readings.
    """
    if sensor not in readings:
        return np.full((n, count), otherwise)
    reading = readings[sensor]
    rows = np.asarray(reading.data, dtype=np.float64).reshape(n, -1)[:, :count]
    return np.where(np.reshape(reading.valid, (n, -1))[:, :1], rows, otherwise)


def _mixed(where: NDArray[np.bool_], new: dict[str, Any], old: dict[str, Any]) -> dict[str, Any]:
    """`new` in some copies, `old` in the others."""
    return {k: np.where(where.reshape((-1,) + (1,) * (old[k].ndim - 1)), new[k], old[k]) for k in old}

"""A fleet as RSL-RL takes it, and learners of the Isaac Lab family."""

from __future__ import annotations

from typing import Any

import torch
from rsl_rl.env import VecEnv
from tensordict import TensorDict

from pelagos.envs.fleet import FleetEnv
from pelagos.errors import CommandError


class RslRlEnv(VecEnv):  # type: ignore[misc]
    """A `FleetEnv` as RSL-RL's `VecEnv`; for `arrays="torch"`, `autoreset="same_step"`."""

    def __init__(self, fleet: FleetEnv) -> None:
        """Raises: CommandError: a fleet of another kind."""
        if fleet.arrays != "torch" or fleet.program.autoreset != "same_step":
            raise CommandError("RSL-RL takes a fleet with arrays='torch' and autoreset='same_step'")
        self.fleet, self.num_envs, self.num_actions = fleet, fleet.num_envs, fleet.program.actions
        self.max_episode_length = int(fleet.program.constants.limit[0])
        self.device, self.cfg = torch.device("cpu"), {"task": type(fleet.task).__name__}
        self._seen, _ = fleet.reset()
        self._length = torch.zeros(self.num_envs, dtype=torch.long)

    @property
    def episode_length_buf(self) -> Any:
        """Decisions since each episode began `(n,)`; learners that write to it do not change the episodes."""
        return self._length

    @episode_length_buf.setter
    def episode_length_buf(self, value: Any) -> None:
        """RSL-RL spreads first episodes by random lengths; the fleet's own limits stay."""
        self._length = value

    def get_observations(self) -> Any:
        """The present observations, as `policy`."""
        return TensorDict({"policy": self._seen}, batch_size=[self.num_envs])

    def reset(self) -> tuple[Any, dict[str, Any]]:
        """The next episodes."""
        self._seen, _ = self.fleet.reset()
        self._length = torch.zeros_like(self._length)
        return self.get_observations(), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, dict[str, Any]]:
        """Observations, rewards, dones and extras with `time_outs` and the mean metrics as `log`."""
        self._seen, reward, terminated, truncated, info = self.fleet.step(actions)
        done = terminated | truncated
        self._length = torch.where(done, 0, self._length + 1)
        extras: dict[str, Any] = {"time_outs": truncated}
        if done.any():
            extras["log"] = {name: info[name][done].mean() for name in self.fleet.program.metrics}
        return self.get_observations(), reward, done.long(), extras

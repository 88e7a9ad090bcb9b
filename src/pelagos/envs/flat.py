"""Environments with sensors as learners of plain rows take them: observations `(n, k)`, torch tensors."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.sensing import SensingEnv
from pelagos.errors import CommandError


def row_size(space: gymnasium.Space[Any]) -> int:
    """Numbers of an observation as one row.

    Raises:
        CommandError: it holds a picture.
    """
    parts = space.spaces if isinstance(space, gymnasium.spaces.Dict) else {"observation": space}
    for name, part in parts.items():
        if part.shape is None or len(part.shape) != 1:
            raise CommandError(
                f"'{name}' has shape {part.shape}; the networks of pelagos train take rows of numbers, not pictures. "
                "Take a learner with convolutions (SB3Env and Stable-Baselines3's MultiInputPolicy)"
            )
    return sum(part.shape[0] for part in parts.values() if part.shape)


def as_rows(seen: Any) -> Any:
    """`(n, k)`: the arrays of an observation side by side, in the order of their names in the space."""
    return np.concatenate([*seen.values()], axis=1) if isinstance(seen, Mapping) else seen


class FlatSensing:
    """A `SensingEnv` whose observations are rows of numbers, for `ppo.train`.

    Attributes:
        env: the environment.
        num_envs: copies.
        size: numbers of an observation.
        actions: numbers of an action.
        metrics: names.
    """

    def __init__(self, env: SensingEnv) -> None:
        """One step is made to learn the metrics' names.

        Raises:
            CommandError: an observation holds a picture, or another autoreset than `same_step`.
        """
        if env.autoreset != "same_step":
            raise CommandError("train needs an environment with autoreset='same_step'")
        self.env, self.num_envs, self.actions = env, env.num_envs, env.task.actions
        self.size = row_size(env.single_observation_space)
        env.reset(seed=0)
        *_, info = env.step(np.zeros((env.num_envs, self.actions)))
        flags = ("final_obs", "final_info", "not_finite")
        self.metrics = [name for name in info if name[0] != "_" and name not in flags]

    def reset(self, *, seed: int) -> tuple[Any, dict[str, Any]]:
        """As the environment's."""
        seen, info = self.env.reset(seed=seed)
        return _tensor(as_rows(seen)), info

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """As the environment's; `info` has the metrics and `final_obs`."""
        seen, reward, terminated, truncated, info = self.env.step(actions.numpy())
        told = {name: _tensor(info[name]) for name in self.metrics}
        if "final_obs" in info:
            told["final_obs"] = _tensor(as_rows(info["final_obs"]))
        return _tensor(as_rows(seen)), _tensor(reward), _tensor(terminated), _tensor(truncated), told


def _tensor(values: NDArray[Any]) -> Any:
    import torch

    return torch.from_numpy(np.ascontiguousarray(values))

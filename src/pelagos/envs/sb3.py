"""A fleet as Stable-Baselines3 takes it."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray
from stable_baselines3.common.vec_env import VecEnv

from pelagos.envs.fleet import FleetEnv
from pelagos.envs.sensing import SensingEnv
from pelagos.errors import CommandError

_OF_THE_STEP: Final = ("final_obs", "final_info", "not_finite", "clipped")


class SB3Env(VecEnv):  # type: ignore[misc]
    """A `FleetEnv` or a `SensingEnv` as a `VecEnv`; for NumPy, `autoreset="same_step"`.

    `infos[i]` has the task's metrics, and where an episode ends `terminal_observation` and `TimeLimit.truncated`.
    """

    def __init__(self, fleet: FleetEnv | SensingEnv) -> None:
        """Raises: CommandError: a fleet of another kind."""
        if getattr(fleet, "arrays", "numpy") != "numpy" or fleet.autoreset != "same_step":
            raise CommandError("Stable-Baselines3 takes a fleet with arrays='numpy' and autoreset='same_step'")
        self.fleet = fleet
        self._actions: Any = None
        self._seed_given: int | None = None
        super().__init__(fleet.num_envs, fleet.single_observation_space, fleet.single_action_space)

    def reset(self) -> Any:
        """Observations `(n, k)`, or `(n, ...)` by name, of the next episodes, or of those of the seed given before."""
        seen, _ = self.fleet.reset(seed=self._seed_given)
        self._seed_given = None
        self.reset_infos: list[dict[str, Any]] = [{} for _ in range(self.num_envs)]
        return seen

    def seed(self, seed: int | None = None) -> Sequence[int | None]:
        """The seed of the next reset; one for all copies."""
        self._seed_given = seed
        return [seed] * self.num_envs

    def step_async(self, actions: NDArray[np.float32]) -> None:
        """Take the actions."""
        self._actions = actions

    def step_wait(self) -> tuple[Any, Any, Any, list[dict[str, Any]]]:
        """The step with them."""
        seen, reward, terminated, truncated, info = self.fleet.step(self._actions)
        done = terminated | truncated
        names = [name for name in info if name[0] != "_" and name not in _OF_THE_STEP]
        infos: list[dict[str, Any]] = [
            dict(zip(names, row, strict=True)) for row in zip(*(info[m].tolist() for m in names), strict=True)
        ] or [{} for _ in range(self.num_envs)]
        for i in np.flatnonzero(done):
            last = info["final_obs"]
            one = {k: v[i] for k, v in last.items()} if isinstance(last, dict) else last[i]
            infos[i]["terminal_observation"] = one
            infos[i]["TimeLimit.truncated"] = bool(truncated[i] and not terminated[i])
        return seen, reward, done, infos

    def close(self) -> None:
        """Let go of the states."""
        self.fleet.close()

    def get_attr(self, attr_name: str, indices: Any = None) -> list[Any]:
        """An attribute of the fleet or its task, for each copy asked for."""
        owner = self.fleet if hasattr(self.fleet, attr_name) else self.fleet.task
        return [getattr(owner, attr_name)] * len(self._get_indices(indices))

    def set_attr(self, attr_name: str, value: Any, indices: Any = None) -> None:
        """Refused: what copies share is compiled."""
        raise CommandError(f"{attr_name} cannot be set: copies share a compiled task; make another environment")

    def env_method(self, method_name: str, *args: Any, indices: Any = None, **kwargs: Any) -> list[Any]:
        """Refused: there are no single environments."""
        raise CommandError(f"{method_name}() cannot be called on copies: there are no single environments")

    def env_is_wrapped(self, wrapper_class: Any, indices: Any = None) -> list[bool]:
        """No copy is wrapped."""
        return [False] * len(self._get_indices(indices))

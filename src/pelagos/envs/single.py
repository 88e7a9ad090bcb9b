"""One copy of a task as a Gymnasium `Env`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.fleet import FleetEnv
from pelagos.envs.picture import Track
from pelagos.envs.task import Task
from pelagos.errors import LookupFailed

_RENDER: Final = ("rgb_array",)


class SingleEnv(gymnasium.Env[Any, Any]):
    """A fleet of one without the leading axis; see `FleetEnv` for what the arrays and `info` are.

    Rendered as `rgb_array`, it is a chart of the way since the episode began, from above and from the side.
    """

    metadata: dict[str, Any] = {"render_modes": list(_RENDER), "render_fps": 20}  # noqa: RUF012

    def __init__(self, task: Task, *, render_mode: str | None = None, **options: Any) -> None:
        """A task; options are `seed`, `environment` and `out_of_range` of `FleetEnv`."""
        if render_mode is not None and render_mode not in _RENDER:
            raise LookupFailed("render mode", render_mode, _RENDER)
        self.fleet = FleetEnv(task, 1, autoreset="disabled", **options)
        self.render_mode = render_mode
        self.metadata = {**type(self).metadata, "render_fps": task.rate_hz}
        self.observation_space = self.fleet.single_observation_space
        self.action_space = self.fleet.single_action_space
        self._track = Track(getattr(task, "goal", None))

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin the next episode, or number 0 of a seed."""
        super().reset(seed=seed)
        if options:
            raise LookupFailed("option of reset", next(iter(options)), ())
        observations, _ = self.fleet.reset(seed=seed)
        self._track.clear()
        self._note()
        return observations[0], {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """One decision."""
        given = action if hasattr(action, "detach") else np.asarray(action)
        seen, reward, terminated, truncated, info = self.fleet.step(given[None])
        self._note()
        told = {name: value[0].item() for name, value in info.items()}
        return seen[0], float(reward[0]), bool(terminated[0]), bool(truncated[0]), told

    def render(self) -> NDArray[np.uint8] | None:
        """`(480, 640, 3)` uint8, or None without a render mode."""
        return self._track.picture() if self.render_mode == "rgb_array" else None

    def _note(self) -> None:
        if self.render_mode is not None:
            self._track.note(self.fleet.state)

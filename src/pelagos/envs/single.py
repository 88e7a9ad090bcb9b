"""One copy of a task as a Gymnasium `Env`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import gymnasium
import numpy as np
from numpy.typing import NDArray

from pelagos.envs.fleet import FleetEnv
from pelagos.envs.picture import Track
from pelagos.envs.sensing import SensingEnv
from pelagos.errors import CommandError, LookupFailed

_RENDER: Final = ("rgb_array",)


class SingleEnv(gymnasium.Env[Any, Any]):
    """A fleet of one without the leading axis; see `FleetEnv` for what the arrays and `info` are.

    Rendered as `rgb_array`, it is a chart of the way since the episode began, from above and from the side.
    """

    metadata: dict[str, Any] = {"render_modes": list(_RENDER), "render_fps": 20}  # noqa: RUF012

    def __init__(self, fleet: FleetEnv | SensingEnv, *, render_mode: str | None = None) -> None:
        """A fleet of one with `autoreset="disabled"`."""
        if render_mode is not None and render_mode not in _RENDER:
            raise LookupFailed("render mode", render_mode, _RENDER)
        if fleet.num_envs != 1 or fleet.autoreset != "disabled":
            raise CommandError("a single environment is a fleet of one with autoreset='disabled'")
        self.fleet, task = fleet, fleet.task
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
        return _first(observations), {}

    def step(self, action: Any) -> tuple[Any, float, bool, bool, dict[str, Any]]:
        """One decision."""
        given = action if hasattr(action, "detach") else np.asarray(action)
        seen, reward, terminated, truncated, info = self.fleet.step(given[None])
        self._note()
        told = {name: value[0].item() for name, value in info.items()}
        return _first(seen), float(reward[0]), bool(terminated[0]), bool(truncated[0]), told

    def render(self) -> NDArray[np.uint8] | None:
        """`(480, 640, 3)` uint8, or None without a render mode."""
        return self._track.picture() if self.render_mode == "rgb_array" else None

    def _note(self) -> None:
        if self.render_mode is not None:
            self._track.note(self.fleet.state)


def _first(seen: Any) -> Any:
    return {k: v[0] for k, v in seen.items()} if isinstance(seen, dict) else seen[0]

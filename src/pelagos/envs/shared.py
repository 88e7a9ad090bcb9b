"""Teams as one learner takes them: every member is a copy, and all share one policy.

Source: J. K. Terry et al., "Revisiting parameter sharing in multi-agent deep reinforcement learning", arXiv 2005.13625:
who a member is stands behind what it sees, so that one network can give each its own part.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from pelagos.envs.policy import Policy
from pelagos.errors import CommandError

if TYPE_CHECKING:
    from pettingzoo import ParallelEnv


class SharedTeams:
    """Teams of one kind side by side, for `ppo.train`; a team that is over begins anew within the step.

    Attributes:
        teams: PettingZoo's `ParallelEnv`s whose members are alike and end together.
        num_envs: members of all teams.
        size: numbers of an observation, the 1 of the member's own place among 0s included.
        actions: numbers of an action.
        metrics: names.
    """

    def __init__(self, teams: Sequence[ParallelEnv[str, Any, Any]]) -> None:
        """One step of the first team is made to learn the metrics' names.

        Raises:
            CommandError: no team, or members that see or do different things.
        """
        if not teams:
            raise CommandError("teams that share a policy are at least one")
        self.teams, self.names = list(teams), list(teams[0].possible_agents)
        shapes = {(t.observation_space(a).shape, t.action_space(a).shape) for t in teams for a in t.possible_agents}
        if len(shapes) > 1 or any(list(t.possible_agents) != self.names for t in teams):
            raise CommandError(f"members that share a policy are alike; here are {len(shapes)} kinds")
        ((seen, acts),) = shapes
        assert seen is not None
        assert acts is not None
        self.num_envs, self.actions = len(teams) * len(self.names), acts[0]
        self.size = seen[0] + len(self.names)
        teams[0].reset(seed=0)
        *_, infos = teams[0].step({name: np.zeros(self.actions, dtype=np.float32) for name in self.names})
        self.metrics = list(infos[self.names[0]])

    def reset(self, *, seed: int) -> tuple[Any, dict[str, Any]]:
        """Team i begins with seed + i."""
        rows = [rows_of(team.reset(seed=seed + i)[0]) for i, team in enumerate(self.teams)]
        return _tensor(np.concatenate(rows)), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """As a `FleetEnv` with tensors and `autoreset="same_step"`."""
        kept: dict[str, list[Any]] = {key: [] for key in ("seen", "reward", "terminated", "truncated", "final_obs")}
        told: dict[str, list[float]] = {name: [] for name in self.metrics}
        for team, given in zip(self.teams, actions.numpy().reshape(len(self.teams), -1, self.actions), strict=True):
            seen, *judged, infos = team.step(dict(zip(self.names, given, strict=True)))
            kept["final_obs"].append(rows_of(seen))
            kept["seen"].append(kept["final_obs"][-1] if team.agents else rows_of(team.reset()[0]))
            for key, found in zip(("reward", "terminated", "truncated"), judged, strict=True):
                kept[key].append([found[name] for name in self.names])
            for metric, values in told.items():
                values += [infos[name][metric] for name in self.names]
        seen, reward, terminated, truncated, final = (np.concatenate(parts) for parts in kept.values())
        info = {"final_obs": _tensor(final)} | {m: _tensor(np.array(v, dtype=np.float32)) for m, v in told.items()}
        return _tensor(seen), _tensor(reward.astype(np.float32)), _tensor(terminated), _tensor(truncated), info


def rows_of(seen: Mapping[str, NDArray[np.float32]]) -> NDArray[np.float32]:
    """Observations of the members, each with who it is behind them `(members, k + members)`."""
    return np.concatenate([np.stack([*seen.values()]), np.eye(len(seen), dtype=np.float32)], axis=1)


def acts_of(policy: Policy, seen: Mapping[str, NDArray[np.float32]]) -> dict[str, NDArray[np.float32]]:
    """The actions of a team by a policy that its members share."""
    return dict(zip(seen, policy(rows_of(seen)), strict=True))


def _tensor(values: NDArray[Any]) -> Any:
    import torch

    return torch.from_numpy(np.ascontiguousarray(values))

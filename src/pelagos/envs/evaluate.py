"""Scores of a policy: whole episodes, each copy's first ones, by seed."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.envs.fleet import FleetEnv
from pelagos.envs.policy import Policy
from pelagos.envs.sensing import SensingEnv
from pelagos.errors import CommandError

_FLAGS: Final = ("not_finite", "clipped")


@dataclass(frozen=True)
class Scores:
    """One row an episode.

    Attributes:
        returns: sum of rewards `(episodes,)`.
        lengths: decisions `(episodes,)`.
        terminated: whether it ended before the limit of time `(episodes,)`.
        metrics: the task's, at the end `(episodes,)`, by name.
    """

    returns: NDArray[np.float64]
    lengths: NDArray[np.int64]
    terminated: NDArray[np.bool_]
    metrics: dict[str, NDArray[np.float64]]

    def summary(self) -> dict[str, float]:
        """Means, and the standard error of the return."""
        count = len(self.returns)
        found = {"episodes": float(count), "return": float(self.returns.mean())}
        found["return_standard_error"] = float(self.returns.std(ddof=1) / np.sqrt(count)) if count > 1 else 0.0
        found |= {"length": float(self.lengths.mean()), "terminated": float(self.terminated.mean())}
        return found | {name: float(values.mean()) for name, values in self.metrics.items()}


def episodes_of_each(env: FleetEnv | SensingEnv, episodes: int | None, what: str) -> int:
    """Episodes of each copy, for at least so many in all; one where not given.

    Args:
        env: see `evaluate`.
        episodes: in all.
        what: they are needed for, in words.

    Raises:
        CommandError: another kind of environment, or no episodes.
    """
    if env.autoreset != "same_step" or getattr(env, "arrays", "numpy") != "numpy":
        raise CommandError(f"{what} need an environment with autoreset='same_step' and arrays='numpy'")
    if episodes is not None and episodes < 1:
        raise CommandError(f"episodes is a number from 1 on, not {episodes}")
    return 1 if episodes is None else -(-episodes // env.num_envs)


def evaluate(env: FleetEnv | SensingEnv, policy: Policy, *, seed: int = 0, episodes: int | None = None) -> Scores:
    """The same number of first episodes of every copy, so that short ones do not count more often.

    Args:
        env: with `autoreset="same_step"` and NumPy arrays.
        policy: what acts.
        seed: of the episodes.
        episodes: at least so many; one of each copy where not given.

    Raises:
        CommandError: another kind of environment, or no episodes.
    """
    n, rows, names = env.num_envs, [], list[str]()
    each = episodes_of_each(env, episodes, "scores")
    total, length, left = np.zeros(n), np.zeros(n, dtype=np.int64), np.full(n, each)
    seen, _ = env.reset(seed=seed)
    while left.any():
        seen, reward, terminated, truncated, info = env.step(policy(seen))
        total += reward
        length += 1
        for i in np.flatnonzero((terminated | truncated) & (left > 0)):
            names = [name for name, value in info["final_info"].items() if name[0] != "_" and name not in _FLAGS]
            rows.append((total[i], length[i], terminated[i], *(float(info["final_info"][name][i]) for name in names)))
        done = terminated | truncated
        left[done] = np.maximum(left[done] - 1, 0)
        total[done], length[done] = 0.0, 0
    table = np.array([[float(v) for v in row] for row in rows])
    metrics = {name: table[:, 3 + i] for i, name in enumerate(names)}
    return Scores(table[:, 0], table[:, 1].astype(np.int64), table[:, 2] > 0, metrics)

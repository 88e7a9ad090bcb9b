"""Whole episodes of a policy, kept for learning without a simulator; as Minari's data sets."""

from __future__ import annotations

import os
import re
import shutil
import tempfile
import warnings
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.envs.evaluate import episodes_of_each
from pelagos.envs.fleet import FleetEnv
from pelagos.envs.policy import Policy
from pelagos.envs.sensing import SensingEnv
from pelagos.errors import CommandError, InputError

_ID: Final = re.compile(r"^(?:[\w-]+/)*[\w-]+-v\d+$")
_ROOT: Final = "MINARI_DATASETS_PATH"


@dataclass(frozen=True)
class Trajectory:
    """One episode of T decisions.

    Attributes:
        observations: `(T + 1, ...)`, or arrays of that by name; the last is the one that the episode ended with.
        actions: `(T, m)`.
        rewards, terminations, truncations: `(T,)`.
        seed, environment, episode: what its random numbers are named by.
    """

    observations: Any
    actions: NDArray[np.float32]
    rewards: NDArray[np.float32]
    terminations: NDArray[np.bool_]
    truncations: NDArray[np.bool_]
    seed: int
    environment: int
    episode: int

    def __len__(self) -> int:
        return len(self.rewards)


def collect(
    env: FleetEnv | SensingEnv, policy: Policy, *, seed: int = 0, episodes: int | None = None
) -> list[Trajectory]:
    """The first episodes of every copy, copy by copy; all of them are held in memory.

    Args:
        env: with `autoreset="same_step"` and NumPy arrays.
        policy: what acts.
        seed: of the episodes.
        episodes: at least so many, the same number of every copy; one of each where not given.

    Raises:
        CommandError: another kind of environment, or no episodes.
    """
    n, each = env.num_envs, episodes_of_each(env, episodes, "trajectories")
    seen, _ = env.reset(seed=seed)
    steps: list[tuple[Any, ...]] = []
    begun, found = np.zeros(n, dtype=np.int64), [list[Trajectory]() for _ in range(n)]
    while any(len(mine) < each for mine in found):
        actions = np.clip(np.asarray(policy(seen), dtype=np.float32), -1.0, 1.0)
        after, reward, terminated, truncated, info = env.step(actions)
        steps.append((seen, actions, reward, terminated, truncated))
        for i in np.flatnonzero(terminated | truncated).tolist():
            if len(found[i]) < each:
                name = (seed, env.first_environment + i, len(found[i]))
                found[i].append(_cut(steps[int(begun[i]) :], info["final_obs"], i, name))
            begun[i] = len(steps)
        seen = after
    return [episode for mine in found for episode in mine]


def _cut(steps: Sequence[tuple[Any, ...]], last: Any, i: int, name: tuple[int, int, int]) -> Trajectory:
    """Copy `i`'s part of steps, with the observation that its episode ended with."""
    rows = [step[0] for step in steps] + [last]
    if isinstance(last, Mapping):
        seen: Any = {key: np.stack([row[key][i] for row in rows]) for key in last}
    else:
        seen = np.stack([row[i] for row in rows])
    actions, rewards, terminated, truncated = (np.stack([step[k][i] for step in steps]) for k in (1, 2, 3, 4))
    return Trajectory(seen, actions, rewards, terminated, truncated, *name)


def save_minari(
    episodes: Sequence[Trajectory], env: FleetEnv | SensingEnv, dataset_id: str, *, policy: str = "", what: str = ""
) -> Path:
    """A data set in Minari's own folder (`MINARI_DATASETS_PATH`, or `~/.minari/datasets`), at once or not at all.

    `minari.load_dataset(dataset_id)` reads it. Pictures are kept without loss.

    Args:
        episodes: of `collect`.
        env: where they are from.
        dataset_id: such as "pelagos/hover/script-v0".
        policy: what acted.
        what: a description.

    Returns:
        Its folder.

    Raises:
        CommandError: Minari is not installed, an id that is none, or one that is taken.
        InputError: it cannot be written.
    """
    minari = _minari()
    if not _ID.match(dataset_id):
        raise CommandError(f"'{dataset_id}' is no id of Minari's: write NAMESPACE/NAME-v0, such as pelagos/hover-v0")
    root = Path(os.environ.get(_ROOT) or Path.home() / ".minari" / "datasets")
    folder = root / dataset_id
    if folder.exists():
        raise CommandError(f"{dataset_id} is there already ({folder}); give another version, or remove it")
    from minari.data_collector import EpisodeBuffer

    buffers = [
        EpisodeBuffer(
            id=k, seed=e.seed, options={"environment": e.environment, "episode": e.episode},
            observations=e.observations, actions=e.actions, rewards=e.rewards.tolist(),
            terminations=e.terminations.tolist(), truncations=e.truncations.tolist(),
        )
        for k, e in enumerate(episodes)
    ]  # fmt: skip
    try:
        root.mkdir(parents=True, exist_ok=True)
        with _rooted(root) as part, warnings.catch_warnings():
            warnings.simplefilter("ignore", UserWarning)  # Minari's, of authors and links that are not given
            minari.create_dataset_from_buffers(
                dataset_id, buffers, algorithm_name=policy or None, description=what or None, jpeg_encoding=False,
                observation_space=env.single_observation_space, action_space=env.single_action_space,
            )  # fmt: skip
            folder.parent.mkdir(parents=True, exist_ok=True)
            for file in part.rglob("namespace_metadata.json"):
                if not (root / file.relative_to(part)).exists():
                    shutil.copyfile(file, root / file.relative_to(part))
            (part / dataset_id).rename(folder)
    except OSError as error:
        raise InputError(f"{folder} cannot be written: {error}") from None
    return folder


@contextmanager
def _rooted(root: Path) -> Iterator[Path]:
    """A folder in Minari's that it takes for its own; gone afterwards."""
    before = os.environ.get(_ROOT)
    part = Path(tempfile.mkdtemp(prefix=".part-", dir=root))
    os.environ[_ROOT] = str(part)
    try:
        yield part
    finally:
        if before is None:
            del os.environ[_ROOT]
        else:
            os.environ[_ROOT] = before
        shutil.rmtree(part, ignore_errors=True)


def _minari() -> Any:
    try:
        import minari
    except ImportError:
        raise CommandError("data sets of trajectories need Minari: pip install 'pelagos[minari]'") from None
    return minari

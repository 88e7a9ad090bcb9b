"""Policies that act on observations in NumPy: random, scripted, or a small network from a file."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError, InputError, LookupFailed
from pelagos.files import whole

if TYPE_CHECKING:
    from pelagos.envs.fleet import FleetEnv
    from pelagos.envs.sensing import SensingEnv

Policy = Callable[[Any], NDArray[np.float32]]
"""Observations, `(n, k)` or arrays `(n, ...)` by name -> actions `(n, m)`."""


@dataclass(frozen=True)
class Network:
    """A perceptron with tanh layers on normalised observations, clipped to 10 deviations.

    Attributes:
        mean, deviation: of each number of an observation `(k,)`.
        weights: of each layer `(outputs, inputs)`.
        biases: of each layer `(outputs,)`.
        task: name of what it was trained for.
    """

    mean: NDArray[np.float32]
    deviation: NDArray[np.float32]
    weights: list[NDArray[np.float32]]
    biases: list[NDArray[np.float32]]
    task: str

    def __call__(self, seen: Any) -> NDArray[np.float32]:
        """The mean action, between -1 and 1, for rows `(n, k)` or arrays `(n, ...)` by name."""
        from pelagos.envs.flat import as_rows

        x = np.clip((as_rows(seen) - self.mean) / self.deviation, -10.0, 10.0)
        for weight, bias in zip(self.weights[:-1], self.biases[:-1], strict=True):
            x = np.tanh(x @ weight.T + bias)
        return np.asarray(np.clip(x @ self.weights[-1].T + self.biases[-1], -1.0, 1.0), dtype=np.float32)

    def save(self, path: Path) -> None:
        """As a NumPy archive, at once or not at all."""
        parts: dict[str, Any] = {"mean": self.mean, "deviation": self.deviation, "task": np.array(self.task)}
        for i, (weight, bias) in enumerate(zip(self.weights, self.biases, strict=True)):
            parts |= {f"weight{i}": weight, f"bias{i}": bias}
        with whole(path) as fresh:
            np.savez(fresh, **parts)

    @classmethod
    def load(cls, path: Path) -> Network:
        """From a file of `save`.

        Raises:
            InputError: it cannot be read, or is none.
        """
        try:
            with path.open("rb") as file, np.load(file, allow_pickle=False) as kept:
                count = sum(name.startswith("weight") for name in kept.files)
                weights, biases = ([kept[f"{part}{i}"] for i in range(count)] for part in ("weight", "bias"))
                return cls(kept["mean"], kept["deviation"], weights, biases, str(kept["task"]))
        except (OSError, ValueError, KeyError, TypeError, EOFError, BadZipFile) as error:
            raise InputError(f"{path} is no policy that `pelagos train` wrote: {error}") from None


def policy_of(given: str, env: FleetEnv | SensingEnv, *, seed: int = 0) -> Policy:
    """`random`, `zero`, `script`, or a file.

    Raises:
        CommandError: the task has no script, or the file's policy is for other observations or actions.
        LookupFailed: neither a name nor a file.
    """
    shape = env.action_space.shape
    assert shape is not None
    if given == "random":
        numbers = np.random.default_rng(seed)
        return lambda seen: numbers.uniform(-1, 1, shape).astype(np.float32)
    if given == "zero":
        return lambda seen: np.zeros(shape, dtype=np.float32)
    if given == "script":
        script: Policy | None = getattr(env.task, "script", None)
        if script is None:
            raise CommandError(f"{type(env.task).__name__} has no scripted baseline; choose random, zero or a file")
        return script
    from pelagos.envs.flat import row_size

    path = Path(given)
    if not path.is_file():
        raise LookupFailed("policy, and no file either,", given, ["random", "zero", "script"])
    network = Network.load(path)
    seen, takes = row_size(env.single_observation_space), network.weights[0].shape[1]
    if takes != seen or network.weights[-1].shape[0] != shape[1]:
        raise CommandError(
            f"{path} takes {takes} numbers and gives {network.weights[-1].shape[0]}; it was trained for "
            f"{network.task}, and this task has {seen} numbers and {shape[1]} actions"
        )
    return network

"""Random numbers of modems, from streams named by the modem, the purpose, the environment and its episode."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Protocol

import numpy as np
from numpy.typing import NDArray


class Episodes(Protocol):
    """Names of the random streams of each copy: `(n,)` environment, and number of its episode."""

    environment: NDArray[np.int64]
    number: NDArray[np.int64]


class Chance:
    """Draws for one run: the same names give the same numbers, in whatever order they are asked for."""

    def __init__(self, seed: Callable[[], int], episodes: Episodes) -> None:
        self._seed, self._episodes = seed, episodes

    def _stream(self, path: str, purpose: str, c: int) -> np.random.Generator:
        names = (self._seed(), path, purpose, self._episodes.environment[c], self._episodes.number[c])
        text = "\x1f".join(str(name) for name in names).encode()
        key = int.from_bytes(hashlib.blake2b(text, digest_size=16, person=b"pelagos").digest(), "little")
        return np.random.Generator(np.random.Philox(key=key))

    def uniform(self, path: str, purpose: str, c: int) -> float:
        """One number between 0 and 1."""
        return float(self._stream(path, purpose, c).random())

    def normals(self, path: str, purpose: str, c: int, count: int) -> NDArray[np.float64]:
        """`(count,)` numbers of mean 0 and standard deviation 1."""
        return self._stream(path, purpose, c).standard_normal(count)

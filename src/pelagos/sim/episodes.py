"""Episodes: the life of each copy of a fleet, from a reset of its own until its end."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array

_NEVER: Final = np.iinfo(np.int64).max
_WORD: Final = np.uint64(0xFFFFFFFF)


class Episodes:
    """Number, beginning and end of the present episode of each copy.

    Random streams of a copy are named by (seed, environment, episode), and their moments count from where the episode
    began. So an episode that begins at a multiple of every sensor's period has the same noise whenever it begins.

    Attributes:
        number: `(n,)`, 0 after a reset of the whole fleet.
        began: `(n,)` tick of its first state.
        ended: `(n,)` first tick at which its state was not finite any more; far away while it goes on.
        any_over: an episode has ended by itself; asked for in every tick.
    """

    def __init__(self, n: int, first_environment: int) -> None:
        self.environment = np.arange(first_environment, first_environment + n, dtype=np.int64)
        self.number = np.zeros(n, dtype=np.int64)
        self.began = np.zeros(n, dtype=np.int64)
        self.ended = np.full(n, _NEVER)
        self.any_over = False
        self._names: tuple[Array, Array] | None = None

    @property
    def over(self) -> NDArray[np.bool_]:
        """`(n,)` copies whose episode has ended by itself."""
        return np.asarray(self.ended < _NEVER)

    def restart(self, number: int = 0) -> None:
        """All copies begin this episode at tick 0."""
        self.number[:], self.began[:], self.ended[:] = number, 0, _NEVER
        self.any_over = False
        self._names = None

    def begin(self, where: NDArray[np.bool_], tick: int) -> None:
        """Some copies begin their next episode at a tick."""
        self.number[where] += 1
        self.began[where], self.ended[where] = tick, _NEVER
        self.any_over = bool(self.over.any())
        self._names = None

    def end(self, copies: NDArray[np.intp], ticks: NDArray[np.int64]) -> None:
        """The episodes of some copies have ended at these ticks."""
        self.ended[copies] = np.minimum(self.ended[copies], ticks)
        self.any_over = bool(self.over.any())

    def names(self) -> tuple[Array, Array]:
        """By copy, what its random streams are named by, and the tick from which their moments count, `UInt32`."""
        if self._names is None:
            streams = stream_of(self.environment, self.number)
            self._names = jit.from_numpy(jit.UInt32, streams), jit.from_numpy(jit.UInt32, self.began.astype(np.uint32))
        return self._names

    def memory(self) -> dict[str, Any]:
        """Copies of all three."""
        return {"number": self.number.copy(), "began": self.began.copy(), "ended": self.ended.copy()}

    def recall(self, memory: Mapping[str, Any]) -> None:
        """Go on from there."""
        self.number, self.began, self.ended = (memory[k].copy() for k in ("number", "began", "ended"))
        self.any_over = bool(self.over.any())
        self._names = None


def stream_of(environment: NDArray[np.int64], episode: NDArray[np.int64]) -> NDArray[np.uint32]:
    """A word of 32 bits that names the streams of an episode: of episode 0 the environment itself.

    Of others it is half of a 64-bit mix, so that two of k episodes share streams with a probability of k^2 / 2^33.

    Source: the finaliser of SplitMix64, Steele, Lea and Flood (2014), doi 10.1145/2660193.2660195.
    """
    x = environment.astype(np.uint64) + (episode.astype(np.uint64) << np.uint64(32))
    x = (x ^ (x >> np.uint64(30))) * np.uint64(0xBF58476D1CE4E5B9)
    x = (x ^ (x >> np.uint64(27))) * np.uint64(0x94D049BB133111EB)
    mixed = (x ^ (x >> np.uint64(31))) >> np.uint64(32)
    return np.where(episode == 0, environment.astype(np.uint64) & _WORD, mixed).astype(np.uint32)

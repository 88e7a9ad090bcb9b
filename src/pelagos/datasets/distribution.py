"""Random values by name: the same name and seed give the same value on any machine, in any order."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterator
from typing import Any, Final, Self

import numpy as np
from pydantic import Field, model_validator

from pelagos.config.strict import Strict, refusal

_SEPARATOR: Final = "\x1f"
_KINDS: Final = ("uniform", "log_uniform", "integer", "normal", "choice")


def stream(seed: int, *name: object) -> np.random.Generator:
    """A random stream (Philox) named by a seed and any words and numbers."""
    text = _SEPARATOR.join(str(part) for part in (seed, *name))
    digest = hashlib.blake2b(text.encode(), digest_size=16, person=b"dataset").digest()
    return np.random.Generator(np.random.Philox(key=int.from_bytes(digest, "little")))


class Distribution(Strict):
    """Values that a key of the scenario takes from world to world; give one of its keys."""

    uniform: tuple[float, float] | None = None
    """Lowest and highest value."""
    log_uniform: tuple[float, float] | None = None
    """Lowest and highest value, above 0; every factor of two as likely as the others."""
    integer: tuple[int, int] | None = None
    """Lowest and highest whole number, both among the values."""
    normal: tuple[float, float] | None = None
    """Mean and standard deviation."""
    choice: tuple[Any, ...] | None = Field(default=None, min_length=1)
    """Values of any kind, each as likely as the others."""

    @model_validator(mode="after")
    def _one(self) -> Self:
        given = [name for name in _KINDS if getattr(self, name) is not None]
        if len(given) != 1:
            raise refusal(f"give one of {', '.join(_KINDS)}, not {' and '.join(given) or 'none'}")
        limits = self.uniform or self.log_uniform or self.integer
        if limits is not None and limits[0] > limits[1]:
            raise refusal(f"{given[0]} goes from the lowest to the highest value, not from {limits[0]} to {limits[1]}")
        if self.log_uniform is not None and self.log_uniform[0] <= 0:
            raise refusal(f"log_uniform is for values above 0, not from {self.log_uniform[0]:g}")
        if self.normal is not None and self.normal[1] < 0:
            raise refusal(f"a standard deviation is 0 or positive, not {self.normal[1]:g}")
        return self

    def draw(self, random: np.random.Generator) -> Any:
        """A value, from the next numbers of a stream."""
        if self.uniform is not None:
            return float(random.uniform(*self.uniform))
        if self.log_uniform is not None:
            low, high = self.log_uniform
            return min(max(math.exp(random.uniform(math.log(low), math.log(high))), low), high)
        if self.integer is not None:
            return int(random.integers(self.integer[0], self.integer[1] + 1))
        if self.normal is not None:
            return float(random.normal(*self.normal))
        assert self.choice is not None
        return self.choice[int(random.integers(len(self.choice)))]

    def ends(self) -> Iterator[Any]:
        """Values that a scenario must be able to take: the ends of a range, every choice, the mean."""
        for limits in (self.uniform, self.log_uniform, self.integer, self.choice):
            yield from limits or ()
        if self.normal is not None:
            yield self.normal[0]

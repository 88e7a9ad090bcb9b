"""Finding places for things: seeded, apart from each other and from what must stay clear."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray


@dataclass
class Places:
    """Discs on the ground that are taken.

    Attributes:
        x, y: extent that things may stand in [m].
        taken: `(x, y, radius)` of each disc [m].
    """

    x: tuple[float, float]
    y: tuple[float, float]
    taken: list[tuple[float, float, float]] = field(default_factory=list)

    def take(self, x: float, y: float, radius: float) -> None:
        """Mark a disc as taken."""
        self.taken.append((float(x), float(y), float(radius)))

    def free(self, x: float, y: float, radius: float) -> bool:
        """Whether a disc touches none that is taken."""
        if not self.taken:
            return True
        discs = np.array(self.taken)
        return bool(((discs[:, 0] - x) ** 2 + (discs[:, 1] - y) ** 2 > (discs[:, 2] + radius) ** 2).all())

    def find(
        self,
        rng: np.random.Generator,
        radius: float,
        *,
        around: tuple[NDArray[np.float64], float] | None = None,
        accept: Callable[[float, float], bool] | None = None,
        tries: int = 200,
    ) -> NDArray[np.float64] | None:
        """A free place `(2,)`, marked as taken; None where none was found.

        Args:
            rng: random numbers.
            radius: of the disc that must be free [m].
            around: (middle, standard deviation [m]) of a heap; evenly over the whole extent where not given.
            accept: a further condition on (x, y).
            tries: places drawn before giving up.
        """
        low = np.array([self.x[0], self.y[0]]) + radius
        high = np.array([self.x[1], self.y[1]]) - radius
        for _ in range(tries):
            x, y = rng.uniform(low, high) if around is None else rng.normal(around[0], around[1])
            if not (low[0] <= x <= high[0] and low[1] <= y <= high[1]):
                continue
            if self.free(x, y, radius) and (accept is None or accept(x, y)):
                self.take(x, y, radius)
                return np.array([x, y])
        return None

"""Finding places for things: seeded, apart from each other and from what must stay clear."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from typing import Final

import numpy as np
from numpy.typing import NDArray

_CELL: Final = 8.0  # [m], edge of the cells that discs are looked up by


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
    _cells: dict[tuple[int, int], list[int]] = field(default_factory=dict, repr=False)

    def take(self, x: float, y: float, radius: float) -> None:
        """Mark a disc as taken."""
        for cell in _cells_of(x, y, radius):
            self._cells.setdefault(cell, []).append(len(self.taken))
        self.taken.append((float(x), float(y), float(radius)))

    def free(self, x: float, y: float, radius: float) -> bool:
        """Whether a disc touches none that is taken."""
        for cell in _cells_of(x, y, radius):
            for index in self._cells.get(cell, ()):
                ox, oy, reach = self.taken[index]
                if (ox - x) ** 2 + (oy - y) ** 2 <= (reach + radius) ** 2:
                    return False
        return True

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
        if (low > high).any():  # it is larger than the whole extent
            return None
        for _ in range(tries):
            x, y = rng.uniform(low, high) if around is None else rng.normal(around[0], around[1])
            if not (low[0] <= x <= high[0] and low[1] <= y <= high[1]):
                continue
            if self.free(x, y, radius) and (accept is None or accept(x, y)):
                self.take(x, y, radius)
                return np.array([x, y])
        return None


def covering(low: NDArray[np.float64], high: NDArray[np.float64]) -> NDArray[np.float64]:
    """`(k, 3)` discs, x, y and radius [m], that cover a rectangle between two corners, at most 64 along a side."""
    edge = max(float((high - low).min()) / 4, float((high - low).max()) / 64, 1e-3)
    counts = np.maximum(np.ceil((high - low) / edge), 1).astype(int)
    steps = (high - low) / counts
    x, y = np.meshgrid(*(low[k] + steps[k] * (np.arange(counts[k]) + 0.5) for k in (0, 1)), indexing="ij")
    return np.column_stack([x.ravel(), y.ravel(), np.full(x.size, float(np.linalg.norm(steps)) / 2)])


def _cells_of(x: float, y: float, radius: float) -> Iterator[tuple[int, int]]:
    for i in range(int((x - radius) // _CELL), int((x + radius) // _CELL) + 1):
        for j in range(int((y - radius) // _CELL), int((y + radius) // _CELL) + 1):
            yield i, j

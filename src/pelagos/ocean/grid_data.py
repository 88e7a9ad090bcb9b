"""Variables of a file on a grid, and the window of it that is wanted."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class GriddedData:
    """Variables on a grid; axes that the file lacks have one entry.

    Attributes:
        values: `(channels, times, depths, rows, columns)`, no gaps.
        time: `(times,)` seconds since the start.
        depth: `(depths,)` downwards [m], increasing.
        row, column: latitude and longitude [deg], or metres north and east of the world's origin where `metric`.
        metric: the file's horizontal coordinates are metres.
        filled: share of the values that the file leaves open.
        covers: lowest and highest row, lowest and highest column of the whole file.
    """

    values: NDArray[np.float64]
    time: NDArray[np.float64]
    depth: NDArray[np.float64]
    row: NDArray[np.float64]
    column: NDArray[np.float64]
    metric: bool
    filled: float
    covers: tuple[float, float, float, float]


@dataclass(frozen=True)
class Windows:
    """Part to read: lowest row, highest row, lowest column, highest column, for grids in degrees and in metres; and the
    longitude near which degrees are counted.
    """

    longitude: float
    degrees: tuple[float, float, float, float] | None
    metres: tuple[float, float, float, float] | None

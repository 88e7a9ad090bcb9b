"""The sea surface as the view draws it: the largest of the ocean's own wave components, which the browser adds up."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

MOST: Final = 96
"""Components: those of the largest amplitude; of 200 of a wind sea they have 95 % of the energy or more."""
_COLUMNS: Final = 8


@dataclass(frozen=True)
class SeaSurface:
    """Elevations of a wave table; a flat sea has no components.

    Attributes:
        rows: `(c, 5)` kx, ky [turns/m], frequency [turns/s], phase [turns], amplitude [m].
    """

    rows: NDArray[np.float64]

    @classmethod
    def of(cls, ocean: Any) -> SeaSurface:
        """The waves of an ocean, of a fleet's first copy; called by a thread that may use the device."""
        waves = None if ocean is None else ocean.waves if ocean.own_waves is None else ocean.own_waves
        if waves is None:
            return cls(np.zeros((0, 5)))
        table = np.array(waves.table).reshape(waves.copies, -1, _COLUMNS)[0, :, :5]
        order = np.argsort(-np.abs(table[:, 4]), kind="stable")[:MOST]
        return cls(np.array(table[order], dtype=np.float64))

    def elevation(self, x: NDArray[np.float64], y: NDArray[np.float64], t: float) -> NDArray[np.float64]:
        """Height over the mean [m] at x, y `(...)` [m] and time t [s]."""
        out = np.zeros(np.broadcast(x, y).shape)
        for kx, ky, frequency, phase, amplitude in self.rows:
            out += amplitude * np.cos(2 * math.pi * (kx * x + ky * y - frequency * t + phase))
        return out

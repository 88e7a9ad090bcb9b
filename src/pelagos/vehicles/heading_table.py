"""Forces of waves on a hull by frequency and heading, as a table that every component of a sea looks into."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, Final, Self

import drjit as dr
import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos import jit
from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.math.turns import sincos_turns
from pelagos.ocean.waves import Waves

_FREQUENCIES: Final = 384  # of a table, evenly from zero; the nearest is taken


def checked_table(omega: Any, headings: Any, values: Any, *, columns: int, name: str) -> None:
    """Check of a table as a configuration has it.

    Raises:
        ValueError: shapes that do not fit, frequencies that do not increase, or headings that are not even.
    """
    shape = (len(omega), len(headings), columns)
    if np.shape(values) != shape:
        text = f"{name} must be {shape[0]} x {shape[1]} x {columns}: by frequency, heading and direction"
        raise ValueError(f"{text}, not {' x '.join(map(str, np.shape(values)))}")
    if (np.diff(omega) <= 0).any():
        raise ValueError("omega_radps must increase")
    if not np.allclose(headings, np.linspace(0, 180, shape[1])):
        raise ValueError("heading_deg must go evenly from 0 to 180")


@dataclass(frozen=True)
class Component:
    """A component of a sea as a hull meets it.

    Attributes:
        omega: [rad/s].
        direction: unit vector that it travels along, ahead and to starboard.
        side: 1 where it travels to starboard, -1 to port.
        sin, cos: of its phase at the hull's origin, times its amplitude [m].
    """

    omega: Array
    direction: tuple[Array, Array]
    side: Array
    sin: Array
    cos: Array


def met(waves: Waves, i: Array, place: tuple[Array, Array], heading: tuple[Array, Array], t: Array) -> Component:
    """Component i of a sea at a place x, y NWU [m], seen along a compass heading, given as its cosine and sine."""
    (x, y), (cos, sin) = place, heading
    first, second = waves._rows(i)
    ahead, aside = first[0] * cos - first[1] * sin, -(first[0] * sin + first[1] * cos)
    side = dr.select(aside < 0, -1.0 + 0 * ahead, 1.0 + 0 * ahead)
    s, c = sincos_turns(dr.fma(first[0], x, dr.fma(first[1], y, dr.fma(-first[2], t, first[3]))))
    return Component(2 * math.pi * first[2], (ahead, aside), side, second[0] * s, second[0] * c)


@dataclass(frozen=True)
class HeadingTable:
    """Values on an even grid of frequencies that starts with nothing at zero, and of headings from 0 to 180 degrees.

    Attributes:
        rows: `(frequencies, headings, 3 k)`, k values of each layer, layer after layer.
        step: between frequencies [rad/s].
        layers: that each row holds, such as one for every speed.
    """

    rows: NDArray[np.float64]
    step: float
    layers: int = 1

    @classmethod
    def even(cls, omega: ArrayLike, values: NDArray[np.float64], layers: int = 1) -> Self:
        """From values `(frequencies, headings, 3 k)` at frequencies omega [rad/s], linear between them."""
        at = np.concatenate([[0.0], np.asarray(omega, dtype=np.float64)])
        known = np.concatenate([np.zeros((1, *values.shape[1:])), values])
        grid = np.linspace(0.0, at[-1], _FREQUENCIES)
        rows = np.zeros((_FREQUENCIES, *values.shape[1:]))
        for j in range(rows.shape[1]):
            for k in range(rows.shape[2]):
                rows[:, j, k] = np.interp(grid, at, known[:, j, k])
        return cls(rows, float(grid[1]), layers)

    def on_device(self) -> Array:
        """The rows, `Float64`."""
        return jit.Float64(np.ascontiguousarray(self.rows.ravel()))

    def at(self, table: Array, omega: Array, heading: Vector, layer: Array = 0) -> list[Array]:
        """Values (k `Array3f64`) of the nearest frequency, the last one's beyond it, linear in heading.

        Args:
            table: see `on_device`.
            omega: [rad/s].
            heading: of the waves, two components of any size ahead and to starboard; to port is as to starboard.
            layer: number of the layer, below `layers`.
        """
        last, turns, parts = len(self.rows) - 1, self.rows.shape[1] - 1, self.rows.shape[2] // 3 // self.layers
        ahead, aside = heading
        v = dr.atan2(dr.abs(aside), ahead) * (turns / math.pi)
        i = dr.minimum(jit.UInt32(dr.minimum(dr.fma(omega, 1 / self.step, 0.5), float(last))), last)
        j = dr.minimum(jit.UInt32(v), turns - 1)
        q = v - jit.Float64(j)
        row = i * (turns + 1) + j
        low_row, high_row = row, row + 1
        if self.layers > 1:
            low_row, high_row = low_row * self.layers + layer, high_row * self.layers + layer
        found = []
        for part in range(parts):
            low, high = (
                dr.gather(jit.Array3f64, table, r if parts == 1 else r * parts + part) for r in (low_row, high_row)
            )
            found.append((1 - q) * low + q * high)
        return found

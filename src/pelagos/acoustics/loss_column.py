"""Absorption above and below a place, and its mean along straight ways between two heights."""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array

LAYERS: Final = 32
_LEVEL: Final = 0.02  # [m], rise of a way below which the absorption of its layer counts


@jit.struct
class LossColumn:
    """Absorption by height in layers, one row a place: a Dr.Jit struct.

    Attributes:
        whole: `Float` rows by `LAYERS` + 1, integral of the absorption over that at the place itself, from the lowest
            layer up to each layer's lower edge [dB].
        lowest, step: `Float`, height of the lowest layer's lower edge over the place and thickness of layers [m].
        here: `Float`, absorption at the place [dB/m].
    """

    whole: Array
    lowest: Array
    step: Array
    here: Array

    @property
    def size_key(self) -> int:
        """Number of rows."""
        return len(self.here)

    def mean(self, row: Array, start: Array, end: Array) -> Array:
        """Mean absorption [dB/m] on straight ways between two heights over the place [m].

        Beyond the column's ends the water is as in its outermost layers.
        """
        rise = end - start
        level = dr.abs(rise) < _LEVEL
        low = dr.select(level, 0.5 * (start + end) - _LEVEL, start)
        high = dr.select(level, low + 2.0 * _LEVEL, end)
        excess = (self._up_to(row, high) - self._up_to(row, low)) / (high - low)
        return excess + self._of_row(self.here, row)

    def _up_to(self, row: Array, height: Array) -> Array:
        place = (height - self._of_row(self.lowest, row)) / self._of_row(self.step, row)
        layer = dr.clip(jit.Int32(dr.floor(place)), 0, LAYERS - 1)
        index = jit.UInt32(layer) + row * (LAYERS + 1)
        below = dr.gather(jit.Float, self.whole, index)
        return dr.fma(place - jit.Float(layer), dr.gather(jit.Float, self.whole, index + 1) - below, below)

    def _of_row(self, values: Array, row: Array) -> Array:
        return values if dr.width(values) == 1 else dr.gather(jit.Float, values, row)


def loss_column(
    loss: Callable[[Array, Array], Array], position: Array, t: Array, low: Array, high: Array
) -> LossColumn:
    """The column over each of some places.

    Args:
        loss: absorption [dB/m] at world places `Array3f64` and times [s].
        position: `Array3f64`, places in memory.
        t: times [s], one or one a place.
        low, high: functions of the height [m]: ends of the column over a place.
    """
    rows = dr.width(position)
    edge = dr.arange(jit.UInt32, rows * (LAYERS + 1))
    row, level = edge // (LAYERS + 1), edge % (LAYERS + 1)
    place = position if rows == 1 else dr.gather(jit.Array3f64, position, row)
    when = dr.gather(jit.Float64, t, row) if dr.width(t) > 1 else t
    bottom = low(place.z)
    step = (high(place.z) - bottom) * (1.0 / LAYERS)
    here = loss(place, when)

    def add(k: Array, total: Array) -> tuple[Array, Array]:
        height = bottom + (jit.Float64(k) + 0.5) * step
        return k + 1, total + (loss(jit.Array3f64(place.x, place.y, place.z + height), when) - here) * step

    start = (dr.zeros(jit.UInt32, dr.width(edge)), dr.zeros(jit.Float64, dr.width(edge)))
    _, whole = dr.while_loop(start, lambda k, _: k < level, add, mode="symbolic", labels=("layer", "whole"))
    lowest = low(position.z)
    return LossColumn(
        jit.Float(whole),
        jit.Float(lowest),
        jit.Float((high(position.z) - lowest) * (1.0 / LAYERS)),
        jit.Float(loss(position, t)),
    )

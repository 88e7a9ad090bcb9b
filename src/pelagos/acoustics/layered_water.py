"""Water in layers of linear sound speed over a bottom of straight pieces, as tables by path."""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array

LEVELS: Final = 64
"""Levels of a profile on the device."""


@jit.struct
class Water:
    """Water by path, one row each: columns one after the other along it, linear between `LEVELS` levels that all of
    them share; a Dr.Jit struct of `Float64`.

    Attributes:
        depth: of the levels, increasing from 0, the surface [m]; the last one lies below every bottom.
        speed: of sound, by row, column and level [m/s].
        absorption: likewise [dB/m].
        bubble_loss: of a bounce at the surface at normal incidence [dB], one value a row.
        begins: where each column begins, by row and column; 0 for the first one [m].
        columns: `UInt32`, of a row.
    """

    depth: Array
    speed: Array
    absorption: Array
    bubble_loss: Array
    begins: Array
    columns: Array

    @property
    def size_key(self) -> tuple[int, int, int]:
        """Sizes of all arrays."""
        return dr.width(self.depth), dr.width(self.speed), dr.width(self.bubble_loss)


@jit.struct
class Floor:
    """Bottoms, one row a path, straight between their nodes and level beyond the last: a Dr.Jit struct of `Float64`.

    Attributes:
        x: of the nodes, increasing from 0 [m].
        depth: [m].
        density_ratio, sound_speed_ratio, loss: of the bottom behind each node, see `fluid_reflection`.
        nodes: `UInt32`, of a row.
    """

    x: Array
    depth: Array
    density_ratio: Array
    sound_speed_ratio: Array
    loss: Array
    nodes: Array

    @property
    def size_key(self) -> tuple[int, int]:
        """Sizes of all arrays."""
        return dr.width(self.x), dr.width(self.nodes)


def next_column(water: Water, row: Array, column: Array) -> Array:
    """Beginning of the water's next column [m]; infinitely far behind the last one."""
    count = dr.gather(jit.UInt32, water.columns, row)
    last = column + 1 >= count
    begins = dr.gather(jit.Float64, water.begins, row * count + dr.select(last, column, column + 1))
    return dr.select(last, dr.inf, begins)


def first_level(water: Water, row: Array, column: Array, layer: Array) -> Array:
    """Index of a layer's upper level in tables by row, column and level."""
    return (row * dr.gather(jit.UInt32, water.columns, row) + column) * LEVELS + layer


def speed_at(water: Water, row: Array, column: Array, layer: Array, z: Array) -> tuple[Array, Array, Array]:
    """Sound speed at a depth in a layer [m/s], the layer's gradient [1/s], and its upper edge [m]."""
    level, first = row * LEVELS + layer, first_level(water, row, column, layer)
    z0, z1 = dr.gather(jit.Float64, water.depth, level), dr.gather(jit.Float64, water.depth, level + 1)
    c0, c1 = dr.gather(jit.Float64, water.speed, first), dr.gather(jit.Float64, water.speed, first + 1)
    g = (c1 - c0) / (z1 - z0)
    return dr.select(z == z1, c1, c0 + g * (z - z0)), g, z0


def layer_at(water: Water, row: Array, z: Array) -> Array:
    """The layer that holds a depth, by bisection."""
    found = dr.zeros(jit.UInt32, dr.width(row))
    part = LEVELS // 2
    while part:
        probe = dr.minimum(found + part, LEVELS - 2)
        found = dr.select(dr.gather(jit.Float64, water.depth, row * LEVELS + probe) <= z, probe, found)
        part //= 2
    return found

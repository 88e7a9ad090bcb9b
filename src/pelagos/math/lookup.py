"""Linear interpolation in one-dimensional tables that live on the device."""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


def sample(table: Array, cells: Array) -> Array:
    """Value of an evenly spaced table, linear between entries, held at both ends.

    Args:
        table: `Float64`, at least two entries.
        cells: `Float64`, where: 0 is the first entry, 1 the second.
    """
    last = dr.width(table) - 1
    x = dr.clip(cells, 0.0, float(last))
    i = dr.minimum(jit.UInt32(x), last - 1)
    low = dr.gather(jit.Float64, table, i)
    return low + (x - jit.Float64(i)) * (dr.gather(jit.Float64, table, i + 1) - low)


def locate(nodes: Array, x: Array) -> tuple[Array, Array]:
    """Cell of `x` among two or more increasing `nodes` (`Float64`), and the fraction of it; 0 and 1 beyond the ends."""
    count = dr.width(nodes)
    above = dr.binary_search(1, count - 1, lambda i: dr.gather(jit.Float64, nodes, i) <= x)
    i = jit.UInt32(above) - 1
    low = dr.gather(jit.Float64, nodes, i)
    width = dr.gather(jit.Float64, nodes, i + 1) - low
    return i, dr.clip((x - low) / width, 0.0, 1.0)

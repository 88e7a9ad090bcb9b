"""The ocean's own waves around each camera: heights on square grids, fine about the camera and coarser further out.

The heights are those of `Ocean.elevation` at the nodes, linear between them. Three grids reach 24, 96 and 384 m; a grid
passes over into the next in its outer fifth, and the last into its mean.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array

NODES: Final = 33  # of a grid, each way
STEPS: Final = (1.5, 6.0, 24.0)  # between nodes [m]
REACH: Final = 0.5 * (NODES - 1) * STEPS[-1]  # of the coarsest [m]
_OUTER: Final = 0.2  # share of a grid in which it passes over into the next
_SIZE: Final = NODES * NODES


@jit.struct
class Swell:
    """Elevation of the ocean's waves around each camera, a Dr.Jit struct.

    Attributes:
        elevation: `Float`, `(lanes, grids, NODES, NODES)` flattened, x first [m].
        slope_x, slope_y: `Float` as `elevation`, slopes at the nodes.
        level: `Float` `(lanes,)`, over the camera itself [m].
        mean, lowest, highest: `Float` `(lanes,)`, of the grids [m].
        corner_x, corner_y: `Float64` `(lanes,)`, world position of node (0, 0) of the finest grid [m].
        foam: `Float` as `elevation`, how white the surface is, 0 to 1; None where nothing breaks.
        offset_x, offset_y: `Float` `(lanes, grids)` flattened, from a grid's own node (0, 0) to that one [m].
    """

    elevation: Array
    slope_x: Array
    slope_y: Array
    level: Array
    mean: Array
    lowest: Array
    highest: Array
    corner_x: Array
    corner_y: Array
    offset_x: Array
    offset_y: Array
    foam: Array | None


def swell_around(
    elevation: Callable[..., Array],
    position: Array,
    t: Array,
    lanes: int,
    foam: Callable[..., Array] | None = None,
    copy: Array | None = None,
) -> Swell:
    """`elevation(x, y, t)` and `foam` of the ocean around positions `Array3f64` `(lanes,)` [m] at times `t` [s].

    With the `copy` of a fleet that each camera is in, they are asked with it as well, `elevation(x, y, t, copy)`.
    Components shorter than two steps of a grid are for the ripple to show.
    """
    count = len(STEPS)
    row = dr.arange(jit.UInt32, lanes * count)
    camera, step = row // count, _step_of(row % count)
    half = 0.5 * (NODES - 1) * step
    corners = [
        dr.round((dr.gather(jit.Float64, p, camera) - half) / step) * step for p in (position.x + 0.0, position.y + 0.0)
    ]
    dr.eval(corners)
    node = dr.arange(jit.UInt32, lanes * count * _SIZE)
    grid, inside = node // _SIZE, node % _SIZE
    places = [
        dr.gather(jit.Float64, corner, grid) + jit.Float64(i) * _step_of(grid % count)
        for corner, i in zip(corners, (inside // NODES, inside % NODES), strict=True)
    ]
    here, there = ((), ()) if copy is None else ((copy,), (dr.gather(jit.UInt32, copy, grid // count),))
    level = jit.Float(elevation(position.x, position.y, t, *here))
    then = dr.gather(jit.Float64, t, grid // count)
    heights = jit.Float(elevation(places[0], places[1], then, *there))
    white = None if foam is None else jit.Float(foam(places[0], places[1], then, *there))
    dr.eval(heights, white)
    slopes = []
    for index, stride in ((inside // NODES, NODES), (inside % NODES, 1)):
        ahead = dr.gather(jit.Float, heights, node + dr.select(index < NODES - 1, stride, 0))
        behind = dr.gather(jit.Float, heights, node - dr.select(index > 0, stride, 0))
        apart = dr.select((index == 0) | (index == NODES - 1), 1.0, 2.0) * jit.Float(_step_of(grid % count))
        slopes.append((ahead - behind) / apart)
    dr.eval(slopes)
    size = count * _SIZE
    mean = dr.block_sum(heights, size) * (1 / size)
    lowest, highest = (dr.block_reduce(op, heights, size) for op in (dr.ReduceOp.Min, dr.ReduceOp.Max))
    finest = [dr.gather(jit.Float64, c, dr.arange(jit.UInt32, lanes) * count) for c in corners]
    offsets = [jit.Float(dr.gather(jit.Float64, c, camera * count) - c) for c in corners]
    dr.eval(mean, lowest, highest, finest, offsets)
    corner_x, corner_y = finest
    offset_x, offset_y = offsets
    return Swell(
        heights, slopes[0], slopes[1], level, mean, lowest, highest, corner_x, corner_y, offset_x, offset_y, white
    )


def elevation_at(swell: Swell, x: Array, y: Array, lane: Array) -> Array:
    """Height of the surface over z = 0 [m] at places x, y `Float` relative to the corner of the finest grid [m]."""
    first, second, out, last = _grids(swell, x, y, lane)
    near, far = (_corners(swell.elevation, grid) for grid in (first, second))
    beyond = dr.select(last, dr.gather(jit.Float, swell.mean, lane), _between(*far))
    return dr.lerp(_between(*near), beyond, out)


def whiteness_at(swell: Swell, x: Array, y: Array, lane: Array) -> Array:
    """Whiteness of the surface at world x, y [m], `Float`: 0 to 1, none beyond the grids."""
    if swell.foam is None:
        return 0 * x
    x0, y0 = (
        jit.Float(jit.Float64(p) - dr.gather(jit.Float64, c, lane))
        for p, c in ((x, swell.corner_x), (y, swell.corner_y))
    )
    first, second, out, last = _grids(swell, x0, y0, lane)
    near, far = (_between(*_corners(swell.foam, grid)) for grid in (first, second))
    return dr.lerp(near, dr.select(last, 0, far), out)


def swell_slope(swell: Swell, x: Array, y: Array, lane: Array) -> Array:
    """Slope `Array2f` of the ocean's waves at world x, y [m], `Float`."""
    x0, y0 = (
        jit.Float(jit.Float64(p) - dr.gather(jit.Float64, c, lane))
        for p, c in ((x, swell.corner_x), (y, swell.corner_y))
    )
    first, second, out, last = _grids(swell, x0, y0, lane)
    near, far = (
        jit.Array2f(*(_between(*_corners(values, grid)) for values in (swell.slope_x, swell.slope_y)))
        for grid in (first, second)
    )
    return dr.lerp(near, dr.select(last, jit.Array2f(0), far), out)


def _step_of(grid: Array) -> Array:
    """Step [m] of a grid by its number, `Float64`."""
    return dr.select(grid == 0, jit.Float64(STEPS[0]), dr.select(grid == 1, jit.Float64(STEPS[1]), STEPS[2]))


_Grid = tuple[Array, Array, Array]  # first entry of its values, u, v in steps


def _grids(swell: Swell, x: Array, y: Array, lane: Array) -> tuple[_Grid, _Grid, Array, Array]:
    """The finest grid at a place and the next one, the share of the latter, and whether there is none."""
    middle = 0.5 * (NODES - 1)
    found = []
    for number, step in enumerate(STEPS):
        row = lane * len(STEPS) + number
        u = (x + dr.gather(jit.Float, swell.offset_x, row)) * (1 / step)
        v = (y + dr.gather(jit.Float, swell.offset_y, row)) * (1 / step)
        far = dr.maximum(dr.abs(u - middle), dr.abs(v - middle)) * (1 / middle)
        found.append((row * _SIZE, u, v, far))
    in0, in1 = found[0][3] < 1, found[1][3] < 1
    chosen = [dr.select(in0, a, dr.select(in1, b, c)) for a, b, c in zip(*found, strict=True)]
    after = [dr.select(in0, b, c) for b, c in zip(*found[1:], strict=True)]
    out = dr.clip((chosen[3] - (1 - _OUTER)) * (1 / _OUTER), 0, 1)
    return (chosen[0], chosen[1], chosen[2]), (after[0], after[1], after[2]), out, ~in0 & ~in1


def _corners(values: Array, grid: _Grid) -> tuple[Array, Array, Array, Array, Array, Array]:
    """Place in its cell along x and y, and the values at the cell's corners."""
    base, u, v = grid
    u, v = dr.clip(u, 0, NODES - 1.001), dr.clip(v, 0, NODES - 1.001)
    i, j = jit.UInt32(u), jit.UInt32(v)
    at = base + i * NODES + j
    z00, z01, z10, z11 = (dr.gather(jit.Float, values, at + k) for k in (0, 1, NODES, NODES + 1))
    return u - jit.Float(i), v - jit.Float(j), z00, z01, z10, z11


def _between(a: Array, b: Array, z00: Array, z01: Array, z10: Array, z11: Array) -> Array:
    return dr.lerp(dr.lerp(z00, z01, b), dr.lerp(z10, z11, b), a)

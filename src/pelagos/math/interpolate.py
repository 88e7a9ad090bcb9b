"""Interpolation on regular grids, for NumPy arrays at the boundary."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray


def bilinear(grid: NDArray[np.float64], i: NDArray[np.float64], j: NDArray[np.float64]) -> NDArray[np.float64]:
    """Bilinear values of `grid (ni, nj)` at fractional indices; NaN outside the grid, node values exactly at nodes."""
    a, b, u, v, outside = cell(grid.shape, i, j)
    z00, z10, z01, z11 = grid[a, b], grid[a + 1, b], grid[a, b + 1], grid[a + 1, b + 1]
    value = (z00 * (1 - u) + z10 * u) * (1 - v) + (z01 * (1 - u) + z11 * u) * v
    return np.where(outside, np.nan, value)


def triangulated(grid: NDArray[np.float64], i: NDArray[np.float64], j: NDArray[np.float64]) -> NDArray[np.float64]:
    """Values on the two triangles of each cell, split from node (a, b) to (a + 1, b + 1); NaN outside the grid."""
    a, b, u, v, outside = cell(grid.shape, i, j)
    z00, z11 = grid[a, b], grid[a + 1, b + 1]
    corner = np.where(u >= v, grid[a + 1, b], grid[a, b + 1])
    more, less = np.maximum(u, v), np.minimum(u, v)
    return np.where(outside, np.nan, z00 * (1 - more) + corner * (more - less) + z11 * less)


def cell(
    shape: tuple[int, ...], i: NDArray[np.float64], j: NDArray[np.float64]
) -> tuple[NDArray[np.intp], NDArray[np.intp], NDArray[np.float64], NDArray[np.float64], NDArray[np.bool_]]:
    """The cell of each fractional index: lower node (a, b), fractions (u, v) in 0 .. 1, and what lies outside."""
    ni, nj = shape[:2]
    inside = (i >= 0) & (i <= ni - 1) & (j >= 0) & (j <= nj - 1)
    i, j = np.where(inside, i, 0.0), np.where(inside, j, 0.0)
    a = np.clip(i.astype(np.intp), 0, ni - 2)
    b = np.clip(j.astype(np.intp), 0, nj - 2)
    return a, b, i - a, j - b, ~inside

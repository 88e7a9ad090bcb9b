"""Linear interpolation from scattered points to a grid: each triangle fills the nodes that lie in it.

The other way round, a search for the triangle of every node, takes ten times as long where nodes are many.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

_AT_ONCE: Final = 2_000_000  # nodes in the boxes around triangles that are looked at together
_SLACK: Final = 1e-9  # of a triangle's height: nodes on an edge belong to it


def gridded(
    points: NDArray[np.float64], values: NDArray[np.float64], x: NDArray[np.float64], y: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Values `(nx, ny)` at places x `(nx,)`, y `(ny,)`, both rising, from points `(k, 2)`; NaN outside their hull.

    Linear on Delaunay's triangles; NaN everywhere where there are none, as all points lie on a line.
    """
    from scipy.spatial import Delaunay, QhullError

    out = np.full((len(x), len(y)), np.nan)
    try:
        corners = Delaunay(points).simplices
    except QhullError:
        return out
    place, value = points[corners], values[corners]  # (t, 3, 2), (t, 3)
    low, high = place.min(axis=1), place.max(axis=1)
    first = np.stack([np.searchsorted(axis, low[:, k], "left") for k, axis in enumerate((x, y))], axis=1)
    last = np.stack([np.searchsorted(axis, high[:, k], "right") for k, axis in enumerate((x, y))], axis=1)
    for triangle, i, j in _nodes(first, last):
        p = place[triangle]
        a, b = p[:, 1] - p[:, 0], p[:, 2] - p[:, 0]
        r = np.stack([x[i], y[j]], axis=1) - p[:, 0]
        area = a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            s = (r[:, 0] * b[:, 1] - r[:, 1] * b[:, 0]) / area
            t = (a[:, 0] * r[:, 1] - a[:, 1] * r[:, 0]) / area
        inside = (s >= -_SLACK) & (t >= -_SLACK) & (s + t <= 1 + _SLACK)
        s, t, v = s[inside], t[inside], value[triangle[inside]]
        out[i[inside], j[inside]] = v[:, 0] + s * (v[:, 1] - v[:, 0]) + t * (v[:, 2] - v[:, 0])
    return out


def _nodes(
    first: NDArray[np.int64], last: NDArray[np.int64]
) -> Iterator[tuple[NDArray[np.int64], NDArray[np.int64], NDArray[np.int64]]]:
    """Portions of (triangle, i, j): every node in the box of every triangle, rows `first` to `last`, not included."""
    size = last - first
    some = np.flatnonzero(size.prod(axis=1))
    rows = np.maximum(_AT_ONCE // size[some, 1], 1)  # of the boxes that are too large to be looked at as a whole
    pieces = -(-size[some, 0] // rows)
    triangle = np.repeat(some, pieces)
    piece = np.arange(len(triangle)) - np.repeat(np.cumsum(pieces) - pieces, pieces)
    start = first[triangle, 0] + piece * np.repeat(rows, pieces)
    stop = np.minimum(start + np.repeat(rows, pieces), last[triangle, 0])
    wide = size[triangle, 1]
    count = (stop - start) * wide
    total = np.cumsum(count)
    begin = 0
    while begin < len(triangle):
        done = total[begin - 1] if begin else 0
        end = max(int(np.searchsorted(total, done + _AT_ONCE, "right")), begin + 1)
        here = slice(begin, end)
        which = np.repeat(np.arange(begin, end), count[here])
        k = np.arange(len(which)) - np.repeat(np.cumsum(count[here]) - count[here], count[here])
        yield triangle[which], start[which] + k // wide[which], first[triangle[which], 1] + k % wide[which]
        begin = end

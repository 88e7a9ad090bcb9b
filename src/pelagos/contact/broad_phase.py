"""The broad phase of contact: which bodies are so near one another that they may touch.

Bounding spheres first, of many bodies by k-d trees of places, one for each class of sizes, so that a ship among a
thousand small vehicles costs what it should; then the boxes about the bodies. Nearly linear in bodies at fixed density.
Source: C. Ericson, Real-Time Collision Detection (2005), Chapters 4 and 7, doi 10.1201/b14581.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import rotate_back_np

_CLASS: Final = 2.0  # sizes within one class differ by less than this factor
_FEW: Final = 48  # bodies all of whose pairs are compared sooner than trees are built


@dataclass(frozen=True)
class BoundedBodies:
    """Bodies as the broad phase sees them.

    Attributes:
        position: `(b, 3)` of their origins [m].
        attitude: `(b, 4)`, body to world, w first.
        radius: `(b,)` of the sphere about the origin that holds the body [m].
        low, high: `(b, 3)` corners of the box that holds it, in its own frame [m].
        copy: `(b,)` bodies of different copies do not meet.
    """

    position: NDArray[np.float64]
    attitude: NDArray[np.float64]
    radius: NDArray[np.float64]
    low: NDArray[np.float64]
    high: NDArray[np.float64]
    copy: NDArray[np.int64]


def close_pairs(
    position: NDArray[np.float64], reach: NDArray[np.float64], copy: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Pairs whose distance is less than the sum of their reaches, `(k, 2)` rows i < j, in ascending order.

    Args:
        position: `(b, 3)` [m].
        reach: `(b,)` [m].
        copy: `(b,)`.
    """
    few = len(position) <= _FEW
    pairs = _all_pairs(len(position)) if few else _candidates(position, reach, copy)
    i, j = pairs.T
    with np.errstate(over="ignore", invalid="ignore"):  # of a body that will not be finite soon
        near = np.linalg.norm(position[i] - position[j], axis=1) < reach[i] + reach[j]
    return np.asarray(pairs[near & (copy[i] == copy[j])])


@cache
def _all_pairs(count: int) -> NDArray[np.int64]:
    """`(k, 2)` rows i < j of so many bodies, in ascending order."""
    pairs = np.stack(np.triu_indices(count, 1), axis=1).astype(np.int64)
    pairs.flags.writeable = False
    return pairs


def _candidates(
    position: NDArray[np.float64], reach: NDArray[np.float64], copy: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Pairs that may be close, and all that are, as `close_pairs` gives them."""
    from scipy.spatial import cKDTree  # a tenth of the time that all imports take

    apart = 4.0 * float(reach.max())
    places = np.concatenate([position, copy[:, None] * apart], axis=1)
    size = np.floor(np.log(np.maximum(reach, 1e-9)) / np.log(_CLASS)).astype(np.int64)
    classes = [np.flatnonzero(size == s) for s in np.unique(size)]
    # a balanced tree of many equal zeros never ends where subnormal numbers count as 0, as Dr.Jit has them
    trees = [cKDTree(places[rows], balanced_tree=False) for rows in classes]
    largest = [float(reach[rows].max()) for rows in classes]
    parts = []
    for a, (rows, tree) in enumerate(zip(classes, trees, strict=True)):
        parts.append(rows[tree.query_pairs(2 * largest[a], output_type="ndarray")])
        for b in range(a + 1, len(classes)):
            found = trees[b].sparse_distance_matrix(tree, largest[a] + largest[b], output_type="ndarray")
            parts.append(np.stack([classes[b][found["i"]], rows[found["j"]]], axis=1))
    pairs = np.sort(np.concatenate(parts).astype(np.int64), axis=1)
    return np.asarray(pairs[np.lexsort((pairs[:, 1], pairs[:, 0]))])


def touching_boxes(bodies: BoundedBodies, pairs: NDArray[np.int64], margin: float) -> NDArray[np.bool_]:
    """`(k,)`: whether each of two bodies' spheres comes within `margin` [m] of the other's box; False is certain."""
    i, j = pairs.T
    return _near_box(bodies, i, j, margin) & _near_box(bodies, j, i, margin)


def _near_box(
    bodies: BoundedBodies, sphere: NDArray[np.int64], box: NDArray[np.int64], margin: float
) -> NDArray[np.bool_]:
    local = rotate_back_np(bodies.attitude[box], bodies.position[sphere] - bodies.position[box])
    outside = np.maximum(np.maximum(bodies.low[box] - local, local - bodies.high[box]), 0.0)
    with np.errstate(over="ignore"):  # of a body that will not be finite soon: it is infinitely far away
        return np.asarray(np.linalg.norm(outside, axis=1) < bodies.radius[sphere] + margin)

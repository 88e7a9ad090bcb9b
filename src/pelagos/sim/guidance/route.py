"""The middle line of a long body of the world, such as a pipeline, as points to pass."""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import LookupFailed, ScenarioError
from pelagos.raycast.geometry import Geometry

SLICE_M: Final = 2.0  # the body is cut across its longest extent this often
LONG: Final = 4.0  # times its width: a shorter body has no middle line
FOLDED: Final = 2.0  # times a usual slice's width and thickness: a wider one has more than one piece of the way in it
TOLERANCE_M: Final = 0.3  # points are left out where the line stays within this without them


def middle_line(geometries: list[Geometry], name: str, *, where: str) -> NDArray[np.float64]:
    """`(k, 2)` x, y [m] along the body called `name`: through the middles of slices across its longest extent.

    Raises:
        LookupFailed: no body has this name.
        ScenarioError: the body is not long, or turns back or steps aside within a slice.
    """
    found = [g for g in geometries if g.name == name]
    if not found:
        raise LookupFailed("body of the world", name, sorted({g.name for g in geometries}), where=where)
    vertices = np.concatenate([np.asarray(g.vertices, dtype=np.float64)[:, :2] for g in found])
    middle = vertices.mean(axis=0)
    _, _, axes = np.linalg.svd(vertices - middle, full_matrices=False)
    axes *= np.sign(axes[[0, 1], np.abs(axes).argmax(axis=1)])[:, None]  # whichever way the decomposition took
    along, across = (vertices - middle) @ axes.T[:, 0], (vertices - middle) @ axes.T[:, 1]
    length = float(np.ptp(along))
    if length < LONG * SLICE_M or length < LONG * float(np.ptp(across)):
        raise ScenarioError(
            f"{name!r} is {length:.1f} m long and {np.ptp(across):.1f} m wide: it has no middle line to follow",
            where=where,
        )
    number = np.clip(((along - along.min()) / length * round(length / SLICE_M)).astype(int), 0, None)
    slices = [(along[number == k], across[number == k]) for k in np.unique(number)]
    line = np.array([[a.mean(), b.mean()] for a, b in slices])
    wide = np.array([np.ptp(b) for _, b in slices])
    widest, usual = int(wide.argmax()), float(np.median(wide))
    if wide[widest] > FOLDED * (usual + SLICE_M):
        x, y = middle + line[widest] @ axes
        raise ScenarioError(
            f"{name!r} turns back or steps aside about x {x:.1f}, y {y:.1f} m, where it takes {wide[widest]:.1f} m "
            f"across its way, {usual:.1f} m elsewhere: it has no one middle line to follow; give waypoints",
            where=where,
        )
    line[0, 0], line[-1, 0] = along.min(), along.max()
    return np.asarray(middle + _thinned(line) @ axes)


def _thinned(line: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fewer points, from which the line departs by no more than `TOLERANCE_M` (Ramer, Douglas and Peucker)."""
    if len(line) < 3:
        return line
    chord, out = line[-1] - line[0], line - line[0]
    run = np.clip(out @ chord / max(float(chord @ chord), 1e-18), 0.0, 1.0)  # beyond its ends the piece is an end
    off = np.hypot(*(out - run[:, None] * chord).T)
    k = int(np.argmax(off))
    if off[k] <= TOLERANCE_M:
        return line[[0, -1]]
    return np.concatenate([_thinned(line[: k + 1])[:-1], _thinned(line[k:])])

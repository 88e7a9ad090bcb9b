"""Meshes that are spheres, boxes and cylinders, recognised by their vertices, and the size of all others."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import combinations
from typing import Final, Literal, TypeAlias

import numpy as np
from numpy.typing import NDArray

Kind: TypeAlias = Literal["other", "sphere", "box", "cylinder"]

_ALIKE: Final = 0.01  # relative deviation of lengths that are to be the same: meshes of curved things are polyhedra
_FEWEST_ROUND: Final = 12  # vertices of a cylinder, or of a sphere


@dataclass(frozen=True)
class Solid:
    """A thing by its size.

    Attributes:
        kind: what it is.
        centre: of the smallest sphere about it, roughly, in the mesh's frame `(3,)` [m].
        axes: `(3, 3)`, its own x, y, z as columns.
        half: half lengths along them [m]; a cylinder's axis is its z.
        radius: of a sphere about the centre that holds it [m].
    """

    kind: Kind
    centre: NDArray[np.float64]
    axes: NDArray[np.float64]
    half: NDArray[np.float64]
    radius: float


def recognise_shape(vertices: NDArray[np.floating]) -> Solid:
    """Shape of a mesh with these vertices `(v, 3)` [m]."""
    low, high = vertices.min(axis=0).astype(np.float64), vertices.max(axis=0).astype(np.float64)
    size = float(np.linalg.norm(high - low))
    points = np.unique(np.round(np.asarray(vertices, dtype=np.float64) / size, 6), axis=0) * size
    centre = 0.5 * (low + high)
    offset = points - centre
    reach = np.linalg.norm(offset, axis=1)
    radius, upright = float(reach.max()), np.eye(3)
    levels = len(np.unique(np.round(offset[:, 2] / radius, 3)))  # those of a cylinder's rims lie on a sphere too
    if len(points) >= 2 * _FEWEST_ROUND and reach.std() < _ALIKE * radius and levels > 4 and _even(offset):
        return Solid("sphere", centre, upright, np.full(3, radius), radius)
    for test in (_box, _cylinder):
        found = test(offset)
        if found is not None:
            kind, axes, half = found
            return Solid(kind, centre, axes, half, radius)
    return Solid("other", centre, upright, 0.5 * (high - low), radius)


def _even(offset: NDArray[np.float64]) -> bool:
    """Vertices reach as far along all axes."""
    extent = np.ptp(offset, axis=0)
    return bool(np.ptp(extent) < 0.05 * extent.max())


def _box(offset: NDArray[np.float64]) -> tuple[Kind, NDArray[np.float64], NDArray[np.float64]] | None:
    if len(offset) != 8:
        return None
    edges = offset[1:] - offset[0]
    for three in combinations(edges, 3):
        length = np.linalg.norm(three, axis=1)
        axes = np.array(three).T / length
        opposite = np.allclose(np.sum(three, axis=0), -2.0 * offset[0], atol=1e-4 * length.max())
        if opposite and np.abs(axes.T @ axes - np.eye(3)).max() < _ALIKE:
            if np.linalg.det(axes) < 0:
                axes[:, 0] *= -1.0
            return "box", axes, 0.5 * length
    return None


def _cylinder(offset: NDArray[np.float64]) -> tuple[Kind, NDArray[np.float64], NDArray[np.float64]] | None:
    if len(offset) < _FEWEST_ROUND:
        return None
    principal = np.linalg.eigh(offset.T @ offset)[1].T
    for axis in (*np.eye(3), *principal):
        height = offset @ axis
        half = float(np.abs(height).max())
        off = np.linalg.norm(offset - height[:, None] * axis, axis=1)
        rim = off > 0.5 * off.max()
        widest = off.max()
        if rim.sum() < _FEWEST_ROUND or off[rim].std() > _ALIKE * widest or (off[~rim] > 1e-3 * widest).any():
            continue
        rims = [(rim & (height * side > 0.0)).sum() for side in (1.0, -1.0)]
        if min(rims) >= _FEWEST_ROUND and np.abs(np.abs(height) - half).max() < _ALIKE * half:
            aside = np.cross(np.eye(3)[np.abs(axis).argmin()], axis)
            aside /= np.linalg.norm(aside)
            radius = float(off[rim].mean())
            return "cylinder", np.stack([aside, np.cross(axis, aside), axis], axis=1), np.array([radius, radius, half])
    return None

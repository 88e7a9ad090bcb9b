"""Ground of several materials whose borders run through the triangles, not along them.

Each material has a field over the nodes, and the ground belongs to the highest. Triangles that a border crosses are cut
along it, in their own plane: the surface stays the same, to rounding, and has no cracks, as both neighbours of an edge
cut it at the same point.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.raycast.geometry import Geometry
from pelagos.world.terrain import HeightField

_MANY: Final = 1_000_000
_NEAR_M: Final = 2048.0
_MARGIN: Final = 0.04  # share of an edge, next to a node, where no cut is made: slivers are of no use


def patchwork(
    terrain: HeightField,
    fields: NDArray[np.float32],
    rows: NDArray[np.unsignedinteger],
    *,
    label: int,
    instance: int,
    name: str = "seabed",
) -> Geometry:
    """The mesh of a terrain, cut along the borders between its materials.

    Args:
        terrain: heights `(nx, ny)`.
        fields: `(m, nx, ny)`, of each material.
        rows: `(m,)` material rows.
        label, instance, name: see `Geometry`.
    """
    best = np.argmax(fields, axis=0).astype(np.uint8).reshape(-1)
    faces, vertices, normals = terrain.faces(), terrain.vertices(), terrain.normals().reshape(-1, 3)
    corner = best[faces]
    mixed = (corner[:, 0] != corner[:, 1]) | (corner[:, 1] != corner[:, 2])
    if not mixed.any():
        return Geometry(vertices, faces, rows[corner[:, 0]], label, instance, normals, name)
    cut = _Cut(faces[mixed], best, fields.reshape(len(fields), -1))
    new_vertices, new_normals = cut.points(vertices), cut.points(normals)
    new_normals /= np.linalg.norm(new_normals, axis=1, keepdims=True)
    parts, materials = cut.faces(len(vertices))
    whole = ~mixed
    kinds = rows[np.concatenate([corner[whole, 0], materials])]
    del corner, mixed  # what is not needed any more goes before the large arrays are copied
    faces = np.concatenate([faces[whole], parts])
    return Geometry(
        np.concatenate([vertices, new_vertices], dtype=_precision(vertices)),
        faces,
        kinds,
        label,
        instance,
        np.concatenate([normals, new_normals.astype(np.float32)]),
        name,
    )


def _precision(vertices: NDArray[np.float64]) -> type[np.floating]:
    """Large grounds are kept in single precision where that is within 0.06 mm, which is what rays have anyway."""
    small = len(vertices) < _MANY or float(np.abs(vertices).max()) > _NEAR_M
    return np.float64 if small else np.float32


class _Cut:
    """Triangles that lie on a border: the points that cut them, and what they fall into."""

    def __init__(self, faces: NDArray[np.uint32], best: NDArray[np.uint8], fields: NDArray[np.float32]) -> None:
        kinds = best[faces]
        alone = np.select([kinds[:, 1] == kinds[:, 2], kinds[:, 2] == kinds[:, 0]], [0, 1], 2)
        turn = (alone[:, None] + np.arange(3)) % 3  # the corner that stands alone comes first
        self._faces = np.take_along_axis(faces, turn, axis=1).astype(np.int64)
        self._kinds = np.take_along_axis(kinds, turn, axis=1)
        self._three = self._kinds[:, 1] != self._kinds[:, 2]
        ends = self._faces[:, [[0, 1], [1, 2], [2, 0]]]  # (f, 3 edges, 2)
        used = np.ones(ends.shape[:2], dtype=bool)
        used[:, 1] = self._three
        keys = np.sort(ends[used], axis=1)
        nodes = fields.shape[1]
        codes, inverse = np.unique(keys[:, 0] * nodes + keys[:, 1], return_inverse=True)
        self._a, self._b = codes // nodes, codes % nodes
        self._share = _crossing(self._a, self._b, best, fields)
        self._edge = np.zeros(ends.shape[:2], dtype=np.int64)
        self._edge[used] = inverse.reshape(-1)

    def points(self, values: NDArray[np.floating]) -> NDArray[np.float64]:
        """Values `(v, 3)` of the nodes at the cuts, then at the middles of triangles with three materials."""
        s = self._share[:, None]
        cuts = values[self._a] + s * (values[self._b] - values[self._a])
        return np.concatenate([cuts, cuts[self._edge[self._three]].mean(axis=1)])

    def faces(self, first: int) -> tuple[NDArray[np.uint32], NDArray[np.uint8]]:
        """Triangles `(t, 3)` and the material of each, new points counted from `first`."""
        two = ~self._three
        p, q, r = self._faces[two].T
        s, _, u = self._edge[two].T + first
        alone, rest = self._kinds[two, 0], self._kinds[two, 1]
        found = [np.stack(c, axis=1) for c in ((p, s, u), (s, q, r), (s, r, u))]
        kinds = [alone, rest, rest]
        middle = first + len(self._a) + np.arange(int(self._three.sum()))
        corners, cuts = self._faces[self._three], self._edge[self._three] + first
        for k in range(3):
            ahead, behind = cuts[:, k], cuts[:, (k + 2) % 3]
            found += [np.stack([corners[:, k], ahead, middle], 1), np.stack([corners[:, k], middle, behind], 1)]
            kinds += [self._kinds[self._three, k]] * 2
        return np.concatenate(found).astype(np.uint32), np.concatenate(kinds)


def _crossing(
    a: NDArray[np.int64], b: NDArray[np.int64], best: NDArray[np.uint8], fields: NDArray[np.float32]
) -> NDArray[np.float64]:
    """Share of the way from node a to node b at which the fields of their materials cross."""
    here = (fields[best[a], a] - fields[best[b], a]).astype(np.float64)
    there = (fields[best[b], b] - fields[best[a], b]).astype(np.float64)
    return np.clip(here / np.maximum(here + there, 1e-30), _MARGIN, 1 - _MARGIN)

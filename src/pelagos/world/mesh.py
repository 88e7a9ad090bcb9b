"""A triangle mesh without a meaning yet: it is moved, joined, cut, and then becomes a `Geometry`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.errors import WorldError
from pelagos.raycast.geometry import Geometry

# Odd multipliers that spread three coordinates over 64 bits: one sort of numbers instead of a sort of rows.
_HASH: Final = np.array([0x9E3779B97F4A7C1, 0x42B2AE3D27D4EB4F, 0x165667B19E3779F9], dtype=np.int64)


_GRID_M: Final = 2.0**-30  # of what is cut, a nanometre: the last digit of a sine chooses no other triangles
_DOUBT_DEG: Final = 1e-4  # edges of exactly the crease are flat enough, whichever way a processor rounds


@dataclass(frozen=True)
class Mesh:
    """Triangles, counter-clockwise seen from outside.

    Attributes:
        vertices: `(v, 3)` float64 [m].
        faces: `(f, 3)` uint32.
        welded: no two vertices are known to be in one place, and no face to be without area; see `merged`.
    """

    vertices: NDArray[np.float64]
    faces: NDArray[np.uint32]
    welded: bool = False

    def moved(self, offset: ArrayLike) -> Mesh:
        """Shifted by `offset (3,)` [m]."""
        return Mesh(self.vertices + np.asarray(offset, dtype=np.float64), self.faces, self.welded)

    def scaled(self, factor: ArrayLike) -> Mesh:
        """Stretched about the origin by one factor, or one for each axis."""
        factors = np.broadcast_to(np.asarray(factor, dtype=np.float64), (3,))
        if (factors == 1).all():
            return self
        faces = self.faces[:, ::-1] if np.prod(factors) < 0 else self.faces
        return Mesh(self.vertices * factors, np.ascontiguousarray(faces))

    def turned(self, *, roll: float = 0.0, pitch: float = 0.0, yaw: float = 0.0) -> Mesh:
        """Turned about the origin by R = Rz(yaw) Ry(pitch) Rx(roll) [rad]."""
        return self.rotated(rotation(roll, pitch, yaw))

    def rotated(self, matrix: NDArray[np.float64]) -> Mesh:
        """Turned about the origin by a rotation matrix `(3, 3)`."""
        if (matrix == np.eye(3)).all():
            return self
        return Mesh(self.vertices @ matrix.T, self.faces, self.welded)

    def posed(self, pose: NDArray[np.float64]) -> Mesh:
        """Copy moved by a matrix `(4, 4)` of homogeneous coordinates; mirrored faces are turned round."""
        faces = self.faces[:, ::-1] if np.linalg.det(pose[:3, :3]) < 0 else self.faces
        return Mesh(self.vertices @ pose[:3, :3].T + pose[:3, 3], np.ascontiguousarray(faces))

    @property
    def triangles(self) -> NDArray[np.float64]:
        """`(f, 3, 3)` corners of each face [m]."""
        return self.vertices[self.faces]

    @property
    def bounds(self) -> NDArray[np.float64]:
        """`(2, 3)` lowest and highest coordinates [m]."""
        return np.stack([self.vertices.min(axis=0), self.vertices.max(axis=0)])

    @property
    def volume(self) -> float:
        """Enclosed volume [m^3], positive where faces point outwards; meaningful for closed meshes."""
        first = self.vertices[self.faces[:, 0]]
        return float(np.einsum("ij,ji->", first, _areas(self)) / 6)

    @property
    def closed(self) -> bool:
        """Whether every edge has one face on either side, with consistent orientation."""
        merged = self.merged()
        edges = np.concatenate([merged.faces[:, [0, 1]], merged.faces[:, [1, 2]], merged.faces[:, [2, 0]]]).astype(
            np.int64
        )
        count = len(merged.vertices)
        forward = np.sort(edges[:, 0] * count + edges[:, 1])
        backward = np.sort(edges[:, 1] * count + edges[:, 0])
        return len(edges) > 0 and bool(np.array_equal(forward, backward))

    def merged(self, tolerance: float = 1e-7) -> Mesh:
        """With vertices nearer than about `tolerance` [m] made one, in the order in which they first stand, and faces
        without area removed.
        """
        if self.welded:
            return self
        cells = np.round(self.vertices / tolerance).astype(np.int64)
        _, first, inverse = np.unique(cells @ _HASH, return_index=True, return_inverse=True)
        kept = np.zeros(len(cells), dtype=bool)
        kept[first] = True
        place = np.cumsum(kept) - 1
        faces = place[first][inverse.reshape(-1)][self.faces]
        good = (faces[:, 0] != faces[:, 1]) & (faces[:, 1] != faces[:, 2]) & (faces[:, 2] != faces[:, 0])
        return Mesh(self.vertices[kept], faces[good].astype(np.uint32), welded=True)

    def geometry(
        self,
        *,
        material: int | NDArray[np.uint32],
        label: int,
        instance: int,
        name: str = "",
        crease_deg: float | None = None,
    ) -> Geometry:
        """With a meaning; smooth across edges flatter than `crease_deg` [deg] where that is given."""
        if crease_deg is None:
            return Geometry(self.vertices, self.faces, material, label, instance, None, name)
        vertices, faces, normals = smooth(self, crease_deg)
        return Geometry(vertices, faces, material, label, instance, normals, name)


def rotation(roll: float, pitch: float, yaw: float) -> NDArray[np.float64]:
    """R = Rz(yaw) Ry(pitch) Rx(roll) `(3, 3)`, angles in rad."""
    cr, sr, cp, sp, cy, sy = np.cos(roll), np.sin(roll), np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    return np.array([
        [cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr],
        [sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr],
        [-sp, cp * sr, cp * cr],
    ])  # fmt: skip


def lean(along: float, across: float) -> NDArray[np.float64]:
    """R `(3, 3)` whose z axis is the normal of ground that rises by `along` x and `across` y [-], without a yaw of its
    own: R_y(p) R_x(r) z = (sin p cos r, -sin r, cos p cos r) is on (-along, -across, 1)."""
    pitch = -np.arctan(along)
    return rotation(np.arctan(across * np.cos(pitch)), pitch, 0.0)


def join(meshes: Sequence[Mesh]) -> Mesh:
    """One mesh of several, overlaps kept as they are."""
    starts = np.cumsum([0] + [len(m.vertices) for m in meshes[:-1]])
    return Mesh(
        np.concatenate([m.vertices for m in meshes]),
        np.concatenate([m.faces + np.uint32(s) for m, s in zip(meshes, starts, strict=True)]).astype(np.uint32),
    )


def union(meshes: Sequence[Mesh]) -> Mesh:
    """One closed surface around several closed meshes."""
    import manifold3d

    return _from_manifold(manifold3d.Manifold.batch_boolean([_to_manifold(m) for m in meshes], manifold3d.OpType.Add))


def difference(mesh: Mesh, tools: Sequence[Mesh]) -> Mesh:
    """A closed mesh with others cut out of it."""
    import manifold3d

    solids = [_to_manifold(m) for m in (mesh, *tools)]
    return _from_manifold(manifold3d.Manifold.batch_boolean(solids, manifold3d.OpType.Subtract))


def intersection(mesh: Mesh, other: Mesh) -> Mesh:
    """Common part of two closed meshes."""
    return _from_manifold(_to_manifold(mesh) ^ _to_manifold(other))


def _to_manifold(mesh: Mesh) -> Any:
    import manifold3d

    merged = mesh.merged()
    places = np.round(merged.vertices / _GRID_M) * _GRID_M
    solid = manifold3d.Manifold(manifold3d.Mesh64(places, merged.faces.astype(np.uint64)))
    if solid.status() != manifold3d.Error.NoError:
        raise WorldError(
            f"a mesh of {len(mesh.faces)} faces is not a closed solid ({solid.status()}): it cannot be cut or united"
        )
    return solid


def _from_manifold(solid: Any) -> Mesh:
    out = solid.to_mesh64()
    return Mesh(np.ascontiguousarray(out.vert_properties[:, :3]), out.tri_verts.astype(np.uint32))


def smooth(mesh: Mesh, crease_deg: float) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float32]]:
    """Vertices, faces and vertex normals that are smooth across edges flatter than `crease_deg` [deg].

    Each corner's normal is the area-weighted mean over the faces around its vertex that turn less than the crease from
    the corner's own face; corners that agree share a vertex.
    """
    merged = mesh.merged()
    count = len(merged.vertices)
    faces = np.ascontiguousarray(merged.faces.T, dtype=np.int64)  # (3, f): columns are several times as fast as rows
    areas = _areas(merged)  # (3, f)
    unit = areas / np.maximum(np.sqrt(np.einsum("ij,ij->j", areas, areas)), 1e-30)
    mean: NDArray[np.float64] = np.stack([sum(np.bincount(f, axis, minlength=count) for f in faces) for axis in areas])
    mean /= np.maximum(np.sqrt(np.einsum("ij,ij->j", mean, mean)), 1e-30)
    # within half the crease of the mean, faces are within the crease of one another: most vertices of a fine mesh
    creased = np.zeros(count, dtype=bool)
    for f in faces:
        creased[f[sum(m[f] * u for m, u in zip(mean, unit, strict=True)) < np.cos(np.radians(crease_deg / 2))]] = True
    if not creased.any():
        return merged.vertices, merged.faces, mean.T.astype(np.float32)
    means, weighted, units = (np.ascontiguousarray(columns.T) for columns in (mean, areas, unit))
    return _split(merged, creased, means, weighted, units, np.cos(np.radians(crease_deg + _DOUBT_DEG)))


def _areas(mesh: Mesh) -> NDArray[np.float64]:
    """`(3, f)` normals of the faces, of twice the length of their areas [m^2]."""
    x, y, z = np.ascontiguousarray(mesh.vertices.T)
    a, b, c = np.ascontiguousarray(mesh.faces.T)
    ux, uy, uz, vx, vy, vz = (axis[end] - axis[a] for end in (b, c) for axis in (x, y, z))
    return np.stack([uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx])


def _split(
    merged: Mesh,
    creased: NDArray[np.bool_],
    mean: NDArray[np.float64],
    weighted: NDArray[np.float64],
    unit: NDArray[np.float64],
    limit: float,
) -> tuple[NDArray[np.float64], NDArray[np.uint32], NDArray[np.float32]]:
    """Result of `smooth` where some vertices are `creased`: a vertex for each normal that faces around them have."""
    vertex = merged.faces.reshape(-1).astype(np.int64)  # (3 f,) corner -> vertex
    count = len(merged.vertices)
    rough = np.flatnonzero(creased[vertex])
    normal = _creased(vertex, rough, weighted, unit, limit)
    x, y, z = np.round(normal * 500 + 512).astype(np.int64).T
    keys, keep, place = np.unique(vertex[rough] << 30 | x << 20 | y << 10 | z, return_index=True, return_inverse=True)
    many = np.where(creased, np.bincount(keys >> 30, minlength=count), 1)  # corners that each vertex becomes
    start = np.cumsum(many) - many
    rank = np.arange(len(keys)) - (np.cumsum(np.bincount(keys >> 30, minlength=count)) - many * creased)[keys >> 30]
    at = start[vertex]
    at[rough] += rank[place.reshape(-1)]
    normals = np.repeat(mean, many, axis=0)
    normals[start[keys >> 30] + rank] = normal[keep]
    return np.repeat(merged.vertices, many, axis=0), at.reshape(-1, 3).astype(np.uint32), normals.astype(np.float32)


_PAIRS: Final = 1 << 20  # at a time: memory stays small


def _creased(
    vertex: NDArray[np.int64],
    rough: NDArray[np.int64],
    weighted: NDArray[np.float64],
    unit: NDArray[np.float64],
    limit: float,
) -> NDArray[np.float64]:
    """Normals at corners `rough`, each the mean over the faces at its vertex that agree with its own."""
    corners = rough[np.argsort(vertex[rough], kind="stable")]  # all corners of a vertex are among them
    first = np.searchsorted(vertex[corners], vertex[rough])
    valence = np.searchsorted(vertex[corners], vertex[rough], side="right") - first
    normal = np.zeros((len(rough), 3))
    last = np.cumsum(valence)  # of the pairs of a corner and a face at its vertex
    for some in np.split(np.arange(len(rough)), np.searchsorted(last, np.arange(_PAIRS, last[-1], _PAIRS))):
        corner = np.repeat(some, valence[some])
        turn = np.arange(len(corner)) - np.repeat(np.cumsum(valence[some]) - valence[some], valence[some])
        other = corners[first[corner] + turn] // 3
        near = np.einsum("ij,ij->i", unit[other], unit[rough[corner] // 3]) >= limit
        np.add.at(normal, corner[near], weighted[other[near]])
    normal /= np.maximum(np.linalg.norm(normal, axis=1, keepdims=True), 1e-30)
    return normal

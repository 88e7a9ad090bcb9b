"""Triangles as the ray caster takes them: plain NumPy arrays, no device."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Geometry:
    """A triangle mesh with what it is made of.

    Attributes:
        vertices: `(v, 3)` [m], float64, or float32 where that is precise enough: world NWU for static geometry, body
            FLU for a body.
        faces: `(f, 3)` uint32, counter-clockwise seen from outside.
        material: row of the world's material table: one for all faces, or `(f,)` of any unsigned type.
        label: semantic label 0 .. 255.
        instance: instance id, from 1 on, unique in a world.
        vertex_normals: `(v, 3)` float32 for a smooth surface (terrain, hulls); None for flat faces.
        name: for errors, maps and exports.
    """

    vertices: NDArray[np.floating]
    faces: NDArray[np.uint32]
    material: int | NDArray[np.unsignedinteger]
    label: int
    instance: int
    vertex_normals: NDArray[np.float32] | None = None
    name: str = field(default="")

    @property
    def face_materials(self) -> NDArray[np.uint32]:
        """`(f,)` material rows."""
        return np.broadcast_to(np.asarray(self.material, dtype=np.uint32), (len(self.faces),))

    @cached_property
    def extent(self) -> NDArray[np.float64]:
        """`(2, 3)` lowest and highest coordinates [m]; of a mesh without corners, infinite and the wrong way round."""
        vertices = self.vertices
        low, high = vertices.min(axis=0, initial=np.inf), vertices.max(axis=0, initial=-np.inf)
        return np.stack([low, high]).astype(np.float64)

    @cached_property
    def digest(self) -> bytes:
        """Digest of corners, faces, materials and normals, whatever label, instance and name."""
        normals = () if self.vertex_normals is None else (self.vertex_normals,)
        found = hashlib.blake2b(digest_size=16)
        for array in (self.vertices, self.faces, self.face_materials, *normals):
            found.update(f"{array.dtype.str}{array.shape}".encode())
            found.update(np.ascontiguousarray(array).tobytes())
        return found.digest()

    def share(self, faces: NDArray[np.uint32], vertex_normals: NDArray[np.float32]) -> None:
        """Hold these arrays, equal to its own, in place of them: what a scene needs anyway is not held twice."""
        assert faces.shape == self.faces.shape
        object.__setattr__(self, "faces", faces)
        object.__setattr__(self, "vertex_normals", vertex_normals)

    @property
    def bytes_held(self) -> int:
        """Memory of its own arrays [B]."""
        normals = 0 if self.vertex_normals is None else self.vertex_normals.nbytes
        return self.vertices.nbytes + self.faces.nbytes + normals


class PlacedGeometry(Geometry):
    """A copy of another geometry, the model, turned, scaled and shifted; it has no corners of its own in memory.

    Ray-tracing scenes hold a model once, however many copies of it stand in a world.

    Attributes:
        model: what it is a copy of; its label, instance and name do not count.
        turn: `(3, 3)` rotation matrix.
        scale: in all directions.
        offset: `(3,)` where the model's origin stands, world NWU [m].
    """

    model: Geometry
    turn: NDArray[np.float64]
    scale: float
    offset: NDArray[np.float64]

    def __init__(
        self, model: Geometry, *, turn: NDArray[np.float64], scale: float, offset: NDArray[np.float64], material: int,
        label: int, instance: int, name: str = "",
    ) -> None:  # fmt: skip
        for key, value in {
            "model": model, "turn": turn, "scale": scale, "offset": offset, "faces": model.faces, "material": material,
            "label": label, "instance": instance, "name": name,
        }.items():  # fmt: skip
            object.__setattr__(self, key, value)

    @property
    def vertices(self) -> NDArray[np.floating]:
        """`(v, 3)` [m], made anew whenever it is asked for."""
        return self.model.vertices @ (self.scale * self.turn).T + self.offset

    @property
    def vertex_normals(self) -> NDArray[np.float32] | None:
        """`(v, 3)`, made anew whenever it is asked for."""
        normals = self.model.vertex_normals
        return None if normals is None else normals @ self.turn.T.astype(np.float32)

    @property
    def bytes_held(self) -> int:
        """Memory of its own arrays [B]: the model's are not counted."""
        return self.turn.nbytes + self.offset.nbytes

"""Triangles as the ray caster takes them: plain NumPy arrays, no device."""

from __future__ import annotations

from dataclasses import dataclass, field

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

"""Meshes of bodies, each once, side by side in a scene that never changes.

Rays are brought into the frame of the body that they may meet. So nothing is rebuilt when bodies move, however many
they are, and a hit depends on where ray and body are to one another, not on where in the world.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.hit_tables import Faces
from pelagos.raycast.meshes import mesh_of, watertight

_GAP: Final = 1.0  # [m] between the spheres that hold two meshes; rays look for one of them within its own


@jit.struct
class ShapeTables:
    """Faces of all meshes: a Dr.Jit struct.

    Attributes:
        faces: see `Faces`; `thing` is the number of the face's material among those of its mesh.
        material: `UInt32`, row of the world's material table of each face.
    """

    faces: Faces
    material: Array


class Shapes:
    """The distinct meshes of some bodies, whoever made them: equal ones stand once.

    Where a mesh stands decides how its hits round, so that it depends on nothing but which meshes there are.

    Attributes:
        scene: the `mi.Scene` that holds them, the smallest first.
        tables: see `ShapeTables`.
        offset: `(b, 3)` where the origin of each body's mesh stands in it [m].
        radius: `(b,)` of the sphere about the origin of each body that holds its mesh [m].
        materials: by body, rows of the world's material table that its mesh uses, ascending.
    """

    def __init__(self, bodies: Sequence[Geometry]) -> None:
        keys = _keys(bodies)
        distinct = dict(zip(reversed(keys), reversed(bodies), strict=True))
        radius = {key: float(np.linalg.norm(g.vertices, axis=1).max()) for key, g in distinct.items()}
        used = {key: np.unique(g.face_materials, return_inverse=True) for key, g in distinct.items()}
        place: dict[bytes, NDArray[np.float64]] = {}
        x = 0.0
        order = sorted(distinct, key=lambda k: (radius[k], k))  # not as bodies were named or ordered
        standing = []
        for key in order:
            x += radius[key]
            place[key] = np.array([x, 0.0, 0.0])
            x += radius[key] + _GAP
            standing.append(replace(distinct[key], vertices=distinct[key].vertices + place[key]))
        mesh, faces = mesh_of("shapes", standing, np.zeros(3))
        self.scene: Any = jit.mi.load_dict({"type": "scene", **watertight(), "shapes": mesh}, optimize=False)
        self.tables = ShapeTables(
            faces, jit.from_numpy(jit.UInt32, np.concatenate([g.face_materials for g in standing]).astype(np.uint32))
        )
        parts = np.concatenate([used[key][1] for key in order]).astype(np.uint32)
        self.tables.faces.thing = jit.from_numpy(jit.UInt32, parts)
        dr.make_opaque(self.tables)
        self.offset: NDArray[np.float64] = np.array([place[key] for key in keys]).reshape(-1, 3)
        self.radius: NDArray[np.float64] = np.array([radius[key] for key in keys])
        self.materials: list[list[int]] = [used[key][0].tolist() for key in keys]


def _keys(bodies: Sequence[Geometry]) -> list[bytes]:
    """A digest of the mesh and the materials of each body; bodies of one kind often share arrays, digested once."""
    known: dict[tuple[int, int], bytes] = {}
    for g in bodies:
        shared = id(g.vertices), id(g.material)
        if shared not in known:
            known[shared] = g.digest
    return [known[id(g.vertices), id(g.material)] for g in bodies]

"""Models of which many copies stand in the static scene: held once, each copy an instance."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.raycast.hit_tables import Faces
from pelagos.raycast.meshes import joined, mesh_of
from pelagos.raycast.objects import Objects

_MANY_COPIED: Final = 500_000  # faces of all copies of a model from which on they become instances of it


class Copies:
    """Models of which many copies stand in the static scene, each copy an instance.

    Attributes:
        shapes: Mitsuba's, models and copies.
        faces: of all models, in their own frames.
        first, thing, attitude: by copy, see `Tables`.
    """

    def __init__(self, copies: dict[int, list[PlacedGeometry]], objects: Objects, origin: NDArray[np.float64]) -> None:
        self.shapes: dict[str, Any] = {}
        self.first: list[int] = []
        self.thing: list[int] = []
        parts: list[Faces] = []
        matrices: list[NDArray[np.float64]] = []
        total = 0
        for key, group in copies.items():
            model = group[0].model
            mesh, faces = mesh_of(f"model{key}", [model], np.zeros(3))
            faces.thing = dr.zeros(jit.UInt32, len(model.faces))
            parts.append(faces)
            self.shapes[f"model{key}"] = {"type": "shapegroup", "mesh": mesh}
            for copy in group:
                matrix = np.eye(4)
                matrix[:3, :3], matrix[:3, 3] = copy.scale * copy.turn, copy.offset - origin
                self.shapes[f"copy{len(self.first)}"] = {
                    "type": "instance",
                    "group": {"type": "ref", "id": f"model{key}"},
                    "to_world": jit.mi.ScalarTransform4f(matrix),
                }
                self.first.append(total)
                self.thing.append(int(objects.rows(copy)[0]))
                matrices.append(copy.turn)
            total += len(model.faces)
        self.attitude = upright(len(matrices))
        if matrices:
            from scipy.spatial.transform import Rotation  # a tenth of the time that all imports take

            self.attitude = Rotation.from_matrix(np.array(matrices)).as_quat(scalar_first=True)
        self.faces = joined(parts)


def models(static: Sequence[Geometry]) -> dict[int, list[PlacedGeometry]]:
    """Copies by model, of those models whose copies would together be large."""
    groups: dict[int, list[PlacedGeometry]] = {}
    for g in static:
        if isinstance(g, PlacedGeometry) and len(g.faces):
            groups.setdefault(id(g.model), []).append(g)
    return {k: group for k, group in groups.items() if len(group) * len(group[0].faces) > _MANY_COPIED}


def upright(count: int) -> NDArray[np.float64]:
    """`(count, 4)` attitudes that turn nothing, w first."""
    return np.tile([1.0, 0.0, 0.0, 0.0], (count, 1))

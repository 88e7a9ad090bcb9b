"""The hull of a vehicle as the ray caster takes it."""

from __future__ import annotations

from typing import Annotated, Final, TypeAlias

import numpy as np
from pydantic import Field

from pelagos.raycast.geometry import Geometry
from pelagos.vehicles.shape.mesh import joined
from pelagos.vehicles.shape.parts import PartsHull
from pelagos.vehicles.shape.torpedo import TorpedoHull

VEHICLE_LABEL: Final = 64

HullConfig: TypeAlias = Annotated[PartsHull | TorpedoHull, Field(discriminator="type")]


def hull_materials(config: PartsHull | TorpedoHull, own: tuple[str, ...]) -> tuple[str, ...]:
    """The vehicle's own materials, and those that parts of the hull name, each once."""
    return tuple(dict.fromkeys([*own, *(m.material for m in config.meshes() if m.material is not None)]))


def build_hull(config: PartsHull | TorpedoHull, name: str, materials: tuple[str, ...]) -> Geometry:
    """The hull `(v, 3)` FLU [m] with smooth normals; materials are rows of `materials`, see `hull_materials`."""
    meshes = config.meshes()
    mesh = joined(meshes)
    rows = [0 if m.material is None else materials.index(m.material) for m in meshes]
    return Geometry(
        vertices=mesh.vertices,
        faces=mesh.faces,
        material=np.repeat(np.array(rows, dtype=np.uint32), [len(m.faces) for m in meshes]),
        label=VEHICLE_LABEL,
        instance=1,
        vertex_normals=mesh.normals.astype(np.float32),
        name=name,
    )

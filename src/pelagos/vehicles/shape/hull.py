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


def build_hull(config: PartsHull | TorpedoHull, name: str) -> Geometry:
    """The hull `(v, 3)` FLU [m] with smooth normals."""
    mesh = joined(config.meshes())
    return Geometry(
        vertices=mesh.vertices,
        faces=mesh.faces,
        material=0,
        label=VEHICLE_LABEL,
        instance=1,
        vertex_normals=mesh.normals.astype(np.float32),
        name=name,
    )

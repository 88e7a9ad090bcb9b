"""Props of a scenario: things apart from the world, which may differ from copy to copy and be moved in a run."""

from __future__ import annotations

from typing import Annotated, Literal, Self, TypeAlias

from pydantic import Field, model_validator

from pelagos.config.path import MeshPath
from pelagos.config.strict import Strict, refusal

ShapeName: TypeAlias = Literal["box", "sphere", "cylinder", "cone", "mesh", "corner_reflector"]
_Size: TypeAlias = Annotated[float, Field(gt=0)]


class PropConfig(Strict):
    """A thing in every copy of the world, as `sim.spawn` puts one there: `sim.props["crate"].move(position=...)`. A
    reset puts it back; `vary` draws where it stands."""

    shape: ShapeName
    """`cylinder` and `cone` stand upright; `mesh` reads `path`; `corner_reflector` is open towards its own x."""
    path: MeshPath | None = None
    """Mesh file (OBJ, STL, PLY, glTF), relative to the scenario."""
    position_m: tuple[float, float, float]
    """Its middle, the mesh file's origin, or the corner's tip: x north, y west, z up from the mean sea surface [m]."""
    orientation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw, R = Rz Ry Rx [deg]."""
    size_m: _Size | tuple[_Size, _Size, _Size] = 1.0
    """Extent along its own x, y, z [m], one number for a cube's; a mesh's scale; a corner reflector's edge."""
    material: str = "steel"
    """Material."""
    label: str | int = ""
    """Semantic label by name or number; by its shape where not given."""

    @model_validator(mode="after")
    def _has_file(self) -> Self:
        if (self.shape == "mesh") != (self.path is not None):
            raise refusal("'path' goes with shape: mesh")
        if self.shape == "corner_reflector" and not isinstance(self.size_m, float):
            raise refusal("'size_m' of a corner reflector is one number, its edge")
        return self

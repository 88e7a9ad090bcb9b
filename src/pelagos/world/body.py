"""Things that can be put into a running world: props."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final, get_args

import numpy as np
from numpy.typing import NDArray

from pelagos.config.prop import ShapeName
from pelagos.errors import CommandError, LookupFailed
from pelagos.raycast.geometry import Geometry
from pelagos.world import shapes
from pelagos.world.mesh import Mesh
from pelagos.world.reflector import corner_reflector

if TYPE_CHECKING:
    from pelagos.world.world import World

SHAPES: Final = get_args(ShapeName)
"""What a prop can be."""

_LABELS: Final = {
    "box": "cube", "sphere": "sphere", "cylinder": "base_shape", "cone": "base_shape", "mesh": "debris",
    "corner_reflector": "base_shape",
}  # fmt: skip
_SMOOTH: Final = {"sphere": 60.0, "cylinder": 40.0, "cone": 40.0, "mesh": 30.0}


@dataclass(frozen=True)
class Prop:
    """A thing to spawn: `sim.spawn(Prop("box", position=(5, 0, -10), size=(1, 1, 1), material="steel"))`.

    Attributes:
        shape: "box", "sphere", "cylinder", "cone" (upright, about the middle of its height), "mesh", or
            "corner_reflector" (three plates, open towards its own +x).
        position: of its middle, of the mesh file's own origin, or of the corner's tip, world NWU [m].
        size: extent along its own x, y, z [m], one number for a cube's; of a mesh, the scale; of a corner reflector,
            one number, the edge along which two plates meet.
        attitude: quaternion (w, x, y, z), its own axes to world NWU.
        material: one of `MATERIALS`; a corner reflector is of steel.
        label: semantic label by name or number; by shape where not given.
        path: mesh file (OBJ, STL, PLY, glTF), for the shape "mesh".
    """

    shape: str
    position: Sequence[float] = (0.0, 0.0, 0.0)
    size: float | Sequence[float] = 1.0
    attitude: Sequence[float] = (1.0, 0.0, 0.0, 0.0)
    material: str = "steel"
    label: str | int = ""
    path: str | Path | None = None

    def __post_init__(self) -> None:
        if self.shape not in SHAPES:
            raise LookupFailed("shape of a prop", self.shape, SHAPES)
        if self.shape == "mesh" and self.path is None:
            raise CommandError("a prop of shape 'mesh' needs the path of a mesh file: Prop('mesh', path='rock.obj')")
        extent = self.extent
        if not (np.isfinite(extent).all() and (extent > 0).all()):
            raise CommandError(f"the size of a prop must be greater than zero, not {self.size}")
        if self.shape == "corner_reflector" and (extent != extent[0]).any():
            raise CommandError(f"the size of a corner reflector is one number, its edge, not {self.size}")

    @property
    def extent(self) -> NDArray[np.float64]:
        """`(3,)` size along each axis [m].

        Raises:
            CommandError: `size` is neither one number nor three.
        """
        given = np.asarray(self.size, dtype=np.float64)
        if given.shape not in ((), (1,), (3,)):
            raise CommandError(f"the size of a prop is one number or three, not {self.size}")
        return np.broadcast_to(given, (3,))

    @property
    def mesh(self) -> Mesh:
        """Its surface in its own frame [m]."""
        if self.shape == "mesh":
            from pelagos.world.files import read_mesh

            assert self.path is not None
            return read_mesh(Path(self.path)).scaled(self.extent)
        if self.shape == "corner_reflector":
            return corner_reflector(float(self.extent[0])).mesh
        unit = {
            "box": lambda: shapes.box((1, 1, 1)),
            "sphere": lambda: shapes.sphere(0.5, sides=48, rings=24),
            "cylinder": lambda: shapes.cylinder(0.5, 1.0, sides=48),
            "cone": lambda: shapes.cone(0.5, 1.0, sides=48),
        }[self.shape]()
        return unit.scaled(self.extent)

    def geometry(self, *, instance: int, world: World) -> Geometry:
        """Its geometry in its own frame, with material and label as this world numbers them.

        Raises:
            LookupFailed: unknown material or label.
            WorldError: the mesh file cannot be used.
        """
        label = self.label if self.label != "" else _LABELS[self.shape]
        if self.shape == "corner_reflector":
            corner, number = corner_reflector(float(self.extent[0])), world.label_number(label)
            return corner.geometry(world.material_row, label=number, instance=instance, name=str(label))
        return self.mesh.geometry(
            material=world.material_row(self.material),
            label=world.label_number(label),
            instance=instance,
            name=str(label),
            crease_deg=_SMOOTH.get(self.shape),
        )

    @property
    def bounding_radius(self) -> float:
        """Radius of a sphere about its own origin that holds it [m]."""
        return math.sqrt(float((self.mesh.vertices**2).sum(axis=1).max()))

"""Moving bodies on scripted paths: ships that pass, schools of fish, swinging chains."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Final

import numpy as np
from pydantic import ConfigDict, Field, field_validator

from pelagos.config.described import Described
from pelagos.config.path import MeshPath
from pelagos.errors import LookupFailed
from pelagos.math.so3 import rotate_np
from pelagos.raycast.geometry import Geometry
from pelagos.world.mesh import Mesh
from pelagos.world.path import PathConfig, PathPose

if TYPE_CHECKING:
    from pelagos.world.generate.thing import Kind
    from pelagos.world.world import World

_SHAPES: Final = {"ship": (60.0, "container_boat"), "fish": (0.5, "fish"), "chain": (6.0, "chain"),
                  "box": (1.0, "cube"), "sphere": (1.0, "sphere"), "cylinder": (1.0, "base_shape"),
                  "cone": (1.0, "base_shape"), "file": (1.0, "debris")}  # fmt: skip
"""Shapes of their own, each with its size [m] and label where a scenario says nothing."""

_CREASE_DEG: Final = 35.0


class MoverConfig(Described):
    """A body that moves on a scripted path, whatever happens to it."""

    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)

    name: str = Field(min_length=1)
    """Its name, unique among the movers."""
    body: str
    """`ship`, `fish`, `chain`, `box`, `sphere`, `cylinder`, `cone`, `file`, or any kind of object of a generated world
    (`fish_school`, `mooring`, `wreck_submarine`, ...)."""
    path: PathConfig
    """How it moves."""
    size_m: float | None = Field(default=None, gt=0)
    """Its size [m]: length of a ship, a fish or a chain, edge or diameter of a primitive, scale of a file."""
    material: str | None = None
    """Material, where the body has none of its own."""
    label: str | int | None = None
    """Semantic label by name or number; the body's own where not given."""
    file: MeshPath | None = None
    """Mesh for the body `file` (OBJ, STL, PLY, glTF), relative to the scenario."""
    seed: int = Field(default=0, ge=0)
    """Seed of its shape, where that is random."""

    @field_validator("body")
    @classmethod
    def _known(cls, value: str) -> str:
        known = [*_SHAPES, *_kinds()]
        if value not in known:
            raise ValueError(str(LookupFailed("body of a mover", value, known)))
        return value

    def pose(self, t: float) -> PathPose:
        """Pose at time t [s], and its change."""
        return self.path.pose(t)

    def geometry(self, *, instance: int, world: World) -> Geometry:
        """Its surface in its own frame FLU, material rows and label as this world numbers them.

        Raises:
            LookupFailed: unknown material or label.
            WorldError: the mesh file cannot be used.
        """
        parts, label = self._parts()
        return _joined(
            [mesh for mesh, _ in parts],
            [world.material_row(self.material or material) for _, material in parts],
            label=world.label_number(label if self.label is None else self.label),
            instance=instance,
            name=self.name,
        )

    def standing(self, t: float, *, instance: int, world: World) -> Geometry:
        """Its surface where it is at time t [s], world NWU; raises as `geometry`."""
        made, pose = self.geometry(instance=instance, world=world), self.pose(t)
        q, normals = pose.attitude[None], made.vertex_normals
        return replace(
            made,
            vertices=rotate_np(q, np.asarray(made.vertices, dtype=np.float64)) + pose.position,
            vertex_normals=None if normals is None else rotate_np(q, normals.astype(np.float64)).astype(np.float32),
        )

    def label_number(self, world: World) -> int:
        """Its semantic label, as this world numbers labels.

        Raises:
            LookupFailed: unknown label.
        """
        return world.label_number(self._parts()[1] if self.label is None else self.label)

    def _parts(self) -> tuple[list[tuple[Mesh, str]], str | int]:
        """Meshes with their materials, and the label of the whole."""
        if self.body in _SHAPES:
            size, label = _SHAPES[self.body]
            return _shape(self.body, self.size_m or size, self), label
        kind = _kinds()[self.body]
        rng = np.random.Generator(np.random.PCG64(self.seed))
        thing = kind.build(self.size_m or sum(kind.size) / 2, rng, 10.0)
        return [(part.mesh, part.material) for part in thing.parts], thing.label


def checked(movers: Sequence[MoverConfig]) -> None:
    """Names are unique.

    Raises:
        ValueError: two movers have one name.
    """
    names = [m.name for m in movers]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise ValueError(f"two movers are named {twice[0]!r}; names are unique")


def _kinds() -> dict[str, Kind]:
    from pelagos.world.generate.kinds.lost import LOST
    from pelagos.world.generate.kinds.natural import NATURAL
    from pelagos.world.generate.kinds.structures import STRUCTURES

    return {**NATURAL, **LOST, **STRUCTURES}


def _shape(body: str, size: float, config: MoverConfig) -> list[tuple[Mesh, str]]:
    from pelagos.world import shapes
    from pelagos.world.files import read_mesh
    from pelagos.world.generate.kinds.natural import fish
    from pelagos.world.ship import ship

    if body == "ship":
        return ship(size)
    if body == "fish":
        return [(fish(size), "fish")]
    if body == "chain":  # hangs from its origin
        path = np.stack([np.zeros(24), np.zeros(24), np.linspace(0.0, -size, 24)], axis=1)
        return [(shapes.chain(path, 0.3, 0.03), "rusted_steel")]
    if body == "file":
        if config.file is None:
            raise LookupFailed("mesh file of a mover", "", ["file: PATH"], where=config.name)
        return [(read_mesh(config.file).scaled(size), "steel")]
    unit = {
        "box": lambda: shapes.box((1, 1, 1)),
        "sphere": lambda: shapes.sphere(0.5, sides=32, rings=16),
        "cylinder": lambda: shapes.cylinder(0.5, 1.0, sides=32),
        "cone": lambda: shapes.cone(0.5, 1.0, sides=32),
    }[body]()
    return [(unit.scaled(size), "steel")]


def _joined(meshes: list[Mesh], rows: list[int], *, label: int, instance: int, name: str) -> Geometry:
    """One geometry of several parts, each with its material."""
    made = [m.geometry(material=0, label=label, instance=instance, crease_deg=_CREASE_DEG) for m in meshes]
    starts = np.cumsum([0] + [len(g.vertices) for g in made[:-1]])
    return Geometry(
        vertices=np.concatenate([g.vertices for g in made]),
        faces=np.concatenate([g.faces + np.uint32(s) for g, s in zip(made, starts, strict=True)]),
        material=np.concatenate([np.full(len(g.faces), r, dtype=np.uint32) for g, r in zip(made, rows, strict=True)]),
        label=label,
        instance=instance,
        vertex_normals=np.concatenate([g.vertex_normals for g in made if g.vertex_normals is not None]),
        name=name,
    )

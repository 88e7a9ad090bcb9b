"""A world under construction: things are added with a material's name and a label's, and get their rows and ids."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from numpy.typing import NDArray

from pelagos.math.geodesy import GeoOrigin
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.world.border import patchwork
from pelagos.world.label import label_number
from pelagos.world.material import MATERIALS, Material, material
from pelagos.world.mesh import Mesh
from pelagos.world.reflector import CORNERS, Reflector
from pelagos.world.terrain import HeightField
from pelagos.world.world import World


class Site:
    """Collects geometry; `world()` closes it.

    Attributes:
        geometries: what was added so far.
        materials: the material table so far.
        terrain: the ground, once `ground` was called.
        notes: lines for `World.notes`.
    """

    def __init__(self, *, user_labels: Mapping[str, int] | None = None) -> None:
        self.geometries: list[Geometry] = []
        self.materials: list[Material] = []
        self.terrain: HeightField | None = None
        self.notes: list[str] = []
        self.user_labels = dict(user_labels or {})
        self._instances = 0

    @classmethod
    def reopened(cls, world: World) -> Site:
        """A finished world, to add to."""
        site = cls(user_labels=world.user_labels)
        site.geometries, site.materials, site.terrain = list(world.geometries), list(world.materials), world.terrain
        site._instances = world.next_instance - 1
        return site

    def row(self, what: str | Material) -> int:
        """The row of a material in this world's table; new materials get a new row."""
        wanted = material(what) if isinstance(what, str) else what
        if wanted not in self.materials:
            self.materials.append(wanted)
        return self.materials.index(wanted)

    def new_instance(self) -> int:
        """An instance id that nothing has yet; parts of one thing share one."""
        self._instances += 1
        return self._instances

    def ground(
        self,
        terrain: HeightField,
        what: str | Material | NDArray[np.uint32],
        *,
        label: str = "landscape",
        name: str = "seabed",
    ) -> None:
        """Lay the ground; its material is one, or a row for each cell `(nx-1, ny-1)`."""
        rows = what if isinstance(what, np.ndarray) else self.row(what)
        number = label_number(label, self.user_labels)
        self.geometries.append(terrain.geometry(material=rows, label=number, instance=self.new_instance(), name=name))
        self.terrain = terrain

    def ground_patches(
        self,
        terrain: HeightField,
        materials: Sequence[str],
        fields: NDArray[np.float32],
        *,
        label: str = "landscape",
        name: str = "seabed",
    ) -> None:
        """Lay the ground in several materials: the one whose field `(m, nx, ny)` is the highest; see `patchwork`."""
        found = [self.row(m) for m in materials]
        rows = np.array(found, dtype=np.min_scalar_type(max(found)))  # there are as many of them as triangles
        number = label_number(label, self.user_labels)
        self.geometries.append(patchwork(terrain, fields, rows, label=number, instance=self.new_instance(), name=name))
        self.terrain = terrain

    def add(
        self,
        mesh: Mesh,
        what: str | Material,
        *,
        label: str | int,
        name: str,
        crease_deg: float | None = None,
        instance: int | None = None,
    ) -> int:
        """Add a thing, or a part of the thing `instance`, smooth over edges below the crease; returns its id."""
        number = self.new_instance() if instance is None else instance
        made = mesh.geometry(
            material=self.row(what),
            label=label_number(label, self.user_labels),
            instance=number,
            name=name,
            crease_deg=crease_deg,
        )
        self.geometries.append(made)
        return number

    def add_corner(self, corner: Reflector, *, label: str | int, name: str) -> int:
        """Add a corner reflector where it stands; returns its id."""
        number = self.new_instance()
        label = label_number(label, self.user_labels)
        known = MATERIALS | CORNERS
        made = corner.geometry(lambda m: self.row(known[m]), label=label, instance=number, name=name)
        self.geometries.append(made)
        return number

    def place(
        self,
        model: Geometry,
        what: str | Material,
        *,
        turn: NDArray[np.float64],
        scale: float,
        offset: NDArray[np.float64],
        label: str | int,
        name: str,
        instance: int,
    ) -> None:
        """Add a copy of a model, scaled, turned by a rotation matrix `(3, 3)` and shifted by `offset (3,)` [m]."""
        number = label_number(label, self.user_labels)
        self.geometries.append(
            PlacedGeometry(
                model,
                turn=turn,
                scale=scale,
                offset=offset,
                material=self.row(what),
                label=number,
                instance=instance,
                name=name,
            )
        )

    def world(self, *, name: str, description: str, origin: GeoOrigin, notes: Sequence[str] = ()) -> World:
        """The finished world."""
        return World(
            geometries=tuple(self.geometries),
            materials=tuple(self.materials),
            origin=origin,
            name=name,
            description=description,
            terrain=self.terrain,
            notes=(*self.notes, *notes),
            user_labels=self.user_labels,
        )

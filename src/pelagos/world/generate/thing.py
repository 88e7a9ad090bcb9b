"""A thing that can be set on the ground: parts of different materials, and how it stands."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from pelagos.raycast.geometry import Geometry
from pelagos.world.mesh import Mesh, lean, rotation
from pelagos.world.site import Site


@dataclass(frozen=True)
class Part:
    """A mesh of one material.

    Attributes:
        mesh: in the thing's own frame, which has its origin on the ground and z up, before it is scaled [m].
        material: by name.
        crease_deg: edges flatter than this look smooth; None for flat faces.
        scale: of the mesh, in all directions.
    """

    mesh: Mesh
    material: str
    crease_deg: float | None = 40.0
    scale: float = 1.0

    @cached_property
    def model(self) -> Geometry:
        """The mesh with its normals; all copies of a thing, in whatever size, share it."""
        return self.mesh.geometry(material=0, label=0, instance=0, crease_deg=self.crease_deg)

    @property
    def vertices(self) -> NDArray[np.float64]:
        """`(v, 3)` corners in the thing's own frame [m]."""
        return self.scale * self.mesh.vertices

    def scaled(self, factor: float) -> Part:
        """The same part in another size."""
        made = replace(self, scale=self.scale * factor)
        made.__dict__["model"] = self.model
        return made


@dataclass(frozen=True)
class Thing:
    """Parts that stand together.

    Attributes:
        name: for people.
        label: semantic label.
        parts: see `Part`.
        sink: how deep its origin lies below the ground [m].
        follow: how far it leans with the slope: 0 stands upright, 1 lies flat on it.
    """

    name: str
    label: str | int
    parts: tuple[Part, ...]
    sink: float = 0.0
    follow: float = 1.0

    @cached_property
    def radius(self) -> float:
        """Radius of the smallest upright cylinder about its origin that holds it, however it is turned [m]."""
        points = np.concatenate([p.vertices for p in self.parts])
        if self.follow > 0:
            return float(np.sqrt((points**2).sum(axis=1).max()))
        return float(np.hypot(points[:, 0], points[:, 1]).max())

    def scaled(self, factor: float) -> Thing:
        """The same thing in another size."""
        parts = tuple(p.scaled(factor) for p in self.parts)
        return Thing(self.name, self.label, parts, self.sink * factor, self.follow)


Maker = Callable[[float, np.random.Generator], Thing]
"""Makes a thing of a size [m]; the kind says what the size is."""

DeepMaker = Callable[[float, np.random.Generator, float], Thing]
"""Makes a thing of a size [m] for a depth of water over its foot [m]: things that reach the surface."""


@dataclass(frozen=True)
class Kind:
    """A kind of thing.

    Attributes:
        title: one line.
        size_is: what its size measures.
        size: (least, greatest) size where a scenario says nothing [m].
        make: see `Maker`; None for things that are made for their depth.
        variants: how many different ones are made and then scaled and turned; 0 makes each anew.
        max_slope_deg: steepest ground it stands on.
        needs_depth: least depth of water over its foot, as a multiple of its size (0: may reach out of the water).
        make_deep: see `DeepMaker`.
    """

    title: str
    size_is: str
    size: tuple[float, float]
    make: Maker | None
    variants: int = 0
    max_slope_deg: float = 30.0
    needs_depth: float = 1.0
    make_deep: DeepMaker | None = None

    def build(self, size: float, rng: np.random.Generator, depth: float) -> Thing:
        """One of this kind."""
        if self.make_deep is not None:
            return self.make_deep(size, rng, depth)
        assert self.make is not None
        return self.make(size, rng)


def stand(
    site: Site, thing: Thing, at: NDArray[np.float64], ground: float, slope: tuple[float, float], yaw: float
) -> int:
    """Set a thing on the ground; returns its instance id.

    Args:
        site: the world under construction.
        thing: what.
        at: `(2,)` place [m].
        ground: height of the ground there [m].
        slope: (dz/dx, dz/dy) of the ground there.
        yaw: heading [rad].
    """
    turn = lean(slope[0] * thing.follow, slope[1] * thing.follow) @ rotation(0.0, 0.0, yaw)
    instance = site.new_instance()
    for part in thing.parts:
        site.place(
            part.model,
            part.material,
            turn=turn,
            scale=part.scale,
            offset=np.array([at[0], at[1], ground - thing.sink]),
            label=thing.label,
            name=thing.name,
            instance=instance,
        )
    return instance

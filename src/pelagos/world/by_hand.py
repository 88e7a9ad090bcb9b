"""Things placed one by one, in any kind of world: primitives, mesh files and description files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Annotated, Literal, Self, TypeAlias

import numpy as np
from numpy.typing import NDArray
from pydantic import ConfigDict, Field, model_validator

from pelagos.config.described import Described
from pelagos.config.path import MeshPath
from pelagos.math.geodesy import GeoOrigin
from pelagos.world import shapes
from pelagos.world.doubt import doubts, missing_files
from pelagos.world.files import read_mesh
from pelagos.world.generate.scatter import covering
from pelagos.world.mesh import Mesh, rotation
from pelagos.world.reflector import EDGES, corner_reflector
from pelagos.world.robots.read import SUFFIXES, read_description
from pelagos.world.site import Site
from pelagos.world.world import World

_Size: TypeAlias = Annotated[float, Field(gt=0)]


class ThingConfig(Described):
    """One thing, or a row of the same."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    shape: Literal["box", "sphere", "cylinder", "cone", "plane", "corner_reflector", "file"] = "box"
    """What it is; `file` reads `path`. Cylinders and cones stand upright; a corner reflector of steel is open towards
    its own x, and sends sound back as three plates at right angles do."""
    path: MeshPath | None = None
    """Mesh (OBJ, STL, PLY, glTF) or description (URDF, SDF, MJCF), relative to the scenario."""
    part: Literal["visual", "collision"] = "visual"
    """Which shapes of a description file."""
    at_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Its middle, the tip of a corner, or the file's origin: x north, y west, z up from the mean sea surface [m]."""
    at_deg: tuple[float, float] | None = None
    """Latitude and longitude of its middle [deg], instead of x and y of `at_m`."""
    orientation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw, R = Rz Ry Rx [deg]."""
    size_m: tuple[_Size, _Size, _Size] = (1.0, 1.0, 1.0)
    """Extent along its own x, y, z [m]; of a corner reflector three times its edge; not for files."""
    scale: float = Field(default=1.0, gt=0)
    """Factor on a file's coordinates; 0.001 for millimetres."""
    up: Literal["z", "y"] = "z"
    """Which of a file's axes points up: y in glTF from most programs, and in `world.glb` of an exported world."""
    material: str = "concrete"
    """Material."""
    label: str | int = "unlabeled"
    """Semantic label by name or number."""
    name: str = ""
    """For people; its shape or file where not given."""
    smooth_deg: float | None = 35.0
    """Edges flatter than this look smooth [deg]; null for flat faces."""
    on_ground: bool = False
    """Whether z of `at_m` counts from the ground below."""
    repeat: int = Field(default=1, ge=1)
    """How many of it."""
    step_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """From one repetition to the next [m]."""

    @model_validator(mode="after")
    def _has_file(self) -> Self:
        if (self.shape == "file") != (self.path is not None):
            raise ValueError("path goes with shape: file")
        if self.shape == "corner_reflector":
            low, high = EDGES[0] / 2, EDGES[-1]
            if len(set(self.size_m)) > 1 or not low < self.size_m[0] <= high:
                raise ValueError(
                    f"size_m of a corner reflector is its edge, three times, above {low:g} and up to {high:g}"
                )
        return self


def with_things(world: World, things: Sequence[ThingConfig]) -> World:
    """A world with more things in it.

    Raises:
        WorldError: a file cannot be used.
        LookupFailed: an unknown material or label.
    """
    site = Site.reopened(world)
    for thing in things:
        add(site, thing, world.origin)
    notes = (*world.notes, *site.notes)
    return replace(world, geometries=tuple(site.geometries), materials=tuple(site.materials), notes=notes, _live={})


def footprint(thing: ThingConfig, origin: GeoOrigin) -> NDArray[np.float64]:
    """`(k, 3)` discs, x, y and radius [m], that together cover a thing, or a row of the same, in plan."""
    mesh = _mesh(thing).rotated(rotation(*np.radians(thing.orientation_deg)))
    low, high = mesh.vertices[:, :2].min(axis=0), mesh.vertices[:, :2].max(axis=0)
    discs = covering(low, high)
    first = _place(thing, origin)[:2]
    shifts = first + np.arange(thing.repeat)[:, None] * np.array(thing.step_m)[:2]
    places = (shifts[:, None, :] + discs[:, :2]).reshape(-1, 2)
    return np.column_stack([places, np.full(len(places), discs[0, 2])])


def add(site: Site, thing: ThingConfig, origin: GeoOrigin) -> None:
    """Put a thing, or a row of the same, into a world under construction.

    Raises:
        WorldError: its file cannot be used.
        LookupFailed: an unknown material or label.
    """
    mesh = _mesh(thing)
    if thing.smooth_deg is not None:
        mesh = mesh.merged()
    name = thing.name or (thing.path.name if thing.path else thing.shape)
    if thing.path is not None:
        site.notes += [*doubts(mesh, name, parts=_described(thing.path)), *missing_files(thing.path)]
    mesh = mesh.rotated(rotation(*np.radians(thing.orientation_deg)))
    first = _place(thing, origin)
    for k in range(thing.repeat):
        at = first + k * np.array(thing.step_m)
        if thing.on_ground and site.terrain is not None:
            at[2] += float(site.terrain.surface(at[0], at[1]))
        if thing.shape == "corner_reflector":
            corner = corner_reflector(thing.size_m[0]).placed(rotation(*np.radians(thing.orientation_deg)), at)
            site.add_corner(corner, label=thing.label, name=name)
        else:
            site.add(mesh.moved(at), thing.material, label=thing.label, name=name, crease_deg=thing.smooth_deg)


def _place(thing: ThingConfig, origin: GeoOrigin) -> NDArray[np.float64]:
    """`(3,)` where the first of a row stands; z may count from the ground [m]."""
    first = np.array(thing.at_m)
    if thing.at_deg is not None:
        first[:2] = [float(c) for c in origin.to_xy(*thing.at_deg)]
    return first


def _described(path: Path) -> bool:
    """Whether a file describes several shapes, which are put together."""
    return path.suffix.lower() in SUFFIXES


def _mesh(thing: ThingConfig) -> Mesh:
    if thing.path is not None:
        read = read_description(thing.path, thing.part) if _described(thing.path) else read_mesh(thing.path)
        return (read if thing.up == "z" else read.turned(roll=np.pi / 2)).scaled(thing.scale)
    if thing.shape == "corner_reflector":
        return corner_reflector(thing.size_m[0]).mesh
    unit = {
        "box": lambda: shapes.box((1, 1, 1)),
        "sphere": lambda: shapes.sphere(0.5, sides=48, rings=24),
        "cylinder": lambda: shapes.cylinder(0.5, 1.0, sides=48),
        "cone": lambda: shapes.cone(0.5, 1.0, sides=48),
        "plane": lambda: shapes.plane((1, 1)),
    }[thing.shape]()
    return unit.scaled(thing.size_m)

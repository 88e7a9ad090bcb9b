"""Worlds built by hand: primitives, mesh files and description files, placed one by one."""

from __future__ import annotations

from typing import ClassVar, Literal, Self

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, model_validator

from pelagos.config.path import ScenarioPath
from pelagos.math.geodesy import GeoOrigin
from pelagos.world import shapes
from pelagos.world.config import WorldConfig
from pelagos.world.doubt import doubts, missing_files
from pelagos.world.files import read_mesh
from pelagos.world.mesh import Mesh, rotation
from pelagos.world.robot_files import SUFFIXES, read_description
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World


class ThingConfig(BaseModel):
    """One thing, or a row of the same."""

    model_config = ConfigDict(frozen=True, extra="forbid", use_attribute_docstrings=True)

    shape: Literal["box", "sphere", "cylinder", "cone", "plane", "file"] = "box"
    """What it is; `file` reads `path`. Cylinders and cones stand upright."""
    path: ScenarioPath | None = None
    """Mesh (OBJ, STL, PLY, glTF) or description (URDF, SDF, MJCF), relative to the scenario."""
    part: Literal["visual", "collision"] = "visual"
    """Which shapes of a description file."""
    at_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Its middle, or the file's origin: x north, y west, z up from the mean sea surface [m]."""
    at_deg: tuple[float, float] | None = None
    """Latitude and longitude of its middle [deg], instead of x and y of `at_m`."""
    orientation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw, R = Rz Ry Rx [deg]."""
    size_m: tuple[float, float, float] = (1.0, 1.0, 1.0)
    """Extent along its own x, y, z [m]; not for files."""
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
        return self


class BuiltConfig(WorldConfig):
    """A flat seabed, or none, with things placed one by one."""

    TITLE: ClassVar[str] = "Built by hand: primitives, meshes (OBJ, STL, PLY, glTF), URDF, SDF and MJCF files"

    type: Literal["built"] = "built"
    """The kind of world."""
    depth_m: float | None = Field(default=20.0, gt=0)
    """Depth of a flat seabed [m]; null for no seabed."""
    size_m: tuple[float, float] = (200.0, 200.0)
    """Extent of the seabed [m]."""
    material: str = "sand"
    """Material of the seabed."""
    things: tuple[ThingConfig, ...] = ()
    """Everything that stands in it."""

    def build(self) -> World:
        """Build it.

        Raises:
            WorldError: a file cannot be used.
            LookupFailed: an unknown material or label.
        """
        site = Site(user_labels=self.labels)
        if self.depth_m is not None:
            site.ground(level(self.size_m, self.depth_m), self.material)
        origin = GeoOrigin(self.latitude_deg or 0.0, self.longitude_deg or 0.0)
        for thing in self.things:
            add(site, thing, origin)
        return site.world(name="built", description=f"{len(site.geometries)} things placed by hand", origin=origin)


def level(size: tuple[float, float], depth: float) -> HeightField:
    """A level height field about the origin."""
    spacing = min(size) / 16
    cells = [max(1, round(s / spacing)) for s in size]
    corner = -cells[0] * spacing / 2, -cells[1] * spacing / 2
    return HeightField(*corner, spacing, np.full((cells[0] + 1, cells[1] + 1), -depth))


def add(site: Site, thing: ThingConfig, origin: GeoOrigin) -> None:
    """Put a thing, or a row of the same, into a world under construction.

    Raises:
        WorldError: its file cannot be used.
        LookupFailed: an unknown material or label.
    """
    mesh = _mesh(thing)
    name = thing.name or (thing.path.name if thing.path else thing.shape)
    if thing.path is not None:
        site.notes += [*doubts(mesh, name), *missing_files(thing.path)]
    mesh = mesh.rotated(rotation(*np.radians(thing.orientation_deg)))
    first = np.array(thing.at_m)
    if thing.at_deg is not None:
        first[:2] = [float(c) for c in origin.to_xy(*thing.at_deg)]
    for k in range(thing.repeat):
        at = first + k * np.array(thing.step_m)
        if thing.on_ground and site.terrain is not None:
            at[2] += float(site.terrain.surface(at[0], at[1]))
        site.add(mesh.moved(at), thing.material, label=thing.label, name=name, crease_deg=thing.smooth_deg)


def _mesh(thing: ThingConfig) -> Mesh:
    if thing.path is not None:
        read = (
            read_description(thing.path, thing.part) if thing.path.suffix.lower() in SUFFIXES else read_mesh(thing.path)
        )
        return (read if thing.up == "z" else read.turned(roll=np.pi / 2)).scaled(thing.scale)
    unit = {
        "box": lambda: shapes.box((1, 1, 1)),
        "sphere": lambda: shapes.sphere(0.5, sides=48, rings=24),
        "cylinder": lambda: shapes.cylinder(0.5, 1.0, sides=48),
        "cone": lambda: shapes.cone(0.5, 1.0, sides=48),
        "plane": lambda: shapes.plane((1, 1)),
    }[thing.shape]()
    return unit.scaled(thing.size_m)

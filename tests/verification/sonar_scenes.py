"""Small worlds and still water for the sonar tests."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any, ClassVar

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.raycast.geometry import Geometry
from pelagos.raycast.rays import NO_BODY
from pelagos.raycast.scene import Scene
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sensor import SensorContext
from pelagos.world.material import MATERIALS, Material
from pelagos.world.shapes import box as box_mesh
from pelagos.world.shapes import sphere as sphere_mesh

DT_NS = 5_000_000
LAMBERT_DB = -27.0
PLAIN = replace(
    MATERIALS["concrete"], name="plain", lambert_db=LAMBERT_DB, density_ratio=1.0, sound_speed_ratio=1.0, loss=0.0
)
"""A pure Lambert scatterer: without contrast to the water it has no specular facets."""


@dataclass
class StillWater:
    """An ocean of one sound speed, temperature and salinity, at rest; a Dr.Jit struct."""

    speed: Any
    waves: ClassVar[Any] = None
    tide: ClassVar[Any] = None
    air: ClassVar[Any] = SimpleNamespace(blows=False)
    rain: ClassVar[float] = 0.0
    tracers: ClassVar[Mapping[str, Any]] = {}

    def sound_speed(self, position: Any, t: Any) -> Any:
        return self.speed + 0.0 * position[0]

    def temperature(self, position: Any, t: Any) -> Any:
        return 10.0 + 0.0 * position[0]

    def salinity(self, position: Any, t: Any) -> Any:
        return 35.0 + 0.0 * position[0]

    def current(self, position: Any, t: Any, copy: Any = None) -> Any:
        return jit.Array3f64(0.0 * position[0], 0.0 * position[0], 0.0 * position[0])


@dataclass
class LayeredWater:
    """Water whose sound speed grows by `slope` [1/s] upwards, 1500 m/s at `level` [m]; a Dr.Jit struct."""

    slope: Any
    level: Any
    waves: ClassVar[Any] = None
    tide: ClassVar[Any] = None
    air: ClassVar[Any] = SimpleNamespace(blows=False)
    rain: ClassVar[float] = 0.0
    tracers: ClassVar[Mapping[str, Any]] = {}

    def sound_speed(self, position: Any, t: Any) -> Any:
        return 1500.0 + self.slope * (position[2] - self.level)

    def temperature(self, position: Any, t: Any) -> Any:
        return 10.0 + 0.0 * position[0]

    def salinity(self, position: Any, t: Any) -> Any:
        return 35.0 + 0.0 * position[0]


def still_water(speed: float = 1500.0) -> StillWater:
    return StillWater(dr.opaque(jit.Float64, speed))


def context(
    geometries: list[Geometry],
    *,
    materials: tuple[Material, ...] = (PLAIN,),
    n: int = 1,
    seed: int = 0,
    path: str = "auv0.sonar",
    ocean: Any = None,
) -> Any:
    return SensorContext(
        path=path,
        seed=seed,
        dt_ns=DT_NS,
        scene=Scene(geometries, copies=n),
        world=SimpleNamespace(materials=materials, palette=materials, geometries=()),
        ocean=ocean or still_water(),
        own_body=np.full(n, NO_BODY, np.uint32),
    )


def plane(
    z: float = -10.0, size: float = 600.0, *, material: int = 0, slope: float = 0.0, instance: int = 1
) -> Geometry:
    """A plane z + slope x, facing up."""
    corners = np.array([[x, y, z + slope * x] for x, y in ((-size, -size), (size, -size), (size, size), (-size, size))])
    return Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], np.uint32), material, 1, instance)


def box(centre: tuple[float, float, float], size: tuple[float, float, float], *, material: int = 0) -> Geometry:
    mesh = box_mesh(size)
    return Geometry(np.asarray(mesh.vertices) + np.array(centre), mesh.faces, material, 2, 2)


def sphere(centre: tuple[float, float, float], radius: float, *, material: int = 0, inside: bool = False) -> Geometry:
    mesh = sphere_mesh(radius, sides=192, rings=96)
    faces = np.ascontiguousarray(mesh.faces[:, ::-1]) if inside else mesh.faces
    unit = np.asarray(mesh.vertices) / radius
    normals = (-unit if inside else unit).astype(np.float32)
    return Geometry(np.asarray(mesh.vertices) + np.array(centre), faces, material, 3, 3, vertex_normals=normals)


def at(*position: float, tick: int = 0, **motion: Any) -> Any:
    """Kinematics of one lane."""
    return lanes([tick], dt_ns=DT_NS, position=position, **motion)

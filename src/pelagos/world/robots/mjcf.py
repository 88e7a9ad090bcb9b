"""Shapes out of MJCF, as MuJoCo's compiler reads it: defaults by class, includes, frames, every way to write a turn.

Source: MuJoCo documentation, "XML reference" and "Modeling".
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as Xml
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from pelagos.errors import WorldError
from pelagos.world import shapes
from pelagos.world.files import read_mesh
from pelagos.world.mesh import Mesh
from pelagos.world.robots.pose import (
    Pose,
    compose,
    from_axis,
    from_columns,
    from_euler,
    from_quaternion,
    identity,
    numbers,
    to_axis,
)
from pelagos.world.robots.shape import rod

_SHOWN: Final = 2  # geoms of higher groups are not shown by MuJoCo's viewer: collision shapes, by convention
_Attributes = dict[str, str]


def read_mjcf(root: Xml.Element, folder: Path, which: str) -> Iterator[tuple[Mesh, Pose]]:
    """The shapes of a `<mujoco>`: "visual" those of groups 0 .. 2, "collision" those that touch anything.

    Where nothing is in the groups 0 .. 2, all shapes are visual.
    """
    _include(root, folder, 0)
    file = _File.of(root, folder)
    geoms = [g for world in root.findall("worldbody") for g in file.walk(world, identity(), "main")]
    if which == "collision":
        kept = [g for g in geoms if (g[0].get("contype"), g[0].get("conaffinity")) != ("0", "0")]
    else:
        kept = [g for g in geoms if int(g[0].get("group", "0")) <= _SHOWN] or geoms
    for attributes, pose in kept:
        mesh, own = file.shape(attributes)
        if mesh is not None:
            yield mesh, compose(pose, own)


@dataclass(frozen=True)
class _File:
    """References that the parts of a file share.

    Attributes:
        defaults: attributes by class and kind of element, those of outer classes included.
        assets: mesh assets by name.
        meshes: folder of mesh files.
        angle: radians in a unit of angles.
        order: of Euler angles.
    """

    defaults: dict[str, dict[str, _Attributes]]
    assets: dict[str, _Attributes]
    meshes: Path
    angle: float
    order: str

    @classmethod
    def of(cls, root: Xml.Element, folder: Path) -> _File:
        said: _Attributes = {}
        for compiler in root.findall("compiler"):
            said |= compiler.attrib
        defaults: dict[str, dict[str, _Attributes]] = {"main": {}}
        for top in root.findall("default"):
            _collect(top, top.get("class", "main"), {}, defaults)
        assets: dict[str, _Attributes] = {}
        for mesh in root.iterfind("asset/mesh"):
            found = {**defaults.get(mesh.get("class", "main"), {}).get("mesh", {}), **mesh.attrib}
            assets[found.get("name") or Path(found.get("file", "")).stem] = found
        return cls(
            defaults=defaults,
            assets=assets,
            meshes=folder / (said.get("meshdir") or said.get("assetdir") or ""),
            angle=1.0 if said.get("angle") == "radian" else math.pi / 180,
            order=said.get("eulerseq", "xyz"),
        )

    def walk(self, body: Xml.Element, pose: Pose, inherited: str) -> Iterator[tuple[_Attributes, Pose]]:
        """Every geom under a body with all its attributes, and the pose that its own counts from."""
        for child in body:
            if child.tag == "geom":
                yield self._full(child, inherited), pose
            elif child.tag in ("body", "frame"):
                inner = child.get("childclass", inherited)
                yield from self.walk(child, compose(pose, self._pose(dict(child.attrib))), inner)

    def shape(self, geom: _Attributes) -> tuple[Mesh | None, Pose]:
        """The mesh of a geom, None for kinds without one, and its own pose."""
        kind = geom.get("type", "mesh" if "mesh" in geom and "type" not in geom else "sphere")
        size = numbers(geom.get("size", "0.1"))
        pose = self._pose(geom)
        if "fromto" in geom and kind in ("box", "ellipsoid", "cylinder", "capsule"):
            ends = numbers(geom["fromto"], 6).reshape(2, 3)
            half = float(np.linalg.norm(ends[1] - ends[0])) / 2
            pose = to_axis(ends[0] - ends[1]), ends.mean(axis=0)
            size = np.array([size[0], half] if kind in ("cylinder", "capsule") else [size[0], size[0], half])
        if kind == "mesh":
            return self._mesh(geom), pose
        if kind == "box":
            return shapes.box(2 * size[:3]), pose
        if kind == "sphere":
            return shapes.sphere(float(size[0])), pose
        if kind == "ellipsoid":
            return shapes.sphere(1.0).scaled(size[:3]), pose
        if kind == "plane":
            return shapes.plane((2 * float(size[0] or 50.0), 2 * float(size[1] or 50.0))), pose
        if kind in ("cylinder", "capsule"):
            half = float(size[1]) if len(size) > 1 else 0.0
            return rod(float(size[0]), 2 * half, round_ends=kind == "capsule"), pose
        return None, pose  # height fields have no file shape of their own

    def _mesh(self, geom: _Attributes) -> Mesh:
        asset = self.assets.get(geom.get("mesh", ""))
        if asset is None or "file" not in asset:
            raise WorldError(f"a geom names the mesh {geom.get('mesh')!r}, which no <asset> has a file for")
        mesh = read_mesh(self.meshes / asset["file"])
        if "refpos" in asset or "refquat" in asset:
            turn = from_quaternion(*numbers(asset.get("refquat", "1 0 0 0"), 4))
            mesh = mesh.moved(-numbers(asset.get("refpos", "0 0 0"), 3)).rotated(turn.T)
        return mesh.scaled(numbers(asset.get("scale", "1 1 1"), 3))

    def _full(self, element: Xml.Element, inherited: str) -> _Attributes:
        own = element.get("class", inherited)
        return {**self.defaults.get(own, {}).get(element.tag, {}), **element.attrib}

    def _pose(self, said: _Attributes) -> Pose:
        place = numbers(said.get("pos", "0 0 0"), 3)
        if "quat" in said:
            return from_quaternion(*numbers(said["quat"], 4)), place
        if "axisangle" in said:
            values = numbers(said["axisangle"], 4)
            return from_axis(values[:3], self.angle * float(values[3])), place
        if "euler" in said:
            return from_euler(self.angle * numbers(said["euler"], 3), self.order), place
        if "xyaxes" in said:
            axes = numbers(said["xyaxes"], 6)
            return from_columns(axes[:3], axes[3:]), place
        if "zaxis" in said:
            return to_axis(numbers(said["zaxis"], 3)), place
        return np.eye(3), place


def _collect(
    element: Xml.Element, name: str, outer: dict[str, _Attributes], found: dict[str, dict[str, _Attributes]]
) -> None:
    """Defaults of a class and of those inside it: each begins with what the one around it has."""
    mine = {tag: dict(values) for tag, values in outer.items()}
    for child in element:
        if child.tag != "default":
            mine[child.tag] = {**mine.get(child.tag, {}), **child.attrib}
    found[name] = mine
    for child in element.findall("default"):
        _collect(child, child.get("class", ""), mine, found)


def _include(element: Xml.Element, folder: Path, depth: int) -> None:
    """Put the contents of files that are included in place of the elements that name them."""
    for child in list(element):
        if child.tag != "include":
            _include(child, folder, depth)
            continue
        path = folder / child.get("file", "")
        if not path.is_file() or depth > 8:
            raise WorldError(f"the file {child.get('file')!r} that is included was not found in {folder}")
        other = Xml.parse(path).getroot()
        _include(other, folder, depth + 1)
        at = list(element).index(child)
        element.remove(child)
        for k, part in enumerate(other):
            element.insert(at + k, part)

"""Shapes out of robot and scene descriptions: URDF, SDF and MJCF, each link in the pose that the file gives it.

Joints stay at zero, and what moves in the file stands still in a world. Only geometry is read: no masses, no motors.
"""

from __future__ import annotations

import math
import xml.etree.ElementTree as Xml
from collections.abc import Iterator
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.world import shapes
from pelagos.world.files import read_mesh
from pelagos.world.mesh import Mesh, join, rotation

SUFFIXES: Final = (".urdf", ".sdf", ".world", ".xml", ".mjcf")
"""Endings of description files."""

_Pose = tuple[NDArray[np.float64], NDArray[np.float64]]  # rotation (3, 3) and place (3,) in the file's frame


def read_description(path: Path, which: str = "visual") -> Mesh:
    """All shapes of a description file as one mesh, in the file's frame.

    Args:
        path: URDF, SDF or MJCF.
        which: "visual" or "collision".

    Raises:
        WorldError: missing, not XML, of an unknown kind, without shapes, or with a mesh that cannot be found.
    """
    if not path.is_file():
        raise WorldError(f"description file {path} does not exist")
    try:
        root = Xml.parse(path).getroot()
    except Xml.ParseError as error:
        raise WorldError(f"description file {path} is not XML: {error}") from error
    readers = {"robot": _urdf, "sdf": _sdf, "mujoco": _mjcf}
    if root.tag not in readers:
        raise WorldError(f"description file {path} begins with <{root.tag}>; known: <robot> (URDF), <sdf>, <mujoco>")
    try:
        found = [mesh.rotated(turn).moved(place) for mesh, (turn, place) in readers[root.tag](root, path.parent, which)]
    except (ValueError, KeyError, TypeError) as error:
        raise WorldError(f"description file {path}: a number or an attribute is missing or wrong ({error})") from error
    if not found:
        raise WorldError(f"description file {path} holds no {which} shapes that are read")
    return join(found)


def _urdf(root: Xml.Element, folder: Path, which: str) -> Iterator[tuple[Mesh, _Pose]]:
    links = {link.get("name", ""): link for link in root.findall("link")}
    parents: dict[str, tuple[str, _Pose]] = {}
    for joint in root.findall("joint"):
        child, parent = joint.find("child"), joint.find("parent")
        if child is not None and parent is not None:
            parents[child.get("link", "")] = (parent.get("link", ""), _origin(joint.find("origin")))
    for name, link in links.items():
        pose = _identity()
        at = name
        for _ in range(len(links)):
            if at not in parents:
                break
            at, step = parents[at]
            pose = _compose(step, pose)
        for element in link.findall(which):
            geometry = element.find("geometry")
            mesh = _tagged(geometry[0], folder) if geometry is not None and len(geometry) else None
            if mesh is not None:
                yield mesh, _compose(pose, _origin(element.find("origin")))


def _sdf(root: Xml.Element, folder: Path, which: str) -> Iterator[tuple[Mesh, _Pose]]:
    for model in root.iter("model"):
        for link in model.findall("link"):
            for element in link.findall(which):
                geometry = element.find("geometry")
                mesh = _tagged(geometry[0], folder) if geometry is not None and len(geometry) else None
                if mesh is not None:
                    yield mesh, _compose(_compose(_sdf_pose(model), _sdf_pose(link)), _sdf_pose(element))


def _mjcf(root: Xml.Element, folder: Path, which: str) -> Iterator[tuple[Mesh, _Pose]]:
    compiler = root.find("compiler")
    degrees = compiler is None or compiler.get("angle", "degree") == "degree"
    meshes = folder / (compiler.get("meshdir", "") if compiler is not None else "")
    assets = {a.get("name") or Path(a.get("file", "")).stem: a for a in root.iter("mesh")}

    def walk(body: Xml.Element, pose: _Pose) -> Iterator[tuple[Mesh, _Pose]]:
        for geom in body.findall("geom"):
            if which == "collision" and geom.get("contype") == "0" and geom.get("conaffinity") == "0":
                continue
            mesh = _mjcf_geom(geom, assets, meshes)
            if mesh is not None:
                yield mesh, _compose(pose, _mjcf_pose(geom, degrees))
        for child in body.findall("body"):
            yield from walk(child, _compose(pose, _mjcf_pose(child, degrees)))

    for world in root.findall("worldbody"):
        yield from walk(world, _identity())


def _mjcf_geom(geom: Xml.Element, assets: dict[str, Xml.Element], folder: Path) -> Mesh | None:
    kind = geom.get("type", "sphere")
    size = _numbers(geom.get("size", "0.1"))
    if kind == "mesh":
        asset = assets[geom.get("mesh", "")]
        return read_mesh(folder / asset.get("file", "")).scaled(_numbers(asset.get("scale", "1 1 1")))
    if kind == "box":
        return shapes.box(2 * size)
    if kind == "sphere":
        return shapes.sphere(float(size[0]))
    if kind == "ellipsoid":
        return shapes.sphere(1.0).scaled(size)
    if kind == "plane":
        return shapes.plane((2 * float(size[0] or 50.0), 2 * float(size[1] or 50.0)))
    if kind in ("cylinder", "capsule"):
        if geom.get("fromto"):
            ends = _numbers(geom.get("fromto", "")).reshape(2, 3)
            return shapes.beam(ends[0], ends[1], float(size[0]), sides=24)
        return _capsule(float(size[0]), 2 * float(size[1]), round_ends=kind == "capsule")
    return None  # height fields and sites have no file shape of their own


def _tagged(element: Xml.Element, folder: Path) -> Mesh | None:
    """A URDF or SDF geometry: attributes in the one, child elements in the other."""

    def value(name: str, default: str | None = None) -> str:
        child = element.find(name)
        found = element.get(name) or (child.text if child is not None else None) or default
        if found is None:
            raise KeyError(f"{element.tag} has no {name}")
        return found

    if element.tag == "box":
        return shapes.box(_numbers(value("size")))
    if element.tag == "sphere":
        return shapes.sphere(float(value("radius")))
    if element.tag in ("cylinder", "capsule"):
        return _capsule(float(value("radius")), float(value("length")), round_ends=element.tag == "capsule")
    if element.tag == "plane":
        size = _numbers(value("size", "100 100"))
        return shapes.plane((float(size[0]), float(size[1])))
    if element.tag == "mesh":
        name = element.get("filename") or value("uri")
        plain = name.split("://", 1)[-1]
        for candidate in (folder / plain, folder / Path(plain).name, folder.parent / plain.split("/", 1)[-1]):
            if candidate.is_file():
                return read_mesh(candidate).scaled(_numbers(value("scale", "1 1 1")))
        raise WorldError(f"the mesh {name!r} was not found beside the description file in {folder}")
    return None


def _capsule(radius: float, length: float, *, round_ends: bool) -> Mesh:
    if not round_ends:
        return shapes.cylinder(radius, length)
    arc = np.linspace(0, math.pi / 2, 7)[1:]
    cap = np.stack([radius * np.sin(arc), length / 2 + radius * np.cos(arc)], axis=1)[::-1]
    lower = (cap * [1, -1])[::-1]
    return shapes.revolve(np.concatenate([[[0, -length / 2 - radius]], lower, cap, [[0, length / 2 + radius]]]))


def _identity() -> _Pose:
    return np.eye(3), np.zeros(3)


def _compose(a: _Pose, b: _Pose) -> _Pose:
    return a[0] @ b[0], a[0] @ b[1] + a[1]


def _origin(element: Xml.Element | None) -> _Pose:
    if element is None:
        return _identity()
    roll, pitch, yaw = _numbers(element.get("rpy", "0 0 0"))
    return rotation(roll, pitch, yaw), _numbers(element.get("xyz", "0 0 0"))


def _sdf_pose(element: Xml.Element) -> _Pose:
    pose = element.find("pose")
    values = _numbers(pose.text or "") if pose is not None else np.zeros(6)
    return rotation(*values[3:6]), values[:3]


def _mjcf_pose(element: Xml.Element, degrees: bool) -> _Pose:
    place = _numbers(element.get("pos", "0 0 0"))
    if element.get("quat"):
        w, x, y, z = _numbers(element.get("quat", "")) / np.linalg.norm(_numbers(element.get("quat", "")))
        turn = np.array([
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ])  # fmt: skip
        return turn, place
    roll, pitch, yaw = _numbers(element.get("euler", "0 0 0")) * (math.pi / 180 if degrees else 1.0)
    # MuJoCo's default order is x, y, z about the turned axes
    return rotation(roll, 0, 0) @ rotation(0, pitch, 0) @ rotation(0, 0, yaw), place


def _numbers(text: str) -> NDArray[np.float64]:
    return np.array([float(v) for v in text.split()], dtype=np.float64)

"""Shapes out of SDF: models and worlds, nested models, and models of other files that are included."""

from __future__ import annotations

import xml.etree.ElementTree as Xml
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pelagos.errors import WorldError
from pelagos.world.mesh import Mesh, rotation
from pelagos.world.robots.pose import Pose, compose, from_quaternion, identity, numbers
from pelagos.world.robots.shape import is_below, tagged

_DEEPEST = 8  # files that include files


def read_sdf(root: Xml.Element, folder: Path, which: str, *, depth: int = 0) -> Iterator[tuple[Mesh, Pose]]:
    """The "visual" or "collision" shapes of an `<sdf>`."""
    for group in [root, *root.findall("world")]:
        yield from _models(group, identity(), folder, which, depth)


def _models(group: Xml.Element, pose: Pose, folder: Path, which: str, depth: int) -> Iterator[tuple[Mesh, Pose]]:
    for model in group.findall("model"):
        here = compose(pose, _pose(model))
        for link in model.findall("link"):
            for element in link.findall(which):
                geometry = element.find("geometry")
                mesh = tagged(geometry[0], folder) if geometry is not None and len(geometry) else None
                if mesh is not None:
                    yield mesh, compose(compose(here, _pose(link)), _pose(element))
        yield from _models(model, here, folder, which, depth)
    for include in group.findall("include"):
        yield from _included(include, pose, folder, which, depth)


def _included(include: Xml.Element, pose: Pose, folder: Path, which: str, depth: int) -> Iterator[tuple[Mesh, Pose]]:
    uri = (include.findtext("uri") or "").strip()
    name = uri.split("://", 1)[-1]
    places = [parent / name / "model.sdf" for parent in (folder, *folder.parents[:3])] + [folder / name]
    path = next((p for p in places if p.is_file()), None) if is_below(name.removeprefix("../")) else None
    if path is None or depth >= _DEEPEST:
        raise WorldError(f"the model {uri!r} that is included was not found about the description file in {folder}")
    other = Xml.parse(path).getroot()
    where = compose(pose, _pose(include)) if include.find("pose") is not None else pose
    for mesh, step in read_sdf(other, path.parent, which, depth=depth + 1):
        yield mesh, compose(where, step)


def _pose(element: Xml.Element) -> Pose:
    """Place, and roll, pitch, yaw [rad, or deg where it says so] or a quaternion."""
    pose = element.find("pose")
    if pose is None or not (pose.text or "").strip():
        return identity()
    if pose.get("rotation_format") == "quat_xyzw":
        values = numbers(pose.text or "", 7)
        x, y, z, w = values[3:]
        return from_quaternion(w, x, y, z), values[:3]
    values = numbers(pose.text or "", 6)
    angles = np.radians(values[3:]) if pose.get("degrees") in ("true", "1") else values[3:]
    return rotation(*angles), values[:3]

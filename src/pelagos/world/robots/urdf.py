"""Shapes out of URDF: every link where its joints, all at zero, put it."""

from __future__ import annotations

import xml.etree.ElementTree as Xml
from collections.abc import Iterator
from pathlib import Path

from pelagos.errors import WorldError
from pelagos.world.mesh import Mesh, rotation
from pelagos.world.robots.pose import Pose, compose, identity, numbers
from pelagos.world.robots.shape import tagged


def read_urdf(root: Xml.Element, folder: Path, which: str) -> Iterator[tuple[Mesh, Pose]]:
    """The "visual" or "collision" shapes of a `<robot>`."""
    text = Xml.tostring(root, encoding="unicode")
    if "${" in text or "$(" in text or "ros.org/wiki/xacro" in text:
        raise WorldError(f"a description in {folder} is written in xacro; expand it first: xacro IN.xacro > OUT.urdf")
    links = {link.get("name", ""): link for link in root.findall("link")}
    parents: dict[str, tuple[str, Pose]] = {}
    for joint in root.findall("joint"):
        child, parent = joint.find("child"), joint.find("parent")
        if child is not None and parent is not None:
            parents[child.get("link", "")] = (parent.get("link", ""), _origin(joint.find("origin")))
    for name, link in links.items():
        pose = identity()
        at = name
        for _ in range(len(links)):
            if at not in parents:
                break
            at, step = parents[at]
            pose = compose(step, pose)
        for element in link.findall(which):
            geometry = element.find("geometry")
            mesh = tagged(geometry[0], folder) if geometry is not None and len(geometry) else None
            if mesh is not None:
                yield mesh, compose(pose, _origin(element.find("origin")))


def _origin(element: Xml.Element | None) -> Pose:
    if element is None:
        return identity()
    roll, pitch, yaw = numbers(element.get("rpy", "0 0 0"), 3)
    return rotation(roll, pitch, yaw), numbers(element.get("xyz", "0 0 0"), 3)

"""The shapes that description files name."""

from __future__ import annotations

import math
import xml.etree.ElementTree as Xml
from pathlib import Path, PurePosixPath

import numpy as np

from pelagos.errors import WorldError
from pelagos.world import shapes
from pelagos.world.files import read_mesh
from pelagos.world.mesh import Mesh
from pelagos.world.robots.pose import numbers


def tagged(element: Xml.Element, folder: Path) -> Mesh | None:
    """A URDF or SDF geometry: attributes in the one, child elements in the other; None where it is of no kind we know.

    Raises:
        WorldError: a mesh that cannot be found or read.
        ValueError, KeyError: a number or an attribute is missing or wrong.
    """

    def value(name: str, default: str | None = None) -> str:
        child = element.find(name)
        found = element.get(name) or (child.text if child is not None else None) or default
        if found is None:
            raise KeyError(f"{element.tag} has no {name}")
        return found

    if element.tag == "box":
        return shapes.box(numbers(value("size"), 3))
    if element.tag == "sphere":
        return shapes.sphere(float(value("radius")))
    if element.tag == "ellipsoid":
        return shapes.sphere(1.0).scaled(numbers(value("radii"), 3))
    if element.tag == "cone":
        return shapes.cone(float(value("radius")), float(value("length")))
    if element.tag in ("cylinder", "capsule"):
        return rod(float(value("radius")), float(value("length")), round_ends=element.tag == "capsule")
    if element.tag == "plane":
        size = numbers(value("size", "100 100"))
        return shapes.plane((float(size[0]), float(size[1])))
    if element.tag == "mesh":
        name = element.get("filename") or value("uri")
        return read_mesh(_found(name, folder)).scaled(numbers(value("scale", "1 1 1"), 3))
    return None


def is_below(name: str) -> bool:
    """Whether a relative name stays below the folder that it starts from."""
    parts = PurePosixPath(name.replace("\\", "/"))
    return not parts.is_absolute() and ".." not in parts.parts and ":" not in name


def rod(radius: float, length: float, *, round_ends: bool) -> Mesh:
    """A cylinder, or a capsule whose straight part has this length."""
    if not round_ends:
        return shapes.cylinder(radius, length)
    arc = np.linspace(0, math.pi / 2, 7)[1:]
    cap = np.stack([radius * np.sin(arc), length / 2 + radius * np.cos(arc)], axis=1)[::-1]
    lower = (cap * [1, -1])[::-1]
    return shapes.revolve(np.concatenate([[[0, -length / 2 - radius]], lower, cap, [[0, length / 2 + radius]]]))


def _found(name: str, folder: Path) -> Path:
    """A mesh file: where it says, beside the description, or in the package that the folder is a part of."""
    plain = name.split("://", 1)[-1]
    inside = plain.split("/", 1)[-1]
    above = [parent / part for parent in folder.parents[:3] for part in (plain, inside) if is_below(part)]
    beside = [folder / part for part in (plain, inside, Path(plain).name) if is_below(part.removeprefix("../"))]
    for candidate in (*beside, *above):
        if candidate.is_file():
            return candidate
    if not is_below(plain.removeprefix("../")):
        raise WorldError(f"the mesh {name!r} lies outside of the package of the description file in {folder}; copy it")
    raise WorldError(f"the mesh {name!r} was not found beside the description file in {folder}")

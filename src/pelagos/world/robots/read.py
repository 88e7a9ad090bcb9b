"""Shapes out of robot and scene descriptions: URDF, SDF and MJCF, each link in the pose that the file gives it.

Joints stay at zero, and what moves in the file stands still in a world. Only geometry is read: no masses, no motors.
"""

from __future__ import annotations

import xml.etree.ElementTree as Xml
from pathlib import Path
from typing import Final

from pelagos.errors import WorldError
from pelagos.world.mesh import Mesh, join
from pelagos.world.robots.mjcf import read_mjcf
from pelagos.world.robots.sdf import read_sdf
from pelagos.world.robots.urdf import read_urdf
from pelagos.world.size import refuse_large

SUFFIXES: Final = (".urdf", ".sdf", ".world", ".xml", ".mjcf")
"""Endings of description files."""


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
    refuse_large(path, "description file")
    try:
        root = Xml.parse(path).getroot()
    except Xml.ParseError as error:
        raise WorldError(f"description file {path} is not XML: {error}") from error
    readers = {"robot": read_urdf, "sdf": read_sdf, "mujoco": read_mjcf}
    if root.tag not in readers:
        raise WorldError(f"description file {path} begins with <{root.tag}>; known: <robot> (URDF), <sdf>, <mujoco>")
    try:
        found = [mesh.rotated(turn).moved(place) for mesh, (turn, place) in readers[root.tag](root, path.parent, which)]
    except RecursionError:
        raise WorldError(f"description file {path} is nested too deeply") from None
    except (ValueError, KeyError, TypeError, IndexError, OSError, Xml.ParseError) as error:
        raise WorldError(f"description file {path}: a number or an attribute is missing or wrong ({error})") from error
    if not found:
        raise WorldError(f"description file {path} holds no {which} shapes that are read")
    return join(found)

"""Trihedral corner reflectors: three square plates' halves at right angles, which send sound back where it came from.

A ray sees one plate of the three; what all three do together stands in the plate's material: it scatters by the angle
from the corner's axis, which its vertex normals carry (`acoustics/target_strength.py: corner_lobe`), and by as much a
square metre that the inner faces have the corner's cross section together.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError
from pelagos.raycast.geometry import Geometry
from pelagos.world.material import MATERIALS, Material
from pelagos.world.mesh import Mesh

EDGES: Final = tuple(2.0**k for k in range(-4, 3))
"""Edges [m] of the corners that materials are made for; those in between cover part of their plates with the next."""

CORNERS: Final[dict[str, Material]] = {
    f"corner_{edge:g}": replace(MATERIALS["steel"], name=f"corner_{edge:g}", corner_m=edge) for edge in EDGES
}
"""Materials of the inner faces, by name; for `corner_reflector` only."""

_PLATE: Final = "steel"
_BACK: Final = 0.05  # of the edge, by which the outer side's tip lies behind the corner


@dataclass(frozen=True)
class Reflector:
    """A corner in its own frame: its tip at the origin, open towards +x.

    Attributes:
        mesh: its closed surface [m].
        normals: `(v, 3)`, of the inner faces the corner's axis.
        materials: `(f,)` names.
    """

    mesh: Mesh
    normals: NDArray[np.float32]
    materials: tuple[str, ...]

    def geometry(self, row: Callable[[str], int], *, label: int, instance: int, name: str) -> Geometry:
        """With a meaning; `row` numbers materials."""
        rows = np.array([row(m) for m in self.materials], dtype=np.uint32)
        return Geometry(self.mesh.vertices, self.mesh.faces, rows, label, instance, self.normals, name)

    def placed(self, turn: NDArray[np.float64], offset: NDArray[np.float64]) -> Reflector:
        """Turned by a matrix `(3, 3)`, then shifted by `offset` `(3,)` [m]."""
        moved = Mesh(self.mesh.vertices @ turn.T + offset, self.mesh.faces)
        return replace(self, mesh=moved, normals=(self.normals @ turn.T).astype(np.float32))


def corner_reflector(edge: float) -> Reflector:
    """A corner whose plates are right-angled triangles with legs of the length `edge` [m].

    Raises:
        CommandError: the edge lies outside of what materials are made for.
    """
    if not EDGES[0] / 2 < edge <= EDGES[-1]:
        allowed = f"more than {EDGES[0] / 2:g} m and at most {EDGES[-1]:g} m"
        raise CommandError(f"the edge of a corner reflector is {allowed}, not {edge:g} m")
    size = min(e for e in EDGES if e >= edge)
    covered = edge * edge / size  # legs of the part of each plate that has the whole corner's cross section
    turns = [math.pi / 2 + 2 * math.pi * k / 3 for k in range(3)]
    legs = [np.array([1.0, math.sqrt(2) * math.cos(a), math.sqrt(2) * math.sin(a)]) / math.sqrt(3) for a in turns]
    axis, tip, back = np.array([1.0, 0, 0]), np.zeros(3), np.array([-_BACK * edge, 0, 0])
    corners: list[NDArray[np.float64]] = []
    normals: list[NDArray[np.float64]] = []
    materials: list[str] = []

    def face(points: list[NDArray[np.float64]], material: str, normal: NDArray[np.float64] | None = None) -> None:
        flat = np.cross(points[1] - points[0], points[2] - points[0])
        corners.extend(points)
        normals.extend([flat / np.linalg.norm(flat) if normal is None else normal] * 3)
        materials.append(material)

    for k in range(3):
        a, b = legs[k], legs[(k + 1) % 3]  # a x b is the third leg: seen from inside they run counter-clockwise
        face([tip, covered * a, covered * b], f"corner_{size:g}", axis)
        if covered < edge * (1.0 - 1e-9):
            face([covered * a, edge * a, edge * b], _PLATE)
            face([covered * a, edge * b, covered * b], _PLATE)
        face([back, edge * b, edge * a], _PLATE)
    mesh = Mesh(np.array(corners), np.arange(len(corners), dtype=np.uint32).reshape(-1, 3))
    return Reflector(mesh, np.array(normals, dtype=np.float32), tuple(materials))

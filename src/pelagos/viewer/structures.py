"""Structures of a world in a few meshes: one for each colour, the largest things first."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.drawing.colours import display
from pelagos.raycast.geometry import Geometry
from pelagos.world.world import World

MOST_FACES: Final = 400_000
"""Of all structures together; what does not fit is left out, the smallest things first, and is said."""

_WIDE: Final = 0.98
_LOOKS: Final = 2000  # vertices of a geometry that are compared with the height field
_OFF_M: Final = 0.2


@dataclass(frozen=True)
class Part:
    """Triangles of one colour: vertices `(v, 3)` world NWU [m], faces `(f, 3)`, sRGB 0 .. 255."""

    name: str
    vertices: NDArray[np.float32]
    faces: NDArray[np.uint32]
    colour: tuple[int, int, int]


def ground_of(world: World) -> Geometry | None:
    """The geometry that is the world's height field."""
    if world.ground is not None:
        return next((g for g in world.geometries if g.instance == world.ground.instance), None)
    if world.terrain is None:
        return None
    return next((g for g in world.geometries if _lies_on(g, world.terrain)), None)


def _lies_on(g: Geometry, terrain: Any) -> bool:
    """Whether a geometry is the height field's own surface, finer in places: as wide, and nowhere off it."""
    low, high = (np.array([v[end] for v in (terrain.x, terrain.y)]) for end in (0, -1))
    if not len(g.faces) or (np.ptp(g.extent[:, :2], axis=0) < _WIDE * (high - low)).any():
        return False
    some = np.asarray(g.vertices)[:: max(len(g.vertices) // _LOOKS, 1)]
    off = np.abs(some[:, 2] - terrain.height(some[:, 0], some[:, 1]))
    return bool(np.nanmean(off < _OFF_M) > _WIDE)


def parts_of(world: World) -> tuple[list[Part], int]:
    """Parts of everything but the ground, and how many things are left out."""
    ground = ground_of(world)
    things = [g for g in world.still if g is not ground and len(g.faces)]
    things.sort(key=lambda g: -float(np.ptp(g.extent, axis=0).max()))
    shown, faces = [], 0
    for g in things:
        if faces + len(g.faces) <= MOST_FACES:
            shown.append(g)
            faces += len(g.faces)
    return parts(shown, world.palette), len(things) - len(shown)


def parts(things: Sequence[Geometry], palette: Sequence[Any]) -> list[Part]:
    """One part for each material that is met."""
    by_row: dict[int, list[tuple[NDArray[np.floating], NDArray[np.uint32]]]] = {}
    for g in things:
        rows, vertices = g.face_materials, g.vertices
        for row in np.unique(rows):
            by_row.setdefault(int(row), []).append((vertices, g.faces[rows == row]))
    made = []
    for row, pieces in sorted(by_row.items()):
        vertices, faces = _joined(pieces)
        red, green, blue = (round(255 * float(c)) for c in display(palette[row].albedo))
        made.append(Part(palette[row].name, vertices, faces, (red, green, blue)))
    return made


def _joined(
    pieces: Sequence[tuple[NDArray[np.floating], NDArray[np.uint32]]],
) -> tuple[NDArray[np.float32], NDArray[np.uint32]]:
    all_vertices, all_faces, start = [], [], 0
    for vertices, faces in pieces:
        used, places = np.unique(faces, return_inverse=True)
        all_vertices.append(np.asarray(vertices)[used].astype(np.float32))
        all_faces.append(places.reshape(-1, 3).astype(np.uint32) + np.uint32(start))
        start += len(used)
    return np.concatenate(all_vertices), np.concatenate(all_faces)

"""A hull of your own that floats: a closed mesh, moved up or down until its wet part displaces the weight."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import ScenarioError, WorldError
from pelagos.world.files import read_mesh

Points = NDArray[np.float64]
_MOST: Final = 5000  # triangles: their pressure is summed in every step


@dataclass(frozen=True)
class FloatingMesh:
    """vertices `(v, 3)` FRD about the origin at the waterline [m]; faces `(f, 3)`, outwards; center of the wet part
    `(3,)` [m].
    """

    vertices: Points
    faces: NDArray[np.int64]
    center: Points


def float_mesh(path: Path, volume: float) -> FloatingMesh:
    """A mesh file, forward-left-up [m], at the height at which it displaces `volume` [m^3].

    Raises:
        ScenarioError: the file cannot be read, is not closed, has too many triangles, or sinks.
    """
    where = "afloat.mesh"
    try:
        mesh = read_mesh(path)
    except WorldError as error:
        raise ScenarioError(str(error), where=where) from error
    import trimesh

    solid = trimesh.Trimesh(mesh.vertices, mesh.faces)  # merges corners
    if not solid.is_watertight:
        raise ScenarioError(f"{path} is not closed: pressure needs every edge between two triangles", where=where)
    if len(solid.faces) > _MOST:
        text = f"{path} has {len(solid.faces)} triangles, more than {_MOST}; simplify it, the waves are longer"
        raise ScenarioError(text, where=where)
    solid.fix_normals()
    vertices, faces = np.asarray(solid.vertices, dtype=np.float64), np.asarray(solid.faces, dtype=np.int64)
    low, high = float(vertices[:, 2].min()), float(vertices[:, 2].max())
    whole = wet_part(vertices, faces, high)[0]
    if whole <= volume:
        text = f"{path} sinks: it holds {whole:.4g} m^3, and the weight needs {volume:.4g} m^3 of water"
        raise ScenarioError(text, where=where)
    for _ in range(60):
        level = 0.5 * (low + high)
        low, high = (low, level) if wet_part(vertices, faces, level)[0] > volume else (level, high)
    center = wet_part(vertices, faces, level)[1] - [0.0, 0.0, level]
    flip = np.array([1.0, -1.0, -1.0])
    return FloatingMesh((vertices - [0.0, 0.0, level]) * flip, faces, center * flip)


def wet_part(vertices: Points, faces: NDArray[np.int64], level: float) -> tuple[float, Points]:
    """Volume [m^3] and centre `(3,)` of what a closed mesh, z up, has below z = `level`.

    Sums tetrahedra over the triangles as they are cut by the plane; with their tips in it, the cut itself adds nothing.
    """
    tip = np.array([0.0, 0.0, level])
    corners = vertices[faces] - tip
    wet = corners[..., 2] < 0
    whole = list(corners[wet.all(axis=1)])
    for triangle, below in zip(corners[wet.any(axis=1) & ~wet.all(axis=1)], wet[wet.any(axis=1) & ~wet.all(axis=1)],
                               strict=True):  # fmt: skip
        polygon = []
        for k in range(3):
            a, b = triangle[k], triangle[(k + 1) % 3]
            if below[k]:
                polygon.append(a)
            if below[k] != below[(k + 1) % 3]:
                polygon.append(a + (b - a) * (a[2] / (a[2] - b[2])))
        whole += [np.array([polygon[0], polygon[k], polygon[k + 1]]) for k in range(1, len(polygon) - 1)]
    if not whole:
        return 0.0, tip
    p, q, r = np.moveaxis(np.array(whole), 1, 0)
    lots = np.einsum("fi,fi->f", p, np.cross(q, r)) / 6
    volume = float(lots.sum())
    return volume, tip + np.einsum("f,fi->i", lots, (p + q + r) / 4) / max(volume, 1e-300)

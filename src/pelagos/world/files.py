"""Mesh files: read, checked, and merged into one mesh."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from pelagos.errors import WorldError, did_you_mean
from pelagos.world.mesh import Mesh, join
from pelagos.world.size import refuse_large

_SUFFIXES = (".obj", ".stl", ".ply", ".glb", ".gltf", ".off")


def read_mesh(path: Path) -> Mesh:
    """All triangles of a mesh file in the file's own units and axes; scene nodes are placed as the file says.

    Raises:
        WorldError: missing, unreadable or empty, or with coordinates that are not finite.
    """
    if not path.is_file():
        near = did_you_mean(path.name, [p.name for p in path.parent.glob("*")] if path.parent.is_dir() else [])
        raise WorldError(f"mesh file {path} does not exist{near}")
    if path.suffix.lower() not in _SUFFIXES:
        raise WorldError(f"mesh file {path}: the format {path.suffix!r} is not read; known: {', '.join(_SUFFIXES)}")
    import trimesh

    refuse_large(path, "mesh file")
    try:
        _check_stl(path)
        mesh = _whole(trimesh.load_scene(path, process=False))
    except Exception as error:  # trimesh's readers raise whatever their parsers meet
        why = "" if isinstance(error, ImportError) else f" ({error})"
        raise WorldError(f"mesh file {path} cannot be read; it may be damaged or cut short{why}") from error
    if len(mesh.faces) == 0:
        raise WorldError(f"mesh file {path} holds no triangles")
    if {mesh.vertices.shape[1:], mesh.faces.shape[1:]} != {(3,)}:
        raise WorldError(f"mesh file {path} holds corners of other than three coordinates")
    if mesh.faces.min() < 0 or mesh.faces.max() >= len(mesh.vertices):
        raise WorldError(f"mesh file {path} names corners that it does not have; there are {len(mesh.vertices)}")
    if not np.isfinite(mesh.vertices).all():
        raise WorldError(f"mesh file {path} holds coordinates that are not finite")
    if not mesh_areas(mesh) > 0:
        raise WorldError(f"mesh file {path} holds no triangle with an area")
    return mesh


def _check_stl(path: Path) -> None:
    """Raises ValueError for a binary STL that is shorter than its header says: trimesh reads it as an empty text."""
    if path.suffix.lower() != ".stl":
        return
    with path.open("rb") as file:
        header = file.read(84)
    if header[:5].lower() == b"solid" or len(header) < 84:
        return
    triangles, size = int.from_bytes(header[80:84], "little"), path.stat().st_size
    if size < 84 + 50 * triangles:
        raise ValueError(f"{triangles} triangles take {84 + 50 * triangles} bytes, and there are {size}")


def mesh_areas(mesh: Mesh) -> float:
    """The area of all triangles [file's unit squared]."""
    a, b, c = np.moveaxis(mesh.vertices[mesh.faces], 1, 0)
    with np.errstate(over="ignore", invalid="ignore"):
        return float(np.linalg.norm(np.cross(b - a, c - a), axis=1).sum() / 2)


def _whole(scene: Any) -> Mesh:
    """The meshes of a `trimesh.Scene` where its nodes put them; its own way to join them copies each three times."""
    parts = [Mesh(np.zeros((0, 3)), np.zeros((0, 3), dtype=np.uint32))]
    for node in scene.graph.nodes_geometry:
        pose, name = scene.graph[node]
        part = scene.geometry[name]
        if hasattr(part, "faces"):  # points and lines have none
            mesh = Mesh(np.array(part.vertices, dtype=np.float64), np.array(part.faces, dtype=np.uint32))
            parts.append(mesh if np.allclose(pose, np.eye(4), atol=1e-8) else mesh.posed(pose))
    return join(parts[1:]) if len(parts) > 2 else parts[-1]

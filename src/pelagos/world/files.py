"""Mesh files: read, checked, and merged into one mesh."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from pelagos.errors import WorldError, did_you_mean
from pelagos.world.mesh import Mesh

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

    try:
        loaded = trimesh.load_mesh(path, process=False)
        whole = loaded.to_mesh() if isinstance(loaded, trimesh.Scene) else loaded
        vertices = np.asarray(whole.vertices, dtype=np.float64)
        faces = np.asarray(whole.faces, dtype=np.uint32)
    except Exception as error:  # trimesh's readers raise whatever their parsers meet
        why = "" if isinstance(error, ImportError) else f" ({error})"
        raise WorldError(f"mesh file {path} cannot be read; it may be damaged or cut short{why}") from error
    if len(faces) == 0:
        raise WorldError(f"mesh file {path} holds no triangles")
    if not np.isfinite(vertices).all():
        raise WorldError(f"mesh file {path} holds coordinates that are not finite")
    return Mesh(vertices, faces)

"""Mitsuba's meshes, and the tables of faces that share their arrays."""

from __future__ import annotations

import ctypes
import sys
from collections.abc import Sequence
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.raycast.hit_tables import Faces

_MANY_FACES: Final = 1_000_000


def large(faces: int) -> bool:
    """Whether a scene of so many faces spares memory while it is loaded."""
    return faces > _MANY_FACES


def mesh_of(name: str, group: Sequence[Geometry], origin: NDArray[np.float64]) -> tuple[Any, Faces]:
    """One Mitsuba mesh of several geometries, relative to `origin`, filled part by part to spare memory.

    Its tables of faces share its arrays. `thing` is still to be filled in.
    """
    starts = np.cumsum([0] + [len(g.vertices) for g in group])
    ends = np.cumsum([0] + [len(g.faces) for g in group])
    vertices = np.empty((starts[-1], 3), dtype=np.float32)
    faces = np.empty((ends[-1], 3), dtype=np.uint32)
    normals = np.zeros((starts[-1], 3), dtype=np.float32)
    for g, v, w, f in zip(group, starts, starts[1:], ends, strict=False):
        np.subtract(g.vertices, origin, out=vertices[v:w], casting="same_kind")
        np.add(g.faces, np.uint32(v), out=faces[f : f + len(g.faces)], casting="same_kind")
        if g.vertex_normals is not None:
            normals[v:w] = g.vertex_normals
    mesh = jit.mi.Mesh(name, len(vertices), len(faces))
    parameters = jit.mi.traverse(mesh)
    made = Faces(
        jit.from_numpy(jit.UInt32, faces),
        jit.from_numpy(jit.Float, vertices),
        jit.from_numpy(jit.Float, normals),
        jit.UInt32(0),
    )
    del faces, vertices, normals
    first = group[0]
    shares = large(len(first.faces)) and not isinstance(first, PlacedGeometry) and on_host()
    if shares and first.vertex_normals is not None:
        corners, directions = made.corner.numpy().reshape(-1, 3), made.normal.numpy().reshape(-1, 3)
        first.share(corners[: len(first.faces)], directions[: len(first.vertex_normals)])
    parameters["vertex_positions"], parameters["faces"] = made.place, made.corner
    parameters.update()
    return mesh, made


def joined(parts: Sequence[Faces], thing: Array | None = None) -> Faces:
    """Several tables of faces as one; that of one part is the part itself."""
    if not parts:
        return no_faces()
    if thing is None:
        thing = dr.concat([p.thing for p in parts])
    if len(parts) == 1:
        return Faces(parts[0].corner, parts[0].place, parts[0].normal, thing)
    corners = np.cumsum([0] + [dr.width(p.place) // 3 for p in parts])
    corner = dr.concat([p.corner + int(c) for p, c in zip(parts, corners, strict=False)])
    made = Faces(corner, dr.concat([p.place for p in parts]), dr.concat([p.normal for p in parts]), thing)
    dr.eval(made)
    return made


def no_faces() -> Faces:
    """One face of no size, for scenes without any."""
    made = Faces(dr.zeros(jit.UInt32, 3), dr.zeros(jit.Float, 3), dr.zeros(jit.Float, 3), dr.zeros(jit.UInt32, 1))
    dr.make_opaque(made)
    return made


def give_back() -> None:
    """Return memory that nothing uses any more to the system: Dr.Jit and the C library keep it for later."""
    dr.sync_thread()
    dr.flush_malloc_cache()
    trim = getattr(ctypes.CDLL(None), "malloc_trim", None) if sys.platform == "linux" else None
    if trim is not None:
        trim(0)


def watertight() -> dict[str, bool]:
    """Without it, Embree lets rays slip through that meet an edge or a vertex exactly; it costs no measurable time."""
    return {"embree_use_robust_intersections": True} if on_host() else {}


def on_host() -> bool:
    """Whether arrays lie in the machine's own memory, where NumPy sees them without a copy."""
    return str(jit.mi.variant()).startswith("llvm")

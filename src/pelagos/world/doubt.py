"""Doubts about a mesh from a file, in words: its units, its holes, faces through each other, missing textures."""

from __future__ import annotations

import json
import struct
from pathlib import Path
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.world.mesh import Mesh

_HUGE: Final = 500.0  # [m]: a thing larger than this is suspected to be in other units
_TINY: Final = 0.005  # [m]
_MOST_FACES: Final = 20_000  # of a mesh that is searched for faces through each other: it takes a second or two
_MOST_PAIRS: Final = 8_000_000


def doubts(mesh: Mesh, name: str, *, parts: bool = False) -> list[str]:
    """Sentences about a mesh in metres; empty where nothing is odd. One of several `parts` may pass through itself."""
    found = []
    extent = float(np.ptp(mesh.vertices, axis=0).max())
    if extent > _HUGE:
        found.append(f"{name} is {extent:.0f} m across: are its coordinates millimetres? then set scale: 0.001")
    if extent < _TINY:
        found.append(f"{name} is {1e3 * extent:.2f} mm across: are its coordinates in other units? then set scale")
    if not mesh.closed:
        found.append(f"{name} is not closed: rays pass through its holes, and contact may let things in")
    elif mesh.volume < 0:
        found.append(f"{name} is inside out: its faces look inwards")
    crossed = crossing_faces(mesh) if len(mesh.faces) <= _MOST_FACES and not parts else 0
    if crossed:
        found.append(
            f"{name} intersects itself: {crossed} of its {len(mesh.faces)} faces are cut by edges of others; volume, "
            "contact and what is inside may be wrong there"
        )
    return found


def missing_files(path: Path) -> list[str]:
    """Sentences about material libraries and textures that a mesh file names and that do not exist."""
    suffix = path.suffix.lower()
    named = _of_obj(path) if suffix == ".obj" else _of_gltf(path) if suffix in (".gltf", ".glb") else []
    return [
        f"{path.name} names {file}, which does not exist; its surface is that of the scenario's material"
        for file in dict.fromkeys(named)
        if not (path.parent / file).is_file()
    ]


def _of_obj(path: Path) -> list[str]:
    libraries = _words(path, ("mtllib",))
    textures = []
    for library in libraries:
        if (path.parent / library).is_file():
            textures += _words(path.parent / library, ("map_kd", "map_ks", "map_ka", "map_bump", "bump", "norm"))
    return [*libraries, *textures]


def _words(path: Path, keys: tuple[str, ...]) -> list[str]:
    """The last word of each line that begins with one of the keys."""
    lines = (line.split() for line in path.read_text(encoding="utf-8", errors="replace").splitlines())
    return [line[-1] for line in lines if len(line) > 1 and line[0].lower() in keys]


def _of_gltf(path: Path) -> list[str]:
    raw = path.read_bytes()
    if raw[:4] == b"glTF":
        raw = raw[20 : 20 + struct.unpack_from("<I", raw, 12)[0]]
    images = json.loads(raw).get("images", [])
    return [i["uri"] for i in images if not i.get("uri", "data:").startswith("data:")]


def crossing_faces(mesh: Mesh) -> int:
    """Number of faces that are cut by an edge that belongs to none of their corners."""
    whole = mesh.merged()
    points, faces = whole.vertices, whole.faces.astype(np.int64)
    edges = np.unique(np.sort(faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1), axis=0)
    corners, ends = points[faces], points[edges]  # (f, 3, 3), (e, 2, 3)
    low = points.min(axis=0)
    step = max(
        float(np.linalg.norm(ends[:, 1] - ends[:, 0], axis=1).mean()), 1e-3 * float(np.ptp(points, axis=0).max())
    )
    face, cell_f = _cells(corners, low, step)
    edge, cell_e = _cells(ends, low, step)
    order = np.argsort(cell_f, kind="stable")
    first, last = (np.searchsorted(cell_f[order], cell_e, side=s) for s in ("left", "right"))
    count = last - first
    if count.sum() > _MOST_PAIRS:
        return 0
    which = np.repeat(np.arange(len(edge)), count)
    offset = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    e, f = edge[which], face[order][first[which] + offset]
    apart = (edges[e][:, :, None] != faces[f][:, None, :]).all(axis=(1, 2))
    cut = _cuts(ends[e[apart]], corners[f[apart]])
    return len(np.unique(f[apart][cut]))


def _cells(
    shapes: NDArray[np.float64], low: NDArray[np.float64], step: float
) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """Each shape `(k, corners, 3)` with every cell that its box meets: index of the shape, key of the cell."""
    a = ((shapes.min(axis=1) - low) / step).astype(np.int64)
    span = ((shapes.max(axis=1) - low) / step).astype(np.int64) - a + 1
    count = span.prod(axis=1)
    which = np.repeat(np.arange(len(shapes)), count)
    k = np.arange(count.sum()) - np.repeat(np.cumsum(count) - count, count)
    s = span[which]
    at = a[which] + np.stack([k // (s[:, 1] * s[:, 2]), k // s[:, 2] % s[:, 1], k % s[:, 2]], axis=1)
    return which, (at[:, 0] << 42) + (at[:, 1] << 21) + at[:, 2]


def _cuts(ends: NDArray[np.float64], corners: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Whether each segment passes through the inside of its triangle, touching left out (Moeller and Trumbore 1997)."""
    start, way = ends[:, 0], ends[:, 1] - ends[:, 0]
    a, b, c = corners[:, 0], corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    p = np.cross(way, c)
    det = (b * p).sum(axis=1)
    size = np.linalg.norm(b, axis=1) * np.linalg.norm(c, axis=1) * np.linalg.norm(way, axis=1)
    flat = np.abs(det) <= 1e-9 * size
    inverse = 1.0 / np.where(flat, 1.0, det)
    s = start - a
    u = (s * p).sum(axis=1) * inverse
    q = np.cross(s, b)
    v, t = (way * q).sum(axis=1) * inverse, (c * q).sum(axis=1) * inverse
    rim = 1e-6
    return np.asarray(~flat & (u > rim) & (v > rim) & (u + v < 1 - rim) & (t > rim) & (t < 1 - rim))

"""Triangles with smooth normals: surfaces of revolution, boxes, plates."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import numpy as np
from numpy.typing import NDArray

_AROUND: Final = 32  # vertices around a surface of revolution

Points = NDArray[np.float64]


@dataclass
class Mesh:
    """Triangles with a normal a vertex: vertices `(v, 3)`, faces `(f, 3)`, normals `(v, 3)`.

    `material` is that of all faces by name, None for the vehicle's own.
    """

    vertices: Points
    faces: NDArray[np.uint32]
    normals: Points
    material: str | None = None


def revolved(x: Points, radius: Points) -> Mesh:
    """The surface of a profile `(p,)`, x falling, revolved about x; ends with radius 0 close it."""
    angle = np.linspace(0, 2 * math.pi, _AROUND, endpoint=False)
    ring = np.stack([np.zeros(_AROUND), np.cos(angle), np.sin(angle)], axis=-1)
    vertices = x[:, None, None] * np.array([1.0, 0, 0]) + radius[:, None, None] * ring
    slope = np.gradient(radius, x)
    tip = radius < 1e-9
    normals = np.where(tip[:, None, None], 0.0, ring) - slope[:, None, None] * np.array([1.0, 0, 0])
    normals[tip] = np.array([1.0, 0, 0]) * np.sign(x[tip] - x.mean())[:, None, None]
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    i = np.arange(len(x) - 1)[:, None] * _AROUND
    j, k = np.arange(_AROUND)[None, :], np.roll(np.arange(_AROUND), -1)[None, :]
    a, b, c, d = i + j, i + k, i + _AROUND + j, i + _AROUND + k
    faces = np.concatenate([np.stack([a, b, d], -1).reshape(-1, 3), np.stack([a, d, c], -1).reshape(-1, 3)])
    flat = vertices.reshape(-1, 3)
    p, q, r = (flat[faces[:, n]] for n in range(3))
    faces = faces[np.linalg.norm(np.cross(q - p, r - p), axis=-1) > 1e-14]
    return Mesh(flat, outward(flat, faces.astype(np.uint32), normals.reshape(-1, 3)), normals.reshape(-1, 3))


def outward(vertices: Points, faces: NDArray[np.uint32], normals: Points) -> NDArray[np.uint32]:
    """Faces turned so that they are counter-clockwise seen from the side of their vertices' normals."""
    p, q, r = (vertices[faces[:, n]] for n in range(3))
    wrong = np.einsum("fi,fi->f", np.cross(q - p, r - p), normals[faces].sum(axis=1)) < 0
    faces = faces.copy()
    faces[wrong] = faces[wrong][:, ::-1]
    return faces


def slab(outline: Points, thickness: float, normal: Points) -> Mesh:
    """A convex plate: `outline` `(p, 3)` moved by half the thickness to both sides along the unit `normal`."""
    half = 0.5 * thickness * normal
    top, bottom = outline + half, outline - half
    p = len(outline)
    fan = np.array([[0, i, i + 1] for i in range(1, p - 1)])
    sides = np.array(
        [[i, (i + 1) % p, p + (i + 1) % p] for i in range(p)] + [[i, p + (i + 1) % p, p + i] for i in range(p)]
    )
    return flat_shaded(np.concatenate([top, bottom]), np.concatenate([fan, fan[:, ::-1] + p, sides]))


def flat_shaded(vertices: Points, faces: NDArray[np.int64]) -> Mesh:
    """Every face with vertices and a normal of its own; faces of a convex body are turned outwards."""
    corners = vertices[faces]
    normals = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    normals /= np.linalg.norm(normals, axis=-1, keepdims=True)
    inward = np.einsum("fi,fi->f", normals, corners.mean(axis=1) - vertices.mean(axis=0)) < 0
    corners[inward] = corners[inward][:, ::-1]
    normals[inward] *= -1
    faces_out = np.arange(3 * len(faces), dtype=np.uint32).reshape(-1, 3)
    return Mesh(corners.reshape(-1, 3), faces_out, np.repeat(normals, 3, axis=0))


def joined(parts: list[Mesh]) -> Mesh:
    """One mesh of many."""
    starts = np.cumsum([0] + [len(p.vertices) for p in parts[:-1]])
    return Mesh(
        np.concatenate([p.vertices for p in parts]),
        np.concatenate([p.faces + np.uint32(s) for p, s in zip(parts, starts, strict=True)]).astype(np.uint32),
        np.concatenate([p.normals for p in parts]),
    )


def box(size: Points) -> Mesh:
    """A box `(3,)` about the origin."""
    corners = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]) * size / 2
    quads = np.array([[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]])
    return flat_shaded(corners, np.concatenate([quads[:, [0, 1, 2]], quads[:, [0, 2, 3]]]))


def placed(mesh: Mesh, rotation: Points, position: Points) -> Mesh:
    """A mesh turned by `rotation` `(3, 3)` and moved to `position` `(3,)`."""
    return Mesh(mesh.vertices @ rotation.T + position, mesh.faces, mesh.normals @ rotation.T)

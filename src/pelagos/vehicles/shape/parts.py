"""Hulls put together from boxes, cylinders, ellipsoids and plates."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Annotated, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.math.so3 import from_euler, matrix
from pelagos.vehicles.part import Number, PartConfig, Positive, Three
from pelagos.vehicles.shape.mesh import Mesh, Points, box, joined, placed, revolved, slab

_PROBES: Final = 60


class ShapePart(PartConfig):
    """One primitive, FLU."""

    type: Literal["box", "cylinder", "ellipsoid", "hull"]
    """`cylinder`: along x, with rounded edges. `hull`: a boat's, with a raked bow along x."""
    size_m: tuple[Positive, Positive, Positive]
    """Along x, y, z before it is turned [m]."""
    position_m: Three = (0.0, 0.0, 0.0)
    """Of its middle, forward-left-up from the origin [m]."""
    turn_deg: tuple[Number, Number, Number] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw [deg]."""
    mirror: bool = False
    """A second one on the other side, y reversed."""
    material: str | None = None
    """What it is made of; the vehicle's first material where not given."""

    def meshes(self) -> list[Mesh]:
        """One, or two."""
        found = [self._mesh(1.0)]
        if self.mirror:
            found.append(self._mesh(-1.0))
        return found

    def _mesh(self, side: float) -> Mesh:
        roll, pitch, yaw = (math.radians(a) for a in self.turn_deg)
        rotation = _rotation(side * roll, pitch, side * yaw)
        x, y, z = self.position_m
        mesh = placed(_PRIMITIVES[self.type](np.array(self.size_m)), rotation, np.array([x, side * y, z]))
        return replace(mesh, material=self.material)


class PartsHull(PartConfig):
    """Primitives that stand in each other."""

    type: Literal["parts"]
    parts: Annotated[tuple[ShapePart, ...], Field(min_length=1)]
    """What the hull is made of."""

    def meshes(self) -> list[Mesh]:
        """The parts."""
        return [mesh for part in self.parts for mesh in part.meshes()]

    def probes(self) -> tuple[Points, Points]:
        """Contact probes: starts `(p, 3)` on a spine and vectors `(p, 3)` to outlying points of the hull, FLU [m].

        A boat's hull has a spine of its own, so that no probe reaches across the gap of a catamaran, and what lies on
        one side with it shares that; all other parts have one spine together.
        """
        meshes = [(mesh.vertices, part.type == "hull") for part in self.parts for mesh in part.meshes()]
        points = np.concatenate([vertices for vertices, _ in meshes])
        spines = {_side(vertices): vertices for vertices, boat in meshes if boat}
        chosen = _outlying(points)
        starts, first = _on_spine(points, points[chosen]), 0
        for vertices, _ in meshes:
            belongs = (chosen >= first) & (chosen < first + len(vertices))
            first += len(vertices)
            if _side(vertices) in spines:
                starts[belongs] = _on_spine(spines[_side(vertices)], points[chosen[belongs]])
        vectors = points[chosen] - starts
        kept = np.linalg.norm(vectors, axis=1) > 1e-3
        return starts[kept], vectors[kept]


def _side(points: Points) -> int:
    """1 to port of the middle, -1 to starboard, 0 on both sides."""
    return int(points[:, 1].min() > 0) - int(points[:, 1].max() < 0)


def _outlying(points: Points) -> NDArray[np.int64]:
    """Rows of points far from one another, the foremost first."""
    chosen = [int(np.argmax(points[:, 0]))]
    distance = np.linalg.norm(points - points[chosen[0]], axis=1)
    while len(chosen) < _PROBES and distance.max() > 1e-6:
        chosen.append(int(np.argmax(distance)))
        distance = np.minimum(distance, np.linalg.norm(points - points[chosen[-1]], axis=1))
    return np.array(chosen)


def _on_spine(points: Points, tips: Points) -> Points:
    """Beside each tip, a place on the line through the middle of `points` that stays half a width from their ends."""
    low, high = points.min(axis=0), points.max(axis=0)
    middle, half = (low + high) / 2, (high - low) / 2
    spine = max(0.0, float(half[0] - half[1]))
    starts = np.tile(middle, (len(tips), 1))
    starts[:, 0] += np.clip(tips[:, 0] - middle[0], -spine, spine)
    return starts


def _rotation(roll: float, pitch: float, yaw: float) -> Points:
    return np.array(matrix([float(c) for c in from_euler(roll, pitch, yaw)]))


def _scaled(mesh: Mesh, size: Points) -> Mesh:
    """A mesh of unit size stretched; normals by the inverse."""
    normals = mesh.normals / size
    return Mesh(mesh.vertices * size, mesh.faces, normals / np.linalg.norm(normals, axis=1, keepdims=True))


def _cylinder(size: Points) -> Mesh:
    edge = min(0.1, 0.1 * size[1] / size[0])
    angle = np.linspace(0, math.pi / 2, 5)
    x = np.concatenate([0.5 - edge * (1 - np.sin(angle)), -0.5 + edge * (1 - np.sin(angle[::-1]))])
    r = np.concatenate([0.5 - 0.1 * (1 - np.cos(angle)), 0.5 - 0.1 * (1 - np.cos(angle[::-1]))])
    order = np.argsort(-x, kind="stable")
    x, r = x[order], r[order]
    closed_x = np.concatenate([[x[0]], x, [x[-1]]]) + np.concatenate([[1e-9], np.zeros(len(x)), [-1e-9]])
    return _scaled(revolved(closed_x, np.concatenate([[0.0], r, [0.0]])), size)


def _ellipsoid(size: Points) -> Mesh:
    angle = np.linspace(0, math.pi, 17)
    return _scaled(revolved(0.5 * np.cos(angle), np.maximum(0.5 * np.sin(angle), 0.0) * (np.sin(angle) > 1e-9)), size)


def _boat(size: Points) -> Mesh:
    """A prism with a V bottom and a bow that runs to a point, as three convex plates side by side along x."""
    half = np.array([[-0.5, 0.9], [0.1, 1.0], [0.35, 0.6], [0.5, 0.02]])
    outline = [(x, y) for x, y in half] + [(x, -y) for x, y in half[::-1]]
    deck = np.array([[x, 0.5 * y, 0.25] for x, y in outline])
    upper = slab(deck, 0.5, np.array([0.0, 0.0, 1.0]))
    keel = np.array([[x * 0.96 - 0.02, 0.3 * y, -0.25] for x, y in outline])
    lower = slab(keel, 0.5, np.array([0.0, 0.0, 1.0]))
    return _scaled(joined([upper, lower]), size)


_PRIMITIVES: Final = {"box": box, "cylinder": _cylinder, "ellipsoid": _ellipsoid, "hull": _boat}

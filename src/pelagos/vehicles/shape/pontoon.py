"""Hulls that float, as meshes for pressure: waterplane and section after powers of the distance from their middle."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.vehicles.part import Number, PartConfig, Positive

Points = NDArray[np.float64]


class PontoonConfig(PartConfig):
    """One hull, symmetric fore and aft; the draught follows from the weight that all hulls carry together."""

    length_m: Positive
    """At the waterline [m]."""
    beam_m: Positive
    """Largest, at the waterline [m]."""
    freeboard_m: Positive
    """From the waterline to the deck, wall-sided [m]."""
    position_x_m: Number = 0.0
    """Its middle, forward of the origin [m]."""
    position_y_m: Number = 0.0
    """Its centre line, to starboard of the origin [m]."""
    mirror: bool = False
    """A second one on the other side."""
    waterplane_coefficient: float = Field(default=1.0, gt=0.5, le=1)
    """Area of the waterplane over length times beam [-]; 1 is a box."""
    section_coefficient: float = Field(default=1.0, gt=0.5, le=1)
    """Area of a section over beam times draught [-]; 1 is a box."""

    @property
    def sides(self) -> tuple[float, ...]:
        """Places of the centre lines, to starboard [m]."""
        return (self.position_y_m, -self.position_y_m) if self.mirror else (self.position_y_m,)

    @property
    def volume_per_draught(self) -> float:
        """Displaced volume over the draught [m^2]."""
        return len(self.sides) * self.length_m * self.beam_m * self.waterplane_coefficient * self.section_coefficient


def pontoon_mesh(
    pontoon: PontoonConfig, draught: float, *, along: int = 10, down: int = 3, deck: bool = True
) -> tuple[Points, NDArray[np.int64]]:
    """Triangles of one hull and its mirror image, FRD: vertices `(v, 3)` [m], faces `(f, 3)`, outwards.

    Args:
        pontoon: see `PontoonConfig`.
        draught: [m].
        along, down: number of strips; three strips in ten hold 1 % of the volume.
        deck: with topsides and deck; otherwise open at the waterline, for panel methods.
    """
    u = np.linspace(-1, 1, along + 1)
    wide = 0.5 * pontoon.beam_m * fullness(np.abs(u), pontoon.waterplane_coefficient)
    low = np.linspace(1, 0, down + 1)
    full = fullness(low, pontoon.section_coefficient)
    if pontoon.section_coefficient == 1.0:  # a flat bottom: from the keel straight out, then up
        full, low = np.concatenate([[0.0], full]), np.concatenate([[1.0], low])
    depth = draught * low
    if deck:
        full, depth = np.append(full, [1.0, 0.0]), np.append(depth, [-pontoon.freeboard_m] * 2)
    ring = np.concatenate([np.stack([full, depth], -1), np.stack([-full, depth], -1)[-2 if deck else -1 : 0 : -1]])
    x = pontoon.position_x_m + 0.5 * pontoon.length_m * u
    shape = (along + 1, len(ring))
    one = np.stack([np.broadcast_to(x[:, None], shape), wide[:, None] * ring[:, 0], np.broadcast_to(ring[:, 1], shape)])
    vertices = one.reshape(3, -1).T
    n = len(ring)
    around = [(j, (j + 1) % n) for j in range(n) if deck or not (ring[j, 1] == 0 and ring[(j + 1) % n, 1] == 0)]
    quads = [(i * n + a, i * n + b, (i + 1) * n + b, (i + 1) * n + a) for i in range(along) for a, b in around]
    faces = [t for a, b, c, d in quads for t in ((a, c, b), (a, d, c))]
    if pontoon.waterplane_coefficient == 1.0:  # transoms
        last = along * n
        faces += [(0, a, b) for a, b in around if 0 not in (a, b)]
        faces += [(last, last + b, last + a) for a, b in around if 0 not in (a, b)]
        if not deck:
            top = [j for j in range(n) if ring[j, 1] == 0]
            faces += [] if len(top) != 2 else [(0, top[0], top[1]), (last, last + top[1], last + top[0])]
    triangles = np.array(faces)
    points: list[Points] = []
    found: list[NDArray[np.int64]] = []
    for side in pontoon.sides:
        found.append(triangles + len(vertices) * len(points))
        points.append(vertices + np.array([0.0, side, 0.0]))
    joined, whole = np.concatenate(points), np.concatenate(found)
    p, q, r = (joined[whole[:, k]] for k in range(3))
    cross = np.cross(q - p, r - p)
    return joined, whole[np.linalg.norm(cross, axis=1) > 1e-12]


def displaced(vertices: Points, faces: NDArray[np.int64]) -> float:
    """Volume [m^3] of a closed mesh."""
    p, q, r = (vertices[faces[:, k]] for k in range(3))
    return float(np.einsum("fi,fi->f", p, np.cross(q, r)).sum() / 6)


def fullness(distance: Points, coefficient: float) -> Points:
    """Breadth at a distance from the middle: 1 - distance^n, whose mean over 0 .. 1 is the coefficient."""
    if coefficient == 1.0:
        return np.ones_like(distance)
    return np.asarray(1 - distance ** (coefficient / (1 - coefficient)))

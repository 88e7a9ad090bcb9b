"""Weight and still water on a hull at rest: its stiffness, and the load that they leave unbalanced."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from pelagos.vehicles.afloat_config import AfloatConfig
from pelagos.vehicles.part import Body
from pelagos.vehicles.shape.floating_mesh import wet_part
from pelagos.vehicles.shape.pontoon import PontoonConfig, pontoon_mesh

Values = NDArray[np.float64]


def mesh_stiffness(vertices: Values, faces: NDArray[np.int64], body: Body) -> Values:
    """G `(6, 6)` about the origin of a mesh, FRD, that floats there: -d load / d (heave, roll, pitch), still water."""
    flip, step = np.array([1.0, -1.0, -1.0]), 1e-3
    stiffness = np.zeros((6, 6))
    half = float(np.abs(vertices[:, :2]).max())

    def load(heave: float, roll: float, pitch: float) -> Values:
        (sr, cr), (sp, cp) = ((math.sin(a), math.cos(a)) for a in (roll, pitch))
        turn = np.array([[cp, sp * sr, sp * cr], [0.0, cr, -sr], [-sp, cp * sr, cp * cr]])  # body to level
        volume, center = wet_part((vertices @ turn.T + [0.0, 0.0, heave]) * flip, faces, 0.0)
        push = np.array([0.0, 0.0, -body.density * body.gravity * volume])
        down = np.array([0.0, 0.0, body.weight])
        arm = center * flip - [0.0, 0.0, heave]
        moment = np.cross(arm, push) + np.cross(turn @ body.center_of_gravity, down)
        return np.concatenate([turn.T @ (push + down), turn.T @ moment])

    for axis, move in ((2, np.array([1.0, 0, 0])), (3, np.array([0, 1.0, 0])), (4, np.array([0, 0, 1.0]))):
        size = step * (body.weight / body.gravity / body.density) ** (1 / 3) / (1.0 if axis == 2 else half)
        stiffness[:, axis] = (load(*(-size * move)) - load(*(size * move))) / (2 * size)
    stiffness[np.abs(stiffness) < 1e-7 * np.abs(stiffness).max()] = 0.0
    return stiffness


def to_waterline(hull: PontoonConfig, draught: float) -> tuple[Values, NDArray[np.int64]]:
    """The mesh of a hull up to the water, without its deck: vertices [m] and faces."""
    return pontoon_mesh(hull, draught, along=8, deck=False)


def unbalanced(config: AfloatConfig, draught: float, body: Body) -> list[float]:
    """Wrench (6) of weight and still water on the hull as it lies."""
    volume, first = 0.0, np.zeros(3)
    for hull in config.hulls:
        vertices, faces = to_waterline(hull, draught)
        p, q, r = (vertices[faces[:, k]] for k in range(3))
        lots = np.einsum("fi,fi->f", p, np.cross(q, r)) / 6
        volume += float(lots.sum())
        first += np.einsum("f,fi->i", lots, (p + q + r) / 4)
    return unbalanced_rest(body, volume, first / volume)


def unbalanced_rest(body: Body, volume: float, center: Values) -> list[float]:
    """Wrench (6) of weight and still water that displaces a volume [m^3] about a center [m], FRD."""
    push = np.array([0.0, 0.0, -body.density * body.gravity * volume])
    down = np.array([0.0, 0.0, body.weight])
    moment = np.cross(center, push) + np.cross(body.center_of_gravity, down)
    return [float(x) for x in [*(push + down), *moment]]

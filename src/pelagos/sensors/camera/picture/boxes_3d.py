"""Boxes in space around objects, for detection in three dimensions: of what stands in a world, and of what moves."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.math.so3 import rotate_np
from pelagos.raycast.geometry import Geometry, PlacedGeometry
from pelagos.sensors.camera.picture.camera_rays import ViewConfig, project_points

_CORNERS = np.array([[x, y, z] for x in (-0.5, 0.5) for y in (-0.5, 0.5) for z in (-0.5, 0.5)])


@dataclass(frozen=True, eq=False)
class Box3d:
    """The box around one object, along the axes in which it was made.

    Attributes:
        instance: its id, as instance cameras and semantic LiDARs report it.
        label: its semantic label.
        centre: `(3,)` world NWU [m].
        size: `(3,)` extent along its own axes [m].
        turn: `(3, 3)` rotation matrix, its own axes to world.
    """

    instance: int
    label: int
    centre: NDArray[np.float64]
    size: NDArray[np.float64]
    turn: NDArray[np.float64]

    @property
    def corners(self) -> NDArray[np.float64]:
        """`(8, 3)` world NWU [m], the last axis changing fastest."""
        return np.asarray(self.centre + _CORNERS * self.size @ self.turn.T)

    def corners_seen(
        self, position: NDArray[np.float64], attitude: NDArray[np.float64], config: ViewConfig
    ) -> NDArray[np.float64]:
        """`(8, 2)` pixels (column, row) of the corners in a camera's picture; NaN for corners behind the camera.

        Args:
            position: `(3,)` of the sensor, world NWU [m].
            attitude: `(4,)` (w, x, y, z), sensor frame to world.
            config: the camera's, without a port.
        """
        local = (self.corners - position) @ _matrix(attitude)
        local[local[:, 0] <= 0] = np.nan
        return project_points(local, config)


def boxes_3d(geometries: Iterable[Geometry]) -> dict[int, Box3d]:
    """Boxes around static objects by instance id; parts that share an id share a box.

    Copies of a model have boxes along the model's axes, everything else along the world's.
    """
    parts: dict[int, list[Geometry]] = {}
    for geometry in geometries:
        if len(geometry.faces):
            parts.setdefault(geometry.instance, []).append(geometry)
    return {instance: _static(found) for instance, found in parts.items()}


def box_of_body(geometry: Geometry, position: NDArray[np.float64], attitude: NDArray[np.float64]) -> Box3d:
    """The box around a body, along its own axes.

    Args:
        geometry: in the body's frame FLU.
        position: `(3,)` of its origin, world NWU [m].
        attitude: `(4,)` (w, x, y, z), body to world.
    """
    turn = _matrix(attitude)
    low, high = geometry.extent
    return _box(geometry, turn, np.asarray(position) + turn @ (low + high) / 2, high - low)


def _matrix(q: NDArray[np.float64]) -> NDArray[np.float64]:
    """`(3, 3)` rotation matrix of a quaternion (w, x, y, z)."""
    return rotate_np(np.broadcast_to(np.asarray(q, dtype=np.float64), (3, 4)), np.eye(3)).T


def _static(parts: Sequence[Geometry]) -> Box3d:
    first, turn = parts[0], np.eye(3)
    extents = [p.extent for p in parts]  # (2, 3) each
    copies = [p for p in parts if isinstance(p, PlacedGeometry)]
    if len(copies) == len(parts):  # all stand turned alike
        turn = np.asarray(copies[0].turn, dtype=np.float64)
        extents = [p.scale * p.model.extent + p.offset @ turn for p in copies]
    low, high = np.min([e[0] for e in extents], axis=0), np.max([e[1] for e in extents], axis=0)
    return _box(first, turn, turn @ (low + high) / 2, high - low)


def _box(of: Geometry, turn: NDArray[np.float64], centre: NDArray[np.float64], size: NDArray[np.float64]) -> Box3d:
    return Box3d(of.instance, of.label, np.asarray(centre, float), np.asarray(size, float), turn)

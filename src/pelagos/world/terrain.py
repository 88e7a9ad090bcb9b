"""Ground as heights on a regular grid: the mesh that rays hit, and queries that agree with it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.errors import WorldError
from pelagos.math.interpolate import bilinear, triangulated
from pelagos.raycast.geometry import Geometry


@dataclass(frozen=True)
class HeightField:
    """Heights over a regular grid, world NWU.

    Attributes:
        x0, y0: place of node (0, 0) [m].
        spacing: between nodes, in both directions [m].
        z: `(nx, ny)` float64 [m]; node (i, j) stands at (x0 + i spacing, y0 + j spacing). At least 2 x 2, all finite.
    """

    x0: float
    y0: float
    spacing: float
    z: NDArray[np.float64]

    def __post_init__(self) -> None:
        if self.z.ndim != 2 or min(self.z.shape) < 2:
            raise WorldError(f"a height field needs at least 2 x 2 nodes, not {self.z.shape}")
        if not np.isfinite(self.z).all():
            raise WorldError(f"a height field has {int((~np.isfinite(self.z)).sum())} nodes that are not finite")

    @property
    def x(self) -> NDArray[np.float64]:
        """`(nx,)` node coordinates [m]."""
        return self.x0 + self.spacing * np.arange(self.z.shape[0], dtype=np.float64)

    @property
    def y(self) -> NDArray[np.float64]:
        """`(ny,)` node coordinates [m]."""
        return self.y0 + self.spacing * np.arange(self.z.shape[1], dtype=np.float64)

    @property
    def bounds(self) -> NDArray[np.float64]:
        """`(2, 3)` lowest and highest coordinates [m]."""
        return np.array([[self.x0, self.y0, self.z.min()], [self.x[-1], self.y[-1], self.z.max()]])

    def height(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Bilinear height [m] at places of equal shape [m]; NaN outside the grid, node values exactly at nodes."""
        return bilinear(self.z, *self._indices(x, y))

    def surface(self, x: ArrayLike, y: ArrayLike) -> NDArray[np.float64]:
        """Height [m] of the triangles that rays hit: within a quarter of the cell's twist of `height`."""
        return triangulated(self.z, *self._indices(x, y))

    def _indices(self, x: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        i = (np.asarray(x, dtype=np.float64) - self.x0) / self.spacing
        j = (np.asarray(y, dtype=np.float64) - self.y0) / self.spacing
        # a place at the outermost node must not fall outside by rounding
        return snapped(i, self.z.shape[0] - 1), snapped(j, self.z.shape[1] - 1)

    def normals(self) -> NDArray[np.float32]:
        """`(nx, ny, 3)` unit normals of the smooth surface through the nodes."""
        gx, gy = np.gradient(self.z.astype(np.float32), np.float32(self.spacing))
        n = np.stack([-gx, -gy, np.ones_like(gx)], axis=-1)
        n /= np.sqrt((n * n).sum(axis=-1, keepdims=True))
        return n

    def faces(self) -> NDArray[np.uint32]:
        """`(2 (nx-1) (ny-1), 3)` faces that look up; the two of a cell follow each other, cells in row order."""
        nx, ny = self.z.shape
        a = (np.arange(nx - 1, dtype=np.uint32)[:, None] * np.uint32(ny) + np.arange(ny - 1, dtype=np.uint32)).reshape(
            -1
        )
        faces = np.empty((len(a), 2, 3), dtype=np.uint32)
        faces[:, :, 0] = a[:, None]
        faces[:, 0, 1] = a + np.uint32(ny)
        faces[:, 0, 2] = faces[:, 1, 1] = a + np.uint32(ny + 1)
        faces[:, 1, 2] = a + np.uint32(1)
        return faces.reshape(-1, 3)

    def vertices(self) -> NDArray[np.float64]:
        """`(nx ny, 3)` node places [m]."""
        out = np.empty((*self.z.shape, 3))
        out[..., 0] = self.x[:, None]
        out[..., 1] = self.y
        out[..., 2] = self.z
        return out.reshape(-1, 3)

    def geometry(
        self, *, material: int | NDArray[np.uint32], label: int, instance: int, name: str = "seabed"
    ) -> Geometry:
        """The mesh, with smooth normals; `material` is one row, or one for each cell `(nx-1, ny-1)`."""
        if not isinstance(material, int):
            material = np.repeat(np.asarray(material, dtype=np.uint32).reshape(-1), 2)
        return Geometry(self.vertices(), self.faces(), material, label, instance, self.normals().reshape(-1, 3), name)


def snapped(index: NDArray[np.float64], last: int) -> NDArray[np.float64]:
    """Fractional indices with those that miss a node by rounding alone put on it."""
    near = np.round(index)
    return np.where((np.abs(index - near) < 1e-9 * (1 + last)) & (near >= 0) & (near <= last), near, index)

"""Content of a survey file, once read: a grid or scattered soundings, in the file's own coordinates."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray


@dataclass(frozen=True)
class Grid:
    """Values at the nodes of a rectilinear grid.

    Attributes:
        u: `(nu,)` rising coordinates of the first axis: northing [m] or latitude [deg].
        v: `(nv,)` rising coordinates of the second axis: easting [m] or longitude [deg].
        z: `(nu, nv)` float64 as in the file, NaN where it has none [m].
        crs: "EPSG:4326" (latitude and longitude), another name or WKT that pyproj understands, or "" where unknown.
        name: of the variable, for messages.
        positive_down: what the file itself says about its sign, where it says anything.
        whole: (lowest u, highest u, lowest v, highest v) of the file, of which only a part may have been read; None
            where all was.
        unit: of the values, as the file writes it; "" where it does not.
        words: what else the file calls the values, for the sign convention.
        notes: what people should know about how the file was read.
    """

    u: NDArray[np.float64]
    v: NDArray[np.float64]
    z: NDArray[np.float64]
    crs: str
    name: str
    positive_down: bool | None = None
    whole: tuple[float, float, float, float] | None = None
    unit: str = ""
    words: str = ""
    notes: tuple[str, ...] = ()


@dataclass(frozen=True)
class Soundings:
    """Values at scattered points.

    Attributes:
        u: `(k,)` northing [m] or latitude [deg].
        v: `(k,)` easting [m] or longitude [deg].
        z: `(k,)` float64 as in the file [m], finite.
        crs: as in `Grid`.
        name: for messages.
        positive_down, unit, words, notes: as in `Grid`.
    """

    u: NDArray[np.float64]
    v: NDArray[np.float64]
    z: NDArray[np.float64]
    crs: str
    name: str
    positive_down: bool | None = None
    unit: str = ""
    words: str = ""
    notes: tuple[str, ...] = ()


def closed(grid: Grid) -> Grid:
    """A grid of degrees that goes around the Earth, with its first column again after the last."""
    step = np.diff(grid.v[:2])
    if not np.isclose(grid.v[-1] - grid.v[0] + step, 360.0, atol=0.01 * step).all():
        return grid
    return replace(grid, v=np.append(grid.v, grid.v[0] + 360), z=np.concatenate([grid.z, grid.z[:, :1]], axis=1))


def rising(
    u: NDArray[np.float64], v: NDArray[np.float64], z: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Axes turned so that they rise, with the values turned along."""
    if u[0] > u[-1]:
        u, z = u[::-1], z[::-1]
    if v[0] > v[-1]:
        v, z = v[::-1], z[:, ::-1]
    return np.ascontiguousarray(u), np.ascontiguousarray(v), np.ascontiguousarray(z)

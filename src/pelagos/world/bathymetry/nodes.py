"""Ground whose nodes are the survey's own: regular in the survey's coordinates, curved in the world's."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.bathymetry.projection import from_latlon, to_latlon
from pelagos.world.bathymetry.regrid import fill, fractional
from pelagos.world.bathymetry.survey import Grid
from pelagos.world.terrain import HeightField, snapped


@dataclass(frozen=True)
class SurveyNodes(HeightField):
    """A height field on a survey's nodes. `x0`, `y0` and `spacing` only say where and how dense it is about.

    Heights between nodes are interpolated in the survey's coordinates. Within one cell these are straight in the world
    up to the square of the cell's size over 8 Earth radii (0.2 mm for cells of 100 m), so that rays hit where `surface`
    says.

    Attributes:
        origin: of the world.
        crs: of the survey's coordinates.
        u, v: rising coordinates of the nodes: northing [m] or latitude [deg], easting [m] or longitude [deg]. Node
            (i, j) of `z` stands at u[i], v[-1 - j]: x runs north and y runs west.
    """

    origin: GeoOrigin
    crs: str
    u: NDArray[np.float64]
    v: NDArray[np.float64]

    @property
    def bounds(self) -> NDArray[np.float64]:
        """`(2, 3)` lowest and highest coordinates [m]."""
        places = self.vertices()
        return np.stack([places.min(axis=0), places.max(axis=0)])

    def _indices(self, x: ArrayLike, y: ArrayLike) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        lat, lon = self.origin.to_latlon(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64))
        u, v = from_latlon(self.crs, np.asarray(lat), np.asarray(lon), near=float(self.v[len(self.v) // 2]))
        i, j = fractional(self.u, u), fractional(self.v, v)
        last = self.z.shape[1] - 1
        return snapped(i, self.z.shape[0] - 1), snapped(np.where(j < 0, -1.0, last - j), last)

    def vertices(self) -> NDArray[np.float64]:
        """`(nx ny, 3)` node places [m]."""
        u, v = np.meshgrid(self.u, self.v[::-1], indexing="ij")
        x, y = self.origin.to_xy(*to_latlon(self.crs, u, v))
        return np.stack([x, y, self.z], axis=-1).reshape(-1, 3)

    def normals(self) -> NDArray[np.float32]:
        """`(nx, ny, 3)` unit normals of the smooth surface through the nodes."""
        places = self.vertices().reshape(*self.z.shape, 3)
        n = np.cross(np.gradient(places, axis=0), np.gradient(places, axis=1))
        return np.asarray(n / np.linalg.norm(n, axis=-1, keepdims=True), dtype=np.float32)


def survey_nodes(
    survey: Grid, origin: GeoOrigin, *, middle: tuple[float, float], size: tuple[float, float]
) -> tuple[SurveyNodes, int]:
    """The nodes of a survey inside a crop `size` (north, west) about `middle` [m], and how many had no value.

    Raises:
        WorldError: fewer than 2 x 2 nodes, or none with a value.
    """
    side = np.linspace(-0.5, 0.5, 17)
    x = middle[0] + size[0] * np.concatenate([side, side, np.full(17, -0.5), np.full(17, 0.5)])
    y = middle[1] + size[1] * np.concatenate([np.full(17, -0.5), np.full(17, 0.5), side, side])
    u, v = from_latlon(survey.crs, *origin.to_latlon(x, y), near=float(survey.v[len(survey.v) // 2]))
    rows, columns = _inside(survey.u, u), _inside(survey.v, v)
    if min(rows.sum(), columns.sum()) < 2:
        raise WorldError(
            f"the crop holds {rows.sum()} x {columns.sum()} nodes of the survey; nodes: survey needs 2 x 2 or more"
        )
    values = survey.z[np.ix_(rows, columns)][:, ::-1]
    z, holes = fill(values)
    corner = origin.to_xy(*to_latlon(survey.crs, survey.u[rows][:1], survey.v[columns][-1:]))
    spacing = size[0] / max(int(rows.sum()) - 1, 1)
    field = SurveyNodes(
        float(corner[0][0]), float(corner[1][0]), spacing, z, origin, survey.crs, survey.u[rows], survey.v[columns]
    )
    return field, holes


def _inside(axis: NDArray[np.float64], values: NDArray[np.float64]) -> NDArray[np.bool_]:
    slack = 1e-9 * (axis[-1] - axis[0])
    return np.asarray((axis >= values.min() - slack) & (axis <= values.max() + slack))

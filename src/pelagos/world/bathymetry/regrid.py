"""From a survey to heights on a regular grid in the world's metres, holes filled and counted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.interpolate import bilinear
from pelagos.world.bathymetry.projection import from_latlon, to_latlon
from pelagos.world.bathymetry.survey import Grid, Soundings
from pelagos.world.bathymetry.triangles import gridded
from pelagos.world.terrain import HeightField

_MANY: Final = 200_000  # soundings that are triangulated as they are
_MARGIN: Final = 0.2  # of a crop's width: soundings this far around it count


@dataclass(frozen=True)
class Extent:
    """A survey's extent on Earth, WGS 84 [deg]."""

    south: float
    north: float
    west: float
    east: float

    def __str__(self) -> str:
        lat = f"latitude {self.south:.5f} .. {self.north:.5f}"
        return f"{lat}, longitude {self.west:.5f} .. {self.east:.5f}"

    def holds(self, latitude: float, longitude: float, *, slack: float = 0.0) -> bool:
        """Whether a place lies inside, up to `slack` [deg]."""
        return (
            self.south - slack <= latitude <= self.north + slack and self.west - slack <= longitude <= self.east + slack
        )


def extent(survey: Grid | Soundings) -> Extent:
    """Extent of a survey on Earth."""
    if isinstance(survey, Grid):
        u0, u1, v0, v1 = survey.whole or (survey.u[0], survey.u[-1], survey.v[0], survey.v[-1])
        side = np.linspace(0, 1, 33)
        u = np.concatenate([u0 + side * (u1 - u0)] * 2 + [np.full(33, u0), np.full(33, u1)])
        v = np.concatenate([np.full(33, v0), np.full(33, v1)] + [v0 + side * (v1 - v0)] * 2)
    else:
        u, v = survey.u, survey.v
    lat, lon = to_latlon(survey.crs, u, v)
    if not (np.isfinite(lat).all() and np.isfinite(lon).all()):
        raise WorldError(
            f"the coordinates of the survey do not fit its coordinate system {survey.crs!r}; is it the right one?"
        )
    return Extent(float(lat.min()), float(lat.max()), float(lon.min()), float(lon.max()))


def block_means(
    survey: Soundings, origin: GeoOrigin, *, low: tuple[float, float], high: tuple[float, float], cell: float
) -> Soundings:
    """Soundings on and about a rectangle, of those that share a square `cell` wide [m] their mean: where there are many
    more than the ground will have nodes, triangles between all of them would take minutes, and show nothing more.

    Args:
        survey: the soundings; returned as they are where they are few.
        origin: of the world.
        low, high: corners of the rectangle [m].
        cell: of the squares, the ground's spacing or less [m].
    """
    if len(survey.z) <= _MANY:
        return survey
    x, y = origin.to_xy(*to_latlon(survey.crs, survey.u, survey.v))
    margin = _MARGIN * max(high[0] - low[0], high[1] - low[1])
    start = np.array(low) - margin
    count = np.ceil((np.array(high) + margin - start) / cell).astype(int)
    i, j = ((c - s) / cell for c, s in zip((x, y), start, strict=True))
    near = (i >= 0) & (i < count[0]) & (j >= 0) & (j < count[1])
    if near.sum() <= _MANY:
        return _only(survey, near)
    key = i[near].astype(np.int64) * int(count[1]) + j[near].astype(np.int64)
    filled, which, how_many = np.unique(key, return_inverse=True, return_counts=True)
    u, v, z = (
        np.bincount(which, weights=values[near], minlength=len(filled)) / how_many
        for values in (survey.u, survey.v, survey.z)
    )
    note = f"soundings are dense: the mean was taken in squares of {cell:.3g} m, {len(filled)} for {int(near.sum())}"
    return replace(survey, u=u, v=v, z=z, notes=(*survey.notes, note))


def _only(survey: Soundings, which: NDArray[np.bool_]) -> Soundings:
    return replace(survey, u=survey.u[which], v=survey.v[which], z=survey.z[which])


def sample(
    survey: Grid | Soundings, origin: GeoOrigin, x: NDArray[np.float64], y: NDArray[np.float64]
) -> NDArray[np.float64]:
    """The survey's values `(nx, ny)` at world places x `(nx,)`, y `(ny,)`; NaN where it has none.

    A grid is interpolated bilinearly between its nodes, soundings linearly on their Delaunay triangles.
    """
    if isinstance(survey, Soundings):
        return _triangulate(survey, origin, x, y)
    lat, lon = origin.to_latlon(*np.meshgrid(x, y, indexing="ij"))
    u, v = from_latlon(survey.crs, lat, lon, near=float(survey.v[len(survey.v) // 2]))
    return bilinear(survey.z, fractional(survey.u, u), fractional(survey.v, v))


def far_from_soundings(survey: Soundings, origin: GeoOrigin, ground: HeightField) -> tuple[int, float]:
    """Number of nodes far from every sounding, and the distance meant [m]: ten usual distances, or two cells."""
    tree = _near(survey, origin, ground)
    far = max(10 * _usual(tree), 2 * ground.spacing)
    nodes = np.stack(np.meshgrid(ground.x, ground.y, indexing="ij"), axis=-1).reshape(-1, 2)
    nearest, _ = tree.query(nodes, distance_upper_bound=far)
    return int(np.isinf(nearest).sum()), far


def usual_distance(survey: Soundings, origin: GeoOrigin, ground: HeightField) -> float:
    """Median distance from a sounding on or about the ground to the next [m]."""
    return _usual(_near(survey, origin, ground))


def _near(survey: Soundings, origin: GeoOrigin, ground: HeightField) -> Any:
    """A tree of the soundings on the ground and a fifth of its width around."""
    from scipy.spatial import KDTree

    x, y = origin.to_xy(*to_latlon(survey.crs, survey.u, survey.v))
    low, high = ground.bounds[0, :2], ground.bounds[1, :2]
    margin = _MARGIN * float((high - low).max())
    points = np.stack([x, y], axis=1)
    near = ((points > low - margin) & (points < high + margin)).all(axis=1)
    return KDTree(points[near], balanced_tree=False)  # see `contact.broad_phase.close_pairs`


def _usual(tree: Any) -> float:
    return float(np.median(tree.query(tree.data[:: max(1, tree.n // 2000)], k=2)[0][:, 1]))


def fill(field: NDArray[np.float64]) -> tuple[NDArray[np.float64], int]:
    """Heights with NaN replaced, and how many were: linear between the rims of a hole, the nearest value outside.

    Raises:
        WorldError: all are NaN.
    """
    holes = np.isnan(field)
    count = int(holes.sum())
    if count == 0:
        return field, 0
    if count == field.size:
        raise WorldError("the survey has no value anywhere in the crop: all of it is a hole; choose another part")
    from scipy.interpolate import LinearNDInterpolator
    from scipy.ndimage import binary_dilation, distance_transform_edt
    from scipy.spatial import QhullError

    rim = binary_dilation(holes, iterations=2) & ~holes
    points, values = np.argwhere(rim).astype(np.float64), field[rim]
    wanted = np.argwhere(holes).astype(np.float64)
    filled = np.full(count, np.nan)
    try:
        if len(points) >= 4:
            filled = LinearNDInterpolator(points, values)(wanted)
    except QhullError:
        pass  # all rims on one line: the nearest value serves
    out = field.copy()
    out[holes] = filled
    missing = np.isnan(out)
    if missing.any():  # wide margins have millions of nodes: the transform takes a thirtieth of a tree's time
        nearest = distance_transform_edt(holes, return_distances=False, return_indices=True)
        out[missing] = field[tuple(nearest[:, missing])]
    return out, count


def height_field(
    survey: Grid | Soundings, origin: GeoOrigin, *, corner: tuple[float, float], cells: tuple[int, int], spacing: float
) -> tuple[HeightField, int]:
    """A regular grid of survey values, and how many of its nodes had none and were filled.

    Raises:
        WorldError: the survey has no value anywhere on the grid.
    """
    x = corner[0] + spacing * np.arange(cells[0] + 1, dtype=np.float64)
    y = corner[1] + spacing * np.arange(cells[1] + 1, dtype=np.float64)
    filled, count = fill(sample(survey, origin, x, y))
    return HeightField(corner[0], corner[1], spacing, filled), count


def fractional(axis: NDArray[np.float64], at: NDArray[np.float64]) -> NDArray[np.float64]:
    """Fractional index on a rising axis; outside -1. A place off the edge by rounding counts as on it."""
    slack = 1e-9 * (axis[-1] - axis[0])
    index = np.interp(at, axis, np.arange(len(axis), dtype=np.float64))
    return np.where((at < axis[0] - slack) | (at > axis[-1] + slack), -1.0, index)


def _triangulate(
    survey: Soundings, origin: GeoOrigin, x_nodes: NDArray[np.float64], y_nodes: NDArray[np.float64]
) -> NDArray[np.float64]:
    x, y = origin.to_xy(*to_latlon(survey.crs, survey.u, survey.v))
    low, high = (x_nodes[0], y_nodes[0]), (x_nodes[-1], y_nodes[-1])
    margin = _MARGIN * max(high[0] - low[0], high[1] - low[1])
    near = (x > low[0] - margin) & (x < high[0] + margin) & (y > low[1] - margin) & (y < high[1] + margin)
    if near.sum() < 3:
        return np.full((len(x_nodes), len(y_nodes)), np.nan)
    points, inverse, counts = np.unique(
        np.stack([x[near], y[near]], axis=1), axis=0, return_inverse=True, return_counts=True
    )
    values = np.bincount(inverse.reshape(-1), weights=survey.z[near]) / counts  # two soundings at one place: their mean
    return gridded(points, values, x_nodes, y_nodes)

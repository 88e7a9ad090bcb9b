"""The axes of a gridded survey: which array they are, whether they make sense, and the part of them that is read."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError, did_you_mean
from pelagos.world.bathymetry.projection import from_latlon

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading

LATITUDE: Final = ("lat", "latitude", "nav_lat", "lat_rho")
LONGITUDE: Final = ("lon", "longitude", "nav_lon", "long", "lon_rho")
NORTHING: Final = ("y", "northing", "north", "projection_y_coordinate")
EASTING: Final = ("x", "easting", "east", "projection_x_coordinate")
_VALUES: Final = (
    "elevation",
    "z",
    "topo",
    "bathymetry",
    "bathy",
    "depth",
    "deptho",
    "altitude",
    "h",
    "band1",
    "topography",
)
_MARGIN: Final = 4  # nodes kept around the crop, so that interpolation and hole filling see across its edge
_MOST: Final = 40_000_000  # nodes that are read; of a larger part, every second, third, ... node in both directions


def named(variables: Any, names: Sequence[str]) -> str | None:
    """The first variable with one of these names, capitals or not."""
    return next((k for n in names for k in variables if k.lower() == n), None)


def choose(path: Path, asked: str | None, candidates: Sequence[str]) -> str:
    """The array that is meant.

    Raises:
        WorldError: it does not exist, or several could be meant.
    """
    if asked is not None:
        if asked not in candidates:
            has = ", ".join(candidates) or "none"
            raise WorldError(
                f"bathymetry file {path} has no variable {asked!r}{did_you_mean(asked, candidates)}; it has: {has}"
            )
        return asked
    known = [c for n in _VALUES for c in candidates if c.lower() == n]
    if known:
        return known[0]
    if len(candidates) == 1:
        return candidates[0]
    has = ", ".join(candidates) or "no array on two axes"
    raise WorldError(f"bathymetry file {path} holds {has}; say which one is meant: variable: NAME")


def check_axes(
    path: Path, u: NDArray[np.float64], v: NDArray[np.float64], names: tuple[str, str], *, latlon: bool
) -> None:
    """Both axes rise or fall all the way, and latitudes are such.

    Raises:
        WorldError: they do not.
    """
    for name, axis in zip(names, (u, v), strict=True):
        step = np.diff(axis)
        if len(axis) < 2 or not (np.isfinite(axis).all() and ((step > 0).all() or (step < 0).all())):
            raise WorldError(
                f"bathymetry file {path}: the axis {name!r} has fewer than 2 values, or they neither rise nor fall"
            )
    if latlon and np.abs(u).max() > 90.0001:
        likely = (
            "are latitude and longitude exchanged in the file?"
            if np.abs(u).max() <= 360
            else "if these are metres, say their coordinate system in the scenario (crs: EPSG:...)"
        )
        raise WorldError(
            f"bathymetry file {path}: {names[0]!r} runs from {u.min():g} to {u.max():g}, which no latitude does; "
            f"{likely}"
        )


def window(u: NDArray[np.float64], v: NDArray[np.float64], crs: str, how: Reading) -> tuple[slice, slice]:
    """Index ranges that cover the crop and a margin, everything where there is no crop or it lies elsewhere.

    A range of more nodes than memory is meant for has a step.
    """
    rows, columns = _crop(u, v, crs, how)
    nodes = (rows.stop - rows.start) * (columns.stop - columns.start)
    step = int(np.ceil(np.sqrt(nodes / _MOST)))
    return slice(rows.start, rows.stop, step), slice(columns.start, columns.stop, step)


def thinned(rows: slice) -> tuple[str, ...]:
    """A note on a range with a step."""
    if rows.step == 1:
        return ()
    return (f"so large a grid was thinned: one node in {rows.step} was read both ways; a smaller crop is read whole",)


def whole(u: NDArray[np.float64], v: NDArray[np.float64]) -> tuple[float, float, float, float]:
    """See `Grid.whole`."""
    return float(u.min()), float(u.max()), float(v.min()), float(v.max())


def plain(values: Any) -> NDArray[np.float64]:
    """Values with NaN where they are masked."""
    return np.ma.filled(np.ma.asarray(values).astype(np.float64), np.nan)


def _crop(u: NDArray[np.float64], v: NDArray[np.float64], crs: str, how: Reading) -> tuple[slice, slice]:
    everything = slice(0, len(u)), slice(0, len(v))
    if how.box is None or not crs:
        return everything
    south, north, west, east = how.box
    side = np.linspace(0, 1, 17)
    lat = np.concatenate([south + side * (north - south)] * 2 + [np.full(17, south), np.full(17, north)])
    lon = np.concatenate([np.full(17, west), np.full(17, east)] + [west + side * (east - west)] * 2)
    at_u, at_v = from_latlon(crs, lat, lon, near=float(v[len(v) // 2]))
    ranges = []
    for axis, values in ((u, at_u), (v, at_v)):
        inside = np.flatnonzero((axis >= values.min()) & (axis <= values.max()))
        if len(inside) == 0:
            middle = np.abs(axis - (values.min() + values.max()) / 2).argmin()
            inside = np.array([middle])
        ranges.append(slice(max(int(inside[0]) - _MARGIN, 0), min(int(inside[-1]) + _MARGIN + 1, len(axis))))
    return ranges[0], ranges[1]

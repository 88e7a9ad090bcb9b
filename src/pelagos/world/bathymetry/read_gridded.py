"""Gridded surveys: NetCDF, GeoTIFF and ESRI ASCII (through rasterio), NumPy archives."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError, did_you_mean
from pelagos.world.bathymetry.projection import HOW_TO_INSTALL, from_latlon
from pelagos.world.bathymetry.survey import Grid, Soundings, rising

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading

_LATITUDE: Final = ("lat", "latitude", "nav_lat", "lat_rho")
_LONGITUDE: Final = ("lon", "longitude", "nav_lon", "long", "lon_rho")
_NORTHING: Final = ("y", "northing", "north", "projection_y_coordinate")
_EASTING: Final = ("x", "easting", "east", "projection_x_coordinate")
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


def read_netcdf(path: Path, how: Reading) -> Grid | Soundings:
    """A variable on latitude and longitude, or on projected x and y; two-dimensional coordinates become soundings."""
    try:
        import netCDF4
    except ImportError as error:
        raise WorldError(f"bathymetry file {path} needs the package netcdf4; {HOW_TO_INSTALL}") from error
    with netCDF4.Dataset(str(path)) as data:
        variables = data.variables
        latlon = _named(variables, _LATITUDE) is not None and _named(variables, _LONGITUDE) is not None
        names = (_LATITUDE, _LONGITUDE) if latlon else (_NORTHING, _EASTING)
        u_name, v_name = _named(variables, names[0]), _named(variables, names[1])
        if u_name is None or v_name is None:
            raise WorldError(
                f"bathymetry file {path} has no coordinates named lat, lon or y, x; it has: {', '.join(variables)}"
            )
        name = _choose(
            path, how.variable, [k for k, w in variables.items() if w.ndim >= 2 and k not in (u_name, v_name)]
        )
        chosen = variables[name]
        crs = how.crs or ("EPSG:4326" if latlon else _netcdf_crs(variables, chosen))
        down = {"down": True, "up": False}.get(str(getattr(chosen, "positive", "")).lower())
        u, v = _plain(variables[u_name][:]), _plain(variables[v_name][:])
        if u.ndim == 2:
            z = _plain(chosen[:]).reshape(-1, *u.shape)[0]
            keep = np.isfinite(u) & np.isfinite(v) & np.isfinite(z)
            return Soundings(u[keep], v[keep], z[keep], crs, name, down)
        _check_axes(path, u, v, u_name, v_name, latlon)
        order = [d for d in chosen.dimensions if d in (*variables[u_name].dimensions, *variables[v_name].dimensions)]
        if sorted(order) != sorted((*variables[u_name].dimensions, *variables[v_name].dimensions)):
            raise WorldError(
                f"bathymetry file {path}: {name!r} has dimensions {chosen.dimensions}, not {u_name} and {v_name}"
            )
        iu, iv = _window(u, v, crs, how)
        pick = tuple({u_name: iu, v_name: iv}.get(_axis_of(d, variables, u_name, v_name), 0) for d in chosen.dimensions)
        z = _plain(chosen[pick])
        z = z if order[0] in variables[u_name].dimensions else z.T
        return Grid(*rising(u[iu], v[iv], z), crs, name, down, _whole(u, v))


def read_raster(path: Path, how: Reading) -> Grid:
    """Anything that GDAL reads as an upright raster of one band: GeoTIFF, ESRI ASCII, BAG."""
    try:
        import rasterio
        from rasterio.windows import Window
    except ImportError as error:
        raise WorldError(f"bathymetry file {path} needs the package rasterio; {HOW_TO_INSTALL}") from error
    with rasterio.open(path) as raster:
        t = raster.transform
        if abs(t.b) > 1e-12 or abs(t.d) > 1e-12:
            raise WorldError(f"bathymetry file {path} is a rotated raster; turn it upright first: gdalwarp IN OUT")
        crs = how.crs or (_crs_text(raster.crs) if raster.crs else "")
        v = t.c + t.a * (np.arange(raster.width) + 0.5)  # values stand for the middle of a pixel
        u = t.f + t.e * (np.arange(raster.height) + 0.5)
        if crs == "EPSG:4326":
            _check_axes(path, u, v, "y", "x", True)
        iu, iv = _window(u, v, crs, how)
        window = Window(iv.start, iu.start, iv.stop - iv.start, iu.stop - iu.start)
        band = raster.read(1, window=window, masked=True)
        return Grid(*rising(u[iu], v[iv], _plain(band)), crs, "band 1", None, _whole(u, v))


def read_npz(path: Path, how: Reading) -> Grid:
    """A NumPy archive with two axes and one array on them."""
    with path.open("rb") as file, np.load(file) as data:
        arrays = {k: data[k] for k in data.files}
    axes = {k: a for k, a in arrays.items() if a.ndim == 1}
    latlon = _named(axes, _LATITUDE) is not None and _named(axes, _LONGITUDE) is not None
    names = (_LATITUDE, _LONGITUDE) if latlon else (_NORTHING, _EASTING)
    u_name, v_name = _named(axes, names[0]), _named(axes, names[1])
    if u_name is None or v_name is None:
        raise WorldError(f"bathymetry file {path} has no axes named lat, lon or y, x; it has: {', '.join(arrays)}")
    name = _choose(path, how.variable, [k for k, a in arrays.items() if a.ndim == 2])
    u, v, z = _plain(arrays[u_name]), _plain(arrays[v_name]), _plain(arrays[name])
    if z.shape != (len(u), len(v)):
        raise WorldError(
            f"bathymetry file {path}: {name!r} is {z.shape}, but its axes {u_name}, {v_name} have {len(u)}, {len(v)}"
        )
    _check_axes(path, u, v, u_name, v_name, latlon)
    return Grid(*rising(u, v, z), how.crs or ("EPSG:4326" if latlon else ""), name)


def _named(variables: Any, names: Sequence[str]) -> str | None:
    return next((k for n in names for k in variables if k.lower() == n), None)


def _axis_of(dimension: str, variables: Any, u_name: str, v_name: str) -> str:
    for name in (u_name, v_name):
        if dimension in variables[name].dimensions:
            return name
    return ""


def _choose(path: Path, asked: str | None, candidates: Sequence[str]) -> str:
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


def _check_axes(
    path: Path, u: NDArray[np.float64], v: NDArray[np.float64], u_name: str, v_name: str, latlon: bool
) -> None:
    for name, axis in ((u_name, u), (v_name, v)):
        step = np.diff(axis)
        if len(axis) < 2 or not (np.isfinite(axis).all() and ((step > 0).all() or (step < 0).all())):
            raise WorldError(
                f"bathymetry file {path}: the axis {name!r} has fewer than 2 values, or they neither rise nor fall"
            )
    if latlon and np.abs(u).max() > 90.0001:
        raise WorldError(
            f"bathymetry file {path}: {u_name!r} runs from {u.min():g} to {u.max():g}, which no latitude does; "
            "are latitude and longitude exchanged in the file?"
        )


def _window(u: NDArray[np.float64], v: NDArray[np.float64], crs: str, how: Reading) -> tuple[slice, slice]:
    """Index ranges that cover the crop and a margin; everything where there is no crop or it lies elsewhere."""
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


def _whole(u: NDArray[np.float64], v: NDArray[np.float64]) -> tuple[float, float, float, float]:
    return float(u.min()), float(u.max()), float(v.min()), float(v.max())


def _plain(values: Any) -> NDArray[np.float64]:
    return np.ma.filled(np.ma.asarray(values).astype(np.float64), np.nan)


def _netcdf_crs(variables: Any, chosen: Any) -> str:
    mapping = variables.get(str(getattr(chosen, "grid_mapping", "")))
    for key in ("crs_wkt", "spatial_ref", "epsg_code", "proj4text"):
        text = getattr(mapping, key, None) if mapping is not None else None
        if text is not None:
            return f"EPSG:{text}" if str(text).isdigit() else str(text)
    return ""


def _crs_text(crs: Any) -> str:
    code = crs.to_epsg()
    return f"EPSG:{code}" if code else str(crs.to_wkt())

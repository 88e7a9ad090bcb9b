"""Gridded surveys and the ground of ocean models as NetCDF."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from pelagos.errors import WorldError
from pelagos.world.bathymetry.axes import (
    EASTING,
    LATITUDE,
    LONGITUDE,
    NORTHING,
    check_axes,
    choose,
    named,
    plain,
    thinned,
    whole,
    window,
)
from pelagos.world.bathymetry.projection import HOW_TO_INSTALL
from pelagos.world.bathymetry.survey import Grid, Soundings, rising

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading


def read_netcdf(path: Path, how: Reading) -> Grid | Soundings:
    """A variable on latitude and longitude, or on projected x and y.

    Coordinates are found by standard name or unit, else by name. Curved grids and the nodes of triangulated models
    become soundings.
    """
    try:
        import netCDF4
    except ImportError as error:
        raise WorldError(f"bathymetry file {path} needs the package netcdf4; {HOW_TO_INSTALL}") from error
    with netCDF4.Dataset(str(path)) as data:
        variables = data.variables
        u_name, v_name, latlon = _coordinates(path, variables, how)
        across = set(variables[u_name].dimensions) | set(variables[v_name].dimensions)
        scattered = variables[u_name].dimensions == variables[v_name].dimensions
        others = [k for k in variables if k not in (u_name, v_name)]
        fits = [k for k in others if (across <= set(variables[k].dimensions) if scattered else variables[k].ndim >= 2)]
        name = choose(path, how.variable, fits)
        chosen = variables[name]
        crs = how.crs or ("EPSG:4326" if latlon else _crs(variables, chosen))
        u, v = plain(variables[u_name][:]), plain(variables[v_name][:])
        about = _about(chosen)
        if scattered:
            last = tuple(slice(None) if d in across else 0 for d in chosen.dimensions)
            order = [d for d in chosen.dimensions if d in across]
            z = plain(chosen[last]).transpose([order.index(d) for d in variables[u_name].dimensions])
            keep = np.isfinite(u) & np.isfinite(v) & np.isfinite(z)
            return Soundings(u[keep], v[keep], z[keep], crs, name, *about)
        check_axes(path, u, v, (u_name, v_name), latlon=latlon)
        order = [d for d in chosen.dimensions if d in across]
        if len(order) != 2 or sorted(order) != sorted(across):
            raise WorldError(
                f"bathymetry file {path}: {name!r} has dimensions {chosen.dimensions}, not {u_name} and {v_name}"
            )
        rows, columns = window(u, v, crs, how)
        upright = order[0] in variables[u_name].dimensions
        part = dict(zip(order, (rows, columns) if upright else (columns, rows), strict=True))
        z = plain(chosen[tuple(part.get(d, 0) for d in chosen.dimensions)])
        down, unit, words = about
        grid = rising(u[rows], v[columns], z if upright else z.T)
        return Grid(*grid, crs, name, down, whole(u, v), unit, words, thinned(rows))


def _coordinates(path: Path, variables: Any, how: Reading) -> tuple[str, str, bool]:
    """The variables with northing (or latitude) and easting (or longitude), and whether these are degrees."""
    said = [_said(variables, kind) for kind in ("latitude", "longitude")]
    by_name = [named(variables, LATITUDE), named(variables, LONGITUDE)]
    u, v = (a if a is not None else b for a, b in zip(by_name, said, strict=True))
    if u is not None and v is not None:
        return u, v, True
    u, v = named(variables, NORTHING), named(variables, EASTING)
    if u is not None and v is not None:
        return u, v, False
    for name, w in variables.items():  # unnamed: rows are north, as is usual
        asked = how.variable in (None, name) and w.ndim >= 2
        if asked and all(d in variables and variables[d].ndim == 1 for d in w.dimensions[-2:]):
            return w.dimensions[-2], w.dimensions[-1], False
    raise WorldError(
        f"bathymetry file {path} has no coordinates named lat, lon or y, x; it has: {', '.join(variables) or 'nothing'}"
    )


def _said(variables: Any, kind: str) -> str | None:
    """A variable that says itself, by standard name or unit, that it is latitude or longitude."""
    unit = {"latitude": "degrees_north", "longitude": "degrees_east"}[kind]
    for name, w in variables.items():
        standard = str(getattr(w, "standard_name", "")).lower()
        if standard == kind or (not standard and str(getattr(w, "units", "")).lower() == unit):
            return str(name)
    return None


def _about(chosen: Any) -> tuple[bool | None, str, str]:
    """Description of a variable: its sign, its unit, and in words."""
    down = {"down": True, "up": False}.get(str(getattr(chosen, "positive", "")).lower())
    words = " ".join(str(getattr(chosen, k, "")) for k in ("standard_name", "long_name"))
    return down, str(getattr(chosen, "units", "")), words


def _crs(variables: Any, chosen: Any) -> str:
    mapping = variables.get(str(getattr(chosen, "grid_mapping", "")).split(":")[0], variables.get("crs"))
    for key in ("crs_wkt", "spatial_ref", "epsg_code", "proj4text"):
        text = getattr(mapping, key, None) if mapping is not None else None
        if text is not None:
            return f"EPSG:{text}" if str(text).isdigit() else str(text)
    return ""

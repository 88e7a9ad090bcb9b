"""Reads fields of the ocean from NetCDF: CF conventions, and the names that CMEMS, HYCOM and ROMS use. Host only.

Coordinates are recognised by standard name, axis, units or name; variables by standard name or name. Only what the
world needs is read: a window around it, and the time asked for.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import ScenarioError, did_you_mean
from pelagos.ocean.curvilinear import is_curvilinear, on_regular_grid
from pelagos.ocean.grid_data import GriddedData, Windows
from pelagos.ocean.netcdf_variable import (
    METRES,
    cell_of,
    check_times,
    depths_of,
    find_variable,
    in_our_units,
    seconds_of,
    without_gaps,
)

_AXES: Final = {
    "time": (("time",), "T", ("time", "ocean_time", "time_counter", "mt")),
    "depth": (("depth", "height", "altitude"), "Z", ("depth", "deptht", "depthu", "lev", "level", "z", "z_rho")),
    "latitude": (("latitude", "projection_y_coordinate"), "Y", ("latitude", "lat", "nav_lat", "lat_rho", "y")),
    "longitude": (("longitude", "projection_x_coordinate"), "X", ("longitude", "lon", "nav_lon", "lon_rho", "x")),
}
_POTENTIAL: Final = "sea_water_potential_temperature"
_BIGGEST: Final = 60_000_000  # values of one variable


def read_grid(
    path: Path, quantities: list[tuple[str, str | None]], *, start: str | None, windows: Windows
) -> GriddedData:
    """Read variables that share a grid.

    Args:
        path: the file.
        quantities: (key of `netcdf_variable.QUANTITIES` or a label, name in the file or None to find it).
        start: ISO time that is t = 0 of the simulation; the file's first time where None.
        windows: what to read.

    Raises:
        ScenarioError: the file, a variable or a coordinate is missing or cannot be understood.
    """
    try:
        import netCDF4  # noqa: F401 (what xarray reads with)
        import xarray
    except ImportError as error:
        raise ScenarioError("gridded fields need the extra 'bathymetry': pip install pelagos[bathymetry]") from error
    if path.is_dir():
        raise ScenarioError(f"{path} is a folder, not a NetCDF file")
    if not path.is_file():
        near = did_you_mean(path.name, [p.name for p in path.parent.glob("*")]) if path.parent.is_dir() else ""
        raise ScenarioError(f"there is no file {path}{near}")
    if not _looks_like_netcdf(path):
        raise ScenarioError(f"{path} is not a NetCDF file: it does not begin as one")
    try:
        with xarray.open_dataset(path, decode_times=False) as raw:
            check_times(raw, path)
            data = xarray.decode_cf(raw, decode_timedelta=False)
            return _read(data, path, quantities, start, windows)
    except (OSError, ValueError, RuntimeError, EOFError) as error:
        raise ScenarioError(f"{path} cannot be read, it is damaged or cut short ({error})") from error


def _looks_like_netcdf(path: Path) -> bool:
    """HDF5 (NetCDF 4) or classic."""
    with path.open("rb") as file:
        return file.read(8).startswith((b"\x89HDF\r\n", b"CDF"))


def _read(data: Any, path: Path, quantities: Any, start: str | None, windows: Windows) -> GriddedData:
    variables = [find_variable(data, path, label, name) for label, name in quantities]
    axes = {axis: _axis(data, variables[0], axis) for axis in _AXES}
    if _backwards(data, axes["time"]):
        data = data.isel({axes["time"]: slice(None, None, -1)})
        variables = [data[v.name] for v in variables]
    first = variables[0]
    if is_curvilinear(data, first):
        times = seconds_of(data, path, axes["time"], start)
        if np.any(np.diff(times) <= 0):
            raise ScenarioError(f"{path}: the coordinate of time does not increase from entry to entry")
        named = [(label, v) for (label, _), v in zip(quantities, variables, strict=True)]
        return on_regular_grid(data, path, named, times, axes["time"], windows)
    known = [d for d in axes.values() if d is not None]
    unknown = [d for d in first.dims if d not in known]
    if unknown:
        raise ScenarioError(
            f"{path}: cannot tell what the dimension {unknown[0]!r} of {first.name!r} is; expected time, depth, "
            "latitude and longitude"
        )
    for axis in ("latitude", "longitude"):
        if axes[axis] is None:
            raise ScenarioError(
                f"{path}: {first.name!r} has no coordinate of {axis} (dimensions: {', '.join(first.dims)})"
            )
    row, column = (_coordinate(data, path, str(axes[a])) for a in ("latitude", "longitude"))
    units = str(data[axes["latitude"]].attrs.get("units", "")).lower()
    metric = units in METRES
    if not units and not str(axes["latitude"]).lower().startswith(("lat", "nav_lat")):
        raise ScenarioError(f"{path}: the coordinate {axes['latitude']!r} has no units; known: degrees_north, m")
    if not metric:
        column, eastwards = around(column, windows.longitude)
        if eastwards is not None:
            variables = [v.isel({axes["longitude"]: eastwards}) for v in variables]
    covers = (float(row.min()), float(row.max()), float(column.min()), float(column.max()))
    window = windows.metres if metric else windows.degrees
    rows, columns = _window(row, window, 0), _window(column, window, 2)
    times = seconds_of(data, path, axes["time"], start)
    depth = depths_of(data, path, axes["depth"])
    size = len(times) * len(depth) * (rows.stop - rows.start) * (columns.stop - columns.start)
    _check_size(path, size)
    picked = {axes["latitude"]: rows, axes["longitude"]: columns}
    order = [axes[a] for a in ("time", "depth", "latitude", "longitude")]
    cell = cell_of(row[rows], column[columns], metric=metric)
    blocks = [_values(v, label, path, picked, order, cell) for (label, _), v in zip(quantities, variables, strict=True)]
    values, filled = np.stack([b for b, _ in blocks]), max(gaps for _, gaps in blocks)
    nodes: list[NDArray[np.float64]] = [times, depth, row[rows], column[columns]]
    for k, (name, line) in enumerate(zip(_AXES, tuple(nodes), strict=True)):
        if k > 0 and len(line) > 1 and line[0] > line[-1]:
            nodes[k], values = line[::-1], np.flip(values, k + 1)
        if not np.all(np.isfinite(line)) or np.any(np.diff(nodes[k]) <= 0):
            raise ScenarioError(f"{path}: the coordinate of {name} does not increase from entry to entry")
    t, z, y, x = nodes
    if not metric:
        for k, variable in enumerate(variables):
            if variable.attrs.get("standard_name") == _POTENTIAL:
                values[k] = in_situ_temperature(values[k], z, y)
    return GriddedData(np.ascontiguousarray(values), t, z, y, x, metric, filled, covers)


def _check_size(path: Path, size: int) -> None:
    if size > _BIGGEST:
        raise ScenarioError(
            f"{path}: {size / 1e6:.0f} million values of each variable fall into the world; cut the file, at most "
            f"{_BIGGEST / 1e6:.0f} million"
        )


def _backwards(data: Any, dimension: str | None) -> bool:
    """True where the entries of a dimension's coordinate fall."""
    if dimension not in data.coords or data[dimension].ndim != 1 or data[dimension].size < 2:
        return False
    values = data[dimension].values
    return bool(np.all(values[1:] < values[:-1]))


def around(column: NDArray[np.float64], longitude: float) -> tuple[NDArray[np.float64], NDArray[np.int64] | None]:
    """Longitudes within 180 degrees of a place, and the order in which a file's own then increase; None: as they are.

    A grid from 0 to 360 is cut on the far side of the earth, not at Greenwich; a meridian that stands twice is read
    once.
    """
    if np.abs(column - longitude).max() < 180.0:
        return column, None
    near = longitude + (column - longitude + 180.0) % 360.0 - 180.0
    steps = np.diff(near)
    if (steps > 0).all() or (steps < 0).all():
        return near, None
    kept, order = np.unique(near, return_index=True)
    return kept, order


def in_situ_temperature(
    potential: NDArray[np.float64], depth: NDArray[np.float64], latitude: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Temperature [degC] of potential temperature about the surface `(times, depths, rows, columns)` [degC] (TEOS-10).

    Depths [m] and latitudes [deg] are the axes'. For standard sea water of 35.16504 g/kg: other salinities of the ocean
    change what pressure adds, 0.1 degC a kilometre, by less than 1 %.
    """
    import gsw

    pressure = gsw.p_from_z(-depth[:, None], latitude[None, :])[None, :, :, None]
    standard = 35.16504
    found: NDArray[np.float64] = gsw.t_from_CT(standard, gsw.CT_from_pt(standard, potential), pressure)
    return found


def _values(
    variable: Any, label: str, path: Path, picked: dict[Any, slice], order: list[str | None], cell: tuple[float, float]
) -> tuple[NDArray[np.float64], float]:
    """A variable in the window, `(times, depths, rows, columns)` in our units, and the share of it that was open."""
    block = variable.isel(picked).transpose(*[d for d in order if d is not None])
    values = np.array(block.values, dtype=np.float64)
    for position, dimension in enumerate(order):
        if dimension is None:
            values = np.expand_dims(values, position)
    values = in_our_units(values, label, variable, path)
    missing = ~np.isfinite(values)
    if missing.all():
        raise ScenarioError(f"{path}: {variable.name!r} has no value in the world's window")
    return without_gaps(values, missing, zero=label in ("east", "north", "up"), cell=cell), float(missing.mean())


def _axis(data: Any, variable: Any, axis: str) -> str | None:
    standard, letter, names = _AXES[axis]
    for dimension in variable.dims:
        attributes = data[dimension].attrs if dimension in data.coords else {}
        if attributes.get("standard_name") in standard or attributes.get("axis") == letter:
            return str(dimension)
    for dimension in variable.dims:
        if str(dimension).lower() in names:
            return str(dimension)
    return None


def _coordinate(data: Any, path: Path, dimension: str) -> NDArray[np.float64]:
    if dimension not in data.coords:
        raise ScenarioError(f"{path}: the dimension {dimension!r} has no coordinate values")
    values = np.asarray(data[dimension].values, dtype=np.float64)
    if len(values) < 2:
        raise ScenarioError(f"{path}: the coordinate {dimension!r} has {len(values)} entries; at least two are needed")
    return values


def _window(nodes: NDArray[np.float64], window: tuple[float, ...] | None, first: int) -> slice:
    """The entries that cover the window, and two more on each side."""
    if window is None:
        return slice(0, len(nodes))
    inside = np.nonzero((nodes >= window[first]) & (nodes <= window[first + 1]))[0]
    if len(inside) == 0:
        middle = int(np.argmin(np.abs(nodes - 0.5 * (window[first] + window[first + 1]))))
        inside = np.array([middle])
    low, high = max(int(inside[0]) - 2, 0), min(int(inside[-1]) + 3, len(nodes))
    return slice(low, high)

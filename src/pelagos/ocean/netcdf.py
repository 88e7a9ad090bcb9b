"""Reads fields of the ocean from NetCDF: CF conventions, and the names that CMEMS, HYCOM and ROMS use. Host only.

Coordinates are recognised by standard name, axis, units or name; variables by standard name or name. Only what the
world needs is read: a window around it, and the time asked for.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import ScenarioError, did_you_mean

QUANTITIES: Final[dict[str, tuple[tuple[str, ...], tuple[str, ...]]]] = {
    "east": (("eastward_sea_water_velocity", "sea_water_x_velocity"), ("uo", "water_u", "u_eastward", "u", "ucur")),
    "north": (("northward_sea_water_velocity", "sea_water_y_velocity"), ("vo", "water_v", "v_northward", "v", "vcur")),
    "up": (("upward_sea_water_velocity",), ("wo", "water_w", "w")),
    "temperature": (
        ("sea_water_temperature", "sea_water_potential_temperature", "sea_surface_temperature"),
        ("thetao", "water_temp", "temp", "temperature", "t"),
    ),
    "salinity": (("sea_water_practical_salinity", "sea_water_salinity"), ("so", "salinity", "salt", "s")),
    "oxygen": (("mole_concentration_of_dissolved_molecular_oxygen_in_sea_water",), ("o2", "oxygen")),
    "chlorophyll": (("mass_concentration_of_chlorophyll_a_in_sea_water",), ("chl", "chlorophyll")),
}
"""Standard names and usual names of what we know."""

_VELOCITY: Final = {
    "m s-1": 1.0,
    "m/s": 1.0,
    "m.s-1": 1.0,
    "meter second-1": 1.0,
    "m s^-1": 1.0,
    "cm/s": 0.01,
    "cm s-1": 0.01,
}
_TEMPERATURE: Final = ("degc", "degree_c", "degrees_c", "celsius", "deg_c", "degree_celsius", "degrees_celsius", "°c")
_AXES: Final = {
    "time": (("time",), "T", ("time", "ocean_time", "time_counter", "mt")),
    "depth": (("depth", "height", "altitude"), "Z", ("depth", "deptht", "depthu", "lev", "level", "z", "z_rho")),
    "latitude": (("latitude", "projection_y_coordinate"), "Y", ("latitude", "lat", "nav_lat", "lat_rho", "y")),
    "longitude": (("longitude", "projection_x_coordinate"), "X", ("longitude", "lon", "nav_lon", "lon_rho", "x")),
}
_BIGGEST: Final = 60_000_000  # values of one variable


@dataclass(frozen=True)
class GriddedData:
    """Variables on a grid; axes that the file lacks have one entry.

    Attributes:
        values: `(channels, times, depths, rows, columns)`, no gaps.
        time: `(times,)` seconds since the start.
        depth: `(depths,)` downwards [m], increasing.
        row, column: latitude and longitude [deg], or metres north and east of the world's origin where `metric`.
        metric: the file's horizontal coordinates are metres.
        filled: share of the values that the file leaves open.
        covers: lowest and highest row, lowest and highest column of the whole file.
    """

    values: NDArray[np.float64]
    time: NDArray[np.float64]
    depth: NDArray[np.float64]
    row: NDArray[np.float64]
    column: NDArray[np.float64]
    metric: bool
    filled: float
    covers: tuple[float, float, float, float]


@dataclass(frozen=True)
class Windows:
    """What to read: lowest row, highest row, lowest column, highest column, for grids in degrees and in metres; and the
    longitude near which degrees are counted.
    """

    longitude: float
    degrees: tuple[float, float, float, float] | None
    metres: tuple[float, float, float, float] | None


def read_grid(
    path: Path, quantities: list[tuple[str, str | None]], *, start: str | None, windows: Windows
) -> GriddedData:
    """Read variables that share a grid.

    Args:
        path: the file.
        quantities: (key of `QUANTITIES` or a label, name of the variable in the file or None to find it).
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
    if not path.is_file():
        near = did_you_mean(path.name, [p.name for p in path.parent.glob("*")]) if path.parent.is_dir() else ""
        raise ScenarioError(f"there is no file {path}{near}")
    try:
        with xarray.open_dataset(path, decode_timedelta=False, use_cftime=None) as data:
            return _read(data, path, quantities, start, windows)
    except (OSError, ValueError, RuntimeError) as error:
        raise ScenarioError(f"{path} cannot be read: {error}") from error


def _read(data: Any, path: Path, quantities: Any, start: str | None, windows: Windows) -> GriddedData:
    variables = [_find(data, path, label, name) for label, name in quantities]
    first = variables[0]
    axes = {axis: _axis(data, first, axis) for axis in _AXES}
    known = [d for d in axes.values() if d is not None]
    unknown = [d for d in first.dims if d not in known]
    if unknown:
        raise ScenarioError(
            f"{path}: cannot tell what the dimension {unknown[0]!r} of {first.name!r} is; expected time, depth, "
            "latitude and longitude, each with a coordinate of one dimension (interpolate sigma and curvilinear grids)"
        )
    for axis in ("latitude", "longitude"):
        if axes[axis] is None:
            raise ScenarioError(
                f"{path}: {first.name!r} has no coordinate of {axis} (dimensions: {', '.join(first.dims)})"
            )
    row, column = (_coordinate(data, path, str(axes[a])) for a in ("latitude", "longitude"))
    metric = str(data[axes["latitude"]].attrs.get("units", "")).lower() in ("m", "metre", "meter", "metres", "meters")
    if not metric:
        column = column - 360.0 * round((float(column.mean()) - windows.longitude) / 360.0)
    covers = (float(row.min()), float(row.max()), float(column.min()), float(column.max()))
    window = windows.metres if metric else windows.degrees
    rows, columns = _window(row, window, 0), _window(column, window, 2)
    times = _times(data, path, axes["time"], start)
    depth = _depths(data, path, axes["depth"])
    size = len(times) * len(depth) * (rows.stop - rows.start) * (columns.stop - columns.start)
    if size > _BIGGEST:
        raise ScenarioError(
            f"{path}: {size / 1e6:.0f} million values of each variable fall into the world; cut the file, at most "
            f"{_BIGGEST / 1e6:.0f} million"
        )
    picked = {axes["latitude"]: rows, axes["longitude"]: columns}
    order = [axes[a] for a in ("time", "depth", "latitude", "longitude")]
    blocks = [_values(v, label, path, picked, order) for (label, _), v in zip(quantities, variables, strict=True)]
    values, filled = np.stack([b for b, _ in blocks]), max(gaps for _, gaps in blocks)
    nodes: list[NDArray[np.float64]] = [times, depth, row[rows], column[columns]]
    for k, (name, line) in enumerate(zip(_AXES, tuple(nodes), strict=True)):
        if k > 0 and len(line) > 1 and line[0] > line[-1]:
            nodes[k], values = line[::-1], np.flip(values, k + 1)
        if not np.all(np.isfinite(line)) or np.any(np.diff(nodes[k]) <= 0):
            raise ScenarioError(f"{path}: the coordinate of {name} does not increase from entry to entry")
    t, z, y, x = nodes
    return GriddedData(np.ascontiguousarray(values), t, z, y, x, metric, filled, covers)


def _values(
    variable: Any, label: str, path: Path, picked: dict[Any, slice], order: list[str | None]
) -> tuple[NDArray[np.float64], float]:
    """A variable in the window, `(times, depths, rows, columns)` in our units, and the share of it that was open."""
    block = variable.isel(picked).transpose(*[d for d in order if d is not None])
    values = np.array(block.values, dtype=np.float64)
    for position, dimension in enumerate(order):
        if dimension is None:
            values = np.expand_dims(values, position)
    values = _scale(values, label, variable, path)
    missing = ~np.isfinite(values)
    if missing.all():
        raise ScenarioError(f"{path}: {variable.name!r} has no value in the world's window")
    return _fill(values, missing, zero=label in ("east", "north", "up")), float(missing.mean())


def _find(data: Any, path: Path, label: str, name: str | None) -> Any:
    if name is not None:
        if name not in data.data_vars:
            names = [str(v) for v in data.data_vars]
            raise ScenarioError(
                f"{path} has no variable {name!r}{did_you_mean(name, names)}; it has {', '.join(names)}"
            )
        return data[name]
    standard, usual = QUANTITIES.get(label, ((), (label,)))
    for variable in data.data_vars.values():
        if variable.attrs.get("standard_name") in standard:
            return variable
    lower = {str(v).lower(): v for v in data.data_vars}
    for candidate in usual:
        if candidate in lower:
            return data[lower[candidate]]
    has = ", ".join(str(v) for v in data.data_vars) or "nothing"
    raise ScenarioError(f"{path}: no variable looks like {label!r}; name it in the scenario. The file has {has}")


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


def _times(data: Any, path: Path, dimension: str | None, start: str | None) -> NDArray[np.float64]:
    if dimension is None:
        return np.zeros(1)
    if dimension not in data.coords:
        raise ScenarioError(f"{path}: the dimension {dimension!r} has no coordinate values")
    values = data[dimension].values
    if not np.issubdtype(values.dtype, np.datetime64):
        calendar = getattr(values.flat[0], "calendar", None)
        what = f"its calendar is {calendar!r}" if calendar else "it has no units like 'hours since 2020-01-01'"
        raise ScenarioError(
            f"{path}: the times of {dimension!r} cannot be used: {what}; needed is the standard calendar"
        )
    try:
        origin = values[0] if start is None else np.datetime64(start.replace("Z", ""), "ns")
    except ValueError as error:
        raise ScenarioError(f"start {start!r} is not an ISO time such as 2024-05-01T12:00:00") from error
    seconds: NDArray[np.float64] = (values - origin) / np.timedelta64(1, "ns") * 1e-9
    if len(seconds) > 1 and not seconds[0] <= 0 <= seconds[-1]:
        raise ScenarioError(f"{path} covers {values[0]} to {values[-1]}, and start {start} lies outside")
    return seconds


def _depths(data: Any, path: Path, dimension: str | None) -> NDArray[np.float64]:
    if dimension is None:
        return np.zeros(1)
    if dimension not in data.coords:
        raise ScenarioError(
            f"{path}: the dimension {dimension!r} has no coordinate values; depths in metres are needed"
        )
    coordinate = data[dimension]
    units = str(coordinate.attrs.get("units", "m")).lower()
    if units not in ("m", "metre", "meter", "metres", "meters"):
        raise ScenarioError(f"{path}: depths of {dimension!r} must be in metres, not {units!r}")
    values = np.asarray(coordinate.values, dtype=np.float64)
    upwards = coordinate.attrs.get("positive", "down") == "up" or (values.max() <= 0 and values.min() < 0)
    return -values if upwards else values


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


def _scale(values: NDArray[np.float64], label: str, variable: Any, path: Path) -> NDArray[np.float64]:
    """To m/s and degC by the variable's units, which velocities and temperatures must have."""
    units = variable.attrs.get("units")
    if label not in ("east", "north", "up", "temperature"):
        return values
    if units is None:
        raise ScenarioError(
            f"{path}: the variable {variable.name!r} has no units; write them into the file (CF: units)"
        )
    text = str(units).strip().lower()
    if label == "temperature":
        if text in ("k", "kelvin", "degk", "degrees_k"):
            return values - 273.15
        if text in _TEMPERATURE:
            return values
    elif text in _VELOCITY:
        return values * _VELOCITY[text]
    expected = "degC or K" if label == "temperature" else "m s-1"
    raise ScenarioError(f"{path}: cannot read the units {units!r} of {variable.name!r}; known: {expected}")


def _fill(values: NDArray[np.float64], missing: NDArray[np.bool_], *, zero: bool) -> NDArray[np.float64]:
    """Land and gaps: still water for velocities; for the rest the nearest value of the level, else of the level
    above.
    """
    if not missing.any():
        return values
    if zero:
        return np.where(missing, 0.0, values)
    from scipy.ndimage import distance_transform_edt

    out = values.copy()
    for t in range(out.shape[0]):
        for k in range(out.shape[1]):
            gap = missing[t, k]
            if gap.all():
                out[t, k] = out[t, k - 1] if k > 0 else np.nan
            elif gap.any():
                i, j = distance_transform_edt(gap, return_distances=False, return_indices=True)
                out[t, k] = out[t, k][i, j]
    open_ = ~np.isfinite(out)
    return np.where(open_, float(np.nanmean(out)), out) if open_.any() else out

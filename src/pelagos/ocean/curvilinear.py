"""Fields on curved horizontal grids and on levels that follow the ground, as ROMS and NEMO write them, put on a regular
grid of latitude, longitude and depth. Host only, once.

Horizontally linear in Delaunay triangles of the file's points, vertically linear between the levels of each water
column; velocities along a turned grid are turned to east and north. The regular grid is as fine as the file's own, so a
linear field stays exact and others lose what linear interpolation loses. Levels: A. F. Shchepetkin and J. C.
McWilliams, Ocean Modelling 9:347 (2005), doi 10.1016/j.ocemod.2004.08.002; CF conventions 1.11, Appendix D.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import ScenarioError
from pelagos.ocean.grid_data import GriddedData, Windows
from pelagos.ocean.netcdf_variable import cell_of, depths_of, in_our_units, without_gaps

Values = NDArray[np.float64]

_LEVELS: Final = ("s_rho", "s_w", "sigma", "sc_r")
_TRUE_EAST: Final = ("eastward_sea_water_velocity", "northward_sea_water_velocity")
_GRID_EAST: Final = ("sea_water_x_velocity", "sea_water_y_velocity")
_UPRIGHT_DEG: Final = 0.5  # turn of a grid that needs no angle: 1 % of the speed goes across
_MOST: Final = 400  # rows or columns of the regular grid


@dataclass(frozen=True)
class Plane:
    """From a file's points to those of a regular grid.

    Attributes:
        corners, shares: `(rows, columns, 3)`: points of the file and their weights.
        rows, columns: slices of the file's two horizontal dimensions that the points are in.
    """

    corners: NDArray[np.int64]
    shares: Values
    rows: slice
    columns: slice

    def of(self, values: Values) -> Values:
        """`(..., file's rows, file's columns)` to `(..., rows, columns)`; not a number beside land."""
        flat = values.reshape(*values.shape[:-2], -1)
        return np.asarray(np.sum(flat[..., self.corners] * self.shares, axis=-1))


def is_curvilinear(data: Any, variable: Any) -> bool:
    """Whether a variable's place needs two-dimensional coordinates, or its depth a formula."""
    return _level(variable) is not None or _places(data, variable) is not None


def on_regular_grid(
    data: Any, path: Path, quantities: Sequence[tuple[str, Any]], times: Values, time: str | None, windows: Windows
) -> GriddedData:
    """Variables on a regular grid of latitude, longitude and depth.

    Args:
        data: the open file.
        path: its name, for messages.
        quantities: (label, variable), all on levels of one kind.
        times: of the file, seconds since the start.
        time: name of the time's dimension.
        windows: what to read.

    Raises:
        ScenarioError: something that the places or the levels need is missing.
    """
    planes: list[Plane] = []
    quantities = [(label, _in_order(data, variable, time)) for label, variable in quantities]
    first = quantities[0][1]
    row, column = _regular(data, path, first, windows)
    found = {label: _plane(data, path, v, row, column, windows) for label, v in quantities}
    low, high, left, right = _inside([p.shares for p in found.values()])
    row, column = row[low:high], column[left:right]
    if len(row) < 2 or len(column) < 2:
        raise ScenarioError(f"{path}: the grid of {first.name!r} has no points about the world")
    planes = [
        Plane(p.corners[low:high, left:right], p.shares[low:high, left:right], p.rows, p.columns)
        for p in found.values()
    ]
    level = _level(first)
    blocks = [
        plane.of(_block(variable, time, level, plane, path, label))
        for (label, variable), plane in zip(quantities, planes, strict=True)
    ]  # each (times, levels, rows, columns)
    blocks = _turned(data, path, quantities, blocks, row, column, windows)
    if level is None:
        depth = _depths(data, path, first, time)
        if len(depth) > 1 and depth[0] > depth[-1]:
            depth, blocks = depth[::-1], [block[:, ::-1] for block in blocks]
    else:
        z = _heights(data, path, level, time, row, column, windows)  # (times or 1, levels, rows, columns)
        depth = _even_levels(z)
        blocks = [_at_depths(block, z, depth) for block in blocks]
    missing = [~np.isfinite(block) for block in blocks]
    for gaps, (_, variable) in zip(missing, quantities, strict=True):
        if gaps.all():
            raise ScenarioError(f"{path}: {variable.name!r} has no value in the world's window")
    values = np.stack([
        without_gaps(block, gaps, zero=label in ("east", "north", "up"), cell=cell_of(row, column, metric=False))
        for block, gaps, (label, _) in zip(blocks, missing, quantities, strict=True)
    ])  # fmt: skip
    covers = (float(row[0]), float(row[-1]), float(column[0]), float(column[-1]))
    return GriddedData(values, times, depth, row, column, False, max(float(m.mean()) for m in missing), covers)


def _level(variable: Any) -> str | None:
    return next((str(d) for d in variable.dims if str(d) in _LEVELS), None)


def _places(data: Any, variable: Any) -> tuple[Any, Any] | None:
    """Latitude and longitude `(rows, columns)` of a variable's points; None where they are not two-dimensional."""
    found: dict[str, Any] = {}
    for name, coordinate in {**data.data_vars, **data.coords}.items():
        if coordinate.ndim != 2 or not set(coordinate.dims) <= set(variable.dims):
            continue
        if found and set(coordinate.dims) != set(next(iter(found.values())).dims):
            continue
        units = str(coordinate.attrs.get("units", "")).lower().replace("s_", "_")
        standard = coordinate.attrs.get("standard_name")
        for kind, unit in (("latitude", "degree_north"), ("longitude", "degree_east")):
            if standard == kind or units == unit or str(name).lower() in (kind, kind[:3], f"nav_{kind[:3]}"):
                found.setdefault(kind, coordinate)
    if len(found) < 2:
        return None
    return found["latitude"], found["longitude"].transpose(*found["latitude"].dims)


def _in_order(data: Any, variable: Any, time: str | None = None) -> Any:
    """A variable as `(time, ..., rows, columns)`, whatever order the file has: rows and columns as their places are."""
    places = _places(data, variable)
    plane = variable.dims[-2:] if places is None else places[0].dims
    first = [time] if time in variable.dims else []
    return variable.transpose(*first, ..., *plane)


def _degrees(data: Any, path: Path, variable: Any, windows: Windows) -> tuple[Values, Values]:
    places = _places(data, variable)
    if places is None:
        plane = ", ".join(map(str, variable.dims[-2:]))
        raise ScenarioError(
            f"{path}: {variable.name!r} has no latitude and longitude over ({plane}); ROMS calls them lat_rho, lon_rho"
        )
    lat, lon = (np.asarray(p.values, dtype=np.float64) for p in places)
    if not (np.isfinite(lat).all() and np.isfinite(lon).all()):
        raise ScenarioError(f"{path}: {places[0].name!r} or {places[1].name!r} has gaps")
    return lat, windows.longitude + (lon - windows.longitude + 180.0) % 360.0 - 180.0


def _regular(data: Any, path: Path, variable: Any, windows: Windows) -> tuple[Values, Values]:
    """Rows and columns as fine as the file's own points, over the window."""
    lat, lon = _degrees(data, path, variable, windows)
    scale = np.cos(np.radians(lat.mean()))
    steps = [np.hypot(np.diff(lat, axis=a), scale * np.diff(lon, axis=a)) for a in (0, 1)]
    step = float(min(np.median(s) for s in steps))
    if not step > 0:
        raise ScenarioError(f"{path}: the points of {variable.name!r} coincide")
    low, high, left, right = windows.degrees or (lat.min(), lat.max(), lon.min(), lon.max())
    low, high = max(low - 2 * step, lat.min()), min(high + 2 * step, lat.max())
    left, right = max(left - 2 * step / scale, lon.min()), min(right + 2 * step / scale, lon.max())
    rows = int(np.clip(np.ceil((high - low) / step) + 1, 2, _MOST))
    columns = int(np.clip(np.ceil((right - left) * scale / step) + 1, 2, _MOST))
    if not (high > low and right > left):
        raise ScenarioError(
            f"{path} covers latitude {lat.min():.4f} to {lat.max():.4f} and longitude {lon.min():.4f} to "
            f"{lon.max():.4f}: the world is not there"
        )
    return np.linspace(low, high, rows), np.linspace(left, right, columns)


def _plane(data: Any, path: Path, variable: Any, row: Values, column: Values, windows: Windows) -> Plane:
    from scipy.spatial import Delaunay

    lat, lon = _degrees(data, path, variable, windows)
    room = 3 * max(float(np.ptp(row)) / len(row), float(np.ptp(column)) / len(column))
    near = (np.abs(lat - row.mean()) <= np.ptp(row) / 2 + room) & (
        np.abs(lon - column.mean()) <= np.ptp(column) / 2 + room
    )
    rows, columns = (_span(near.any(axis=a)) for a in (1, 0))
    scale = np.cos(np.radians(row.mean()))
    points = np.stack([lat[rows, columns].ravel(), scale * lon[rows, columns].ravel()], axis=-1)
    points -= points.mean(axis=0)
    offset = np.array([lat[rows, columns].mean(), scale * lon[rows, columns].mean()])
    triangles = Delaunay(points)
    y, x = np.meshgrid(row, scale * column, indexing="ij")
    goal = np.stack([y.ravel(), x.ravel()], axis=-1) - offset
    index = triangles.find_simplex(goal, tol=1e-9)
    affine = triangles.transform[index]
    two = np.einsum("kij,kj->ki", affine[:, :2], goal - affine[:, 2])
    shares = np.concatenate([two, 1 - two.sum(axis=1, keepdims=True)], axis=1)
    shares[index < 0] = np.nan
    shape = (len(row), len(column), 3)
    return Plane(triangles.simplices[index].reshape(shape).astype(np.int64), shares.reshape(shape), rows, columns)


def _span(near: NDArray[np.bool_]) -> slice:
    inside = np.nonzero(near)[0]
    return slice(0, len(near)) if len(inside) == 0 else slice(max(int(inside[0]) - 1, 0), int(inside[-1]) + 2)


def _inside(shares: Sequence[Values]) -> tuple[int, int, int, int]:
    """A large rectangle of rows and columns that all planes cover: edges with most points outside are cut off first."""
    outside = np.any([~np.isfinite(s[..., 0]) for s in shares], axis=0)
    low, high, left, right = 0, outside.shape[0], 0, outside.shape[1]
    while high > low and right > left and outside[low:high, left:right].any():
        box = outside[low:high, left:right]
        edges = [box[0].mean(), box[-1].mean(), box[:, 0].mean(), box[:, -1].mean()]
        worst = int(np.argmax(edges))
        low, high = low + (worst == 0), high - (worst == 1)
        left, right = left + (worst == 2), right - (worst == 3)
    return low, high, left, right


def _block(variable: Any, time: str | None, level: str | None, plane: Plane, path: Path, label: str) -> Values:
    """`(times, levels, file's rows, file's columns)` in our units."""
    picked = variable.isel({variable.dims[-2]: plane.rows, variable.dims[-1]: plane.columns})
    values = np.asarray(picked.values, dtype=np.float64)
    if time not in variable.dims:
        values = values[None]
    rest = [d for d in variable.dims[:-2] if d != time]
    if not rest:
        values = values[:, None]
    elif len(rest) > 1 or (level is not None and rest != [level]):
        raise ScenarioError(f"{path}: cannot tell what the dimensions {rest} of {variable.name!r} are")
    return in_our_units(values, label, variable, path)


def _turned(
    data: Any, path: Path, quantities: Sequence[tuple[str, Any]], blocks: list[Values], row: Values, column: Values,
    windows: Windows,
) -> list[Values]:  # fmt: skip
    """Velocities along the grid's axes, turned to east and north by the file's `angle`.

    Raises:
        ScenarioError: velocities between the grid's points, which go along its axes, or those that say so, on a turned
            grid without the angle.
    """
    labels = [label for label, _ in quantities]
    if "east" not in labels:
        return blocks
    i, j = labels.index("east"), labels.index("north")
    east, north = quantities[i][1], quantities[j][1]
    standard = [v.attrs.get("standard_name") for v in (east, north)]
    if any(name in _TRUE_EAST for name in standard) or str(east.name).endswith("eastward"):
        return blocks
    if "angle" not in data.variables:
        along_axes = east.dims[-2:] != north.dims[-2:] or any(name in _GRID_EAST for name in standard)
        turn = _turn(data, path, east, windows)
        if along_axes and turn > _UPRIGHT_DEG:
            raise ScenarioError(
                f"{path}: {east.name!r} and {north.name!r} are along the axes of a grid that is turned by up to "
                f"{turn:.3g} deg, and the file lacks its 'angle'; add it, or velocities to east and north"
            )
        return blocks
    angle = _in_order(data, data["angle"])
    field = np.asarray(angle.values, dtype=np.float64)
    if str(angle.attrs.get("units", "radians")).lower().startswith("deg"):
        field = np.radians(field)
    plane = _plane(data, path, angle, row, column, windows)
    part = field[plane.rows, plane.columns]
    c, s = plane.of(np.cos(part)), plane.of(np.sin(part))
    turned = list(blocks)
    turned[i], turned[j] = blocks[i] * c - blocks[j] * s, blocks[i] * s + blocks[j] * c
    return turned


def _turn(data: Any, path: Path, variable: Any, windows: Windows) -> float:
    """Largest angle between a grid's rows, or columns where these are nearer, and the parallels [deg]."""
    lat, lon = _degrees(data, path, variable, windows)
    across = np.cos(np.radians(lat))
    angles = []
    for axis in (0, 1):
        north, east = np.gradient(lat, axis=axis), np.gradient(lon, axis=axis) * across
        angles.append(float(np.degrees(np.abs(np.arctan2(north, np.abs(east))).max())))
    return min(angles)


def _heights(
    data: Any, path: Path, level: str, time: str | None, row: Values, column: Values, windows: Windows
) -> Values:
    """Height z of every level over the mean surface, `(times or 1, levels, rows, columns)` [m]."""
    s = np.asarray(data[level].values, dtype=np.float64) if level in data.variables else None
    kind = str(data[level].attrs.get("standard_name", "")) if s is not None else ""
    if s is None or "h" not in data.variables:
        lacking = "h" if s is not None else level
        raise ScenarioError(f"{path}: levels {level!r} need the variable {lacking!r}, which the file lacks")
    h = _on_plane(data, path, "h", row, column, windows)
    zeta = _on_plane(data, path, "zeta", row, column, windows) if "zeta" in data.variables else np.zeros((1, 1, 1))
    if zeta.ndim == 2:
        zeta = zeta[None]
    zeta = np.nan_to_num(zeta)[:, None]  # (times, 1, rows, columns)
    s = s[None, :, None, None]
    if level == "sigma" or kind == "ocean_sigma_coordinate":
        return np.asarray(zeta + s * (h + zeta))
    stretching = "Cs_w" if level == "s_w" else "Cs_r"
    lacking_all = [name for name in (stretching, "hc") if name not in data.variables]
    form = {"ocean_s_coordinate_g1": 1, "ocean_s_coordinate_g2": 2}.get(kind)
    if "Vtransform" in data.variables:
        form = int(np.asarray(data["Vtransform"].values))
    if lacking_all or form not in (1, 2):
        what = ", ".join(lacking_all) or "Vtransform (1 or 2), or a standard_name ocean_s_coordinate_g1 or _g2"
        raise ScenarioError(f"{path}: levels {level!r} need {what}, which the file lacks")
    c = np.asarray(data[stretching].values, dtype=np.float64)[None, :, None, None]
    hc = float(np.asarray(data["hc"].values))
    if form == 1:
        z0 = hc * s + (h - hc) * c
        return np.asarray(z0 + zeta * (1 + z0 / h))
    return np.asarray(zeta + (zeta + h) * (hc * s + h * c) / (hc + h))


def _on_plane(data: Any, path: Path, name: str, row: Values, column: Values, windows: Windows) -> Values:
    variable = _in_order(data, data[name])
    plane = _plane(data, path, variable, row, column, windows)
    picked = variable.isel({variable.dims[-2]: plane.rows, variable.dims[-1]: plane.columns})
    return plane.of(np.asarray(picked.values, dtype=np.float64))


def _depths(data: Any, path: Path, variable: Any, time: str | None) -> Values:
    """Depths [m] of a variable on ordinary levels, in the file's order; one entry where it has none."""
    rest = [str(d) for d in variable.dims[:-2] if d != time]
    values = depths_of(data, path, rest[0] if rest else None)
    steps = np.diff(values)
    if not (np.all(steps > 0) or np.all(steps < 0)):
        raise ScenarioError(f"{path}: the depths of {rest[0]!r} neither increase nor decrease from entry to entry")
    return values


def _even_levels(z: Values) -> Values:
    """Depths that are as close as the levels of the deepest, the middle and the shallowest column."""
    columns = np.moveaxis(-z[0], 0, -1).reshape(-1, z.shape[1])
    order = np.argsort(columns.max(axis=1), kind="stable")
    chosen = columns[order[[0, len(order) // 4, len(order) // 2, -1]]]
    depth = np.unique(np.round(np.maximum(chosen, 0.0), 3))
    apart = np.concatenate([[True], np.diff(depth) > 1e-3 * max(depth[-1], 1.0)])
    kept = depth[apart]
    return kept if len(kept) > 1 else np.array([0.0, max(float(depth[-1]), 1.0)])


def _at_depths(values: Values, z: Values, depth: Values) -> Values:
    """Linear between levels: `(times, levels, rows, columns)` to `(times, depths, rows, columns)`; held beyond them."""
    z = np.broadcast_to(z, values.shape)
    if z[0, 0].mean() > z[0, -1].mean():
        z, values = z[:, ::-1], values[:, ::-1]  # upwards
    out = np.empty((values.shape[0], len(depth), *values.shape[2:]))
    for k, d in enumerate(depth):
        above = np.clip(np.sum(z < -d, axis=1), 1, z.shape[1] - 1)[:, None]
        z0, z1 = np.take_along_axis(z, above - 1, 1), np.take_along_axis(z, above, 1)
        v0, v1 = np.take_along_axis(values, above - 1, 1), np.take_along_axis(values, above, 1)
        share = np.clip((-d - z0) / np.where(z1 > z0, z1 - z0, 1.0), 0.0, 1.0)
        out[:, k] = (v0 + share * (v1 - v0))[:, 0]
    return out

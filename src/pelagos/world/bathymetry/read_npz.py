"""Gridded surveys as NumPy archives."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pelagos.errors import WorldError
from pelagos.world.bathymetry.axes import EASTING, LATITUDE, LONGITUDE, NORTHING, check_axes, choose, named, plain
from pelagos.world.bathymetry.survey import Grid, rising
from pelagos.world.size import refuse_large

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading


def read_npz(path: Path, how: Reading) -> Grid:
    """A NumPy archive with two axes and one array on them."""
    refuse_large(path, "bathymetry file")
    with path.open("rb") as file, np.load(file, allow_pickle=False) as data:
        arrays = {k: data[k] for k in data.files}
    axes = {k: a for k, a in arrays.items() if a.ndim == 1}
    latlon = named(axes, LATITUDE) is not None and named(axes, LONGITUDE) is not None
    names = (LATITUDE, LONGITUDE) if latlon else (NORTHING, EASTING)
    u_name, v_name = named(axes, names[0]), named(axes, names[1])
    if u_name is None or v_name is None:
        raise WorldError(f"bathymetry file {path} has no axes named lat, lon or y, x; it has: {', '.join(arrays)}")
    name = choose(path, how.variable, [k for k, a in arrays.items() if a.ndim == 2])
    u, v, z = plain(arrays[u_name]), plain(arrays[v_name]), plain(arrays[name])
    if z.shape != (len(u), len(v)):
        raise WorldError(
            f"bathymetry file {path}: {name!r} is {z.shape}, but its axes {u_name}, {v_name} have {len(u)}, {len(v)}"
        )
    check_axes(path, u, v, (u_name, v_name), latlon=latlon)
    return Grid(*rising(u, v, z), how.crs or ("EPSG:4326" if latlon else ""), name)

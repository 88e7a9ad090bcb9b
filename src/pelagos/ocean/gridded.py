"""Fields on a grid in time, depth and place, from NetCDF: linear in all four, exact at the grid's points."""

from __future__ import annotations

import warnings
from abc import abstractmethod
from dataclasses import replace
from pathlib import Path
from typing import Final, Literal, TypeAlias

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.config.path import ScenarioPath
from pelagos.config.strict import Strict
from pelagos.errors import ScenarioError, ValidityWarning
from pelagos.jit import Array
from pelagos.math.lookup import locate
from pelagos.ocean.current import Current
from pelagos.ocean.grid_data import GriddedData, Windows
from pelagos.ocean.netcdf import read_grid
from pelagos.ocean.site import Site

Outside: TypeAlias = Literal["error", "clamp", "fade"]

_MARGIN_M: Final = 2_000.0  # read around the world
_BEYOND: Final = {"clamp": "the value at its edge holds", "fade": "the field goes to zero within a cell"}
_OR_SAY: Final = "or say 'outside: clamp' or 'outside: fade'"
_FASTEST: Final = 20.0  # [m/s], beyond every current of the sea
_NORTHWARDS_DEG: Final = 1e-3  # of latitude, over which true north is found
_PRECISE_DEG: Final = 2e-9  # of the map from metres to degrees; 0.2 mm


class _Gridded(Strict):
    file: ScenarioPath
    """A NetCDF file; a relative path starts at the scenario's own folder."""
    start: str | None = None
    """Time of the file that is t = 0 of the simulation, ISO 8601; the file's first time where not given."""
    outside: Outside = "error"
    """Beyond the grid: `error` refuses a world or a moment that the file does not cover; `clamp` holds the value at the
    edge; `fade` lets it go to zero within one cell."""

    def read(self, site: Site) -> GridField:
        """The variables on the device."""
        return grid_field(self._data(site), site, outside=self.outside, where=str(self.file))

    def _data(self, site: Site) -> GriddedData:
        return read_grid(self.file, self.quantities, start=self.start, windows=_windows(site))

    @property
    @abstractmethod
    def quantities(self) -> list[tuple[str, str | None]]:
        """Variables to read: key or label, and the variable's name or None to find it."""

    def check(self, site: Site) -> None:
        """Read the file as a run would, without a device.

        Raises:
            ScenarioError: what is wrong with it, or what of the site it does not cover although it must.
        """
        data = self._data(site)
        lacking = _lacking(data, site, str(self.file))
        if lacking and self.outside == "error":
            raise ScenarioError(f"{lacking}, {_OR_SAY}")


class GriddedCurrentConfig(_Gridded):
    """Currents from a NetCDF file, such as CMEMS, HYCOM or ROMS (on depth levels) write."""

    type: Literal["gridded"] = "gridded"
    """The kind of current."""
    east_variable: str | None = None
    """Name of the eastward velocity in the file; found by its standard name where not given."""
    north_variable: str | None = None
    """Name of the northward velocity in the file."""
    up_variable: str | None = None
    """Name of the upward velocity in the file; none is read where not given."""

    @property
    def quantities(self) -> list[tuple[str, str | None]]:
        """See `_Gridded`."""
        wanted = [("east", self.east_variable), ("north", self.north_variable)]
        return wanted if self.up_variable is None else [*wanted, ("up", self.up_variable)]

    def build(self, site: Site) -> Current:
        """The component on the device."""
        return GriddedCurrent(self.read(site))

    def _data(self, site: Site) -> GriddedData:
        data = super()._data(site)
        fastest = float(np.abs(data.values).max())
        if fastest > _FASTEST:
            raise ScenarioError(
                f"{self.file} has speeds of up to {fastest:.3g} m/s; a mark for missing values must be declared (CF: "
                "_FillValue)"
            )
        return along_axes(data, site)


@jit.struct
class GridField:
    """Values on a grid: a Dr.Jit struct.

    Attributes:
        values: `Float64`, the channels of each point side by side (three padded to four), in the order of time, depth,
            row, column.
        time, depth, row, column: `Float64`, coordinates; one entry where the field does not depend on them.
        to_row, to_column: `Float64`, coefficients of the polynomials from world x, y to row and column coordinates.
        scale: `Float64` (1), metres to the polynomials' argument.
        channels, outside: how many values a point has, and what holds beyond the grid.
        source: the file's name.
    """

    values: Array
    time: Array
    depth: Array
    row: Array
    column: Array
    to_row: Array
    to_column: Array
    scale: Array
    channels: int
    outside: str
    source: str

    def beyond(self, position: Array, t: Array) -> Array:
        """Whether `position` (`Array3f64` NWU [m]) or time t [s] lies outside the grid, `Bool`; whatever the depth."""
        when, _, row, column = self._places(position, t)
        places, found = (when, row, column), jit.Bool(False)
        for nodes, place in zip((self.time, self.row, self.column), places, strict=True):
            count = dr.width(nodes)
            if count > 1:
                first, last = (dr.gather(jit.Float64, nodes, jit.UInt32(i)) for i in (0, count - 1))
                found = found | (place < first - 1e-6) | (place > last + 1e-6)
        return found

    def at(self, position: Array, t: Array) -> list[Array]:
        """`Float64` by channel, at `position` (`Array3f64` NWU [m]) and time t [s]."""
        places = self._places(position, t)
        axes = (self.time, self.depth, self.row, self.column)
        corners: list[tuple[Array, Array]] = [(jit.UInt32(0), jit.Float64(1.0))]
        weight = jit.Float64(1.0)
        for number, (nodes, place) in enumerate(zip(axes, places, strict=True)):
            count = dr.width(nodes)
            if count == 1:
                continue
            i, fraction = locate(nodes, place)
            weight = weight * self._edge(nodes, place, count, above=number == 1)
            corners = [
                (index * count + i + step, share * part)
                for index, share in corners
                for step, part in ((0, 1 - fraction), (1, fraction))
            ]
        kind = {1: jit.Float64, 2: jit.Array2f64, 3: jit.Array4f64}[self.channels]  # one access a corner
        value = sum(share * dr.gather(kind, self.values, index) for index, share in corners) * weight
        return [value] if self.channels == 1 else [value[c] for c in range(self.channels)]

    def _places(self, position: Array, t: Array) -> tuple[Array, Array, Array, Array]:
        """Coordinates of the grid: time, depth, row, column."""
        x, y = position[0] * self.scale, position[1] * self.scale
        return t, -position[2], _polynomial(self.to_row, x, y), _polynomial(self.to_column, x, y)

    def _edge(self, nodes: Array, place: Array, count: int, *, above: bool) -> Array:
        """Factor for places beyond the grid: 1 (clamp), falling to 0 (fade), not a number (error).

        Water above the first level belongs to it, and below the last one to that: depths are held.
        """
        if self.outside == "clamp" or above:
            return jit.Float64(1.0)
        first, second, before, last = (
            dr.gather(jit.Float64, nodes, jit.UInt32(i)) for i in (0, 1, count - 2, count - 1)
        )
        beyond = dr.maximum((first - place) / (second - first), (place - last) / (last - before))
        if self.outside == "fade":
            return dr.clip(1 - beyond, 0.0, 1.0)
        return dr.select(beyond > 1e-6, dr.nan, 1.0)


@jit.struct
class GriddedCurrent:
    """Attributes: field: velocity along -y, along x and perhaps upwards [m/s]."""

    field: GridField

    def velocity(self, position: Array, t: Array) -> Array:
        """See `Current`."""
        v = self.field.at(position, t)
        return jit.Array3f64(v[1], -v[0], v[2] if len(v) > 2 else 0.0)


def along_axes(data: GriddedData, site: Site) -> GriddedData:
    """Velocities to the Earth's east and north (the first two channels) turned to the world's axes, node by node.

    Meridians converge: away from the origin's own, true north is not the world's x.
    """
    if data.metric:
        return data
    lat, lon = np.meshgrid(data.row, data.column, indexing="ij")
    ends = [site.origin.to_xy(np.clip(lat + step, -90.0, 90.0), lon) for step in (-_NORTHWARDS_DEG, _NORTHWARDS_DEG)]
    angle = np.arctan2(ends[0][1] - ends[1][1], ends[1][0] - ends[0][0])  # of true north, from x towards east
    c, s = np.cos(angle), np.sin(angle)
    values = data.values.copy()
    values[0], values[1] = data.values[0] * c + data.values[1] * s, data.values[1] * c - data.values[0] * s
    return replace(data, values=values)


def grid_field(data: GriddedData, site: Site, *, outside: str, where: str) -> GridField:
    """Put a grid on the device, with the map from world metres to its coordinates.

    Raises:
        ScenarioError: `outside` is error and the grid does not cover the world.
    """
    if data.metric:  # row: metres north, column: metres east
        to_row, to_column, scale = np.array([0.0, 0.0, 1.0]), np.array([0.0, -1.0, 0.0]), 1.0
    else:
        to_row, to_column, scale = _degrees(data, site)
    lacking = _lacking(data, site, where)
    if lacking and outside == "error":
        raise ScenarioError(f"{lacking}, {_OR_SAY}")
    if lacking:
        message = f"{lacking}; beyond it {_BEYOND[outside]} (outside: {outside})"
        warnings.warn(message, ValidityWarning, stacklevel=2)
    channels = np.moveaxis(data.values, 0, -1)
    if channels.shape[-1] == 3:
        channels = np.concatenate([channels, np.zeros_like(channels[..., :1])], axis=-1)
    values = np.ascontiguousarray(channels).ravel()
    arrays = (values, data.time, data.depth, data.row, data.column, to_row, to_column, np.array([scale]))
    v, time, depth, row, column, a, b, s = (jit.Float64(np.array(x, dtype=np.float64)) for x in arrays)
    field = GridField(v, time, depth, row, column, a, b, s, len(data.values), outside, Path(where).name)
    jit.align(field)
    return field


def _windows(site: Site) -> Windows:
    """The world and a margin around it; everything where the world has no extent."""
    low, high = site.corners
    if not np.any(high > low):
        return Windows(site.origin.longitude, None, None)
    x = np.array([low[0] - _MARGIN_M, high[0] + _MARGIN_M])
    y = np.array([low[1] - _MARGIN_M, high[1] + _MARGIN_M])
    lat, lon = _unwrapped(site, *_outline(x, y))
    degrees = (float(lat.min()), float(lat.max()), float(lon.min()), float(lon.max()))
    return Windows(site.origin.longitude, degrees, (float(x[0]), float(x[1]), float(-y[1]), float(-y[0])))


def _outline(
    x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:  # fmt: skip
    """Corners of a rectangle, and where its edges cross the origin's meridian.

    Parallels bend towards the pole to both sides of that meridian: the edge reaches nearest to the pole on it.
    """
    across, along = np.meshgrid(x, np.array([y[0], np.clip(0.0, y[0], y[1]), y[1]]))
    return across, along


def _unwrapped(
    site: Site, x: NDArray[np.float64], y: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Latitude and longitude [deg] of places; longitudes do not jump at the date line."""
    lat, lon = site.origin.to_latlon(x, y)
    return lat, site.origin.longitude + (lon - site.origin.longitude + 180) % 360 - 180


def _lacking(data: GriddedData, site: Site, where: str) -> str:
    """Parts of the world and the run that the file does not cover; empty where nothing."""
    if len(data.time) > 1 and site.duration_s > data.time[-1]:
        return (
            f"{where} ends {data.time[-1]:g} s after the start, and the run lasts {site.duration_s:g} s; take an "
            "earlier 'start' or a longer file"
        )
    low, high = site.corners
    x, y = _outline(np.array([low[0], high[0]]), np.array([low[1], high[1]]))
    row, column = (x, -y) if data.metric else _unwrapped(site, x, y)
    for name, values, (first, last) in (("latitude", row, data.covers[:2]), ("longitude", column, data.covers[2:])):
        if values.min() < first - 1e-9 or values.max() > last + 1e-9:
            covered, needed = f"{first:.4f} to {last:.4f}", f"{values.min():.4f} to {values.max():.4f}"
            return f"{where} covers {name} {covered}, and the world reaches from {needed}; take another file or place"
    return ""


def _degrees(data: GriddedData, site: Site) -> tuple[NDArray[np.float64], NDArray[np.float64], float]:
    """Polynomials in (x, y) * scale for latitude and longitude, over the grid and the world."""
    lat, lon = np.meshgrid(data.row[[0, -1]], data.column[[0, -1]])
    x, y = site.origin.to_xy(lat, lon)
    reach = max(float(np.abs(x).max()), float(np.abs(y).max()), float(np.abs(site.corners[:, :2]).max()), 1.0)
    c = np.cos(np.pi * (np.arange(40) + 0.5) / 40)
    u, v = (a.ravel() for a in np.meshgrid(c, c))
    goal_lat, goal_lon = site.origin.to_latlon(u * reach, v * reach)
    goal_lon = site.origin.longitude + (goal_lon - site.origin.longitude + 180) % 360 - 180
    for degree in (4, 6, 9, 12, 16):
        terms = np.stack([u**i * v**j for i in range(degree + 1) for j in range(degree + 1 - i)], axis=-1)
        solution, *_ = np.linalg.lstsq(terms, np.stack([goal_lat, goal_lon], axis=-1), rcond=None)
        if np.abs(terms @ solution - np.stack([goal_lat, goal_lon], axis=-1)).max() < _PRECISE_DEG:
            break
    return solution[:, 0], solution[:, 1], 1 / reach


def _polynomial(coefficients: Array, x: Array, y: Array) -> Array:
    """Sum of c[i, j] x^i y^j over i + j <= degree, coefficients in the order of `_degrees`, by Horner's rule."""
    count = dr.width(coefficients)
    degree = round((np.sqrt(8 * count + 1) - 3) / 2)
    index = count
    total = jit.Float64(0.0)
    for i in range(degree, -1, -1):
        inner = jit.Float64(0.0)
        for _ in range(degree - i, -1, -1):
            index -= 1
            inner = dr.fma(inner, y, dr.gather(jit.Float64, coefficients, jit.UInt32(index)))
        total = dr.fma(total, x, inner)
    return total

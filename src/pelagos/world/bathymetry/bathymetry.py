"""A world made from a survey of the real seabed: its file, its crop, its grid."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, ClassVar, Final, Literal, Self

import numpy as np
from pydantic import AfterValidator, ConfigDict, Field, ValidationInfo, model_validator

from pelagos.config.described import Described
from pelagos.config.path import from_folder
from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.bathymetry.detail import add_detail
from pelagos.world.bathymetry.nodes import survey_nodes
from pelagos.world.bathymetry.projection import to_latlon
from pelagos.world.bathymetry.read import MATPLOTLIB, Reading, read_survey
from pelagos.world.bathymetry.regrid import (
    Extent,
    block_means,
    extent,
    far_from_soundings,
    height_field,
    usual_distance,
)
from pelagos.world.bathymetry.survey import Grid, Soundings
from pelagos.world.bathymetry.values import Unit, upwards
from pelagos.world.config import WorldConfig
from pelagos.world.material import material
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World

_MAX_NODES: Final = 40_000_000
_WIDEST_M: Final = 2_000_000.0  # beyond, a plane is no likeness of the Earth: scale errs by 1 % at its rim
_EARTH_M: Final = 6_371_000.0  # mean radius
_DEFAULT_CELLS: Final = 400  # along the longer side, where no resolution is asked for and the survey has none
_LEAST_CELLS: Final = 4  # along the shorter side, where no resolution is asked for ...
_MOST_CELLS: Final = 5000  # ... and along the longer side


def _place(value: str, info: ValidationInfo) -> str:
    return value if value.startswith(MATPLOTLIB) else str(from_folder(Path(value), info))


class DetailConfig(Described):
    """Invented relief, finer than the survey."""

    model_config = ConfigDict(frozen=True, extra="forbid")

    seed: int = Field(default=0, ge=0)
    """Seed of the relief."""
    strength: float = Field(default=1.0, gt=0)
    """Factor on its height; 1 carries on the spectrum that the survey has."""


class BathymetryConfig(WorldConfig):
    """The seabed, and the land, of a survey file."""

    TITLE: ClassVar[str] = "A real seabed from NetCDF, GeoTIFF, ESRI ASCII, BAG, NumPy, LAS or soundings as text"

    type: Literal["bathymetry"] = "bathymetry"
    """The kind of world."""
    path: Annotated[str, AfterValidator(_place)]
    """The survey file, relative to the scenario; or `matplotlib:topobathy.npz`, a piece of the Salish Sea that ships
    inside matplotlib."""
    variable: str | None = None
    """Which array or band of the file; needed only where it holds several that could be meant."""
    crs: str | None = None
    """Coordinate system of the file's coordinates (`EPSG:3004`); needed where the file does not say it."""
    columns: str = "xyz"
    """Order of the columns of a text file without a header: x is easting or longitude, y northing or latitude."""
    sign: Literal["auto", "up", "down"] = "auto"
    """Whether values count upwards (elevation) or downwards (depth); `auto` asks the file's words, then its values."""
    unit: Unit = "auto"
    """Unit of the values in the file; `auto` takes the file's own word, else metres."""
    datum_offset_m: float = 0.0
    """Added to every height, to refer them to the mean sea surface [m]."""
    centre_deg: tuple[float, float] | None = None
    """Latitude and longitude of the middle of the crop [deg]; it becomes the world's origin."""
    size_m: tuple[float, float] | None = None
    """Extent of the crop along x (north) and y (west), with `centre_deg` [m]."""
    latitude_range_deg: tuple[float, float] | None = None
    """Southern and northern limit of the crop, instead of `centre_deg` and `size_m` [deg]."""
    longitude_range_deg: tuple[float, float] | None = None
    """Western and eastern limit of the crop [deg]."""
    resolution_m: float | None = Field(default=None, gt=0)
    """Spacing of the world's grid [m]; the survey's own, or 1/400 of the crop for soundings, where not given."""
    nodes: Literal["world", "survey"] = "world"
    """`world` interpolates the survey to a square grid; `survey` keeps a grid's own nodes and values."""
    detail: DetailConfig | None = None
    """Invented relief, finer than the survey; none where not given."""
    material: str = "sand"
    """Material of the seabed."""

    @model_validator(mode="after")
    def _one_crop(self) -> Self:
        if (self.centre_deg is None) != (self.size_m is None):
            raise ValueError("centre_deg and size_m go together: give both, or neither")
        if (self.latitude_range_deg is None) != (self.longitude_range_deg is None):
            raise ValueError("latitude_range_deg and longitude_range_deg go together: give both, or neither")
        if self.centre_deg is not None and self.latitude_range_deg is not None:
            raise ValueError(
                "give the crop once: centre_deg with size_m, or latitude_range_deg with longitude_range_deg"
            )
        for name in ("latitude_range_deg", "longitude_range_deg"):
            limits = getattr(self, name)
            if limits is not None and not limits[0] < limits[1]:
                raise ValueError(f"{name} must rise, not {list(limits)}")
        if self.size_m is not None and not min(self.size_m) > 0:
            raise ValueError(f"size_m must be greater than zero, not {list(self.size_m)}")
        if self.nodes == "survey" and (self.resolution_m is not None or self.detail is not None):
            raise ValueError("nodes: survey keeps the survey's own nodes: leave resolution_m and detail out")
        return self

    def build(self) -> World:
        """Read, crop and regrid the survey.

        Raises:
            WorldError: the file, its coordinate system or the crop cannot be used.
        """
        material(self.material)
        self._refuse_impossible()
        survey = read_survey(self.path, Reading(self.variable, self.crs, self.columns, self._box(), self.unit))
        survey, sign = upwards(survey, self.sign, self.datum_offset_m)
        covered = extent(survey)
        middle, size = self._crop(covered)
        origin = GeoOrigin(
            middle[0] if self.latitude_deg is None else self.latitude_deg,
            middle[1] if self.longitude_deg is None else self.longitude_deg,
        )
        at = origin.to_xy(middle[0], middle[1])
        spacing = self.resolution_m or _sensible(_own_spacing(survey, origin, size), size)
        if isinstance(survey, Soundings):
            low = (float(at[0]) - size[0] / 2, float(at[1]) - size[1] / 2)
            survey = block_means(survey, origin, low=low, high=(low[0] + size[0], low[1] + size[1]), cell=spacing)
        ground, holes, notes = self._ground(survey, origin, (float(at[0]), float(at[1])), size, spacing)
        if not (ground.z < 0).any():
            raise WorldError(
                f"bathymetry {self.path}: the crop lies wholly above the sea (lowest {ground.z.min():.2f} m); if the "
                "values are depths, say sign: down; else choose a part with water, or check datum_offset_m. "
                f"The file covers {covered}"
            )
        site = Site(user_labels=self.labels)
        site.ground(ground, self.material)
        site.notes += [*_notes(ground, survey, origin, holes, sign), *survey.notes, *notes]
        name = Path(self.path.removeprefix(MATPLOTLIB)).name
        wide = f"{ground.bounds[1, 0] - ground.bounds[0, 0]:.0f} m x {ground.bounds[1, 1] - ground.bounds[0, 1]:.0f} m"
        return site.world(
            name="bathymetry",
            description=f"{name}: {wide} at {spacing:.4g} m, z {ground.z.min():.2f} .. {ground.z.max():.2f} m",
            origin=origin,
        )

    def _ground(
        self,
        survey: Grid | Soundings,
        origin: GeoOrigin,
        at: tuple[float, float],
        size: tuple[float, float],
        spacing: float,
    ) -> tuple[HeightField, int, list[str]]:
        """The ground about `at` [m], how many of its nodes were filled, and notes about it."""
        if self.nodes == "world":
            cells = self._cells(size, spacing)
            corner = (at[0] - cells[0] * spacing / 2, at[1] - cells[1] * spacing / 2)
            ground, holes = height_field(survey, origin, corner=corner, cells=cells, spacing=spacing)
            if self.detail is None:
                return ground, holes, []
            own = (
                _own_spacing(survey, origin, size)
                if isinstance(survey, Grid)
                else usual_distance(survey, origin, ground)
            )
            finer, note = add_detail(
                ground, survey, origin, spacing=own, seed=self.detail.seed, strength=self.detail.strength
            )
            return finer, holes, [note]
        if isinstance(survey, Soundings):
            raise WorldError(f"bathymetry {self.path}: nodes: survey needs a grid, and this file holds soundings")
        nodes, holes = survey_nodes(survey, origin, middle=at, size=size)
        return nodes, holes, [f"the nodes are the survey's own: {nodes.z.shape[0]} x {nodes.z.shape[1]} values"]

    def _cells(self, size: tuple[float, float], spacing: float) -> tuple[int, int]:
        """Cells along x and y: as many as are nearest to a crop that was asked for, else as many as the survey holds.

        Raises:
            WorldError: more nodes than memory is meant for.
        """
        share = 1e-6 if self.centre_deg is None and self.latitude_range_deg is None else 0.5
        cells = (max(1, int(size[0] / spacing + share)), max(1, int(size[1] / spacing + share)))
        nodes = (cells[0] + 1) * (cells[1] + 1)
        if nodes > _MAX_NODES:
            coarser = spacing * float(np.sqrt(nodes / _MAX_NODES))
            asked = f"{size[0]:.0f} m x {size[1]:.0f} m at {spacing:g} m"
            raise WorldError(f"{asked} are {nodes} nodes; use resolution_m: {coarser:.3g} or more")
        return cells

    def _refuse_impossible(self) -> None:
        """No latitude is above 90 degrees: say so before any file is opened."""
        asked = self.centre_deg[:1] if self.centre_deg else self.latitude_range_deg or ()
        if any(abs(lat) > 90 for lat in asked):
            raise WorldError(f"latitude {max(asked, key=abs):g} is not on Earth; are latitude and longitude exchanged?")

    def _box(self) -> tuple[float, float, float, float] | None:
        """South, north, west, east of the crop [deg], a little generous."""
        if self.latitude_range_deg and self.longitude_range_deg:
            return (*self.latitude_range_deg, *self.longitude_range_deg)
        if self.centre_deg is None or self.size_m is None:
            return None
        place = GeoOrigin(*self.centre_deg)
        reach = np.array(self.size_m) * (0.55 if self.detail is None else 3.0)  # a spectrum needs more of the survey
        lat, lon = place.to_latlon(reach[0] * np.array([-1, -1, 1, 1]), reach[1] * np.array([-1, 1, -1, 1]))
        return float(lat.min()), float(lat.max()), float(lon.min()), float(lon.max())

    def _crop(self, covered: Extent) -> tuple[tuple[float, float], tuple[float, float]]:
        """Middle (latitude, longitude) [deg] and size (north, west) [m] of the crop, checked against the data."""
        if self.centre_deg is not None and self.size_m is not None:
            _require(self.path, covered, [self.centre_deg])
            return self.centre_deg, self.size_m
        box = covered
        if covered.north <= covered.south or covered.east <= covered.west:
            raise WorldError(f"bathymetry {self.path}: the survey covers no area, only {covered}")
        if self.latitude_range_deg and self.longitude_range_deg:
            box = Extent(*self.latitude_range_deg, *self.longitude_range_deg)
            _require(self.path, covered, [(box.south, box.west), (box.north, box.east)])
        middle = ((box.south + box.north) / 2, (box.west + box.east) / 2)
        across = np.radians([box.north - box.south, (box.east - box.west) * np.cos(np.radians(middle[0]))]) * _EARTH_M
        if across.max() > _WIDEST_M:
            raise WorldError(
                f"bathymetry {self.path}: {across[0] / 1e3:.0f} km x {across[1] / 1e3:.0f} km of a round Earth make no "
                f"flat world (at most {_WIDEST_M / 1e3:.0f} km); choose a part with centre_deg and size_m"
            )
        place = GeoOrigin(*middle)
        x, _ = place.to_xy(np.array([box.south, box.north]), np.full(2, middle[1]))
        _, y = place.to_xy(np.full(2, middle[0]), np.array([box.east, box.west]))
        return middle, (float(x[1] - x[0]), float(y[1] - y[0]))


def _require(path: str, covered: Extent, places: list[tuple[float, float]]) -> None:
    """Every place lies on the survey; where exchanging latitude and longitude would help, say that."""
    slack = 1e-6 + 0.01 * max(covered.north - covered.south, covered.east - covered.west)
    wrapped = [(lat, (lon + 180) % 360 - 180) for lat, lon in places]
    outside = [p for p in wrapped if not covered.holds(*p, slack=slack)]
    if not outside:
        return
    lat, lon = outside[0]
    message = f"bathymetry {path}: latitude {lat:g}, longitude {lon:g} lies outside the data, which cover {covered}"
    if all(covered.holds(b, a, slack=slack) for a, b in places):
        message += f". Latitude and longitude look exchanged: {lon:g}, {lat:g} lies inside (latitude comes first)"
    raise WorldError(message)


def _sensible(spacing: float, size: tuple[float, float]) -> float:
    """A survey's spacing, within what a crop of this size can be built of [m]."""
    return min(max(spacing, max(size) / _MOST_CELLS), min(size) / _LEAST_CELLS)


def _own_spacing(survey: Grid | Soundings, origin: GeoOrigin, size: tuple[float, float]) -> float:
    """Spacing that keeps a grid's detail [m]."""
    if isinstance(survey, Soundings):
        return max(size) / _DEFAULT_CELLS
    rows, columns = len(survey.u) // 2, len(survey.v) // 2
    u, v = survey.u[[rows - 1, rows, rows - 1]], survey.v[[columns - 1, columns - 1, columns]]
    x, y = origin.to_xy(*to_latlon(survey.crs, u, v))
    step = float(min(np.hypot(x[1:] - x[0], y[1:] - y[0])))
    return float(f"{step:.3g}")


def _notes(ground: HeightField, survey: Grid | Soundings, origin: GeoOrigin, holes: int, sign: str) -> list[str]:
    what = f"{survey.z.size} nodes" if isinstance(survey, Grid) else f"{survey.z.size} soundings"
    notes = [f"read {what}; values taken as {sign}"]
    if holes:
        share = 100 * holes / ground.z.size
        notes.append(
            f"{holes} of {ground.z.size} grid nodes ({share:.1f} %) had no data and were filled: linearly across holes"
            ", with the nearest value beyond the survey's edge"
        )
    else:
        notes.append("no holes: every grid node lies between surveyed values")
    if isinstance(survey, Soundings):
        lonely, far = far_from_soundings(survey, origin, ground)
        if lonely:
            share = 100 * lonely / ground.z.size
            notes.append(
                f"{lonely} grid nodes ({share:.1f} %) lie more than {far:.1f} m from any sounding: interpolated across"
            )
    land = float((ground.z >= 0).mean())
    if land > 0:
        notes.append(f"{100 * land:.1f} % of the area is land or lies at the sea surface")
    return notes

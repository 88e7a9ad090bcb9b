"""A world of any size: generated or surveyed ground, insets at finer resolutions, streamed within a memory limit."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import AfterValidator, ConfigDict, Field, ValidationInfo

from pelagos.config.described import Described
from pelagos.config.path import from_folder
from pelagos.errors import WorldError
from pelagos.math.geodesy import GeoOrigin
from pelagos.world.bathymetry.values import Unit
from pelagos.world.by_hand import add
from pelagos.world.config import Positive, WorldConfig
from pelagos.world.label import label_number
from pelagos.world.large.field import FieldConfig, fill
from pelagos.world.large.ground import Inset, LargeGround, Overview
from pelagos.world.large.noise import Fractal
from pelagos.world.large.quadtree import CELLS, TRIANGLES
from pelagos.world.large.source import FieldSource, FileSource, FractalSource, Source, grid_file_shape
from pelagos.world.large.stream import Stream, details, reached
from pelagos.world.large.survey import survey_source
from pelagos.world.material import material
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World

BYTES_PER_TRIANGLE: Final = 260  # measured: mesh, its tree, and both twice while one is exchanged for the next
PROCESS_MB: Final = 420.0  # measured: the interpreter, the ray tracer, kernels and the sensors of a survey
_LEAST_TRIANGLES: Final = 150_000
_OVERVIEW: Final = 400  # cells of the overview along the longer side
_LARGEST_CELLS: Final = 2**24


def _file(value: Path, info: ValidationInfo) -> Path:
    return from_folder(value, info)


class _Part(Described):
    model_config = ConfigDict(frozen=True, extra="forbid")


class FractalGround(_Part):
    """Ground from a seed: relief with a power-law spectrum about a plane."""

    kind: Literal["fractal"] = "fractal"
    """Where the ground comes from."""
    seed: int = Field(default=0, ge=0)
    """Of the relief."""
    mean_depth_m: float = 200.0
    """Depth of the plane at the origin [m]."""
    relief_m: float = Field(default=40.0, ge=0)
    """Root mean square of the relief [m]."""
    longest_m: float = Field(default=20_000.0, gt=0)
    """Longest wavelength with relief [m]."""
    spectral_slope: float = Field(default=3.5, ge=2, le=5)
    """S(k) ~ k^-slope, two-dimensional: 2 is rough, 4 is smooth."""
    gradient: tuple[float, float] = (0.0, 0.0)
    """Rise of the plane along x (north) and y (west) [m/m]."""


class SurveyGround(_Part):
    """Ground from a survey file, interpolated to the world's grid where it is needed."""

    kind: Literal["survey"] = "survey"
    """Where the ground comes from."""
    path: Annotated[Path, AfterValidator(_file)]
    """Any file that `bathymetry` reads, relative to the scenario; soundings become a grid first."""
    variable: str | None = None
    """Which array or band of the file; needed only where it holds several that could be meant."""
    crs: str | None = None
    """Coordinate system of the file's coordinates; needed where the file does not say it."""
    columns: str = "xyz"
    """Order of the columns of a text file without a header."""
    sign: Literal["auto", "up", "down"] = "auto"
    """Whether values count upwards (elevation) or downwards (depth)."""
    unit: Unit = "auto"
    """Unit of the values in the file; `auto` takes the file's own word, else metres."""
    datum_offset_m: float = 0.0
    """Added to every height [m]."""


class FileGround(_Part):
    """Ground from a NumPy file at the world's own resolution, read from disk piece by piece."""

    kind: Literal["file"] = "file"
    """Where the ground comes from."""
    path: Annotated[Path, AfterValidator(_file)]
    """Heights `(nx, ny)`, float32 or float64, x north and y west from the low corner; relative to the scenario."""


class InsetConfig(_Part):
    """A rectangle of the ground at a finer resolution."""

    centre_m: tuple[float, float]
    """Its middle, x and y [m]."""
    size_m: tuple[Positive, Positive]
    """Its extent along x and y [m]."""
    resolution_m: float = Field(gt=0)
    """Spacing of its grid [m], rounded down to the world's resolution divided by a power of two."""
    path: Annotated[Path, AfterValidator(_file)] | None = None
    """A NumPy file of heights `(nx, ny)` that fills it from corner to corner; without one, fractal detail is added."""
    relief_m: float = Field(default=0.3, ge=0)
    """Root mean square of the fractal detail [m], where there is no file."""
    spectral_slope: float = Field(default=3.0, ge=2, le=5)
    """Of the fractal detail."""
    blend_m: float | None = Field(default=None, ge=0)
    """Width of the rim on which it fades into the ground around it [m]; a tenth of the shorter side if not given."""
    material: str | None = None
    """Its material; the ground's own where not given."""


class LargeConfig(WorldConfig):
    """Ground up to hundreds of kilometres wide: detail follows the vehicles, memory stays bounded."""

    TITLE: ClassVar[str] = "Ground of any size, generated or surveyed, with fine insets; streamed within a memory limit"

    PLACES_THINGS: ClassVar[bool] = True

    type: Literal["large"] = "large"
    """The kind of world."""
    size_m: tuple[Positive, Positive] = (100_000.0, 100_000.0)
    """Extent along x (north) and y (west), about the origin [m]; a whole number of cells."""
    resolution_m: float = Field(default=10.0, gt=0)
    """Spacing of the ground's grid [m]."""
    ground: Annotated[FractalGround | SurveyGround | FileGround, Field(discriminator="kind")] = FractalGround()
    """Where heights come from: `fractal`, `survey` or `file`."""
    insets: tuple[InsetConfig, ...] = ()
    """Rectangles at finer resolutions; the finest lies on top."""
    memory_mb: float = Field(default=1024.0, gt=0)
    """What the whole process may use [MB]; sensors with large images need room in it."""
    reach_m: float | None = Field(default=None, gt=0)
    """How far full resolution shall go around every vehicle [m]; as far as memory allows where not given. The shorter,
    the shorter are the pauses in which ground is exchanged."""
    material: str = "sand"
    """Material of the ground."""
    fields: tuple[FieldConfig, ...] = ()
    """Rectangles with natural and man-made things on the ground."""

    def build(self) -> World:
        """Prepare the ground; heights are computed or read where they are needed.

        Raises:
            WorldError: too small a limit, a file that cannot be used, an inset outside the world.
        """
        site = Site(user_labels=self.labels)
        rows = tuple(site.row(material(m)) for m in dict.fromkeys([self.material, *self._inset_materials()]))
        origin = GeoOrigin(self.latitude_deg or 0.0, self.longitude_deg or 0.0)
        cells = self._cells()
        x0, y0 = -cells[0] * self.resolution_m / 2, -cells[1] * self.resolution_m / 2
        source = self._source(x0, y0, cells, origin)
        ground = LargeGround(
            x0=x0,
            y0=y0,
            cells=cells,
            spacing=self.resolution_m,
            source=source,
            insets=self._insets(x0, y0, cells),
            materials=rows,
            label=label_number("landscape"),
            instance=site.new_instance(),
            triangles=self._triangles(source, 0),
            reach=np.inf if self.reach_m is None else self.reach_m,
        )
        site.terrain = _overview(ground)
        placed = fill(site, self.fields, ground, origin)
        for thing in self.things:
            add(site, thing, origin)
        standing = sum(len(g.faces) for g in site.geometries)
        return _world(self, site, replace(ground, triangles=self._triangles(source, standing)), origin, placed)

    def _cells(self) -> tuple[int, int]:
        cells = [round(s / self.resolution_m) for s in self.size_m]
        for size, count in zip(self.size_m, cells, strict=True):
            if count < 2 or count > _LARGEST_CELLS or abs(count * self.resolution_m - size) > 1e-6 * size:
                near = max(count, 2) * self.resolution_m
                raise WorldError(
                    f"large: size_m {size:g} is not a whole number (2 to {_LARGEST_CELLS}) of cells of resolution_m "
                    f"{self.resolution_m:g}; nearest: {near:g}"
                )
        return cells[0], cells[1]

    def _inset_materials(self) -> list[str]:
        return [i.material for i in self.insets if i.material is not None]

    def _source(self, x0: float, y0: float, cells: tuple[int, int], origin: GeoOrigin) -> Source:
        g = self.ground
        if isinstance(g, FractalGround):
            shortest = min(2 * self.resolution_m, g.longest_m)
            relief = Fractal(g.seed, g.relief_m, g.longest_m, shortest, g.spectral_slope)
            return FractalSource(relief, -g.mean_depth_m, g.gradient)
        if isinstance(g, SurveyGround):
            return survey_source(g, origin, x0=x0, y0=y0, cells=cells, spacing=self.resolution_m)
        shape = grid_file_shape(g.path)
        if shape != (cells[0] + 1, cells[1] + 1):
            sizes = tuple((n - 1) * self.resolution_m for n in shape)
            raise WorldError(
                f"heights {g.path} hold {shape[0]} x {shape[1]} nodes; size_m {list(self.size_m)} at resolution_m "
                f"{self.resolution_m:g} needs {cells[0] + 1} x {cells[1] + 1}. For this file: size_m: {list(sizes)}"
            )
        return FileSource(g.path, x0=x0, y0=y0, spacing=self.resolution_m)

    def _insets(self, x0: float, y0: float, cells: tuple[int, int]) -> tuple[Inset, ...]:
        names = list(dict.fromkeys([self.material, *self._inset_materials()]))
        made = []
        for index, config in enumerate(self.insets):
            where = f"large: insets[{index}]"
            level = -int(np.ceil(np.log2(self.resolution_m / config.resolution_m) - 1e-9))
            if level >= 0:
                raise WorldError(
                    f"{where}: resolution_m {config.resolution_m:g} must be finer than the world's, "
                    f"{self.resolution_m:g}"
                )
            half = np.array(config.size_m) / 2
            low, high = np.array(config.centre_m) - half, np.array(config.centre_m) + half
            end = (x0 + cells[0] * self.resolution_m, y0 + cells[1] * self.resolution_m)
            if low[0] < x0 or low[1] < y0 or high[0] > end[0] or high[1] > end[1] or half.min() <= 0:
                raise WorldError(
                    f"{where}: x {low[0]:g} .. {high[0]:g}, y {low[1]:g} .. {high[1]:g} m does not lie in the world, "
                    f"x {x0:g} .. {end[0]:g}, y {y0:g} .. {end[1]:g} m"
                )
            chosen = config.material if config.material is not None else self.material
            made.append(
                Inset(
                    low=(float(low[0]), float(low[1])),
                    high=(float(high[0]), float(high[1])),
                    level=level,
                    source=_inset_source(config, index, low, self.resolution_m, where),
                    adds=config.path is None,
                    blend_m=max(float(half.min()) / 5 if config.blend_m is None else config.blend_m, 1e-9),
                    material=names.index(chosen),
                )
            )
        return tuple(sorted(made, key=lambda i: -i.level))

    def _triangles(self, source: Source, standing: int) -> int:
        """Number of triangles that the ground may have beside those that stand on it."""
        things = standing * BYTES_PER_TRIANGLE * 1e-6
        held = getattr(source, "megabytes", 0.0)
        room = (self.memory_mb - PROCESS_MB - held - things) * 1e6
        count = int(room / BYTES_PER_TRIANGLE)
        if count < _LEAST_TRIANGLES:
            least = PROCESS_MB + held + things + _LEAST_TRIANGLES * BYTES_PER_TRIANGLE * 1e-6
            survey = f" (the survey's grid takes {held:.0f} MB of it)" if held > 1 else ""
            survey += f" (the things on it take {things:.0f} MB of it)" if things > 1 else ""
            raise WorldError(
                f"large: memory_mb {self.memory_mb:g} leaves no room for the ground{survey}; allow at least {least:.0f}"
            )
        return count


def _inset_source(config: InsetConfig, index: int, low: NDArray[np.float64], coarse: float, where: str) -> Source:
    if config.path is None:
        shortest = min(2 * config.resolution_m, 2 * coarse)
        return FractalSource(Fractal(7919 + index, config.relief_m, 2 * coarse, shortest, config.spectral_slope), 0.0)
    shape = grid_file_shape(config.path)
    spacing = [s / (n - 1) for s, n in zip(config.size_m, shape, strict=True)]
    if abs(spacing[0] - spacing[1]) > 1e-6 * spacing[0]:
        raise WorldError(
            f"{where}: {config.path} holds {shape[0]} x {shape[1]} nodes, which over size_m {list(config.size_m)} are "
            f"{spacing[0]:g} m apart along x and {spacing[1]:g} m along y; they must be the same"
        )
    z = np.asarray(np.load(config.path, allow_pickle=False), dtype=np.float64)
    return FieldSource(HeightField(float(low[0]), float(low[1]), spacing[0], z))


def _overview(ground: LargeGround) -> Overview:
    step = int(np.ceil(max(ground.cells) / _OVERVIEW))
    nodes = [np.arange(0, c + 1, step) for c in ground.cells]
    i, j = np.meshgrid(*nodes, indexing="ij")
    return Overview(ground.x0, ground.y0, step * ground.spacing, ground.nodes(0, i, j), ground)


def _furthest(ground: LargeGround) -> float:
    """Reach that full resolution could have, were there no limit to memory [m]."""
    return details(ground)[0] * 2 * CELLS * ground.spacing_at(ground.finest)


def _world(config: LargeConfig, site: Site, ground: LargeGround, origin: GeoOrigin, placed: list[str]) -> World:
    overview = _overview(ground)
    geometry = overview.geometry(
        material=ground.materials[0], label=ground.label, instance=ground.instance, name="seabed"
    )
    z = overview.z
    asked, given = config.reach_m or 0.0, reached(ground, Stream(ground).view.detail)
    if given < asked:
        site.notes.append(f"reach_m {asked:g} does not fit into memory_mb {config.memory_mb:g}: it is {given:.4g} m")
    radius = 2 * Stream(ground).view.detail * CELLS * ground.spacing_at(ground.finest)
    notes = [
        f"at most {ground.triangles // TRIANGLES * TRIANGLES} triangles stand in the scene at a time",
        f"full resolution reaches at least {0.6 * radius:.4g} m around a vehicle"
        + (" in the finest inset" if ground.insets else "")
        + f" (up to {_furthest(ground):.4g} m with more memory)",
        "maps and exports show it in full detail where things stand, and coarser elsewhere",
    ]
    notes += [f"inset at {i.low}: drawn at {ground.spacing_at(i.level):g} m" for i in ground.insets]
    return World(
        geometries=(geometry, *site.geometries),
        materials=tuple(site.materials),
        origin=origin,
        name="large",
        description=f"{config.size_m[0] / 1e3:g} km x {config.size_m[1] / 1e3:g} km at {config.resolution_m:g} m, "
        f"z {z.min():.1f} .. {z.max():.1f} m, "
        f"{len(ground.insets)} {'inset' if len(ground.insets) == 1 else 'insets'}"
        + (f": {', '.join(placed)}" if placed else ""),
        terrain=overview,
        notes=(*notes, *site.notes),
        ground=ground,
    )

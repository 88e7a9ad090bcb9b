"""Read a survey file of any of the known formats; everything that can be wrong with it is one `WorldError`."""

from __future__ import annotations

import struct
import zlib
from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final, TypeAlias
from zipfile import BadZipFile

import numpy as np

from pelagos.errors import WorldError, did_you_mean
from pelagos.world.bathymetry.projection import in_degrees
from pelagos.world.bathymetry.read_las import read_las
from pelagos.world.bathymetry.read_netcdf import read_netcdf
from pelagos.world.bathymetry.read_npz import read_npz
from pelagos.world.bathymetry.read_raster import read_raster
from pelagos.world.bathymetry.read_soundings import read_soundings
from pelagos.world.bathymetry.survey import Grid, Soundings, closed
from pelagos.world.bathymetry.values import Unit, in_metres

MATPLOTLIB: Final = "matplotlib:"
"""Prefix of samples that ship inside matplotlib."""

Reader: TypeAlias = Callable[..., Grid | Soundings]

_READERS: Final[dict[str, Reader]] = {
    ".nc": read_netcdf, ".nc4": read_netcdf, ".cdf": read_netcdf, ".grd": read_netcdf,
    ".tif": read_raster, ".tiff": read_raster, ".asc": read_raster, ".bag": read_raster,
    ".npz": read_npz,
    ".las": read_las, ".laz": read_las,
    ".csv": read_soundings, ".xyz": read_soundings, ".txt": read_soundings, ".dat": read_soundings,
}  # fmt: skip
_BEGINNINGS: Final[tuple[tuple[bytes, str, Reader], ...]] = (
    (b"CDF", "NetCDF", read_netcdf), (b"II*\0", "TIFF", read_raster), (b"MM\0*", "TIFF", read_raster),
    (b"II+\0", "TIFF", read_raster), (b"LASF", "LAS", read_las), (b"PK\3\4", "NumPy", read_npz),
    (b"DSAA", "Surfer", read_raster), (b"DSBB", "Surfer", read_raster), (b"DSRB", "Surfer", read_raster),
    (b"ncols", "ESRI ASCII", read_raster), (b"NCOLS", "ESRI ASCII", read_raster),
)  # fmt: skip
"""How files of known formats begin, whatever their names say."""


@dataclass(frozen=True)
class Reading:
    """Way of reading a file.

    Attributes:
        variable: of a file that holds several.
        crs: overrides, or supplies, the file's coordinate system.
        columns: of a text file, in order.
        box: (south, north, west, east) [deg] that will be used; a reader of large grids may leave out the rest.
        unit: of the values; "auto" for the file's own.
    """

    variable: str | None
    crs: str | None
    columns: str
    box: tuple[float, float, float, float] | None
    unit: Unit = "auto"


def read_survey(source: str, how: Reading) -> Grid | Soundings:
    """Read `source`, a path or "matplotlib:NAME": values in metres, NaN where there are none.

    Raises:
        WorldError: missing, of an unknown kind, unreadable, truncated, empty, without any value, or without a known
            coordinate system.
    """
    path = _matplotlib_sample(source) if source.startswith(MATPLOTLIB) else Path(source)
    if not path.is_file():
        near = did_you_mean(path.name, [p.name for p in path.parent.glob("*")]) if path.parent.is_dir() else ""
        raise WorldError(f"bathymetry file {path} does not exist{near}")
    if path.stat().st_size == 0:
        raise WorldError(f"bathymetry file {path} is empty (0 bytes)")
    suffix = Path(path.stem).suffix.lower() if path.suffix.lower() == ".gz" else path.suffix.lower()
    if suffix not in _READERS:
        raise WorldError(f"bathymetry file {path}: the format {suffix!r} is not read; known: {', '.join(_READERS)}")
    reader, note = _reader(path, suffix)
    survey = _guarded(reader, path, how)
    if survey.z.size == 0:
        raise WorldError(f"bathymetry file {path} holds no values")
    if not np.isfinite(survey.z).any():
        raise WorldError(
            f"bathymetry file {path}: all {survey.z.size} values of {survey.name!r} are NaN or marked as missing"
        )
    if not survey.crs:
        latlon = float(np.abs(survey.u).max()) <= 90 and float(np.abs(survey.v).max()) <= 360
        likely = "; the numbers look like longitude and latitude: crs: EPSG:4326" if latlon else ", as crs: EPSG:32633"
        raise WorldError(f"bathymetry file {path} does not say its coordinate system; say it in the scenario{likely}")
    _check_units(path, survey)
    if isinstance(survey, Grid) and in_degrees(survey.crs):
        survey = closed(survey)
    survey = in_metres(str(path), survey, how.unit)
    return replace(survey, notes=(*note, *survey.notes))


def _reader(path: Path, suffix: str) -> tuple[Reader, tuple[str, ...]]:
    """Reader of a file: by how it begins, where that is known, else by its name."""
    reader = _READERS[suffix]
    with path.open("rb") as file:
        begins = file.read(8)
    for start, what, other in _BEGINNINGS:
        if begins.startswith(start) and other is not reader:
            return other, (f"{path.name} is named {suffix}, but begins as {what}, and was read as such",)
    return reader, ()


def _check_units(path: Path, survey: Grid | Soundings) -> None:
    """Degrees that are said to be metres, and the other way round.

    Raises:
        WorldError: the coordinates cannot be in the coordinate system.
    """
    u, v = (float(np.abs(c).max()) for c in (survey.u, survey.v))
    degrees = in_degrees(survey.crs)
    if degrees and (u > 90.01 or v > 540.01):
        raise WorldError(
            f"bathymetry file {path}: coordinates up to {v:g} and {u:g} cannot be longitudes and latitudes, which "
            f"{survey.crs} needs; if they are metres, say their coordinate system in the scenario (crs: EPSG:...)"
        )
    if not degrees and u <= 90 and v <= 360 and max(np.ptp(survey.u), np.ptp(survey.v)) < 5:
        raise WorldError(
            f"bathymetry file {path}: coordinates about {v:g} and {u:g} look like degrees, but {survey.crs} counts in "
            "metres; for longitudes and latitudes say crs: EPSG:4326"
        )


def _guarded(reader: Reader, path: Path, how: Any) -> Grid | Soundings:
    try:
        return reader(path, how)
    except WorldError:
        raise
    except (
        OSError,
        EOFError,
        ArithmeticError,
        LookupError,
        MemoryError,
        RuntimeError,
        TypeError,
        ValueError,
        BadZipFile,
        struct.error,
        zlib.error,
    ) as error:
        text = str(error).strip() or type(error).__name__
        raise WorldError(f"bathymetry file {path} cannot be read; it may be damaged or cut short ({text})") from error


def _matplotlib_sample(source: str) -> Path:
    from matplotlib import cbook

    name = source.removeprefix(MATPLOTLIB)
    found = Path(str(cbook.get_sample_data("topobathy.npz", asfileobj=False))).with_name(name)
    if not found.is_file():
        raise WorldError(f"matplotlib ships no sample {name!r}; it has topobathy.npz")
    return found

"""Gridded surveys as rasters, through GDAL: GeoTIFF, ESRI ASCII, BAG, Surfer grids."""

from __future__ import annotations

import warnings
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError, did_you_mean
from pelagos.world.bathymetry.axes import check_axes, plain, thinned, whole, window
from pelagos.world.bathymetry.projection import HOW_TO_INSTALL, in_degrees, vertical_axis
from pelagos.world.bathymetry.survey import Grid, rising

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading

DRIVERS: Final = {
    b"II*\0": "GTiff", b"MM\0*": "GTiff", b"II+\0": "GTiff", b"MM\0+": "GTiff", b"\x89HDF": "BAG", b"DSAA": "GSAG",
    b"DSBB": "GSBG", b"DSRB": "GS7BG",
}  # fmt: skip
"""The drivers of GDAL that may read a file, by how it begins, and AAIGrid for text: none follows references to other
files or to the network."""
_NO_NETWORK: Final = {
    "GDAL_DISABLE_READDIR_ON_OPEN": "EMPTY_DIR",  # no side files either
    "GDAL_HTTP_MAX_RETRY": 0, "GDAL_HTTP_TIMEOUT": 1, "CPL_VSIL_CURL_ALLOWED_EXTENSIONS": ".none", "GDAL_CACHEMAX": 256,
}  # fmt: skip
_STRIP: Final = 2048  # rows that are read at a time where only some of them are kept


def read_raster(path: Path, how: Reading) -> Grid:
    """One band of anything that GDAL reads as an upright raster; values stand for the middle of a pixel."""
    try:
        import rasterio
    except ImportError as error:
        raise WorldError(f"bathymetry file {path} needs the package rasterio; {HOW_TO_INSTALL}") from error
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", rasterio.errors.NotGeoreferencedWarning)  # said below, in words
        with rasterio.Env(**_NO_NETWORK):
            raster = rasterio.open(path, driver=_driver(path))
    with rasterio.Env(**_NO_NETWORK), raster:
        t = raster.transform
        _refuse(path, raster, how)
        crs = how.crs or (_crs_text(raster.crs) if raster.crs else "")
        v = t.c + t.a * (np.arange(raster.width) + 0.5)
        u = t.f + t.e * (np.arange(raster.height) + 0.5)
        check_axes(path, u, v, ("y", "x"), latlon=bool(crs) and in_degrees(crs))
        rows, columns = window(u, v, crs, how)
        band = _band(path, raster, how.variable)
        said, words = vertical_axis(raster.crs.to_wkt()) if raster.crs else ("", "")
        unit = raster.units[band - 1] or said
        z = _read(raster, band, rows, columns)
        name = raster.descriptions[band - 1] or f"band {band}"
        grid = rising(u[rows], v[columns], z)
        return Grid(*grid, crs, name, None, whole(u, v), unit, words, thinned(rows))


def _driver(path: Path) -> str:
    with path.open("rb") as file:
        return DRIVERS.get(file.read(4), "AAIGrid")


def _refuse(path: Path, raster: Any, how: Reading) -> None:
    t = raster.transform
    if t.is_identity:
        how_to = "gdalwarp IN OUT" if raster.gcps[0] else "gdal_edit.py -a_srs EPSG:... -a_ullr WEST NORTH EAST SOUTH"
        raise WorldError(f"bathymetry file {path} does not say where on Earth its pixels lie; add that first: {how_to}")
    if abs(t.b) > 1e-12 or abs(t.d) > 1e-12:
        raise WorldError(f"bathymetry file {path} is a rotated raster; turn it upright first: gdalwarp IN OUT")
    if how.variable is None and raster.count >= 3 and set(raster.dtypes) == {"uint8"}:
        raise WorldError(
            f"bathymetry file {path} is a picture ({raster.count} bands of bytes), not heights; if one of its bands "
            "holds heights, say its number (variable: '1')"
        )


def _band(path: Path, raster: Any, asked: str | None) -> int:
    """A band by its number or description; the first where none is asked for."""
    if asked is None:
        return 1
    names = [d or "" for d in raster.descriptions]
    if asked in names:
        return names.index(asked) + 1
    if asked.isdigit() and 1 <= int(asked) <= raster.count:
        return int(asked)
    known = [n for n in names if n]
    has = f"{raster.count} bands" + (f": {', '.join(known)}" if known else "")
    raise WorldError(f"bathymetry file {path} has no band {asked!r}{did_you_mean(asked, known)}; it has {has}")


def _read(raster: Any, band: int, rows: slice, columns: slice) -> NDArray[np.float64]:
    """Values of a part of a band, scaled as the file says."""
    from rasterio.windows import Window

    strip = rows.stop - rows.start if rows.step == 1 else _STRIP // rows.step * rows.step
    parts = []
    for first in range(rows.start, rows.stop, strip):
        count = min(strip, rows.stop - first)
        part = Window(columns.start, first, columns.stop - columns.start, count)
        parts.append(plain(raster.read(band, window=part, masked=True)[:: rows.step, :: columns.step]))
    z = np.concatenate(parts)
    scale, offset = raster.scales[band - 1], raster.offsets[band - 1]
    return z if (scale, offset) == (1.0, 0.0) else z * scale + offset


def _crs_text(crs: Any) -> str:
    code = crs.to_epsg()
    return f"EPSG:{code}" if code else str(crs.to_wkt())

"""Soundings as LAS or LAZ point clouds, as multibeam and airborne laser surveys deliver them (through laspy)."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pelagos.errors import WorldError
from pelagos.world.bathymetry.projection import HOW_TO_INSTALL, vertical_axis
from pelagos.world.bathymetry.survey import Soundings

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading

_NOISE: Final = (7, 18)  # ASPRS classes of low and high noise
_WATER: Final = (9, 41, 42, 45)  # water: ASPRS 9, and those of the topo-bathymetric domain that are not the bed
_PACKED: Final = 100  # LAZ packs points to a tenth; to a hundredth is beyond it
_BED: Final = 40  # ASPRS topo-bathymetric domain profile: bathymetric point


def read_las(path: Path, how: Reading) -> Soundings:
    """Points of a LAS or LAZ file without those classified as noise or water surface, and without withheld ones.

    Where any point is classified as bathymetric (ASPRS class 40), only those and the ground (class 2) are taken.
    """
    try:
        import laspy
    except ImportError as error:
        raise WorldError(f"bathymetry file {path} needs the package laspy; {HOW_TO_INSTALL}") from error
    try:
        _refuse_lying(path)
        cloud = laspy.read(path)
    except WorldError:
        raise
    except Exception as error:  # laspy and lazrs raise whatever damaged files lead to
        raise WorldError(f"bathymetry file {path} cannot be read: {error}") from error
    if len(cloud.points) < cloud.header.point_count:
        has = f"{len(cloud.points)} of {cloud.header.point_count} points"
        raise WorldError(f"bathymetry file {path} cannot be read; it holds {has}: it is cut short")
    keep = _bed(np.asarray(cloud.classification)) & ~np.asarray(cloud.withheld).astype(bool)
    u, v, z = (np.asarray(a, dtype=np.float64)[keep] for a in (cloud.y, cloud.x, cloud.z))
    crs, unit, words = _crs(cloud.header)
    return Soundings(u, v, z, how.crs or crs, "z", None, unit, words)


def _refuse_lying(path: Path) -> None:
    """Refuse a header that promises more than the file can hold, before memory and time are given to it.

    Fields: ASPRS, LAS Specification 1.4 R15, Table 3.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        header = file.read(375).ljust(375, b"\0")
    minor, header_size, points_at, records = header[25], *struct.unpack_from("<HII", header, 94)
    kind, width, count = struct.unpack_from("<BHI", header, 104)
    extended = 0
    if minor >= 4:
        extended, count = struct.unpack_from("<IQ", header, 243)
    packed = bool(kind & 0xC0)  # as LAZ marks it
    if header[24] != 1 or not 227 <= header_size <= points_at <= size:
        raise WorldError(f"bathymetry file {path} cannot be read; its header is no LAS header: it is damaged")
    if (
        records * 54 > points_at - header_size
        or extended * 60 > size
        or count * width > size * (_PACKED if packed else 1)
    ):
        raise WorldError(
            f"bathymetry file {path} cannot be read; its header says {count} points and {records + extended} records, "
            f"which {size} bytes cannot hold: it is cut short or damaged"
        )


def _bed(classes: Any) -> Any:
    """`(k,)` which points are taken."""
    if (classes == _BED).any():
        return np.isin(classes, (2, _BED))
    return ~np.isin(classes, _NOISE + _WATER)


def _crs(header: Any) -> tuple[str, str, str]:
    """The horizontal coordinate system, "" where the file says none; the heights' unit, and "depth" if they count down.

    Where a file in feet says nothing about its heights, they are taken to be in the same feet.
    """
    try:
        known = header.parse_crs()
    except ImportError as error:
        raise WorldError(f"the coordinate system of a LAS file needs the package pyproj; {HOW_TO_INSTALL}") from error
    if known is None:
        return "", "", ""
    flat = next((part for part in known.sub_crs_list if part.is_projected or part.is_geographic), known)
    unit, words = vertical_axis(known.to_wkt())
    if not unit and flat.is_projected:
        unit = str(flat.axis_info[0].unit_name)
    code = flat.to_epsg()
    return f"EPSG:{code}" if code else str(flat.to_wkt()), unit, words

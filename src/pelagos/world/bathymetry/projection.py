"""From a survey's own coordinates to latitude and longitude and back."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError

_PLAIN: Final = ("EPSG:4326", "OGC:CRS84", "WGS84", "WGS 84")
HOW_TO_INSTALL: Final = "install it with: pip install 'pelagos[bathymetry]'"


def is_latlon(crs: str) -> bool:
    """Whether coordinates are latitude and longitude on WGS 84 itself, for which no library is needed."""
    return crs.upper() in _PLAIN


def in_degrees(crs: str) -> bool:
    """Whether coordinates are degrees.

    Raises:
        WorldError: as `to_latlon`.
    """
    return is_latlon(crs) or _known(crs).is_geographic


def vertical_axis(crs: str) -> tuple[str, str]:
    """The unit of a compound coordinate system's heights, "" where it says none, and "depth" where they count down.

    Files are not to be trusted with the latter: BAG is always upwards, whatever its vertical datum.
    """
    known = _known(crs)
    axes = [a for part in (known.sub_crs_list or [known]) for a in part.axis_info if a.direction in ("up", "down")]
    return (str(axes[0].unit_name), "depth" if axes[0].direction == "down" else "") if axes else ("", "")


def to_latlon(
    crs: str, u: NDArray[np.float64], v: NDArray[np.float64]
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """(northing or latitude, easting or longitude) -> WGS 84 (latitude, longitude) [deg].

    Raises:
        WorldError: the coordinate system is unknown, or pyproj is not installed.
    """
    if is_latlon(crs):
        return u, _wrap(v)
    longitude, latitude = _transformer(crs, True)(v, u)
    return np.asarray(latitude), np.asarray(longitude)


def from_latlon(
    crs: str, latitude: NDArray[np.float64], longitude: NDArray[np.float64], *, near: float = 0.0
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """WGS 84 (latitude, longitude) [deg] -> the survey's (u, v); a longitude falls within 180 degrees of `near`."""
    if is_latlon(crs):
        return latitude, near + _wrap(longitude - near)
    easting, northing = _transformer(crs, False)(longitude, latitude)
    return np.asarray(northing), np.asarray(easting)


def _wrap(degrees: NDArray[np.float64]) -> NDArray[np.float64]:
    inside = (degrees >= -180) & (degrees <= 180)
    return np.where(inside, degrees, (degrees + 180) % 360 - 180)


@cache
def _known(crs: str) -> Any:
    try:
        import pyproj
    except ImportError as error:
        raise WorldError(f"the coordinate system {crs!r} needs the package pyproj; {HOW_TO_INSTALL}") from error
    try:
        return pyproj.CRS.from_user_input(crs)
    except pyproj.exceptions.CRSError as error:
        raise WorldError(
            f"{crs!r} is not a coordinate system that pyproj knows; write an EPSG code such as crs: EPSG:32633"
        ) from error


@cache
def _transformer(crs: str, forward: bool) -> Callable[..., Any]:
    known = _known(crs)
    import pyproj

    ends = (known, "EPSG:4326") if forward else ("EPSG:4326", known)
    made: Callable[..., Any] = pyproj.Transformer.from_crs(*ends, always_xy=True).transform
    return made

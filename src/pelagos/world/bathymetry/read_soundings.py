"""Scattered soundings: text with three or more columns, plain or gzipped."""

from __future__ import annotations

import gzip
import io
import re
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.world.bathymetry.survey import Soundings

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading

_MEANING: Final = {
    "x": "v", "easting": "v", "east": "v", "e": "v", "lon": "v", "longitude": "v", "long": "v",
    "y": "u", "northing": "u", "north": "u", "n": "u", "lat": "u", "latitude": "u",
    "z": "z", "depth": "z", "elevation": "z", "height": "z", "elev": "z", "altitude": "z",
}  # fmt: skip
_DEGREES: Final = {"lon", "longitude", "long", "lat", "latitude"}


def read_soundings(path: Path, how: Reading) -> Soundings:
    """Rows of x, y, z with any of comma, semicolon, tab and blank between; a header line, if any, names the columns."""
    raw = gzip.decompress(path.read_bytes()) if path.suffix.lower() == ".gz" else path.read_bytes()
    text = raw.decode("utf-8", errors="replace").lstrip("\ufeff")
    lines = text.splitlines()
    start = next((k for k, line in enumerate(lines[:200]) if _numbers(line) is not None), None)
    if start is None:
        raise WorldError(f"bathymetry file {path} holds no row of numbers")
    header = [c.strip().lower() for c in re.split(r"[,;\t ]+", lines[start - 1].strip(" #\t"))] if start else []
    order = _order(path, header, how.columns)
    values = _table(path, lines, start)
    if values.shape[1] <= max(order.values()):
        raise WorldError(
            f"bathymetry file {path} has {values.shape[1]} columns; x, y and z need at least {max(order.values()) + 1}"
        )
    u, v, z = values[:, order["u"]], values[:, order["v"]], values[:, order["z"]]
    keep = np.isfinite(u) & np.isfinite(v) & np.isfinite(z)
    degrees = bool(_DEGREES & set(header))
    if degrees and len(u) and np.abs(u[keep]).max(initial=0) > 90.0001:
        raise WorldError(
            f"bathymetry file {path}: its latitudes run to {np.abs(u[keep]).max():g}; are the columns exchanged?"
        )
    name = next((h for h in header if _MEANING.get(h) == "z"), "z")
    return Soundings(u[keep], v[keep], z[keep], how.crs or ("EPSG:4326" if degrees else ""), name)


def _order(path: Path, header: list[str], columns: str) -> dict[str, int]:
    """Where northing u, easting v and value z stand."""
    named = {_MEANING[h]: k for k, h in reversed(list(enumerate(header))) if h in _MEANING}
    if len(named) == 3:
        return named
    if sorted(columns) != ["x", "y", "z"]:
        raise WorldError(
            f"bathymetry file {path}: columns must be an order of x, y and z such as 'xyz', not {columns!r}"
        )
    return {"v": columns.index("x"), "u": columns.index("y"), "z": columns.index("z")}


def _numbers(line: str) -> list[float] | None:
    cells = [c for c in re.split(r"[,;\t ]+", line.strip()) if c]
    try:
        return [float(c) for c in cells] if len(cells) >= 3 else None
    except ValueError:
        return None


def _table(path: Path, lines: list[str], start: int) -> NDArray[np.float64]:
    body = lines[start:]
    while body and not body[-1].strip():
        body.pop()
    joint = "\n".join(body).translate(str.maketrans(",;\t", "   "))
    try:
        return np.loadtxt(io.StringIO(joint), dtype=np.float64, ndmin=2)
    except ValueError as error:
        width = len(_numbers(body[0]) or [])
        for k, line in enumerate(body):
            if line.strip() and len(_numbers(line) or []) != width:
                shown = line[:60]
                raise WorldError(
                    f"bathymetry file {path}, line {start + k + 1}: {shown!r} is not a row of {width} numbers; "
                    "the file may be damaged or cut short"
                ) from error
        raise

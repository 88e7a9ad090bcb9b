"""Scattered soundings: text with three or more columns, plain or gzipped."""

from __future__ import annotations

import io
import re
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import WorldError
from pelagos.world.bathymetry.survey import Soundings
from pelagos.world.bathymetry.values import known_unit
from pelagos.world.size import unpacked

if TYPE_CHECKING:
    from pelagos.world.bathymetry.read import Reading

_MEANING: Final = {
    "x": "v", "easting": "v", "east": "v", "e": "v", "lon": "v", "longitude": "v", "long": "v",
    "y": "u", "northing": "u", "north": "u", "n": "u", "lat": "u", "latitude": "u",
    "z": "z", "depth": "z", "elevation": "z", "height": "z", "elev": "z", "altitude": "z",
}  # fmt: skip
_SINGLE: Final = {"e", "n"}  # too short to mean anything as a part of a name
_DEGREES: Final = {"lon", "longitude", "long", "lat", "latitude"}
_HEAD: Final = 200  # lines among which the first row of numbers is looked for


@dataclass(frozen=True)
class _Layout:
    """Layout of a text file.

    Attributes:
        mark: between columns; None for any blanks.
        comma: whether numbers have decimal commas.
        start: the first row of numbers.
        order: the columns of northing u, easting v and value z.
        header: names of the columns, "" where there are none.
    """

    mark: str | None
    comma: bool
    start: int
    order: dict[str, int]
    header: list[str]

    def cells(self, line: str) -> list[str]:
        return _cells(line, self.mark, self.comma)

    def triple(self, line: str) -> list[float] | None:
        """The three numbers of a row, NaN for empty cells; None where it is no row."""
        return _triple(self.cells(line), self.order)


def read_soundings(path: Path, how: Reading) -> Soundings:
    """Rows of x, y, z with comma, semicolon, tab or blanks between; a header line, if any, names the columns.

    Columns that are not asked for may hold anything; decimal commas are understood where commas do not separate. Empty
    lines, and lines of nothing but separators, are passed over.
    """
    text = unpacked(path, "bathymetry file").decode("utf-8", errors="replace")
    lines = text.lstrip("\ufeff").splitlines()
    layout = _layout(path, lines, how.columns)
    u, v, z = _table(path, lines, layout).T
    keep = np.isfinite(u) & np.isfinite(v) & np.isfinite(z)
    words = [_words(layout.header[layout.order[k]]) if layout.header else [] for k in "uvz"]
    degrees = bool(_DEGREES & {*words[0], *words[1]})
    if degrees and np.abs(u[keep]).max(initial=0) > 90.0001:
        raise WorldError(
            f"bathymetry file {path}: its latitudes run to {np.abs(u[keep]).max():g}; are the columns exchanged?"
        )
    name = layout.header[layout.order["z"]].strip() if layout.header else "z"
    unit = next((w for w in words[2] if known_unit(w)), "")
    crs = how.crs or ("EPSG:4326" if degrees else "")
    left = int((~keep).sum())
    notes = (f"{left} rows without a value were left out",) if left else ()
    return Soundings(u[keep], v[keep], z[keep], crs, name, unit=unit, notes=notes)


def _layout(path: Path, lines: list[str], columns: str) -> _Layout:
    before = ""
    few = 0
    for k, line in enumerate(lines[:_HEAD]):
        mark, comma = _separator(line)
        header = _cells(before.lstrip("#% \t"), _separator(before)[0], False)
        cells = _cells(line, mark, comma)
        if mark is None and len(header) != len(cells):
            header = [c for c in header if not c.startswith(("(", "["))]  # units that stand apart
        named = _named(header) if len(header) <= len(cells) else None
        if _triple(cells, order := named or _order(path, columns)) is not None:
            return _Layout(mark, comma, k, order, header if named else [])
        few = max(few, len(cells) if cells and _number(cells[0]) is not None else 0)
        before = line if line.strip() else before
    if few:
        raise WorldError(f"bathymetry file {path} has {few} columns of numbers; x, y and z need 3")
    raise WorldError(f"bathymetry file {path} holds no row of numbers")


def _separator(line: str) -> tuple[str | None, bool]:
    """Separator of columns, and whether numbers have decimal commas."""
    for mark in (";", "\t"):
        if mark in line:
            return mark, "," in line and "." not in line
    blank = line.split()
    if len(blank) >= 3 and all(re.fullmatch(r"[-+]?\d+,\d+", c) for c in blank):
        return None, True
    return ("," if "," in line else None), False


def _cells(line: str, mark: str | None, comma: bool) -> list[str]:
    found = [c.strip().strip('"') for c in line.split(mark)]
    return [c.replace(",", ".") for c in found] if comma else found


def _words(name: str) -> list[str]:
    return re.findall(r"[a-z]+", name.lower())


def _named(header: list[str]) -> dict[str, int] | None:
    """Columns of u, v and z by their names: whole names first, then their parts, the first of each."""
    found: dict[str, int] = {}
    for k, name in enumerate(header):
        if name.lower() in _MEANING:
            found.setdefault(_MEANING[name.lower()], k)
    for k, name in enumerate(header):
        for word in _words(name):
            if word in _MEANING and word not in _SINGLE and k not in found.values():
                found.setdefault(_MEANING[word], k)
    return found if len(found) == 3 else None


def _order(path: Path, columns: str) -> dict[str, int]:
    if sorted(columns) != ["x", "y", "z"]:
        raise WorldError(
            f"bathymetry file {path}: columns must be an order of x, y and z such as 'xyz', not {columns!r}"
        )
    return {"v": columns.index("x"), "u": columns.index("y"), "z": columns.index("z")}


def _number(cell: str) -> float | None:
    try:
        return float(cell) if cell else np.nan
    except ValueError:
        return None


def _triple(cells: list[str], order: dict[str, int]) -> list[float] | None:
    if len(cells) <= max(order.values()) or not any(cells):
        return None
    found = [_number(cells[order[k]]) for k in "uvz"]
    return [f for f in found if f is not None] if None not in found else None


def _table(path: Path, lines: list[str], layout: _Layout) -> NDArray[np.float64]:
    """`(k, 3)` u, v and z."""
    body = lines[layout.start :]
    text = "\n".join(body)
    try:
        return np.loadtxt(
            io.StringIO(text.replace(",", ".") if layout.comma else text),
            delimiter=layout.mark,
            usecols=[layout.order[k] for k in "uvz"],
            dtype=np.float64,
            ndmin=2,
            quotechar='"',
        )
    except ValueError:  # empty cells, or a damaged row: slowly, line by line
        pass
    rows = []
    for k, line in enumerate(body):
        plain = line.split("#")[0]
        if not any(layout.cells(plain)):  # an empty line, or, as spreadsheets write it, marks alone
            continue
        row = layout.triple(plain)
        if row is None:
            raise WorldError(
                f"bathymetry file {path}, line {layout.start + k + 1}: {line[:60]!r} holds no x, y and z in columns "
                f"{', '.join(str(c + 1) for c in sorted(layout.order.values()))}; the file may be damaged or cut short"
            )
        rows.append(row)
    return np.array(rows, dtype=np.float64)

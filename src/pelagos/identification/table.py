"""Columns of a CSV file, by name."""

from __future__ import annotations

import csv
import gzip
import io
from collections.abc import Collection, Mapping
from pathlib import Path
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError, LookupFailed, did_you_mean

Table = Mapping[str, NDArray[np.float64]]
_RECORDING: Final = b"\x89MCAP"
_SEPARATORS: Final = {";": "semicolons", "\t": "tabs", "|": "bars"}


def read_table(path: str | Path, names: Collection[str] | None = None) -> dict[str, NDArray[np.float64]]:
    """Columns of a CSV file by the names in its first line; `.csv.gz` too.

    Args:
        path: of the file.
        names: of the columns that are read, others may hold anything; None: all.

    Raises:
        InputError: no such file, no names, another separator, a row of another length, or a cell that is no number
            (names line and column).
        LookupFailed: no column has one of these names.
    """
    path = Path(path)
    if not path.exists():
        others = [p.name for p in path.parent.iterdir()] if path.parent.is_dir() else []
        raise InputError(f"{path}: there is no such file{did_you_mean(path.name, others)}")
    try:
        raw = gzip.decompress(path.read_bytes()) if path.suffix == ".gz" else path.read_bytes()
        rows = csv.reader(io.StringIO(raw.decode("utf-8-sig"), newline=""))
        lines = [(n, row) for n, row in enumerate(rows, 1) if row and not row[0].startswith("#")]
    except UnicodeDecodeError as error:
        if raw.startswith(_RECORDING):
            raise InputError(f"{path}: is a recording, whose name must end in .mcap") from None
        raise InputError(
            f"{path}: is no text in UTF-8 (byte {error.start}): give a CSV file (.csv, .csv.gz) or a recording (.mcap)"
        ) from None
    except (OSError, EOFError, csv.Error) as error:
        raise InputError(f"{path}: cannot be read: {error}") from error
    if len(lines) < 2:
        raise InputError(f"{path}: needs a first line with names of columns and rows of numbers below it")
    heads = [name.strip() for name in lines[0][1]]
    _separated(heads, path)
    if len(set(heads)) < len(heads):
        twice = sorted({n for n in heads if heads.count(n) > 1})
        raise InputError(f"{path}: columns with the same name: {', '.join(twice)}")
    for name in names or ():
        if name not in heads:
            raise LookupFailed("column", name, heads, where=str(path))
    places = [k for k, name in enumerate(heads) if names is None or name in names]
    table = np.empty((len(lines) - 1, len(places)))
    for k, (n, row) in enumerate(lines[1:]):
        if len(row) != len(heads):
            raise InputError(f"{path}:{n}: {len(row)} cells, but the first line names {len(heads)} columns")
        for j, place in enumerate(places):
            table[k, j] = _number(row[place], f"{path}:{n}: column {heads[place]!r}")
    return {heads[place]: table[:, j] for j, place in enumerate(places)}


def _separated(heads: list[str], path: Path) -> None:
    if len(heads) > 1:
        return
    for sign, word in _SEPARATORS.items():
        if sign in heads[0]:
            raise InputError(
                f"{path}: the first line has {word} and no comma: separate cells with commas, and write 0.5, not 0,5"
            )


def _number(cell: str, where: str) -> float:
    if not cell.strip():
        return float("nan")
    try:
        return float(cell)
    except ValueError:
        raise InputError(f"{where}: {cell.strip()!r} is not a number") from None


def numeric(values: Any, label: str) -> NDArray[Any]:
    """Numbers of a column that Python gives `(n,)`, integers as they are; cells of text are read as those of a file.

    Raises:
        InputError: it is no column, or holds dates or something that is no number (names the row).
    """
    if isinstance(values, np.ma.MaskedArray):
        values = np.ma.filled(values.astype(np.float64), np.nan)
    try:
        raw = np.asarray(values)
    except ValueError as error:
        raise InputError(f"{label} is no column of numbers: {error}") from error
    if raw.ndim != 1:
        given = f"has the shape {raw.shape}" if raw.ndim else f"is {values!r}"
        raise InputError(f"{label} {given}: give one number a row")
    if raw.dtype.kind in "iuf":
        return raw
    if raw.dtype.kind in "mM":
        raise InputError(
            f"{label} holds dates and not numbers: give seconds, such as (t - t[0]) / np.timedelta64(1, 's')"
        )
    if raw.dtype.kind == "c":
        raise InputError(f"{label} holds complex numbers: give real ones")
    return np.array([_cell(cell, f"{label}, row {k + 1}") for k, cell in enumerate(raw)], dtype=np.float64)


def _cell(cell: Any, where: str) -> float:
    if cell is None:
        return float("nan")
    if isinstance(cell, str):
        return _number(cell, where)
    try:
        return float(cell)
    except (TypeError, ValueError):
        raise InputError(f"{where}: {cell!r} is not a number") from None

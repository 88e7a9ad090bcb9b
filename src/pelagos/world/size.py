"""Sizes of files before they are unpacked: what would not fit is refused, whatever it says of itself."""

from __future__ import annotations

import gzip
import math
import zlib
from pathlib import Path
from typing import Final
from zipfile import BadZipFile, ZipFile

from numpy.lib.format import read_array_header_1_0, read_array_header_2_0, read_magic

from pelagos.errors import WorldError

MAX_BYTES: Final = 2 << 30  # of one file, unpacked
_PIECE: Final = 1 << 24


def refuse_large(path: Path, what: str) -> None:
    """Refuse a file that is too large, and an archive that would be when it is unpacked.

    Raises:
        WorldError: it is larger than `MAX_BYTES`.
    """
    size = path.stat().st_size
    with path.open("rb") as file:
        begins = file.read(4)
    if begins == b"PK\x03\x04":
        try:
            with ZipFile(path) as archive:
                size = max(size, sum(entry.file_size for entry in archive.infolist()))
                _refuse_lying(archive, path, what)
        except BadZipFile:
            return  # its reader says what is wrong
    if size > MAX_BYTES:
        raise WorldError(f"{what} {path} has {size / 1e9:.1f} GB unpacked; at most {MAX_BYTES / 1e9:.1f} GB are read")


def _refuse_lying(archive: ZipFile, path: Path, what: str) -> None:
    """Refuse an archive with an array that says that it is larger than it is."""
    for entry in archive.infolist():
        if not entry.filename.endswith(".npy"):
            continue
        try:
            with archive.open(entry) as file:
                read = read_array_header_1_0 if read_magic(file) == (1, 0) else read_array_header_2_0
                shape, _, dtype = read(file)
        except (ValueError, OSError, EOFError, BadZipFile, zlib.error, NotImplementedError, RuntimeError):
            continue  # its reader says what is wrong
        says = math.prod(map(float, shape)) * dtype.itemsize
        if says > entry.file_size:
            name = entry.filename.removesuffix(".npy")
            has = f"says that it has {says / 1e9:.3g} GB, and has {entry.file_size / 1e9:.3g}"
            raise WorldError(f"{what} {path}: array {name!r} {has}")


def unpacked(path: Path, what: str) -> bytes:
    """The bytes of a file, unpacked where it is gzipped.

    Raises:
        WorldError: they are more than `MAX_BYTES`.
    """
    refuse_large(path, what)
    with path.open("rb") as file:
        if file.read(2) != b"\x1f\x8b":
            file.seek(0)
            return file.read()
    parts, size = [], 0
    with gzip.open(path) as packed:
        while part := packed.read(_PIECE):
            parts.append(part)
            size += len(part)
            if size > MAX_BYTES // 4:  # as text it takes four times that in memory
                raise WorldError(f"{what} {path} has more than {MAX_BYTES / 4e9:.1f} GB of text when it is unpacked")
    return b"".join(parts)

"""Files that appear whole: written under another name, then given their own."""

from __future__ import annotations

import contextlib
import errno
import os
from collections.abc import Iterator
from pathlib import Path


def give_name(fresh: Path, path: Path) -> None:
    """Rename `fresh` to `path`, in place of the file that has that name.

    Raises:
        OSError: it cannot be renamed, or `path` is a device, a pipe or a folder, which a rename would take away.
    """
    refuse_other_than_file(path)
    os.replace(fresh, path)


@contextlib.contextmanager
def whole(path: Path) -> Iterator[Path]:
    """Another name to write a file under, which becomes `path` at the end; after an error nothing is left of it.

    Raises:
        OSError: it cannot be written; tells the file's name, which the error of a full disk lacks.
    """
    fresh = path.with_name(f".new.{path.name}")
    try:
        yield fresh
        give_name(fresh, path)
    except OSError as error:
        if error.filename not in (None, fresh, str(fresh)):
            raise
        raise OSError(error.errno, error.strerror, str(path)) from error
    finally:
        with contextlib.suppress(OSError):
            fresh.unlink(missing_ok=True)


def write_whole(path: Path, data: str | bytes) -> None:
    """Write a file of bytes, or of text in UTF-8, whole or not at all.

    Raises:
        OSError: it cannot be written; tells the file's name.
    """
    with whole(path) as fresh:
        if isinstance(data, bytes):
            fresh.write_bytes(data)
        else:
            fresh.write_text(data, encoding="utf-8")


def refuse_other_than_file(path: Path) -> None:
    """Refuse a name that something other than a file has.

    Raises:
        FileExistsError: it is a device, a pipe or a folder.
    """
    if path.exists() and not path.is_file():
        what = "a folder" if path.is_dir() else "a device or a pipe"
        raise FileExistsError(errno.EEXIST, f"is {what}, not a file", str(path))

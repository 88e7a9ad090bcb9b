"""Files that appear whole: written under another name, then given their own."""

from __future__ import annotations

import contextlib
import errno
import os
from pathlib import Path


def give_name(fresh: Path, path: Path) -> None:
    """Rename `fresh` to `path`, in place of the file that has that name.

    Raises:
        OSError: it cannot be renamed, or `path` is a device, a pipe or a folder, which a rename would take away.
    """
    refuse_other_than_file(path)
    os.replace(fresh, path)


def write_whole(path: Path, text: str) -> None:
    """Write a file of text in UTF-8, whole or not at all.

    Raises:
        OSError: it cannot be written; tells the file's name, which the error of a full disk lacks.
    """
    fresh = path.with_name(f".{path.name}.new")
    try:
        fresh.write_text(text, encoding="utf-8")
        give_name(fresh, path)
    except OSError as error:
        with contextlib.suppress(OSError):
            fresh.unlink(missing_ok=True)
        raise OSError(error.errno, error.strerror, str(path)) from error


def refuse_other_than_file(path: Path) -> None:
    """Refuse a name that something other than a file has.

    Raises:
        FileExistsError: it is a device, a pipe or a folder.
    """
    if path.exists() and not path.is_file():
        what = "a folder" if path.is_dir() else "a device or a pipe"
        raise FileExistsError(errno.EEXIST, f"is {what}, not a file", str(path))

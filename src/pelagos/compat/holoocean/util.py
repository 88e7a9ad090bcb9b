"""HoloOcean's helpers: its version, its folder of worlds, sizes for people."""

from __future__ import annotations

import os
import platform
from pathlib import Path
from typing import Any, Final

VERSION: Final = "2.3.0"
"""The version of HoloOcean whose interface this is."""

_PREFIXES: Final = ("", "K", "M", "G", "T", "P", "E", "Z")


def get_holoocean_version() -> str:
    """The version of HoloOcean whose interface this is."""
    return VERSION


def get_holoocean_path() -> str:
    """The folder of this version, where users keep scenarios of their own below `worlds`.

    `HOLODECKPATH` replaces the folder above the version's.
    """
    above = os.environ.get("HOLODECKPATH")
    if not above:  # an empty one counts as none
        local = ("AppData", "Local") if get_os_key() == "Windows" else (".local", "share")
        above = str(Path.home().joinpath(*local, "holoocean"))
    return str(Path(above) / VERSION)


def get_os_key() -> str:
    """The system's name: "Linux", "Windows" or "Darwin"."""
    return platform.system()


def human_readable_size(size_bytes: float) -> str:
    """A size in powers of 1024, such as "1.5 KB"."""
    size = float(size_bytes)
    for prefix in _PREFIXES:
        if abs(size) < 1024.0:
            return f"{size:.1f} {prefix}B"
        size /= 1024.0
    return f"{size:.1f} YB"


def convert_unicode(value: Any) -> Any:
    """The value itself: text of Python 3 is Unicode already."""
    return value

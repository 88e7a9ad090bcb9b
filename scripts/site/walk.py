"""A walk: the files of Pelagos that one reading passes, counted while it is computed without a recording."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import pelagos

SOURCE: Final = Path(pelagos.__file__).parent


def walked(work: Callable[[], Any]) -> tuple[dict[str, list[str]], Any]:
    """By file, in the order of first calls, the functions that ran; and what `work` gave."""
    rooms: dict[str, list[str]] = {}

    def note(frame: Any, event: str, argument: Any) -> None:
        if event != "call":
            return
        file = frame.f_code.co_filename
        if file.startswith(str(SOURCE)):
            names = rooms.setdefault(str(Path(file).relative_to(SOURCE)), [])
            name = frame.f_code.co_qualname if hasattr(frame.f_code, "co_qualname") else frame.f_code.co_name
            if "<" not in name and name not in names:
                names.append(name)

    sys.setprofile(note)
    try:
        result = work()
    finally:
        sys.setprofile(None)
    return rooms, result

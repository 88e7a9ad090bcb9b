"""Benchmarks must do the work that they time."""

from __future__ import annotations

from pathlib import Path

import pelagos
from pelagos.errors import PelagosError


class BenchError(PelagosError):
    """A benchmark's output is not what it must be, or it cannot run here."""


def must(condition: bool, what: str) -> None:
    """Stop a benchmark whose output is wrong.

    Raises:
        BenchError: `what` does not hold.
    """
    if not condition:
        raise BenchError(f"wrong output: {what}")


def example(name: str) -> Path:
    """A file of `examples`.

    Raises:
        BenchError: this is no source tree.
    """
    for folder in (Path("examples"), Path(pelagos.__file__).parents[2] / "examples"):
        if (folder / name).is_file():
            return folder / name
    raise BenchError(f"needs examples/{name}: run it in a source tree")

"""Formats of data sets: each writes the files of one shard, sample by sample, and what is common to all shards."""

from __future__ import annotations

from importlib import import_module
from pathlib import Path
from typing import Any, Protocol

from pelagos.datasets.plan import Plan, Shard
from pelagos.datasets.sample import Sample


class Writer(Protocol):
    """Writes the files of one shard below a folder. No file holds a clock or a host."""

    def __init__(self, folder: Path, plan: Plan, shard: Shard, maker: Any) -> None: ...

    def add(self, sample: Sample) -> None:
        """Write a sample; they come in order."""
        ...

    def close(self) -> None:
        """End the files."""
        ...


def writer_of(name: str) -> type[Writer]:
    """The class of a format, whose packages are imported now.

    Raises:
        InputError: a package that it needs is not installed.
    """
    found: type[Writer] = import_module(f"{__name__}.{name}").FORMAT
    return found

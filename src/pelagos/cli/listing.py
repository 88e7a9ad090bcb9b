"""`pelagos list`: what a scenario can name, one line each."""

from __future__ import annotations

from typing import Final

from rich.table import Table

from pelagos.cli.console import out
from pelagos.config import registry

KINDS: Final[dict[str, registry.Kind]] = {"vehicles": "vehicle", "sensors": "sensor", "worlds": "world"}


def print_list(what: str) -> None:
    """Print a table's names, each with one line about it and the package that brought it."""
    table = Table(box=None, show_header=False, pad_edge=False)
    table.add_column(no_wrap=True, style="bold")
    table.add_column(overflow="fold")
    for name, entry in registry.entries(KINDS[what]).items():
        table.add_row(name, entry.title + (f" (from {entry.package})" if entry.package else ""))
    out.print(table, soft_wrap=False)

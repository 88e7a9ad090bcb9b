"""`pelagos check --cost`: memory and work of a run, by part, before anything is built."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rich.table import Table

from pelagos.cli.console import out
from pelagos.cli.trusted import load

_SHOWN: Final = 12  # the largest parts


def show_cost(path: Path, changes: Sequence[str], *, copies: int, trust: bool = False) -> None:
    """Print the estimate of a scenario, the largest parts first."""
    from pelagos.sim.cost import cost_of, free_memory, size

    cost = cost_of(load(path, changes, trust=trust), copies)
    table = Table(box=None, pad_edge=False, padding=(0, 2, 0, 0))
    table.add_column("part")
    for column in ("memory", "rays in a simulated second"):
        table.add_column(column, justify="right")
    for part in cost.parts[:_SHOWN]:
        table.add_row(part.path, size(part.memory), f"{part.rays_per_s:,.0f}")
    table.add_row("together, with the program", size(cost.memory), f"{cost.rays_per_s:,.0f}")
    out.print(table)
    out.print(f"{cost.ticks:,.0f} ticks at most; {size(free_memory())} of memory are free", markup=False)

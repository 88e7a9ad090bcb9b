"""`pelagos sweep`."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Final

from rich.table import Table

from pelagos.cli.console import err, out, shown
from pelagos.cli.dataset import Bar
from pelagos.cli.trusted import load
from pelagos.datasets.engine import Engine
from pelagos.datasets.sweep import TABLE, axis_of, rows_of, run_sweep, sweep_of
from pelagos.errors import InputError

ROWS: Final = 40  # printed at most


def sweep(
    scenario: Path, vary: Sequence[str], folder: Path | None, changes: Sequence[str], *, duration: float | None,
    engine: Engine, record: bool, trust: bool,
) -> int:  # fmt: skip
    """Do the runs of every combination that are missing, and print the table.

    Returns:
        1 where a run ended with an error, otherwise 0.

    Raises:
        InputError: something is wrong with the scenario, the values or the folder.
    """
    if duration is not None and not 0 < duration < float("inf"):
        raise InputError(f"--duration must be a positive number of seconds, not {duration:g}")
    axes = [axis_of(text) for text in vary]
    place = folder or Path("results") / f"{scenario.stem}-sweep"
    made = sweep_of(load(scenario, changes, trust=trust), axes, place, seconds=duration, record=record)
    with Bar("runs") as bar:
        records = run_sweep(made, engine, progress=bar)
    head, rows = rows_of(records, made.axes)
    table = Table(box=None, header_style="bold")
    for name in head:
        table.add_column(name, overflow="fold")
    for row in rows[:ROWS]:
        table.add_row(*row)
    out.print(table)
    if len(rows) > ROWS:
        out.print(f"... and {len(rows) - ROWS} more")
    out.print(f"table: {shown(place / TABLE)}", markup=False)
    failed = [r for r in records if "error" in r]
    for r in failed[:3]:
        err.print(f"run {r['run']}: {r['error']}", markup=False)
    return 1 if failed else 0

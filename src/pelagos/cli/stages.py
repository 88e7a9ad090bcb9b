"""Progress of a command in stages: a bar on a terminal, a line for each stage elsewhere."""

from __future__ import annotations

from rich.progress import BarColumn, MofNCompleteColumn, SpinnerColumn, TextColumn, TimeElapsedColumn

from pelagos.cli.console import err
from pelagos.cli.live_bar import LiveBar


class Stages(LiveBar):
    """Call it with what begins now; use it as a context manager."""

    def __init__(self, total: int) -> None:
        columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
        super().__init__(*columns, TimeElapsedColumn(), total=total, transient=True)
        self._total = total
        self._begun = 0

    def __call__(self, what: str) -> None:
        """The stage before is done, and `what` begins."""
        if self._bar is not None:
            self._bar.update(self._task, description=what, completed=self._begun)
        else:
            err.print(f"[{self._begun + 1}/{self._total}] {what}", markup=False)
        self._begun += 1

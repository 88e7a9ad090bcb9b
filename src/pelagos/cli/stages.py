"""Progress of a command in stages: a bar on a terminal, a line for each stage elsewhere."""

from __future__ import annotations

from types import TracebackType
from typing import Self

from rich.progress import BarColumn, MofNCompleteColumn, Progress, SpinnerColumn, TaskID, TextColumn, TimeElapsedColumn

from pelagos.cli.console import err


class Stages:
    """Call it with what begins now; use it as a context manager."""

    def __init__(self, total: int) -> None:
        self._total = total
        self._begun = 0
        self._bar: Progress | None = None
        self._task = TaskID(0)
        if err.is_terminal:
            columns = (SpinnerColumn(), TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
            self._bar = Progress(*columns, TimeElapsedColumn(), console=err, transient=True)
            self._task = self._bar.add_task("", total=total)

    def __call__(self, what: str) -> None:
        """The stage before is done, and `what` begins."""
        if self._bar is not None:
            self._bar.update(self._task, description=what, completed=self._begun)
        else:
            err.print(f"[{self._begun + 1}/{self._total}] {what}", markup=False)
        self._begun += 1

    def __enter__(self) -> Self:
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

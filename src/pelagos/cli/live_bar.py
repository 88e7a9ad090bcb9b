"""A bar on a terminal as a context manager: what every display of progress has in common."""

from __future__ import annotations

import time
from types import TracebackType
from typing import Any, Self

from rich.progress import Progress, ProgressColumn, TaskID

from pelagos.cli.console import err


class LiveBar:
    """Base of displays of progress; without a terminal there is no bar, and a subclass prints lines.

    Args:
        columns: of the bar.
        total: of its only task; None: not known yet.
        transient: whether the bar goes when it ends.
        **fields: of the task, which columns show.
    """

    def __init__(
        self, *columns: ProgressColumn, total: float | None = None, transient: bool = False, **fields: Any
    ) -> None:
        self._started = time.perf_counter()
        self._bar = Progress(*columns, console=err, transient=transient) if err.is_terminal else None
        self._task = TaskID(0) if self._bar is None else self._bar.add_task("", total=total, **fields)

    def __enter__(self) -> Self:
        self._started = time.perf_counter()
        if self._bar is not None:
            self._bar.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._bar is not None:
            self._bar.stop()

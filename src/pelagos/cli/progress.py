"""Progress of a run: a bar with simulated time and real-time factor on a terminal, a line now and then elsewhere."""

from __future__ import annotations

import time
from typing import Final

from rich.progress import BarColumn, TextColumn, TimeRemainingColumn

from pelagos.cli.console import err
from pelagos.cli.live_bar import LiveBar

LINE_EVERY_S: Final = 10.0


class RunProgress(LiveBar):
    """Call it with simulated seconds and seconds in all; use it as a context manager."""

    def __init__(self) -> None:
        time_shown, factor = TextColumn("{task.fields[time]}"), TextColumn("{task.fields[factor]}", style="bold")
        super().__init__(
            TextColumn("simulated"), BarColumn(), time_shown, factor, TimeRemainingColumn(), time="", factor=""
        )
        self._shown_s = 0.0
        self._next_line = LINE_EVERY_S

    def __call__(self, t_s: float, duration_s: float) -> None:
        """Show that `t_s` of `duration_s` seconds are simulated."""
        if t_s < self._shown_s:  # a run that begins anew, after a reset
            self._started, self._next_line = time.perf_counter(), LINE_EVERY_S
        self._shown_s = t_s
        wall = time.perf_counter() - self._started
        factor = f"{t_s / wall:.1f} x real time" if wall > 0 else ""
        if self._bar is not None:
            self._bar.update(
                self._task, completed=t_s, total=duration_s, time=f"{t_s:.1f} of {duration_s:g} s", factor=factor
            )
        elif wall >= self._next_line:
            self._next_line = wall + LINE_EVERY_S
            err.print(f"simulated {t_s:.1f} of {duration_s:g} s, {factor}")

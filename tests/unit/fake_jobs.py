"""Work for engines that loses its worker; imports little, for a worker imports this."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any


@dataclass(frozen=True)
class Killed:
    """Work whose worker is killed at piece 2, as often as asked."""

    folder: Path
    times: int

    def open(self) -> Callable[[int], dict[str, Any]]:
        return self.work

    def work(self, index: int) -> dict[str, Any]:
        if index == 2:
            tries = len(list(self.folder.iterdir()))
            (self.folder / str(tries)).touch()
            if tries < self.times:
                os.kill(os.getpid(), signal.SIGKILL)
        return {"index": index}


@dataclass(frozen=True)
class Failing:
    """Work that raises at piece 1."""

    error: Exception

    def open(self) -> Callable[[int], dict[str, Any]]:
        return self.work

    def work(self, index: int) -> dict[str, Any]:
        if index == 1:
            raise self.error
        return {"index": index}

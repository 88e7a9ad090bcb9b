"""Benchmarks must do the work that they time."""

from __future__ import annotations

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

"""Times of a record, from its first row on: stamps since 1970 have no digits to spare for differences."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.identification.plan import ColumnConfig

_LARGE_S: Final = 1e6  # a beginning from which times are told with it apart
_FINEST_S: Final = 1e-9  # of stamps that were written or added up
_ROUNDINGS: Final = 2.5  # of a stamp: two in each of two differences that are compared, and some
_FINE: Final = 0.01  # of a step: coarser stamps say nothing of evenness
_ROWS: Final = 10  # fewer say nothing


@dataclass(frozen=True)
class Clock:
    """Times of the rows.

    Attributes:
        start_s: of the first row [s]; t: since the first row `(n,)` [s].
        grain_s: by how much differences of stamps may be off for their digits alone [s].
    """

    start_s: float
    t: NDArray[np.float64]
    grain_s: float

    def say(self, seconds: float) -> str:
        """A time since the first row, as the record has it."""
        if abs(self.start_s) < _LARGE_S:
            return f"{self.start_s + seconds:.6g}"
        if abs(seconds) > _LARGE_S:  # as far as that, such as a time that does not count from 1970
            return f"{self.start_s + seconds:.10g}"
        return f"{self.start_s:.10g}{seconds:+.6g}"

    @property
    def step_s(self) -> float:
        """Spacing of the rows [s].

        The median of differences; of rows that are even to the digits of their stamps, what the whole record says, as
        a round spacing or a round rate wherever that ends at the same row.
        """
        off = np.diff(self.t)
        middle = float(np.median(off))
        even = np.abs(off - middle) <= self.grain_s
        if even.mean() <= 0.5:
            return round(middle, 9)
        step = float(off[even].mean())
        for round_one in (float(f"{step:.6g}"), 1 / float(f"{1 / step:.6g}")):
            if len(self.t) * abs(round_one - step) <= self.grain_s:
                return round_one
        return step


def clock_of(stamps: Any, column: ColumnConfig, where: str, origin_s: float = 0.0) -> Clock:
    """Times of a column of stamps `(n,)`, which may be integers.

    Args:
        stamps: as recorded; column: its unit; where: for messages.
        origin_s: what the stamps count from [s].

    Raises:
        InputError: times are not finite, too few, out of order or twice.
    """
    raw = np.asarray(stamps)
    whole = raw.dtype.kind in "iu"
    raw = raw.astype(np.int64 if whole else np.float64)
    if not np.isfinite(raw).all():
        raise InputError(f"{where}: the time of row {int(np.argmin(np.isfinite(raw))) + 1} is not a number")
    if len(raw) < _ROWS:
        raise InputError(f"{where}: {len(raw)} of the {_ROWS} rows that a record needs at least")
    digits = (1.0 if whole else float(np.spacing(np.abs(raw).max()))) * abs(column.factor)
    t = (raw - raw[0]).astype(np.float64) * column.factor
    start = origin_s + (float(raw[0]) - column.zero) * column.factor
    grain = min(_ROUNDINGS * max(digits, _FINEST_S), _FINE * abs(float(np.median(np.diff(t)))))
    clock = Clock(start, t, grain)
    _ordered(clock, where)
    return clock


def _ordered(clock: Clock, where: str) -> None:
    t, steps = clock.t, np.diff(clock.t)
    if (steps < 0).any():
        k = int(np.argmax(steps < 0))
        raise InputError(
            f"{where}: times are not in order: row {k + 2} has {clock.say(t[k + 1])} s after {clock.say(t[k])} s "
            f"({int((steps < 0).sum())} such places); sort the rows, or split the file where a clock was set"
        )
    if (steps == 0).any():
        k = int(np.argmax(steps == 0))
        raise InputError(
            f"{where}: {clock.say(t[k])} s occurs twice, in rows {k + 1} and {k + 2} ({int((steps == 0).sum())} such "
            "places); keep one row a time"
        )
    step = float(np.median(steps))
    if step > 60:
        raise InputError(f"{where}: rows are {step:.4g} s apart; is the time in ms, us or ns? Give time: {{unit: ms}}")

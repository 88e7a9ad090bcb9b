"""Excitation of a record: whether anything happens in it that could tell of parameters."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import InputError
from pelagos.identification.coordinates import RATES
from pelagos.identification.plan import Plan
from pelagos.identification.record import Record, rate_of
from pelagos.identification.shots import Shots

_RESEMBLANCE: Final = 0.4
"""Correlation that a motion has with itself a smoothing length later, and noise has not."""


def refuse_unexcited(record: Record, plan: Plan, shots: Shots) -> None:
    """Refuse a record in which nothing happens.

    Raises:
        InputError: no command changes, and nothing moves.
    """
    rows = (shots.starts[:, None] + np.arange(shots.steps)).ravel()
    commanded = any(np.ptp(c[rows]) > 0 for c in record.commands.values())
    moves = any(np.nanstd(x[rows]) > 0 for x in _velocities(record, plan))
    if not moves or (record.commands and not commanded and not _swings(record, plan)):
        raise InputError(
            "too little excitation: no command changes and no velocity differs from its mean in the rows that are used"
        )


def _swings(record: Record, plan: Plan) -> bool:
    """True for a motion without commands that is no noise: it resembles itself beyond the smoothing of slopes."""
    lag = max(2, round(1.5 * plan.smooth_s / record.step_s))
    for x in _velocities(record, plan):
        for a, b in record.runs:
            y = x[a:b] - np.nanmean(x[a:b])
            power = float(np.nanmean(y * y)) if len(y) > 10 * lag else 0.0
            if power > 0 and abs(float(np.nanmean(y[lag:] * y[:-lag]))) > _RESEMBLANCE * power:
                return True
    return False


def _velocities(record: Record, plan: Plan) -> Iterator[NDArray[np.float64]]:
    """Velocities `(n,)`, NaN between stretches; of a pose that is known in part, such as north alone, its own rate."""
    for pose, name in RATES.items():
        x = record.values(name)
        if x is not None:
            yield x
        elif pose in record.measured:
            yield rate_of(record.measured[pose], record.runs, record.step_s, plan.smooth_s)

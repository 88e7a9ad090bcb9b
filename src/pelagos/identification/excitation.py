"""Excitation of a record: whether anything happens in it that could tell of parameters."""

from __future__ import annotations

from typing import Final

import numpy as np

from pelagos.errors import InputError
from pelagos.identification.coordinates import COORDINATES
from pelagos.identification.plan import Plan
from pelagos.identification.record import Record
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
    moves = [n for n in COORDINATES[6:] if (x := record.values(n)) is not None and np.nanstd(x[rows]) > 0]
    if not moves or (record.commands and not commanded and not _swings(record, plan)):
        raise InputError(
            "too little excitation: no command changes and no velocity differs from its mean in the rows that are used"
        )


def _swings(record: Record, plan: Plan) -> bool:
    """True for a motion without commands that is no noise: it resembles itself beyond the smoothing of slopes."""
    lag = max(2, round(1.5 * plan.smooth_s / record.step_s))
    for name in COORDINATES[6:]:
        x = record.values(name)
        for a, b in record.runs if x is not None else ():
            y = x[a:b] - np.nanmean(x[a:b]) if x is not None else np.zeros(0)
            power = float(np.nanmean(y * y)) if len(y) > 10 * lag else 0.0
            if power > 0 and abs(float(np.nanmean(y[lag:] * y[:-lag]))) > _RESEMBLANCE * power:
                return True
    return False

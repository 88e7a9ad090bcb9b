"""The guard of readings: a number that is not finite stops the run, and names sensor, copy and time."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Final, TypeAlias

import numpy as np

from pelagos.errors import SimulationError
from pelagos.sim.sampled import Sampled

_all: Final = partial(np.logical_and.reduce, axis=None)
_NUMBERS: Final = "fc"  # kinds of arrays that can hold what is not finite
Uncovered: TypeAlias = Callable[[str, int, float], Sequence[str]]


def require_finite(one: Sampled, n: int, dt_ns: int, uncovered: Uncovered) -> None:
    """Check the data of valid lanes; sensors that may lack values (`MAY_LACK`) are not asked.

    Args:
        one: the readings.
        n: copies.
        dt_ns: the tick [ns].
        uncovered: names the fields of the ocean that end before the place of an agent's copy at a time [s].

    Raises:
        SimulationError: a value is NaN or infinite.
    """
    m = one.measurement
    if m.data.dtype.kind not in _NUMBERS or getattr(one.model.sensor, "MAY_LACK", False) or _all(np.isfinite(m.data)):
        return
    bad = ~np.isfinite(m.data).reshape(len(m.data), -1).all(axis=1)
    if m.valid is not None:
        bad &= m.valid
    if not bad.any():
        return
    lane = int(np.argmax(bad))
    tick, row = divmod(lane, n * len(one.members))  # rows go agent by agent, and copy by copy within
    agent, copy, t_s = one.members[row // n], row % n, one.ticks[tick] * dt_ns * 1e-9
    lacking = uncovered(agent, copy, t_s)
    why = f"{' and '.join(lacking)} ends before that place or moment (outside: error)" if lacking else (
        "a sensor whose data may lack values says MAY_LACK"
    )  # fmt: skip
    raise SimulationError(
        f"{agent}.{one.model.name} (type {one.model.config.type}, copy {copy}) reads a number that is "
        f"not finite at t = {t_s:.3f} s; {why}"
    )

"""The guard of readings: a number that is not finite stops the run, and names sensor, copy and time."""

from __future__ import annotations

from functools import partial
from typing import Final

import numpy as np

from pelagos.errors import SimulationError
from pelagos.sim.sampled import Sampled

_all: Final = partial(np.logical_and.reduce, axis=None)
_NUMBERS: Final = "fc"  # kinds of arrays that can hold what is not finite


def require_finite(one: Sampled, n: int, dt_ns: int) -> None:
    """Check the data of valid lanes; sensors that may lack values (`MAY_LACK`) are not asked.

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
    name = f"{one.members[row // n]}.{one.model.name}"
    raise SimulationError(
        f"{name} (type {one.model.config.type}, copy {row % n}) reads a number that is "
        f"not finite at t = {one.ticks[tick] * dt_ns * 1e-9:.3f} s; a sensor whose data may lack values says MAY_LACK"
    )

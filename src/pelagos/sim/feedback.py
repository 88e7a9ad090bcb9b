"""Readings that guidance looks at, between the tick at which they come and that at which it asks."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.guidance.follow import FollowWall
from pelagos.sim.guidance.plan import altitude_of, looks_down
from pelagos.sim.model import AgentModel
from pelagos.sim.sampled import Sampled


@dataclass
class Feedback:
    """Sensors' share of what guidance knows.

    Attributes:
        altitude: `(n,)` the last one measured [m]; infinite where none was.
        gps: `(n,)` whether a fix came since guidance last asked.
        readings: newest readings by key, see `Aboard.readings`.
        keys: of the readings that guidance looks at, by sensor.
        down: sensors that measure the altitude, and the part of their readings that it is ("" the data).
    """

    altitude: NDArray[np.float64]
    gps: NDArray[np.bool_]
    readings: dict[str, NDArray[np.float64]] = field(default_factory=dict)
    keys: dict[str, list[str]] = field(default_factory=dict)
    down: Mapping[str, str] = field(default_factory=dict)


def down_lookers(agent: AgentModel) -> dict[str, str]:
    """Sensors that measure the altitude, where a task asks for one, each with the part of its reading that it is:
    altimeters, or DVLs where there are none.
    """
    if all(step.task.common.level.altitude_m is None for step in agent.tasks):
        return {}
    found = {s: altitude_of(m.config) or "" for s, m in agent.sensors.items() if looks_down(m.config)}
    return {s: part for s, part in found.items() if part == ""} or found


def keys_of(agent: AgentModel) -> list[str]:
    """Readings that the tasks look at."""
    tasks = [step.task for step in agent.tasks]
    keys = [t.common.until.key for t in tasks if t.common.until is not None]
    return sorted({*keys, *(t.key for t in tasks if isinstance(t, FollowWall))})


def newest_row(sampled: Sampled, array: str, n: int) -> NDArray[np.float64]:
    """`(n, k)` of the last tick, not a number where there is no reading; array: of the extras, or "" for the data."""
    m = sampled.measurement
    values = np.asarray(m.extras[array] if array else m.data, dtype=np.float64)
    rows = values.reshape(len(sampled.ticks), n, -1)[-1]
    return rows if m.valid is None else np.where(m.valid[-n:, None], rows, np.nan)

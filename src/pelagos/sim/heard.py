"""Readings that an estimator keeps until guidance asks."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.sim.sampled import Sampled

Heard = dict[str, Any]
"""Readings of one sensor, plain: its name, their ticks, `data` and `extra` `(lanes, k)`, `valid` `(lanes,)`."""


def heard_of(sampled: Sampled, kind: str) -> Heard:
    """Measurements in readings: of a GPS the position NWU [m], of a DVL also its beams' deviations, of a USBL
    the place of a beacon.
    """
    m, lanes = sampled.measurement, len(sampled.measurement.data)
    data = m.extras["position"] if kind == "gps" else m.extras["fix"] if kind == "usbl" else m.data
    return {
        "name": sampled.model.name,
        "ticks": list(sampled.ticks),
        "data": np.array(data, dtype=np.float64).reshape(lanes, -1),
        "valid": np.ones(lanes, dtype=bool) if m.valid is None else np.array(m.valid),
        "extra": np.array(m.extras["sigma"], dtype=np.float64) if kind == "dvl" else None,
    }


def side_by_side(parts: Sequence[Heard]) -> Heard:
    """Readings of one sensor of several agents, whose lanes follow one another at every tick."""
    count = len(parts[0]["ticks"])

    def join(key: str) -> NDArray[Any] | None:
        values = [part[key] for part in parts]
        if values[0] is None:
            return None
        rows = np.concatenate([v.reshape(count, -1, *v.shape[1:]) for v in values], axis=1)
        return rows.reshape(-1, *values[0].shape[1:])

    return parts[0] | {key: join(key) for key in ("data", "valid", "extra")}


def part_of(one: Heard, lanes: slice) -> Heard:
    """The part of some lanes of every tick."""
    count = len(one["ticks"])

    def cut(values: NDArray[Any] | None) -> NDArray[Any] | None:
        if values is None:
            return None
        return values.reshape(count, -1, *values.shape[1:])[:, lanes].reshape(-1, *values.shape[1:])

    return one | {key: cut(one[key]) for key in ("data", "valid", "extra")}

"""Readings of one sensor over a block of ticks, before they are cut into single readings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Measurement, Reading
from pelagos.sim.model import SensorModel


@dataclass(frozen=True)
class Sampled:
    """Readings of one sensor at the due ticks of a block: a measurement of ticks times copies lanes, tick-major."""

    agent: str
    model: SensorModel
    ticks: range
    measurement: Measurement

    def count(self, n: int) -> int:
        """Ticks at which at least one copy has a reading."""
        valid = self.measurement.valid
        return len(self.ticks) if valid is None else int(valid.reshape(-1, n).any(axis=1).sum())

    @staticmethod
    def join(parts: Sequence[Sampled]) -> Sampled:
        """What one sensor read in blocks that follow one another, as one."""
        one = parts[0]
        if len(parts) == 1:
            return one
        measured = [p.measurement for p in parts]
        valid = [m.valid for m in measured if m.valid is not None]
        joined = Measurement(
            data=np.concatenate([m.data for m in measured]),
            truth=promised(lambda: np.concatenate([m.truth for m in measured])),
            valid=np.concatenate(valid) if valid else None,
            extras={name: np.concatenate([m.extras[name] for m in measured]) for name in one.measurement.extras},
            tables=one.measurement.tables,
        )
        ticks = range(one.ticks.start, parts[-1].ticks[-1] + 1, one.model.period)
        return Sampled(one.agent, one.model, ticks, joined)

    def without(self, ended: NDArray[np.int64]) -> Sampled:
        """The same, not valid in each copy from the tick on at which it `ended`."""
        goes_on = (np.array(self.ticks)[:, None] < ended).reshape(-1)
        m = self.measurement
        valid = goes_on if m.valid is None else m.valid & goes_on
        return replace(self, measurement=replace(m, truth=promised(lambda: m.truth), valid=valid))

    def newest(self, n: int, dt_ns: int) -> Reading | None:
        """The reading of the last tick at which a copy has one; None where there is no such tick."""
        found = (self._at(k, n, dt_ns) for k in reversed(range(len(self.ticks))))
        return next((reading for reading in found if reading is not None), None)

    def readings(self, n: int, dt_ns: int) -> Iterator[Reading]:
        """Those of every tick at which a copy has one, in order."""
        for k in range(len(self.ticks)):
            reading = self._at(k, n, dt_ns)
            if reading is not None:
                yield reading

    def _at(self, k: int, n: int, dt_ns: int) -> Reading | None:
        m, row = self.measurement, slice(k * n, (k + 1) * n)
        valid = np.ones(n, dtype=bool) if m.valid is None else m.valid[row]
        if not valid.any():
            return None
        return m.reading(row, valid, self.ticks[k] * dt_ns, f"{self.agent}/{self.model.name}")

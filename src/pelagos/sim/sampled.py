"""Readings of one sensor over a block of ticks, before they are cut into single readings."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Measurement, Reading
from pelagos.sim.batch import SensorModel


@dataclass(frozen=True)
class Sampled:
    """Readings of one sensor at the due ticks of a block: a measurement of ticks times rows lanes, tick-major.

    Attributes:
        members: the agents that it reads for; rows go agent by agent, and copy by copy within.
        model: the sensor.
        ticks: at which it read.
        measurement: what it read.
    """

    members: tuple[str, ...]
    model: SensorModel
    ticks: range
    measurement: Measurement

    def each(self, n: int) -> Iterator[Sampled]:
        """The same by agent, of `n` copies."""
        if len(self.members) == 1:
            yield self
            return
        for member in range(len(self.members)):
            yield self.of(member, n)

    def of(self, member: int, n: int) -> Sampled:
        """That of one agent, of `n` copies."""
        return self if len(self.members) == 1 else self._cut(slice(member * n, (member + 1) * n), [member], n)

    def some(self, members: Sequence[int], n: int) -> Sampled:
        """That of some of the agents, of `n` copies."""
        rows = (np.array(members)[:, None] * n + np.arange(n)).ravel()
        return self._cut(rows, members, n)

    def _cut(self, rows: slice | NDArray[np.intp], members: Sequence[int], n: int) -> Sampled:
        """Rows of every tick, which are those of some agents."""
        m, k = self.measurement, len(self.ticks)
        own = rows if k == 1 else np.arange(k * n * len(self.members)).reshape(k, -1)[:, rows].ravel()
        part = Measurement(
            data=m.data[own],
            truth=promised(lambda: m.truth[own]),
            valid=None if m.valid is None else m.valid[own],
            extras={name: values[own] for name, values in m.extras.items()},
            tables=m.tables,
        )
        return Sampled(tuple(self.members[i] for i in members), self.model, self.ticks, part)

    def counts(self, n: int) -> list[int]:
        """By agent, ticks at which at least one copy has a reading."""
        valid = self.measurement.valid
        if valid is None:
            return [len(self.ticks)] * len(self.members)
        read = valid.reshape(len(self.ticks), len(self.members), n).any(axis=2)
        return [int(count) for count in read.sum(axis=0)]

    @staticmethod
    def join(parts: Sequence[Sampled]) -> Sampled:
        """Readings of one sensor in blocks that follow one another, as one."""
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
        return Sampled(one.members, one.model, ticks, joined)

    def without(self, ended: NDArray[np.int64]) -> Sampled:
        """The same, not valid in each copy from the tick on at which it `ended`."""
        goes_on = (np.array(self.ticks)[:, None] < np.tile(ended, len(self.members))).reshape(-1)
        m = self.measurement
        valid = goes_on if m.valid is None else m.valid & goes_on
        return replace(self, measurement=replace(m, truth=promised(lambda: m.truth), valid=valid))

    def newest(self, n: int, dt_ns: int) -> Reading | None:
        """An agent's reading of the last tick at which a copy has one; None where there is no such tick."""
        found = (self._at(k, n, dt_ns) for k in reversed(range(len(self.ticks))))
        return next((reading for reading in found if reading is not None), None)

    def newest_of(self, block: slice, n: int, dt_ns: int, group: str) -> Reading | None:
        """The reading of a block of agents together, `(n, members, ...)`, of the last tick at which one has one.

        Data of agents without a reading then are zero, and not valid.
        """
        m, shape = self.measurement, (len(self.ticks), len(self.members), n)
        valid = np.ones(shape, dtype=bool) if m.valid is None else m.valid.reshape(shape)
        read = np.flatnonzero(valid[:, block].any(axis=(1, 2)))
        if not len(read):
            return None
        last = read[-1]
        silent = ~valid[last, block].any(axis=1)  # (members,)

        def cut(values: NDArray[Any]) -> NDArray[Any]:
            part = values.reshape(shape + values.shape[1:])[last, block]
            if silent.any():
                part = np.where(silent.reshape(-1, *[1] * (part.ndim - 1)), np.zeros_like(part), part)
            return np.ascontiguousarray(np.moveaxis(part, 0, 1))

        extras = {name: cut(values) for name, values in m.extras.items()} | dict(m.tables)
        return Reading(
            cut(m.data), promised(lambda: cut(m.truth)), self.ticks[last] * dt_ns, f"{group}/{self.model.name}",
            np.ascontiguousarray(valid[last, block].T), extras, self.model.config.type,
        )  # fmt: skip

    def readings(self, n: int, dt_ns: int, *, invalid: bool = False) -> Iterator[Reading]:
        """An agent's readings of every tick at which a copy has one, in order; with `invalid` of every tick."""
        for k in range(len(self.ticks)):
            reading = self._at(k, n, dt_ns, invalid=invalid)
            if reading is not None:
                yield reading

    def _at(self, k: int, n: int, dt_ns: int, *, invalid: bool = False) -> Reading | None:
        m, row = self.measurement, slice(k * n, (k + 1) * n)
        valid = np.ones(n, dtype=bool) if m.valid is None else m.valid[row]
        if not (invalid or valid.any()):
            return None
        frame = f"{self.members[0]}/{self.model.name}"
        return m.reading(row, valid, self.ticks[k] * dt_ns, frame, self.model.config.type)


def newest(parts: Sequence[Sampled], n: int) -> list[Sampled]:
    """Those of what one sensor read, in order of time, that hold the newest reading of an agent."""
    kept: list[Sampled] = []
    have = np.zeros(len(parts[-1].members), dtype=bool)
    for one in reversed(parts):
        reads = np.array(one.counts(n)) > 0
        if (reads & ~have).any():
            kept.append(one)
            have |= reads
    return kept[::-1]

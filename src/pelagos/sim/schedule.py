"""The schedule of a run: how long the next block of ticks is, and which sensors may be read some blocks later."""

from __future__ import annotations

from typing import Final

from pelagos.sim.batch import Batch, SensorModel
from pelagos.sim.bodies import Bodies
from pelagos.sim.clock import next_multiple
from pelagos.sim.listeners import Listeners
from pelagos.sim.missions import Missions
from pelagos.sim.model import Model

MAX_BLOCK_S: Final = 1.0


class Schedule:
    """A block ends where anything outside of the vehicles' dynamics may act: a sensor that casts rays, a mission, a
    listener, the caller."""

    def __init__(self, model: Model, bodies: Bodies, missions: Missions, listeners: Listeners) -> None:
        self._model, self._bodies, self._missions, self._listeners = model, bodies, missions, listeners
        self._longest = max(1, model.clock.ticks(MAX_BLOCK_S))
        self._facts: tuple[object, ...] = ()
        self._waiting: dict[tuple[str, str], bool] = {}
        self._periods: dict[bool, list[int]] = {}

    def end(self, tick: int, last: int, *, wait: bool) -> int:
        """The tick at which a block from `tick` ends at the latest, at most `last`.

        With `wait`, sensors that may wait do not end a block.
        """
        self._look()
        if wait not in self._periods:
            self._periods[wait] = self._ends(wait)
        return next_multiple(tick, self._periods[wait], min(last, tick + self._longest))

    def waits(self, batch: Batch, sensor: SensorModel) -> bool:
        """Leave to read a sensor some blocks later."""
        self._look()
        key = batch.name, sensor.name
        if key not in self._waiting:
            self._waiting[key] = self._may_wait(batch, sensor)
        return self._waiting[key]

    def _look(self) -> None:
        """Forget what was found where anything has changed since that it depends on."""
        listeners = self._listeners
        seen = self._bodies.any or self._model.scene.streamed
        facts = listeners.sensors, listeners.periods, seen, self._missions.changes
        if facts != self._facts:
            self._facts = facts
            self._waiting.clear()
            self._periods.clear()

    def _ends(self, wait: bool) -> list[int]:
        """Periods at whose multiples blocks end."""
        heard = self._listeners.sensors
        periods = [
            sensor.period
            for batch in self._model.batches.values()
            for sensor in batch.sensors.values()
            if (sensor.sees and not (wait and self.waits(batch, sensor)))
            or (heard and any((name, sensor.name) in heard for name in batch.members))
        ]
        periods += self._listeners.periods
        if self._missions.any:
            periods.append(self._missions.period)
        return sorted(set(periods))

    def _may_wait(self, batch: Batch, sensor: SensorModel) -> bool:
        heard = self._listeners.sensors
        if not sensor.waits or (sensor.sees and (self._bodies.any or self._model.scene.streamed)):
            return False
        if heard and any((name, sensor.name) in heard for name in batch.members):
            return False
        return not self._missions.any or not any(self._missions.guided(name, sensor.name) for name in batch.members)

"""The schedule of a run: how long the next block of ticks is, and which sensors may be read some blocks later."""

from __future__ import annotations

from typing import Final

from pelagos.sim.bodies import Bodies
from pelagos.sim.clock import next_multiple
from pelagos.sim.listeners import Listeners
from pelagos.sim.missions import Missions
from pelagos.sim.model import AgentModel, Model, SensorModel

MAX_BLOCK_S: Final = 1.0


class Schedule:
    """A block ends where anything outside of the vehicles' dynamics may act: a sensor that casts rays, a mission, a
    listener, the caller."""

    def __init__(self, model: Model, bodies: Bodies, missions: Missions, listeners: Listeners) -> None:
        self._model, self._bodies, self._missions, self._listeners = model, bodies, missions, listeners
        self._longest = max(1, model.clock.ticks(MAX_BLOCK_S))

    def end(self, tick: int, last: int, *, wait: bool) -> int:
        """The tick at which a block from `tick` ends at the latest, at most `last`.

        With `wait`, sensors that may wait do not end a block.
        """
        heard = self._listeners.sensors
        periods = [
            sensor.period
            for agent in self._model.agents.values()
            for sensor in agent.sensors.values()
            if (sensor.sees and not (wait and self.waits(agent, sensor)))
            or (heard and (agent.name, sensor.name) in heard)
        ]
        periods += self._listeners.periods
        if self._missions.any:
            periods.append(self._missions.period)
        return next_multiple(tick, periods, min(last, tick + self._longest))

    def waits(self, agent: AgentModel, sensor: SensorModel) -> bool:
        """Whether a sensor's readings may be read some blocks later."""
        if not sensor.waits or (agent.name, sensor.name) in self._listeners.sensors:
            return False
        changes = self._bodies.any or self._model.scene.streamed
        return not self._missions.guided(agent.name, sensor.name) and not (sensor.sees and changes)

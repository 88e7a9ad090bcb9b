"""Outside commands of a run, read back from its recording and given again: the same bytes."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Final

from pelagos.sim.order import Order, apply
from pelagos.sim.replay import Recording
from pelagos.sim.simulation import Simulation

TOPIC: Final = "/outside/orders"
"""std_msgs/String in JSON: tick, simulation and wall-clock time [ns], kind, target, data, source."""


def recorded_orders(path: str | Path) -> list[tuple[int, Order]]:
    """(tick, order) of every order that a recorded run obeyed, in order; empty where nobody told it anything."""
    recording = Recording(path)
    if TOPIC not in recording.channels or not recording.count(TOPIC):
        return []
    found = []
    for recorded in recording.messages(TOPIC):
        said = json.loads(recorded.message.data)
        found.append((int(said["tick"]), Order(said["kind"], said["target"], said["data"], said["source"])))
    return found


class Repeat:
    """Tells a simulation what another run was told, each order at its own tick."""

    def __init__(self, sim: Simulation, path: str | Path) -> None:
        self._sim = sim
        self._left = recorded_orders(path)
        self._subscription = sim.on_tick(self._tell)

    def _tell(self, sim: Simulation) -> None:
        tick = sim.time_ns // sim.dt_ns
        while self._left and self._left[0][0] <= tick:
            apply(self._left.pop(0)[1], sim)
        if not self._left:
            self._subscription.cancel()

"""Outside commands of a run, read back from its recording and given again: the same bytes."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, Final

from pelagos.sim.order import Order, apply
from pelagos.sim.replay import Recording
from pelagos.sim.simulation import Simulation

TOPIC: Final = "/outside/orders"
"""std_msgs/String in JSON: tick, simulation and wall-clock time [ns], kind, target, data, source."""


def recorded_orders(path: str | Path) -> list[tuple[int, Order]]:
    """(tick, order) of every order that a recorded run obeyed, in order; empty where nobody told it anything."""
    return [(int(said["tick"]), _order(said)) for said in map(json.loads, _texts(path))]


def _texts(path: str | Path) -> list[str]:
    recording = Recording(path)
    if TOPIC not in recording.channels or not recording.count(TOPIC):
        return []
    return [str(recorded.message.data) for recorded in recording.messages(TOPIC)]


def _order(said: Mapping[str, Any]) -> Order:
    return Order(said["kind"], said["target"], said["data"], said["source"])


class Repeat:
    """Tells a simulation what another run was told, each order at its own tick.

    Args:
        sim: the simulation.
        path: the other run's recording.
        note: writes an order's text down at a time [ns], so that the repeated run can be repeated too.
    """

    def __init__(self, sim: Simulation, path: str | Path, *, note: Callable[[str, int], None] | None = None) -> None:
        self._note = note
        self._left = [(json.loads(text), text) for text in _texts(path)]
        self._subscription = sim.on_tick(self._tell)

    def _tell(self, sim: Simulation) -> None:
        tick = sim.time_ns // sim.dt_ns
        while self._left and int(self._left[0][0]["tick"]) <= tick:
            said, text = self._left.pop(0)
            apply(_order(said), sim)
            if self._note is not None:
                self._note(text, int(said["t_ns"]))
        if not self._left:
            self._subscription.cancel()

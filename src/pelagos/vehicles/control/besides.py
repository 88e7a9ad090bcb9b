"""A control mode with set-points for what the vehicle carries, besides its own."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

from pelagos.jit import Array
from pelagos.vehicles.control.controller import Controller, Demand
from pelagos.vehicles.flow import Flow


@dataclass(frozen=True)
class Besides:
    """mode: the control law; carried: actuators whose commands follow its set-points."""

    mode: Controller
    carried: tuple[str, ...]

    @property
    def commands(self) -> tuple[str, ...]:
        """See `Controller`."""
        return (*self.mode.commands, *self.carried)

    @property
    def memory(self) -> int:
        """See `Controller`."""
        return self.mode.memory

    def start(self, flow: Flow) -> list[Array]:
        """See `Controller`."""
        return self.mode.start(flow)

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """See `Controller`."""
        own = len(self.mode.commands)
        demand, kept = self.mode.act(memory, flow, command[:own], h)
        orders = dict(zip(self.carried, command[own:], strict=True))
        return replace(demand, actuators={**demand.actuators, **orders}), kept

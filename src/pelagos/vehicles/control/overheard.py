"""A control mode whose demand is read while a step is computed: commands of the actuators, for a recording."""

from __future__ import annotations

from collections.abc import Sequence
from copy import copy
from math import nan
from typing import TYPE_CHECKING

from pelagos import jit
from pelagos.jit import Array
from pelagos.vehicles.control.controller import Controller, Demand
from pelagos.vehicles.flow import Flow

if TYPE_CHECKING:
    from pelagos.vehicles.vehicle import Vehicle


class Overheard:
    """`mode` with its last demand, which belongs to the step that is being computed.

    Args:
        mode: the control law.
        actuators: names, in the order of commands.
    """

    def __init__(self, mode: Controller, actuators: tuple[str, ...]) -> None:
        self._mode, self._actuators = mode, actuators
        self._demand = Demand()

    @property
    def commands(self) -> tuple[str, ...]:
        """See `Controller`."""
        return self._mode.commands

    @property
    def memory(self) -> int:
        """See `Controller`."""
        return self._mode.memory

    def start(self, flow: Flow) -> list[Array]:
        """See `Controller`."""
        return self._mode.start(flow)

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """See `Controller`."""
        self._demand, kept = self._mode.act(memory, flow, command, h)
        return self._demand, kept

    def told(self) -> list[Array]:
        """Command to each actuator, `Float64`; not a number where the mode moves the body without it."""
        beside = self._demand.wrench is not None or self._demand.acceleration is not None
        rest = nan if beside else 0.0
        return [jit.Float64(self._demand.actuators.get(name, rest)) for name in self._actuators]


def overheard(vehicle: Vehicle, mode: str) -> tuple[Vehicle, Overheard]:
    """A vehicle whose demands in one mode are read, and the mode that knows them."""
    vehicle.check_mode(mode)
    other, heard = copy(vehicle), Overheard(vehicle.controllers[mode], vehicle.actuator_names)
    other.controllers = {**vehicle.controllers, mode: heard}
    return other, heard

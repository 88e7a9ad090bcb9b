"""The contract of a control mode: set-points and a memory in, a demand and the next memory out."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Protocol

from pelagos.hydro.algebra import Vector
from pelagos.jit import Array
from pelagos.vehicles.flow import Flow


@dataclass(frozen=True)
class Demand:
    """Demand of a mode.

    Attributes:
        actuators: command by actuator; those not named get 0.
        wrench: a further wrench on the body (6), FRD, for modes that act without actuators.
        acceleration: the body's acceleration itself (6), which then replaces the equation of motion.
    """

    actuators: Mapping[str, Array] = field(default_factory=dict)
    wrench: Vector | None = None
    acceleration: Vector | None = None


class Controller(Protocol):
    """A control law, pure: its memory is part of the vehicle's state."""

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points, in order."""
        ...

    @property
    def memory(self) -> int:
        """Number of values that it keeps."""
        ...

    def start(self, flow: Flow) -> list[Array]:
        """The memory when the mode is entered: references begin where the vehicle is."""
        ...

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """The demand for this step of h [s], and the memory for the next."""
        ...

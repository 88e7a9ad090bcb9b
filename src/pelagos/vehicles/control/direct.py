"""Modes without a control law: actuators, and a wrench on the body."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from pelagos.jit import Array
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import PartConfig

_AXES: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")


class ActuatorsConfig(PartConfig):
    """Commands go to the actuators, in their order and units."""

    type: Literal["actuators"]

    def build(self, plant: Plant) -> Direct:
        """The mode."""
        return Direct(tuple(plant.model.actuators), "actuators")


class WrenchConfig(PartConfig):
    """Force and moment on the body about its origin, forward-right-down [N], [N m]; actuators rest."""

    type: Literal["wrench"]

    def build(self, plant: Plant) -> Direct:
        """The mode."""
        return Direct(tuple(f"{a}_{'force' if i < 3 else 'moment'}" for i, a in enumerate(_AXES)), "wrench")


@dataclass(frozen=True)
class Direct:
    """`commands`: set-points, handed on as `kind`."""

    commands: tuple[str, ...]
    kind: Literal["actuators", "wrench"]
    memory: int = 0

    def start(self, flow: Flow) -> list[Array]:
        """Nothing is kept."""
        return []

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """The command itself."""
        if self.kind == "actuators":
            return Demand(dict(zip(self.commands, command, strict=True))), []
        return Demand(wrench=list(command)), []

"""Going to a place on the surface: the bow is turned to it, and pull grows with the distance."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import drjit as dr

from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of
from pelagos.vehicles.control.angle import smallest_angle
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive


class PlaceConfig(PartConfig):
    """Set-points: x, y of a place, world NWU [m]. For craft that push ahead and turn, and cannot go sideways."""

    type: Literal["place"]
    pull_n_m: Positive
    """Pull by distance [N/m]."""
    brake_kg_s: NonNegative = 0.0
    """Less pull by speed [kg/s]."""
    pull_limit_n: Positive
    """Greatest pull [N]."""
    turn_n_m: Positive
    """Moment by bearing [N m/rad]."""
    turn_damping: NonNegative
    """Less moment by rate of turn [N m s]."""
    turn_limit_n_m: Positive
    """Greatest moment [N m]."""

    def build(self, plant: Plant) -> PlaceControl:
        """The control law."""
        return PlaceControl(self, allocation_of(plant.model, (0, 5)))


@dataclass(frozen=True)
class PlaceControl:
    """See `PlaceConfig`."""

    config: PlaceConfig
    allocation: Allocation
    memory: int = 0
    commands: tuple[str, ...] = ("x", "y")

    def start(self, flow: Flow) -> list[Array]:
        """Nothing is kept."""
        return []

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the thrusters; no pull while the place lies behind."""
        c = self.config
        x, y = command[0] - flow.position[0], -command[1] - flow.position[1]
        bearing = smallest_angle(dr.atan2(y, x) - flow.yaw)
        ahead = c.pull_n_m * dr.sqrt(x * x + y * y) * dr.maximum(dr.cos(bearing), 0.0)
        pull = dr.clip(ahead - c.brake_kg_s * flow.nu[0], -c.pull_limit_n, c.pull_limit_n)
        moment = dr.clip(c.turn_n_m * bearing - c.turn_damping * flow.nu[5], -c.turn_limit_n_m, c.turn_limit_n_m)
        return Demand(self.allocation.commands([pull, 0.0, 0.0, 0.0, 0.0, moment])), []

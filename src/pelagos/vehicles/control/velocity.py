"""Velocity control by thrusters: what a pilot's sticks ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import drjit as dr
import numpy as np

from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive

Axis = Literal["surge", "sway", "heave", "roll", "pitch", "yaw"]
AXES: Final[tuple[Axis, ...]] = ("surge", "sway", "heave", "roll", "pitch", "yaw")
_SIGN: Final = (1.0, -1.0, -1.0, 1.0, -1.0, -1.0)  # FLU <-> FRD


class VelocityConfig(PartConfig):
    """Set-points: velocity over ground and rates, body FLU, one by each controlled axis [m/s], [rad/s]."""

    type: Literal["velocity"]
    axes: tuple[Axis, ...]
    """What is controlled."""
    bandwidth_rad_s: Positive
    """Of the closed loop [rad/s]."""
    integral: NonNegative = 0.5
    """Rate of the integrator over the bandwidth [-]."""
    level: tuple[Literal["roll", "pitch"], ...] = ()
    """Angles that are kept at 0 by the thrusters."""
    level_frequency_rad_s: Positive = 2.0
    """Of their closed loop [rad/s]."""

    def build(self, plant: Plant) -> Velocity:
        """The control law."""
        mass = [float(m) for m in np.diag(plant.body.mass_matrix)]
        return Velocity(self, mass, allocation_of(plant.model, [AXES.index(a) for a in (*self.axes, *self.level)]))


@dataclass(frozen=True)
class Velocity:
    """See `VelocityConfig`."""

    config: VelocityConfig
    mass: Sequence[float]
    allocation: Allocation
    memory: int = 6

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return tuple(f"{axis}_{'speed' if AXES.index(axis) < 3 else 'rate'}" for axis in self.config.axes)

    def start(self, flow: Flow) -> list[Array]:
        """No integral."""
        return [0.0] * 6

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the thrusters."""
        wanted = dict(zip(self.config.axes, command, strict=True))
        w = self.config.bandwidth_rad_s
        wrench: list[Array] = [0.0] * 6
        kept: list[Array] = [0.0] * 6
        for i, axis in enumerate(AXES):
            if axis not in wanted:
                continue
            error = _SIGN[i] * wanted[axis] - flow.nu[i]
            kept[i] = dr.clip(memory[i] + h * w * self.config.integral * error, -5.0, 5.0)
            wrench[i] = self.mass[i] * w * (error + kept[i])
        f = self.config.level_frequency_rad_s
        for angle, name, i in ((flow.roll, "roll", 3), (flow.pitch, "pitch", 4)):
            if name in self.config.level:
                wrench[i] = -self.mass[i] * (f * f * angle + 2 * f * flow.nu[i])
        return Demand(self.allocation.commands(wrench)), kept

"""Velocity control by thrusters: what a pilot's sticks ask for."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal, Self

import numpy as np
from pydantic import model_validator

from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of, unsaturated
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.feed_forward import current_of, filtered_current, holding_wrench
from pelagos.vehicles.control.free_pitch import upright_heave
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.model import Model
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
    neutral_speed_mps: Positive | None = None
    """For vehicles whose pitch is not controlled: the way through the water from which on the flow tilts them more
    than weight and buoyancy right them [m/s]. Faster than this heave is made by the angle of the flow."""

    @model_validator(mode="after")
    def _free_to_pitch(self) -> Self:
        if self.neutral_speed_mps is not None and (
            "pitch" in (*self.axes, *self.level) or "heave" not in self.axes or "surge" not in self.axes
        ):
            raise ValueError(
                "neutral_speed_mps is for axes with surge and heave, without pitch: thrusters that pitch keep it level"
            )
        return self

    def build(self, plant: Plant) -> Velocity:
        """The control law."""
        mass = [float(m) for m in np.diag(plant.body.mass_matrix)]
        allocation = allocation_of(plant.model, [AXES.index(a) for a in (*self.axes, *self.level)])
        return Velocity(self, mass, allocation, plant.model)


@dataclass(frozen=True)
class Velocity:
    """See `VelocityConfig`; memory: integrals of the errors (6), and the slow part of the current, NED (3) [m/s]."""

    config: VelocityConfig
    mass: Sequence[float]
    allocation: Allocation
    model: Model
    memory: int = 9

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return tuple(f"{axis}_{'speed' if AXES.index(axis) < 3 else 'rate'}" for axis in self.config.axes)

    def start(self, flow: Flow) -> list[Array]:
        """No integral; the present current."""
        return [0.0] * 6 + current_of(flow)

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the thrusters: PI on velocities, drag and current fed forward, upright before all else."""
        c = self.config
        given = dict(zip(c.axes, command, strict=True))
        wanted: list[Array] = [_SIGN[i] * given[axis] if axis in given else 0.0 for i, axis in enumerate(AXES)]
        current = filtered_current(memory[6:9], flow, h)
        if c.neutral_speed_mps is not None:
            wanted[2] = upright_heave(flow, wanted[2], current, c.neutral_speed_mps)
        held = holding_wrench(self.model, flow, wanted, current)
        wrench: list[Array] = [0.0] * 6
        for i, axis in enumerate(AXES):
            if axis in given:
                wrench[i] = self.mass[i] * c.bandwidth_rad_s * (wanted[i] - flow.nu[i] + memory[i]) + held[i]
        f = c.level_frequency_rad_s
        for angle, name, i in ((flow.roll, "roll", 3), (flow.pitch, "pitch", 4)):
            if name in c.level:
                wrench[i] = held[i] - self.mass[i] * (f * f * angle + 2 * f * flow.nu[i])
        thrusts, shares = self.allocation.prioritised(wrench)
        rate = h * c.bandwidth_rad_s * c.integral
        kept = [
            memory[i] + unsaturated(shares[i], wrench[i], rate * (wanted[i] - flow.nu[i])) if axis in given else 0.0
            for i, axis in enumerate(AXES)
        ]
        return Demand(self.allocation.commands_of(thrusts)), [*kept, *current]

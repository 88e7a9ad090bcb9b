"""Multirotor: position by tilting, attitude and thrust by the rotors.

Source: T. Lee, M. Leok, N. H. McClamroch, "Geometric tracking control of a quadrotor UAV on SE(3)", CDC 2010,
doi 10.1109/CDC.2010.5717652, with a limited tilt and an integral against wind.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

import drjit as dr

from pelagos.hydro.algebra import cross, dot, scaled
from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import NonNegative, PartConfig, Positive

_TURN: Final = 0.2  # rad of the attitude loop in a step: beyond it the step's delay makes it swing
_APART: Final = 5.0  # of the attitude loop's frequency to the position loop's, where the step slows them


class MultirotorConfig(PartConfig):
    """Set-points: x, y, z world NWU [m] and yaw of FLU in NWU [rad]; with `moving` also the velocity of that place."""

    type: Literal["multirotor"]
    moving: bool = False
    """The place moves: its velocity, world NWU [m/s], is a further set-point, and what missions follow paths with."""
    frequency_rad_s: Positive
    """Of the position loop [rad/s]."""
    turn_frequency_rad_s: Positive
    """Of the attitude loop [rad/s]; no more than 0.2 rad a step, and the position loop's a fifth of that."""
    ratio: Positive = 0.9
    """Damping ratio [-]."""
    integral: NonNegative = 0.2
    """Rate of the integrator over the position loop's frequency [-]."""
    reach_m: Positive = 3.0
    """Position errors count no more than this [m]."""
    tilt_limit_deg: Positive = 30.0
    """[deg]"""

    def build(self, plant: Plant) -> Multirotor:
        """The control law."""
        body = plant.body
        inertia = [float(body.mass_matrix[i, i]) for i in (3, 4, 5)]
        allocation = allocation_of(plant.model, (2, 3, 4, 5))
        return Multirotor(self, float(body.mass_matrix[0, 0]), inertia, body.gravity, allocation)


@dataclass(frozen=True)
class Multirotor:
    """See `MultirotorConfig`; memory: integrals of the position error (3) [m]."""

    config: MultirotorConfig
    mass: float
    inertia: Sequence[float]
    gravity: float
    allocation: Allocation
    memory: int = 3

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return ("x", "y", "z", "yaw", *(("x_speed", "y_speed", "z_speed") if self.config.moving else ()))

    def start(self, flow: Flow) -> list[Array]:
        """No integral."""
        return [0.0, 0.0, 0.0]

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the rotors."""
        c, rotation = self.config, flow.rotation
        x, y, z, yaw = command[:4]
        ahead, left, up = command[4:] if c.moving else (0.0, 0.0, 0.0)
        goal, moving = (x, -y, -z), (ahead, -left, -up)
        wanted: list[Array] = []
        kept: list[Array] = []
        f = dr.minimum(c.turn_frequency_rad_s, _TURN / h)
        w = dr.minimum(c.frequency_rad_s, f / _APART)
        for i in range(3):
            error = dr.clip(goal[i] - flow.position[i], -c.reach_m, c.reach_m)
            kept.append(dr.clip(memory[i] + h * w * c.integral * error, -c.reach_m, c.reach_m))
            velocity = dot(rotation[i], flow.nu[:3]) - moving[i]
            wanted.append(w * w * (error + kept[i]) - 2 * c.ratio * w * velocity)
        lift = -(wanted[2] - self.gravity)  # of the thrust's acceleration
        lift = dr.maximum(lift, 0.3 * self.gravity)
        tilt = math.tan(math.radians(c.tilt_limit_deg))
        across = dr.sqrt(wanted[0] ** 2 + wanted[1] ** 2 + 1e-12)
        share = dr.minimum(1.0, tilt * lift / across)
        thrust = [share * wanted[0], share * wanted[1], -lift]
        down = scaled(-dr.rsqrt(dot(thrust, thrust)), thrust)  # the body's z axis, NED
        sin, cos = dr.sincos(-yaw)
        right = cross(down, [cos, sin, 0.0])
        right = scaled(dr.rsqrt(dot(right, right)), right)
        goal_axes = (cross(right, down), right, down)
        axes = list(zip(*rotation, strict=True))
        moments: list[Array] = []
        for i, (j, k) in enumerate(((1, 2), (2, 0), (0, 1))):
            error = 0.5 * (dot(goal_axes[k], axes[j]) - dot(goal_axes[j], axes[k]))
            moments.append(-self.inertia[i] * (f * f * error + 2 * c.ratio * f * flow.nu[3 + i]))
        force = self.mass * dot(thrust, axes[2])
        return Demand(self.allocation.commands([0.0, 0.0, force, *moments])), kept

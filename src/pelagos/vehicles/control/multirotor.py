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
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.control.rotorcraft import LEAST_LIFT, Rotorcraft, RotorcraftConfig, airframe
from pelagos.vehicles.flow import Flow
from pelagos.vehicles.part import Positive

_APART: Final = 5.0  # of the attitude loop's frequency to the position loop's, where the step slows them


class MultirotorConfig(RotorcraftConfig):
    """Set-points: x, y, z world NWU [m] and yaw of FLU in NWU [rad]; with `moving` also the velocity of that place."""

    type: Literal["multirotor"]
    moving: bool = False
    """The place moves: its velocity, world NWU [m/s], is a further set-point, and what missions follow paths with."""
    tilt_limit_deg: Positive = 30.0
    """[deg]"""

    def build(self, plant: Plant) -> Multirotor:
        """The control law."""
        return Multirotor(self, *airframe(plant))


@dataclass(frozen=True)
class Multirotor(Rotorcraft):
    """See `MultirotorConfig`; memory: integrals of the position error (3) [m]."""

    config: MultirotorConfig
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
        f = self.turn_frequency(h)
        w = dr.minimum(c.frequency_rad_s, f / _APART)
        for i in range(3):
            speed = dot(rotation[i], flow.nu[:3]) - moving[i]
            acceleration, integral = self.approach(w, goal[i] - flow.position[i], memory[i], speed, h)
            wanted.append(acceleration)
            kept.append(integral)
        lift = -(wanted[2] - self.gravity)  # of the thrust's acceleration
        lift = dr.maximum(lift, LEAST_LIFT * self.gravity)
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
            moments.append(self.turning(f, i, -error, flow.nu[3 + i]))
        force = self.mass * dot(thrust, axes[2])
        return Demand(self.allocation.commands([0.0, 0.0, force, *moments])), kept

"""Pose control by thrusters: 6-DOF PID, dynamic positioning and station keeping.

Source: F21 Chapter 15 (MIMO PID with pole placement, gravity compensated): Kp = w^2 M, Kd = 2 ratio w M, Ki = w/10 Kp.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal

import drjit as dr
import numpy as np

from pelagos.hydro.algebra import Matrix, Vector, dot, matmul, matvec, transpose
from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow, rotation_from_euler
from pelagos.vehicles.part import NonNegative, PartConfig, Positive
from pelagos.vehicles.terms.restoring import Submerged

Axis = Literal["x", "y", "z", "roll", "pitch", "yaw"]
AXES: Final[tuple[Axis, ...]] = ("x", "y", "z", "roll", "pitch", "yaw")


class PoseConfig(PartConfig):
    """Set-points: a pose, world NWU [m] and angles of FLU in NWU [rad]; or none, to stay where the mode was entered."""

    type: Literal["pose"]
    axes: tuple[Axis, ...] = AXES
    """What is controlled; the thrusters must be able to act on each."""
    hold: bool = False
    """Station keeping: the set-point is the pose at which the mode was entered."""
    frequency_rad_s: Positive
    """Of the closed loop in position [rad/s]."""
    turn_frequency_rad_s: Positive
    """Of the closed loop in angles [rad/s]."""
    ratio: Positive = 1.0
    """Damping ratio [-]."""
    integral: NonNegative = 0.1
    """Integral action: rate of the integrator over the loop's frequency [-]."""
    reach_m: Positive = 1.0
    """Position errors count no more than this, which limits the speed of approach [m]."""

    def build(self, plant: Plant) -> Pose:
        """The control law."""
        mass = np.diag(plant.body.mass_matrix)
        restoring = [t for t in plant.model.terms.values() if isinstance(t, Submerged)]
        return Pose(
            config=self,
            mass=[float(m) for m in mass],
            allocation=allocation_of(plant.model, [AXES.index(a) for a in self.axes]),
            restoring=restoring[0] if restoring else None,
        )


@dataclass(frozen=True)
class Pose:
    """See `PoseConfig`."""

    config: PoseConfig
    mass: Sequence[float]
    allocation: Allocation
    restoring: Submerged | None

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        return () if self.config.hold else tuple(self.config.axes)

    @property
    def memory(self) -> int:
        """Six integrals, and six numbers of the pose where the mode was entered."""
        return 12

    def start(self, flow: Flow) -> list[Array]:
        """No integral; the present pose."""
        return [0.0] * 6 + world_pose(flow)

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the thrusters."""
        c = self.config
        goal = list(memory[6:12])
        for axis, value in zip(self.commands, command, strict=True):
            goal[AXES.index(axis)] = value
        apart = position_error(flow, goal)
        near = dot(apart, apart) < c.reach_m**2
        error = [*_limited(apart, c.reach_m), *attitude_error(flow, goal)]
        wrench: list[Array] = []
        integrals: list[Array] = []
        held = [0.0] * 6 if self.restoring is None else self.restoring.wrench(flow)
        for i, (axis, e) in enumerate(zip(AXES, error, strict=True)):
            w = c.frequency_rad_s if i < 3 else c.turn_frequency_rad_s
            largest = 3.0 * c.reach_m if i < 3 else 1.0
            step = h * w * c.integral * e
            moved = dr.clip(memory[i] + (dr.select(near, step, 0.0) if i < 3 else step), -largest, largest)
            active = axis in c.axes
            integrals.append(moved if active else 0.0)
            pull = self.mass[i] * (w * w * (e + moved) + 2 * c.ratio * w * flow.nu[i])
            wrench.append(-pull - held[i] if active else 0.0)
        return Demand(self.allocation.commands(wrench)), [*integrals, *memory[6:12]]


def world_pose(flow: Flow) -> list[Array]:
    """x, y, z NWU [m], roll, pitch, yaw of FLU in NWU [rad]."""
    p = flow.position
    return [p[0], -p[1], -p[2], flow.roll, -flow.pitch, -flow.yaw]


def position_error(flow: Flow, goal: Sequence[Array]) -> list[Array]:
    """Where the vehicle is, seen from the goal, in body axes FRD (3) [m]."""
    p = flow.position
    return matvec(transpose(flow.rotation), [p[0] - goal[0], p[1] + goal[1], p[2] + goal[2]])


def attitude_error(flow: Flow, goal: Sequence[Array]) -> list[Array]:
    """2 sin(angle/2) times the axis of the turn from the goal's attitude to the vehicle's, in body axes FRD (3)."""
    wanted: Matrix = rotation_from_euler(goal[3], -goal[4], -goal[5])
    turn: Any = matmul(transpose(wanted), flow.rotation)
    trace = turn[0][0] + turn[1][1] + turn[2][2]
    scale = dr.rsqrt(dr.maximum(1 + trace, 1e-6))
    return [scale * (turn[j][i] - turn[i][j]) for i, j in ((1, 2), (2, 0), (0, 1))]


def _limited(error: Vector, reach: float) -> list[Array]:
    factor = reach * dr.rsqrt(dr.maximum(dot(error, error), reach * reach))
    return [factor * e for e in error]

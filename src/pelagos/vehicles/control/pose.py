"""Pose control by thrusters: dynamic positioning, station keeping and following a pose that moves.

A proportional loop asks for a velocity, limited so that approaches stay slow, and for rates of turn; a PI loop with the
drag of that velocity fed forward makes them. Gains by pole placement, Kp = w^2 M, Kd = 2 ratio w M.

Source: F21 Chapter 15 (MIMO PID with pole placement, model-based feed-forward) and Section 15.2.4 (integrator
anti-windup by conditional integration).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Final, Literal, Self

import drjit as dr
import numpy as np
from pydantic import model_validator

from pelagos.hydro.algebra import Matrix, Vector, add, dot, matmul, matvec, scaled, transpose
from pelagos.jit import Array
from pelagos.vehicles.control.allocation import Allocation, allocation_of, unsaturated
from pelagos.vehicles.control.controller import Demand
from pelagos.vehicles.control.feed_forward import current_of, filtered_current, holding_wrench
from pelagos.vehicles.control.free_pitch import upright_heave
from pelagos.vehicles.control.plant import Plant
from pelagos.vehicles.flow import Flow, rotation_from_euler
from pelagos.vehicles.model import Model
from pelagos.vehicles.part import NonNegative, PartConfig, Positive

Axis = Literal["x", "y", "z", "roll", "pitch", "yaw"]
AXES: Final[tuple[Axis, ...]] = ("x", "y", "z", "roll", "pitch", "yaw")
MOVING: Final = ("x_speed", "y_speed", "z_speed", "drive")


class PoseConfig(PartConfig):
    """Set-points: a pose, world NWU [m] and angles of FLU in NWU [rad]; or none, to stay where the mode was entered.

    With `moving` also the velocity of that pose, world NWU [m/s], and the share of the thrust ahead and sideways that
    may be used, 0 (adrift) .. 1.
    """

    type: Literal["pose"]
    axes: tuple[Axis, ...] = AXES
    """What is controlled; the thrusters must be able to act on each."""
    hold: bool = False
    """Station keeping: the set-point is the pose at which the mode was entered."""
    moving: bool = False
    """The pose moves: its velocity is a further set-point, and what missions follow paths with."""
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
    neutral_speed_mps: Positive | None = None
    """For vehicles without `pitch` among their axes: the way through the water from which on the flow tilts them more
    than weight and buoyancy right them [m/s]. Faster than this depth is held by the angle of the flow."""

    @model_validator(mode="after")
    def _free_to_pitch(self) -> Self:
        if self.neutral_speed_mps is not None and ("pitch" in self.axes or "z" not in self.axes):
            raise ValueError(
                "neutral_speed_mps is for axes with z and without pitch: thrusters that pitch keep it level"
            )
        return self

    def build(self, plant: Plant) -> PoseControl:
        """The control law."""
        mass = np.diag(plant.body.mass_matrix)
        return PoseControl(
            config=self,
            mass=[float(m) for m in mass],
            allocation=allocation_of(plant.model, [AXES.index(a) for a in self.axes]),
            model=plant.model,
        )


@dataclass(frozen=True)
class PoseControl:
    """See `PoseConfig`.

    Memory: integrals of the velocity error, body axes (6), times the loop's frequency [m/s], [rad/s]; the pose where
    the mode was entered (6); the slow part of the current, NED (3) [m/s].
    """

    config: PoseConfig
    mass: Sequence[float]
    allocation: Allocation
    model: Model
    memory: int = 15

    @property
    def commands(self) -> tuple[str, ...]:
        """Names of the set-points."""
        if self.config.hold:
            return ()
        return (*self.config.axes, *(MOVING if self.config.moving else ()))

    def start(self, flow: Flow) -> list[Array]:
        """No integral; the present pose and current."""
        return [0.0] * 6 + world_pose(flow) + current_of(flow)

    def act(
        self, memory: Sequence[Array], flow: Flow, command: Sequence[Array], h: Array
    ) -> tuple[Demand, list[Array]]:
        """Commands of the thrusters."""
        goal = list(memory[6:12])
        given = dict(zip(self.commands, command, strict=True))
        for i, axis in enumerate(AXES):
            goal[i] = given.get(axis, goal[i])
        moving = [given.get(name, 0.0) for name in MOVING[:3]]
        drive = given.get("drive", 1.0)
        current = filtered_current(memory[12:15], flow, h)
        wanted = self._approach(flow, goal, [moving[0], -moving[1], -moving[2]])
        if self.config.neutral_speed_mps is not None:
            sinking = dot(flow.rotation[2], wanted) - current[2]
            wanted[2] = upright_heave(flow, sinking, current, self.config.neutral_speed_mps)
        held = holding_wrench(self.model, flow, [*wanted, 0.0, 0.0, 0.0], current)
        wrench, steps = self._pull(memory, flow, wanted, attitude_error(flow, goal), h)
        wrench = [a + b if axis in self.config.axes else 0.0 for axis, a, b in zip(AXES, wrench, held, strict=True)]
        wrench = [drive * wrench[0], drive * wrench[1], *wrench[2:]]
        thrusts, shares = self.allocation.prioritised(wrench)
        kept = [
            memory[i] + unsaturated(shares[i], wrench[i], steps[i]) if axis in self.config.axes else 0.0
            for i, axis in enumerate(AXES)
        ]
        kept = [drive * kept[0], drive * kept[1], *kept[2:]]
        return Demand(self.allocation.commands_of(thrusts)), [*kept, *memory[6:12], *current]

    def _approach(self, flow: Flow, goal: Sequence[Array], velocity: Vector) -> list[Array]:
        """Velocity (3) [m/s], body axes, that leads to the goal, which itself moves with `velocity`, NED."""
        c = self.config
        apart = _limited(position_error(flow, goal), c.reach_m)
        return add(scaled(-c.frequency_rad_s / (2 * c.ratio), apart), matvec(transpose(flow.rotation), velocity))

    def _pull(
        self, memory: Sequence[Array], flow: Flow, wanted: Vector, turned: Vector, h: Array
    ) -> tuple[list[Array], list[Array]]:
        """Wrench (6) of the loops alone, and the steps (6) of their integrals."""
        c = self.config
        wrench: list[Array] = []
        steps: list[Array] = []
        rates = scaled(-c.turn_frequency_rad_s / (2 * c.ratio), turned)
        for i, velocity in enumerate([*wanted, *rates]):
            w = c.frequency_rad_s if i < 3 else c.turn_frequency_rad_s
            error = velocity - flow.nu[i]
            wrench.append(self.mass[i] * 2 * c.ratio * w * (error + memory[i]))
            steps.append(h * w * c.integral * error)
        return wrench, steps


def world_pose(flow: Flow) -> list[Array]:
    """x, y, z NWU [m], roll, pitch, yaw of FLU in NWU [rad]."""
    p = flow.position
    return [p[0], -p[1], -p[2], flow.roll, -flow.pitch, -flow.yaw]


def position_error(flow: Flow, goal: Sequence[Array]) -> list[Array]:
    """Place of the vehicle, seen from the goal, in body axes FRD (3) [m]."""
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

"""Common parts of autopilots: a vehicle's state in their frames, and the actuator that each of their outputs moves.

Autopilots speak north-east-down of the world and forward-right-down of the body.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Final, NamedTuple, TypeAlias

import numpy as np

from pelagos.bridges.transport import BridgeMismatch
from pelagos.errors import LookupFailed
from pelagos.math.constants import GRAVITY
from pelagos.math.so3 import euler_np, matrix
from pelagos.sim.simulation import Simulation

Three: TypeAlias = tuple[float, float, float]

SUB_SIX: Final = {
    "front_starboard": (1, -1), "front_port": (2, -1), "rear_starboard": (3, 1), "rear_port": (4, 1),
    "vertical_starboard": (5, -1), "vertical_port": (6, -1),
}  # fmt: skip
"""ArduSub's frame "vectored" (AP_Motors6DOF.cpp): its motor and the sense in which it turns."""
SUB_EIGHT: Final = {
    "front_starboard": (1, -1), "front_port": (2, -1), "rear_starboard": (3, 1), "rear_port": (4, 1),
    "top_front_starboard": (5, -1), "top_front_port": (6, -1), "top_rear_starboard": (7, -1), "top_rear_port": (8, -1),
}  # fmt: skip
"""ArduSub's frame "vectored_6dof" (AP_Motors6DOF.cpp)."""
COPTER_X: Final = {
    "front_starboard": (1, 1), "rear_port": (2, 1), "front_port": (3, 1), "rear_starboard": (4, 1),
}  # fmt: skip
"""The X of four rotors, the same for ArduCopter and PX4."""
OUTPUTS: Final[Mapping[str, Mapping[str, tuple[int, int]]]] = {
    "bluerov2": SUB_SIX,
    "bluerov2_heavy": SUB_EIGHT,
    "wamv": {"left_thruster": (1, 1), "right_thruster": (3, 1)},  # Rover, motorboat with skid steering
    "otter": {"left_propeller": (1, 1), "right_propeller": (3, 1)},
    "quadrotor": COPTER_X,
}


@dataclass(frozen=True)
class Output:
    """One actuator and the output that moves it.

    Attributes:
        channel: counted from 0.
        low, high: the actuator's value at the output's ends; in the middle it rests where `low` is below 0.
    """

    channel: int
    low: float
    high: float

    def value(self, level: float) -> float:
        """The actuator's command at a level -1 .. 1."""
        level = min(max(level, -1.0), 1.0)
        if self.low < 0 < self.high or self.high < 0 < self.low:
            return level * (self.high if level > 0 else -self.low)
        return self.low + 0.5 * (level + 1.0) * (self.high - self.low)

    @property
    def rests_at(self) -> float:
        """The level at which the actuator does nothing."""
        return 0.0 if self.low * self.high < 0 else -1.0


def outputs_of(sim: Simulation, agent: str, given: Mapping[str, int], where: str) -> list[Output]:
    """One output for each actuator of an agent, in the vehicle's order.

    Args:
        sim: the simulation.
        agent: whose actuators.
        given: output, counted from 1, by actuator; negative where it turns the other way. Empty: by the vehicle's type.
        where: for messages.

    Raises:
        BridgeMismatch: there is no table for this vehicle, or an actuator has no output.
    """
    vehicle = sim.model.agents[agent].vehicle
    names = list(vehicle.actuator_names)
    table = {name: (abs(number), 1 if number > 0 else -1) for name, number in given.items()}
    if not table:
        kind = sim.model.agents[agent].config.vehicle.type
        if kind not in OUTPUTS:
            raise BridgeMismatch(
                f"{where}: which output moves which actuator of {kind!r}? give `outputs`, such as "
                f"{{{names[0]}: 1}}; known vehicles: {', '.join(OUTPUTS)}"
            )
        table = dict(OUTPUTS[kind])
    for name in table:
        if name not in names:
            raise BridgeMismatch(str(LookupFailed("actuator", name, names, where=where)))
    lacking = [name for name in names if name not in table]
    if lacking:
        raise BridgeMismatch(f"{where}: no output moves {', '.join(lacking)}")
    found = []
    for name in names:
        number, sense = table[name]
        lag: Any = vehicle.model.actuators[name].lag
        ends = (float(lag.low), float(lag.high))
        found.append(Output(number - 1, *(ends if sense > 0 else (ends[1], ends[0]))))
    return found


class VehicleMotion(NamedTuple):
    """Pose and motion of a vehicle, for an autopilot; plain numbers, for they are asked for every tick.

    Attributes:
        position: north, east, down of the world's origin [m].
        velocity: north, east, down [m/s].
        attitude: quaternion (w, x, y, z), body to north-east-down.
        gyro: forward, right, down [rad/s].
        force: specific force, forward, right, down [m/s^2]; (0, 0, -9.81) at rest.
    """

    position: Three
    velocity: Three
    attitude: tuple[float, float, float, float]
    gyro: Three
    force: Three

    @property
    def euler(self) -> tuple[float, float, float]:
        """Roll, pitch, yaw [rad]."""
        roll, pitch, yaw = euler_np(np.array(self.attitude)).tolist()
        return roll, pitch, yaw


def motion_of(sim: Simulation, agent: str) -> VehicleMotion:
    """The true motion of the first copy of an agent, now."""
    row = sim.stepper.row(agent)[0].tolist()  # what `sim.state` shows, without a look at the actuators
    x, y, z, qw, qx, qy, qz, u, v, w, p, q, r, ax, ay, az = row[:16]
    turn = matrix((qw, qx, qy, qz))
    up_x, up_y, up_z = turn[2]
    north, west, up = (a * u + b * v + c * w for a, b, c in turn)
    return VehicleMotion(
        (x, -y, -z),
        (north, -west, -up),
        (qw, qx, -qy, -qz),
        (p, -q, -r),
        (ax + GRAVITY * up_x, -ay - GRAVITY * up_y, -az - GRAVITY * up_z),
    )


def the_agent(sim: Simulation, asked: str, where: str) -> str:
    """The agent that a door is for: the one asked for, or the only one.

    Raises:
        BridgeMismatch: there is none of that name, or several to choose from.
    """
    names: Sequence[str] = list(sim.model.agents)
    if asked and asked not in names:
        raise BridgeMismatch(str(LookupFailed("agent", asked, names, where=where)))
    if not asked and len(names) != 1:
        raise BridgeMismatch(f"{where}: which agent? give `agent`, one of {', '.join(names)}")
    return asked or names[0]

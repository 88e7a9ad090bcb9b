"""HoloOcean's agents in the air and on land: limits and schemes; their vehicles are in `ground_agents`."""

from __future__ import annotations

from typing import Any, Final

import numpy as np

from pelagos.compat.holoocean.agent_type import AgentType, Array, Scheme, sockets_of
from pelagos.compat.holoocean.ground_agents import (
    NAV_LIMITS,
    SPHERE_LIMITS,
    SPHERE_MOVES,
    TURTLE_LIMITS,
    husky_vehicle,
    husky_wrench,
    point_moved,
    righted,
    sphere_moved,
    sphere_vehicle,
    turtle_vehicle,
    turtle_wrench,
)

_UAV_HIGH: Final = np.array([5.087, 6.508, 0.8, 5984.4])
_UAV_ATTITUDE: Final = {
    "type": "attitude", "frequency_rad_s": 1.0, "turn_frequency_rad_s": 5.0, "ratio": 0.8,  # HoloOcean: P 25, D 8
}  # fmt: skip


def _uav_wrench(action: Array) -> Array:
    """Pitch, roll and yaw torques [N m] and thrust [N] -> a wrench FRD."""
    return np.array([0.0, 0.0, -action[3], action[1], -action[0], -action[2]])


UAV: Final = AgentType(
    "UavAgent", "UAV",
    {
        "type": "quadrotor", "terms": {"drag": {"diagonal": [2.0, 2.0, 2.0, 0.01, 0.01, 0.01]}},
        "modes": {"ho_attitude": _UAV_ATTITUDE},
    },
    (
        Scheme("[pitch_torque, roll_torque, yaw_torque, thrust]", 4, "wrench", -_UAV_HIGH, _UAV_HIGH, _uav_wrench),
        Scheme("[roll_target, pitch_target, yaw_rate_target, altitude_target]", 4, "ho_attitude"),
    ),
    sockets=sockets_of(CameraSocket=(0, 0, 0), Viewport=(-130, 0, 120)),
    accel_limit=100.0,  # assumed: a fall from 10 m is beyond it
)  # fmt: skip


def _sphere_steps(world: Any, state: Any, scheme: int, action: Array) -> dict[str, Any]:
    forward, turn = SPHERE_MOVES[int(action[0])] if scheme == 0 else action
    return sphere_moved(world, state.position[0], state.attitude[0], forward_m=float(forward), turn_deg=float(turn))


def _nav_steps(world: Any, state: Any, scheme: int, action: Array) -> dict[str, Any]:
    return point_moved(world, state.position[0], state.attitude[0], action)


def _husky_steps(world: Any, state: Any, scheme: int, action: Array) -> dict[str, Any]:
    return righted(state.position[0], state.attitude[0]) if action[2] > 0.5 else {}


SPHERE: Final = AgentType(
    "SphereAgent", "SphereRobot", sphere_vehicle(),
    (
        Scheme("0: forward, 1: back, 2: left, 3: right", 1, "wrench", np.zeros(1), np.full(1, 3.0),
               lambda a: np.zeros(6), discrete=4),
        Scheme("[forward_movement, rotation]", 2, "wrench", -SPHERE_LIMITS, SPHERE_LIMITS, lambda a: np.zeros(6)),
    ),
    sockets=sockets_of(CameraSocket=(0, 0, 0), Viewport=(-130, 0, 120)), steps=_sphere_steps,
)  # fmt: skip

NAV: Final = AgentType(
    "NavAgent", "NavAgent", sphere_vehicle(),
    (
        Scheme("[x_target, y_target, z_target]", 3, "wrench", -NAV_LIMITS, NAV_LIMITS, lambda a: np.zeros(6),
               enforced=False),
    ),
    sockets=sockets_of(CameraSocket=(0, 0, 0), Viewport=(-130, 0, 120)), steps=_nav_steps,
)  # fmt: skip
"""A point that goes to a place; the limits are what HoloOcean's action space says, not those of the place."""

TURTLE: Final = AgentType(
    "TurtleAgent", "TurtleAgent", turtle_vehicle(),
    (Scheme("[forward_force, rot_force]", 2, "wrench", -TURTLE_LIMITS, TURTLE_LIMITS, turtle_wrench),),
    sockets=sockets_of(CameraSocket=(30, 0, 5), Viewport=(-130, 0, 120)), accel_limit=250.0,
)  # fmt: skip

HUSKY: Final = AgentType(
    "HuskyVehicle", "HuskyVehicle", husky_vehicle(),
    (Scheme("[left_force, right_force, flip_reset]", 3, "wrench", command=husky_wrench),),
    sockets=sockets_of(CameraSocket=(-37, 0, 122.5), Viewport=(-147, 0, 71)), steps=_husky_steps,
)  # fmt: skip

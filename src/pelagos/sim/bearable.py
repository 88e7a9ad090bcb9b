"""Limits of orders from outside: what no vehicle could bear, and what no step could follow, is refused.

They lie far beyond what vehicles do. A run that is told such a thing would end with a state that is not finite.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy.typing import NDArray

from pelagos.errors import CommandError
from pelagos.sim.simulation import Simulation
from pelagos.vehicles.vehicle import Vehicle

BEARABLE_MPS2: Final = 100.0
"""Ten times gravity; and in rotation what gives the hull's farthest point so much [m/s^2]."""
FASTEST_WATER_MPS: Final = 15.0
"""Tidal streams of the fastest straits reach 10 m/s."""


def check_command(agent: str, vehicle: Vehicle, mode: str, values: Sequence[float]) -> None:
    """Refuse forces, moments and accelerations of a command `(k,)` that the vehicle could not bear.

    Raises:
        CommandError: says what was asked for, and the limit.
    """
    if len(values) != len(vehicle.command_names(mode)):
        return  # another refusal says so
    names = vehicle.set_points(mode)
    values = values[: len(names)]
    if all(name.endswith(("_force", "_moment")) for name in names) and len(names) == 6:
        pushed = np.linalg.solve(vehicle.config.body.mass_matrix, np.array(values, dtype=np.float64))
        _check(agent, vehicle, np.asarray(pushed, dtype=np.float64), f"a {mode} of {_text(values)} N, N m")
    elif names and all(name.endswith("_acceleration") for name in names):
        _check(agent, vehicle, np.resize(np.asarray(values, dtype=np.float64), 6), f"a command of {_text(values)}")


def check_motion(agent: str, vehicle: Vehicle, velocity: Sequence[float], spin: Sequence[float]) -> None:
    """Refuse a velocity (3) [m/s] and rates (3) [rad/s], body FLU, at which the medium would tear at the vehicle.

    Raises:
        CommandError: says the deceleration there, and the limit.
    """
    if (len(velocity), len(spin)) != (3, 3):
        return
    nu = np.array([*velocity, *spin], dtype=np.float64) * [1, -1, -1, 1, -1, -1]
    if not nu.any():
        return
    count = len(vehicle.actuator_names)
    idle, still = np.zeros((1, count + vehicle.model.kept)), np.zeros((1, 6))
    at = [vehicle.accelerations(still, row[None], idle, np.zeros((1, count)))[0][0] for row in (nu, still[0])]
    asked = f"a velocity through the water of {_text(velocity)} m/s with {_text(spin)} rad/s"
    _check(agent, vehicle, at[0] - at[1], asked)


def check_current(sim: Simulation, current: Sequence[float]) -> None:
    """Refuse water, NWU (3) [m/s], that is faster than any on Earth, or that would tear at a vehicle.

    Raises:
        CommandError: says the limit.
    """
    from scipy.spatial.transform import Rotation

    if len(current) != 3:
        return  # another refusal says so
    speed = math.hypot(*current)
    if speed > FASTEST_WATER_MPS:
        raise CommandError(f"a current of {speed:g} m/s; at most {FASTEST_WATER_MPS:g} m/s")
    for name, agent in sim.model.agents.items():
        if agent.vehicle.config.body.in_air:
            continue
        state = sim.state[name]
        past = state.velocity - Rotation.from_quat(state.attitude[:, [1, 2, 3, 0]]).inv().apply(current)
        for velocity, spin in zip(past.tolist(), state.angular_velocity.tolist(), strict=True):
            check_motion(name, agent.vehicle, velocity, spin)


def _check(agent: str, vehicle: Vehicle, accelerations: NDArray[np.float64], asked: str) -> None:
    pulled, turned = (float(np.abs(part).max()) for part in (accelerations[:3], accelerations[3:]))
    most = BEARABLE_MPS2 / vehicle.bounding_radius_m
    if not (pulled <= BEARABLE_MPS2 and turned <= most):
        raise CommandError(
            f"{agent}: {asked} would accelerate it by {pulled:.3g} m/s^2 and {turned:.3g} rad/s^2; "
            f"at most {BEARABLE_MPS2:g} m/s^2 and {most:.3g} rad/s^2"
        )


def _text(values: Sequence[float]) -> str:
    return "(" + ", ".join(f"{v:g}" for v in values) + ")"

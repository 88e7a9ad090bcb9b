"""HoloOcean's agents on land: TurtleAgent and HuskyVehicle as native vehicles, and SphereAgent, which only has places.

Facts: HoloOcean 2.3 and its documentation (BYU FRoSt Lab, MIT licence) for limits and meanings of actions. Masses and
resistances of turtle and sphere live in its art and are not published: what stands here is assumed. The Husky's size
and mass are those of Clearpath's A200 data sheet; its resistance is assumed: 2 m/s at the recommended forces.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.math.so3 import matrix_np, yaw_np
from pelagos.world.world import World

TURTLE_LIMITS: Final = np.array([160.0, 35.0])
"""Greatest forward force [N] and yaw torque [N m], either way."""
SPHERE_LIMITS: Final = np.array([20.0, 20.0])
"""Greatest step forward [m] and turn [deg] of a tick, either way."""
SPHERE_MOVES: Final = ((0.185, 0.0), (-0.185, 0.0), (0.0, 10.0), (0.0, -10.0))
"""The discrete actions 0 .. 3: step forward [m] and turn [deg] of a tick."""
SPHERE_RADIUS_M: Final = 0.25
"""How near it comes to walls; assumed."""
NAV_LIMITS: Final = np.full(3, 0.5)
"""Limits of HoloOcean's NavAgent: here the farthest that it goes in a tick [m]."""
_PEA_M: Final = 0.02
"""Diameter of what others see of it: no contact is to push it about."""
HUSKY_TRACK_M: Final = 0.555
"""Between the wheels of both sides: Clearpath A200."""


def _on_land(mass: float, size: tuple[float, float, float], damping: list[float], parts: list[Any]) -> dict[str, Any]:
    """A native vehicle on free wheels, which weight holds on the ground and damping slows down; it sinks in water."""
    length, width, height = size
    inertia = [
        mass / 12 * (width**2 + height**2), mass / 12 * (length**2 + height**2), mass / 12 * (length**2 + width**2)
    ]  # fmt: skip
    return {
        "type": "custom", "medium": "air", "density_kg_m3": 1.225, "length_m": length, "beam_m": width,
        "height_m": height, "mass": {"type": "explicit", "mass_kg": mass, "inertia_kg_m2": inertia, "volume_m3": 0},
        "added_mass": {"type": "none"}, "hull_grip": 0.02,
        "terms": {
            "weight": {"type": "submerged", "free_surface": False},
            "rolling": {"type": "linear_damping", "diagonal": damping},
            "ditching": {"type": "ditching", "volume_m3": 0.5e-3 * mass,
                         "area_m2": [width * height, length * height, length * width]},
        },
        "modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench",
        "hull": {"type": "parts", "parts": parts},
    }  # fmt: skip


def turtle_vehicle() -> dict[str, Any]:
    """TurtleAgent: 20 kg on free wheels, 4 m/s at full force."""
    size = (0.6, 0.5, 0.24)
    return _on_land(20.0, size, [40.0, 400.0, 0.5, 2.0, 2.0, 10.0], [{"type": "box", "size_m": size}])


def turtle_wrench(action: ArrayLike) -> NDArray[np.float64]:
    """Forward force [N] and yaw torque to the left [N m] -> the command of mode `wrench`, FRD."""
    force, torque = np.clip(np.asarray(action, dtype=np.float64)[:2], -TURTLE_LIMITS, TURTLE_LIMITS)
    return np.array([force, 0.0, 0.0, 0.0, 0.0, -torque])


def husky_vehicle() -> dict[str, Any]:
    """HuskyVehicle: 50 kg on four wheels."""
    wheels = [
        {"type": "cylinder", "size_m": [0.114, 0.33, 0.33], "turn_deg": [90, 0, 90], "material": "black",
         "position_m": [x, HUSKY_TRACK_M / 2, -0.03], "mirror": True}
        for x in (0.256, -0.256)
    ]  # fmt: skip
    body = [{"type": "box", "size_m": [0.86, 0.42, 0.24], "position_m": [0, 0, 0.03]}]
    return _on_land(50.0, (0.99, 0.67, 0.39), [750.0, 1000.0, 0.5, 5.0, 5.0, 100.0], [*body, *wheels])


def husky_wrench(action: ArrayLike) -> NDArray[np.float64]:
    """Forces of the left and the right wheels [N] -> the command of mode `wrench`, FRD."""
    left, right = np.asarray(action, dtype=np.float64)[:2]
    return np.array([left + right, 0.0, 0.0, 0.0, 0.0, (left - right) * HUSKY_TRACK_M / 2])


def righted(position: ArrayLike, attitude: ArrayLike) -> dict[str, Any]:
    """Arguments of `Simulation.set_state` that put an agent `(3,)`, `(4,)` on its wheels, at rest, with its heading."""
    yaw = float(yaw_np(np.ravel(attitude)))
    place = np.asarray(position, dtype=np.float64).reshape(3) + np.array([0.0, 0.0, 0.3])
    return {
        "position": place, "attitude": np.array([math.cos(yaw / 2), 0.0, 0.0, math.sin(yaw / 2)]),
        "velocity": np.zeros(3), "angular_velocity": np.zeros(3),
    }  # fmt: skip


def sphere_vehicle() -> dict[str, Any]:
    """SphereAgent: it has no dynamics, and stays where it is put; walls stop it in `sphere_moved`."""
    mass = {"type": "explicit", "mass_kg": 10.0, "inertia_kg_m2": [0.25] * 3, "volume_m3": 0}
    return {
        "type": "custom", "medium": "air", "density_kg_m3": 1.225, "gravity_m_s2": 0.0, "length_m": _PEA_M,
        "diameter_m": _PEA_M, "mass": mass, "added_mass": {"type": "none"},
        "hull": {"type": "parts", "parts": [{"type": "ellipsoid", "size_m": [_PEA_M] * 3}]},
        "modes": {"wrench": {"type": "wrench"}}, "default_mode": "wrench",
    }  # fmt: skip


def sphere_moved(
    world: World, position: ArrayLike, attitude: ArrayLike, *, forward_m: float, turn_deg: float
) -> dict[str, Any]:
    """Arguments of `Simulation.set_state` that move a sphere for one tick: it turns, then goes ahead until a wall.

    Args:
        world: whose walls stop it.
        position, attitude: `(3,)` NWU [m] and `(4,)` (w, x, y, z) before.
        forward_m: step along its x axis, negative astern.
        turn_deg: to the left about the vertical.
    """
    half = math.radians(turn_deg) / 2
    w, x, y, z = (float(v) for v in np.ravel(attitude))
    c, s = math.cos(half), math.sin(half)
    turned = np.array([c * w - s * z, c * x - s * y, c * y + s * x, c * z + s * w])
    ahead = matrix_np(turned)[:, 0] * math.copysign(1.0, forward_m)
    place = np.asarray(position, dtype=np.float64).reshape(3)
    return _at_rest(place + _free(world, place, ahead, abs(forward_m)) * ahead, turned)


def point_moved(world: World, position: ArrayLike, attitude: ArrayLike, goal: ArrayLike) -> dict[str, Any]:
    """Arguments of `Simulation.set_state` that move a point for one tick: it faces its goal and goes to it or a wall.

    Args:
        world: whose walls stop it.
        position, attitude: `(3,)` NWU [m] and `(4,)` (w, x, y, z) before.
        goal: `(3,)` NWU [m].
    """
    place, turned = np.asarray(position, dtype=np.float64).reshape(3), np.ravel(attitude)
    line = np.asarray(goal, dtype=np.float64).reshape(3) - place
    left = float(np.linalg.norm(line))
    if left == 0:
        return _at_rest(place, turned)
    if math.hypot(line[0], line[1]) > 1e-9 * left:
        half = math.atan2(line[1], line[0]) / 2
        turned = np.array([math.cos(half), 0.0, 0.0, math.sin(half)])
    return _at_rest(place + _free(world, place, line / left, min(left, float(NAV_LIMITS[0]))) * line / left, turned)


def _free(world: World, place: NDArray[np.float64], ahead: NDArray[np.float64], step: float) -> float:
    """The free part of a step in a direction [m]."""
    if step == 0:
        return 0.0
    hit = world.cast(place + _PEA_M * ahead, ahead, step + SPHERE_RADIUS_M - _PEA_M)  # from outside its own hull
    return min(max(float(hit.t[0]) + _PEA_M - SPHERE_RADIUS_M, 0.0), step) if hit.valid[0] else step


def _at_rest(position: NDArray[np.float64], attitude: NDArray[np.float64]) -> dict[str, Any]:
    still = {"velocity": np.zeros(3), "angular_velocity": np.zeros(3)}
    return {"position": position, "attitude": attitude, **still}

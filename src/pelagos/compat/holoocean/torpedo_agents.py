"""HoloOcean's torpedo-shaped agents: four fins and a propeller.

Facts: HoloOcean 2.3 and its documentation (BYU FRoSt Lab, MIT licence); FLU unless FRD is said.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pelagos.compat.holoocean.agent_type import (
    AgentType,
    Array,
    Scheme,
    acceleration,
    engine_modes,
    world_acceleration_mode,
)

FIN_AT: Final = {"right": "port_plane", "bottom": "bottom_rudder", "left": "starboard_plane", "top": "top_rudder"}
"""Native fin at each place, counted from the right downwards: the catalogue's names are those of its source, in which
the starboard plane's axis points to 180 degrees. Angles are right-handed about the outward axis on both sides."""
_GIVEN: Final = ("right", "top", "left", "bottom")
_FIN_ORDER: Final = ("top_rudder", "bottom_rudder", "starboard_plane", "port_plane")


def _fins_and_thrust(action: Array) -> Array:
    """Right, top, left, bottom fin [deg] and thrust [N] -> the native fins [rad], and the thrust."""
    given = {FIN_AT[place]: math.radians(angle) for place, angle in zip(_GIVEN, action, strict=False)}
    return np.array([*(given[name] for name in _FIN_ORDER), action[4]])


def torpedo(
    name: str,
    engine: str,
    native: str,
    *,
    drag_area: float,
    inertia: tuple[float, float, float],
    products: tuple[float, float, float],
    limits: tuple[float, float] | None,
    **more: Any,
) -> AgentType:
    """An agent of this shape.

    Args:
        name, engine, native: type string, what the engine calls it, and the native vehicle.
        drag_area: drag coefficient times area of the force model [m^2].
        inertia, products: of the force model, FRD, fitted to the accelerations of HoloOcean's tests [kg m^2].
        limits: of the accelerations in the world, linear and angular.
        more: sockets and lamps.
    """
    full = np.array([45.0, 45.0, 45.0, 45.0, 100.0])
    thrust = {
        "type": "force_thruster", "position_m": [-0.8, 0, 0], "direction": [1, 0, 0], "low_n": -100, "high_n": 100,
        "time_constant_s": 0.1,
    }  # fmt: skip
    fins = {fin: {"limit_deg": 45} for fin in _FIN_ORDER}
    places = ((0.0, -1), (1, 0.0), (0.0, 1), (-1, 0.0))  # right, top, left, bottom: (z, y) FLU by 0.0707
    lifts = ((0.0, 0.0, -1.0), (0.0, -1.0, 0.0), (0.0, 0.0, 1.0), (0.0, 1.0, 0.0))  # FRD
    made = [
        {"position_m": (-1.05, -0.0707 * y, -0.0707 * z), "lift": lift}
        for (z, y), lift in zip(places, lifts, strict=True)
    ]
    unused = ("depth_heading_speed", "depth_heading", "altitude_heading_speed", "line_of_sight")
    modes: dict[str, Any] = {"ho_acceleration": world_acceleration_mode(limits), **dict.fromkeys(unused)}
    return AgentType(
        name, engine,
        {"type": native, "actuators": {**fins, "propeller": thrust}, "modes": modes, "default_mode": "actuators",
         "as_published": {}},
        (
            Scheme(
                "[right_fin, top_fin, left_fin, bottom_fin, thrust]", 5, "actuators", -full, full, _fins_and_thrust,
                "engine_thrusters",
            ),
            acceleration(limits),
        ),
        accel_limit=200.0,
        legacy=engine_modes(
            {"engine_thrusters": "thrusters"}, mass_kg=36, volume_m3=36 / 997, inertia_kg_m2=inertia,
            inertia_products_kg_m2=products, center_of_buoyancy_m=(0, 0, -0.01), drag_area_m2=drag_area,
            damping_1_s=0.75, turn_damping_1_s=0.5, half_height_m=0.1, fins=made,
            thrusters=[{"position_m": (-1.2, 0, 0), "direction": (1.0, 0.0, 0.0), "limit_n": 100.0}],
        ),
        constants={
            "mass": 36, "water_density": 997, "volume": 36 / 997, "cob": np.array([0, 0, 0.07]),
            "I": np.diag([2, 1.2, 1.2]), "thruster_p": np.array([-1.2, 0.0, 0.0]),
            "fin_p": np.array([[-1.05, -0.0707, 0], [-1.05, 0, 0.0707], [-1.05, 0.0707, 0], [-1.05, 0, -0.0707]]),
        },
        **more,
    )  # fmt: skip

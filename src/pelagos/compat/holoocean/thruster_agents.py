"""HoloOcean's agents with thrusters: the hovering ones, BlueROV2 and the surface vessel.

Inertias of the force model are fitted to the accelerations that HoloOcean's own tests expect; its own follow from
meshes that are not published.

Facts: HoloOcean 2.3 and its documentation (BYU FRoSt Lab, MIT licence); FLU unless FRD is said.
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np

from pelagos.compat.holoocean.agent_type import (
    DOWN,
    FLIPPED,
    POSE,
    AgentType,
    Scheme,
    acceleration,
    engine_modes,
    reordered,
    sockets_of,
    thrusters,
    world_acceleration_mode,
)

_S: Final = 1 / math.sqrt(2)
_ANGLED: Final = ((_S, -_S, 0.0), (_S, _S, 0.0), (_S, -_S, 0.0), (_S, _S, 0.0))  # FRD: FS, FP, BP, BS


def _eight(
    vertical: tuple[float, float, float], angled: tuple[float, float, float], limit: float
) -> list[dict[str, Any]]:
    """Eight thrusters FRD: four that lift, four at 45 deg; front starboard, front port, back port, back starboard.

    Args:
        vertical, angled: |x|, |y| and z (FLU) of each four [m].
        limit: [N].
    """
    corners = ((1, -1), (1, 1), (-1, 1), (-1, -1))  # FLU signs of x, y
    made = []
    for (x, y, z), turns in ((vertical, [(0.0, 0.0, -1.0)] * 4), (angled, list(_ANGLED))):
        for (sx, sy), turn in zip(corners, turns, strict=True):
            made.append({"position_m": (sx * x, -sy * y, -z), "direction": turn, "limit_n": limit})
    return made


HOVERING_SOCKETS: Final = sockets_of(
    COM=(7, 0, 0), SonarSocket=(42, 22, -5), DVLSocket=(-28, 0.5, -23.5), IMUSocket=(-9.7, 7, 6, FLIPPED),
    DepthSocket=(-14, 2, -15), CameraRightSocket=(32, -11, 15.5), CameraLeftSocket=(32, 11.5, 15.5),
    Origin=(0, 0, 0), Viewport=(-250, 0, 217),
)  # fmt: skip
HOVER_LIMIT: Final = 10 * 31.02 / 4
HOVER_ACCEL: Final = (10.0, 2.0)
_HOVER_POSE: Final = {
    "type": "pose", "frequency_rad_s": 2.0, "turn_frequency_rad_s": 2.5, "ratio": 1.0, "integral": 0.1, "reach_m": 1.2,
}  # fmt: skip
_HOVER_MODES: Final = {"ho_acceleration": world_acceleration_mode(HOVER_ACCEL), "ho_pose": _HOVER_POSE}
_COMMANDS: Final = {"engine_thrusters": "thrusters", "engine_pose": "pose"}


def hovering(name: str, engine: str, *, mass: float, limit: float, **more: Any) -> AgentType:
    """An agent of HoveringAUV's shape, of a mass [kg], with thrusters up to a limit [N]."""
    changes: dict[str, Any] = {"type": "hovering_auv", "modes": dict(_HOVER_MODES)}
    if limit != HOVER_LIMIT or mass != 31.02:
        sides = ("front_starboard", "front_port", "back_port", "back_starboard")
        changes["actuators"] = {
            f"{k}_{s}": {"low_n": -limit, "high_n": limit} for k in ("vertical", "angled") for s in sides
        }
        changes["mass"] = {"mass_kg": mass, "volume_m3": mass / 997}
    mounted = _eight((0.2481, 0.2214, -0.0379), (0.1402, 0.1823, 0.0), limit)
    return AgentType(
        name, engine, changes, (thrusters(8, limit), POSE, acceleration(HOVER_ACCEL)), (0, 2, 1),
        accel_limit=400.0,
        legacy=engine_modes(
            _COMMANDS, mass_kg=mass, volume_m3=mass / 997, inertia_kg_m2=(1.4756723, 2.0020764, 2.5315777),
            inertia_products_kg_m2=(-0.07339836, 0.0074321318, -0.026399793),
            center_of_buoyancy_m=(0, 0, -0.05), drag_area_m2=0.4, damping_1_s=1.0, turn_damping_1_s=0.75,
            half_height_m=0.2, thrusters=mounted,
        ),
        constants={
            "mass": mass, "water_density": 997, "volume": mass / 997, "cob": np.array([0, 0, 0.05]), "I": np.eye(3),
            "thruster_p": np.array([
                [0.25, -0.22, -0.04], [0.25, 0.22, -0.04], [-0.25, 0.22, -0.04], [-0.25, -0.22, -0.04],
                [0.14, -0.18, 0.0], [0.14, 0.18, 0.0], [-0.14, 0.18, 0.0], [-0.14, -0.18, 0.0],
            ]),
            "thruster_d": np.array([[0, 0, 1]] * 4 + [[_S, _S, 0], [_S, -_S, 0], [_S, _S, 0], [_S, -_S, 0]]),
        },
        **more,
    )  # fmt: skip


_BLUE_LIMIT: Final = 10 * 11.5 / 4
_BLUE_NAMES: Final = ("front_starboard", "front_port", "rear_starboard", "rear_port")
_BLUE_ACTUATORS: Final = {
    name: {
        "type": "force_thruster", "position_m": place, "direction": turn, "low_n": -_BLUE_LIMIT, "high_n": _BLUE_LIMIT,
        "time_constant_s": 0.1,
    }
    for name, place, turn in (
        ("front_starboard", (0.1562, 0.0988, 0.0), (1, -1, 0)), ("front_port", (0.1562, -0.0988, 0.0), (1, 1, 0)),
        ("rear_starboard", (-0.1562, 0.0988, 0.0), (1, 1, 0)), ("rear_port", (-0.1562, -0.0988, 0.0), (1, -1, 0)),
        ("top_front_starboard", (0.12, 0.2181, -0.0809), (0, 0, -1)),
        ("top_front_port", (0.12, -0.2181, -0.0809), (0, 0, -1)),
        ("top_rear_starboard", (-0.12, 0.2181, -0.0809), (0, 0, -1)),
        ("top_rear_port", (-0.12, -0.2181, -0.0809), (0, 0, -1)),
    )
}  # fmt: skip
BLUEROV2: Final = AgentType(
    "BlueROV2", "BlueROV2",
    {"type": "bluerov2_heavy", "battery": None, "actuators": _BLUE_ACTUATORS, "modes": dict(_HOVER_MODES)},
    (thrusters(8, _BLUE_LIMIT, command=reordered((4, 5, 7, 6, 0, 1, 3, 2))), POSE, acceleration(HOVER_ACCEL)),
    (0, 2, 1),
    sockets_of(
        COM=(0, 0, 0), SonarSocket=(15, 0, 14), DVLSocket=(0, 10, -10), IMUSocket=(11, 0, 6.5, FLIPPED),
        DepthSocket=(-17, 0, 6), CameraSocket=(21, 0, 6), Origin=(0, 0, 0), Viewport=(-200, 0, 115),
    ),
    ((0.22, 0.19, 0.11), (0.22, -0.19, 0.11), (0.22, 0.19, -0.06), (0.22, -0.19, -0.06)),
    400.0,
    engine_modes(
        _COMMANDS, mass_kg=11.5, volume_m3=11.5 / 997, inertia_kg_m2=(0.29678538, 0.23588581, 0.4236891),
        inertia_products_kg_m2=(-0.00023743367, -0.00025779739, 2.451253e-05),
        center_of_buoyancy_m=(0, 0, -0.05),
        drag_area_m2=0.36, damping_1_s=1.0, turn_damping_1_s=0.75, half_height_m=0.13,
        thrusters=_eight((0.12, 0.2181, 0.0809), (0.1562, 0.0988, 0.0), _BLUE_LIMIT),
    ),
    {
        "mass": 11.5, "water_density": 997, "volume": 11.5 / 997, "cob": np.zeros(3), "I": np.eye(3),
        "thruster_p": np.array([
            [-0.12, -0.218, 0], [-0.12, 0.218, 0], [0.12, 0.218, 0], [0.12, -0.218, 0],
            [-0.156, -0.111, 0.085], [-0.156, 0.111, 0.085], [0.156, 0.111, 0.085], [0.156, -0.111, 0.085],
        ]),
        "thruster_d": np.array([[0, 0, 1]] * 4 + [[_S, -_S, 0], [_S, _S, 0], [_S, -_S, 0], [_S, _S, 0]]),
    },
)  # fmt: skip

_SV_LIMITS: Final = (20.0, 2.0)
SURFACE: Final = AgentType(
    "SurfaceVessel", "SurfaceVessel",
    {
        "type": "surface_vessel",
        # heave: no leap when it comes up from below, as in HoloOcean
        "terms": {"linear_damping": {"diagonal": [60, 120, 5000, 700, 2600, 600]}},
        "actuators": {f"{s}_thruster": {"low_n": -1500, "high_n": 1500} for s in ("left", "right")},
        "modes": {
            "ho_acceleration": world_acceleration_mode(_SV_LIMITS),
            "ho_place": {
                "type": "place", "pull_n_m": 100, "brake_kg_s": 50, "pull_limit_n": 1000, "turn_n_m": 860,
                "turn_damping": 400, "turn_limit_n_m": 1000,
            },
        },
    },
    (
        thrusters(2, 1500.0),
        Scheme("[des_x, des_y]", 2, "ho_place", legacy="engine_place"),
        acceleration(_SV_LIMITS),
    ),
    (0, 2, 1),
    sockets_of(Payload=(0, 0, 0, DOWN), Platform=(55, 0, 130), Viewport=(-500, 0, 400)),
    ((0.94, 0.0, 1.26),),
    400.0,
    engine_modes(
        {"engine_thrusters": "thrusters", "engine_place": "place"}, mass_kg=200, volume_m3=6 * 200 / 997,
        inertia_kg_m2=(110, 420, 1435), inertia_products_kg_m2=(0, 6.8, 0),
        center_of_buoyancy_m=(0, 0, -0.10), drag_area_m2=0.8, damping_1_s=3.0,
        turn_damping_1_s=0.75, half_height_m=0.25,
        thrusters=[{"position_m": (-2.5, y, 0), "direction": (1.0, 0.0, 0.0), "limit_n": 1500.0} for y in (-1.0, 1.0)],
    ),
    {
        "mass": 200, "water_density": 997, "volume": 6 * 200 / 997, "cob": np.array([0, 0, 0.1]),
        "I": np.diag([2, 2, 1]), "thruster_p": np.array([[-2.5, -1, 0], [-2.5, 1, 0]]),
    },
)  # fmt: skip

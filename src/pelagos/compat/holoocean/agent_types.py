"""HoloOcean's agents as data: limits, sockets, and the native vehicle and modes that stand for their control schemes.

Inertias of the force model are fitted to the angular accelerations that HoloOcean's own tests expect; its own follow
from meshes that are not published.

Facts: HoloOcean 2.3 and its documentation (BYU FRoSt Lab, MIT licence); metres, forward-left-up from the agent's
origin.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.ground_agents import (
    SPHERE_LIMITS,
    SPHERE_MOVES,
    TURTLE_LIMITS,
    husky_vehicle,
    husky_wrench,
    righted,
    sphere_moved,
    sphere_vehicle,
    turtle_vehicle,
    turtle_wrench,
)

Array = NDArray[np.float64]
FLIPPED: Final = (180.0, 0.0, 0.0)
"""A socket whose frame is turned by half a turn about x: y right, z down."""
DOWN: Final = (0.0, 90.0, 0.0)
"""A socket whose x points down and z forward."""
Socket = tuple[tuple[float, float, float], tuple[float, float, float]]


@dataclass(frozen=True)
class Scheme:
    """A control scheme.

    Attributes:
        description: what HoloOcean calls it.
        size: numbers of an action.
        low, high: limits of an action, which are enforced; None: none.
        mode: native control mode.
        command: action -> the native command.
        legacy: native mode under `legacy_dynamics`; None: the same.
        discrete: how many actions there are, of a scheme that takes a number of one.
    """

    description: str
    size: int
    mode: str
    low: Any = None
    high: Any = None
    command: Callable[[Array], Array] = field(default=lambda a: a)
    legacy: str | None = None
    discrete: int = 0


@dataclass(frozen=True)
class AgentType:
    """One of HoloOcean's agents.

    Attributes:
        name: its type string.
        engine: what the engine calls it.
        vehicle: native vehicle, with changes.
        schemes: by number.
        listed: order of the schemes in `control_schemes`, where that differs.
        sockets: place and turn by name.
        lamps: places of the lamps flashlight1 and so on.
        accel_limit: of AbuseSensor [m/s^2].
        legacy: native modes of HoloOcean's own force model.
        constants: class attributes that scripts read.
        steps: (world, state, scheme, action) -> arguments of `Simulation.set_state` by which an action moves it in a
            tick; empty for nothing.
    """

    name: str
    engine: str
    vehicle: Mapping[str, Any]
    schemes: Sequence[Scheme]
    listed: Sequence[int] = ()
    sockets: Mapping[str, Socket] = field(default_factory=dict)
    lamps: Sequence[tuple[float, float, float]] = ()
    accel_limit: float = -1.0
    legacy: Mapping[str, Any] = field(default_factory=dict)
    constants: Mapping[str, Any] = field(default_factory=dict)
    steps: Callable[[Any, Any, int, Array], dict[str, Any]] | None = None


def _sockets(**centimetres: Any) -> dict[str, Socket]:
    """Sockets from centimetres, with their turn behind where there is one."""
    found: dict[str, Socket] = {}
    for name, given in centimetres.items():
        place, turn = (given[:3], given[3]) if len(given) == 4 else (given, (0.0, 0.0, 0.0))
        found[name] = (tuple(c / 100 for c in place), turn)
    return found


def _degrees_last(action: Array) -> Array:
    """A pose whose three angles are in degrees."""
    return np.concatenate([action[:3], np.radians(action[3:6])])


def _reordered(order: Sequence[int]) -> Callable[[Array], Array]:
    index = list(order)
    return lambda a: a[index]


def _accel(limits: tuple[float, float] | None) -> Scheme:
    low = None if limits is None else -np.repeat(limits, 3)
    return Scheme(
        "[lin_accel_x, lin_accel_y, lin_accel_z, ang_accel_x, ang_accel_y, ang_accel_x]", 6, "ho_acceleration",
        low, None if low is None else -low,
    )  # fmt: skip


_TURNS: Final = (180.0, 90.0, 180.0)
_POSE: Final = Scheme(
    "[des_x, des_y, des_z, des_roll, des_pitch, des_yaw]", 6, "ho_pose",
    -np.array([np.nan, np.nan, np.nan, *_TURNS]), np.array([np.nan, np.nan, np.nan, *_TURNS]), _degrees_last,
    "engine_pose",
)  # fmt: skip


def _thrusters(count: int, limit: float, mode: str = "actuators", **more: Any) -> Scheme:
    full = np.full(count, limit)
    return Scheme(
        "[Control over each thruster, in newtons]", count, mode, -full, full, legacy="engine_thrusters", **more
    )


def _world_acceleration(limits: tuple[float, float] | None) -> dict[str, Any]:
    made: dict[str, Any] = {"type": "world_acceleration"}
    if limits is not None:
        made |= {"limit_m_s2": limits[0], "turn_limit_rad_s2": limits[1]}
    return made


def _engine(commands: Mapping[str, str], **body: Any) -> dict[str, Any]:
    """Native modes of the force model, by the set-points of each."""
    return {
        name: {"type": "engine_forces", "command": kind, **body} for name, kind in commands.items()
    }  # fmt: skip


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


_HOVERING_SOCKETS: Final = _sockets(
    COM=(7, 0, 0), SonarSocket=(42, 22, -5), DVLSocket=(-28, 0.5, -23.5), IMUSocket=(-9.7, 7, 6, FLIPPED),
    DepthSocket=(-14, 2, -15), CameraRightSocket=(32, -11, 15.5), CameraLeftSocket=(32, 11.5, 15.5),
    Origin=(0, 0, 0), Viewport=(-250, 0, 217),
)  # fmt: skip
_HOVER_LIMIT: Final = 10 * 31.02 / 4
_HOVER_ACCEL: Final = (10.0, 2.0)
_HOVER_POSE: Final = {
    "type": "pose", "frequency_rad_s": 2.0, "turn_frequency_rad_s": 2.5, "ratio": 1.0, "integral": 0.1, "reach_m": 1.2,
}  # fmt: skip
_HOVER_MODES: Final = {"ho_acceleration": _world_acceleration(_HOVER_ACCEL), "ho_pose": _HOVER_POSE}
_COMMANDS: Final = {"engine_thrusters": "thrusters", "engine_pose": "pose"}


def _hovering(name: str, engine: str, *, mass: float, limit: float, **more: Any) -> AgentType:
    changes: dict[str, Any] = {"type": "hovering_auv", "modes": dict(_HOVER_MODES)}
    if limit != _HOVER_LIMIT or mass != 31.02:
        sides = ("front_starboard", "front_port", "back_port", "back_starboard")
        changes["actuators"] = {
            f"{k}_{s}": {"low_n": -limit, "high_n": limit} for k in ("vertical", "angled") for s in sides
        }
        changes["mass"] = {"mass_kg": mass, "volume_m3": mass / 997}
    thrusters = _eight((0.2481, 0.2214, -0.0379), (0.1402, 0.1823, 0.0), limit)
    return AgentType(
        name, engine, changes, (_thrusters(8, limit), _POSE, _accel(_HOVER_ACCEL)), (0, 2, 1),
        accel_limit=400.0,
        legacy=_engine(
            _COMMANDS, mass_kg=mass, volume_m3=mass / 997, inertia_kg_m2=(1.3845, 1.9346, 2.5572),
            center_of_buoyancy_m=(0, 0, -0.05), drag_area_m2=0.4, damping_1_s=1.0, turn_damping_1_s=0.75,
            half_height_m=0.2, thrusters=thrusters,
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
_BLUEROV2: Final = AgentType(
    "BlueROV2", "BlueROV2",
    {"type": "bluerov2_heavy", "battery": None, "actuators": _BLUE_ACTUATORS, "modes": dict(_HOVER_MODES)},
    (_thrusters(8, _BLUE_LIMIT, command=_reordered((4, 5, 7, 6, 0, 1, 3, 2))), _POSE, _accel(_HOVER_ACCEL)),
    (0, 2, 1),
    _sockets(
        COM=(0, 0, 0), SonarSocket=(15, 0, 14), DVLSocket=(0, 10, -10), IMUSocket=(11, 0, 6.5, FLIPPED),
        DepthSocket=(-17, 0, 6), CameraSocket=(21, 0, 6), Origin=(0, 0, 0), Viewport=(-200, 0, 115),
    ),
    ((0.22, 0.19, 0.11), (0.22, -0.19, 0.11), (0.22, 0.19, -0.06), (0.22, -0.19, -0.06)),
    400.0,
    _engine(
        _COMMANDS, mass_kg=11.5, volume_m3=11.5 / 997, inertia_kg_m2=(0.2966, 0.2356, 0.4245),
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

_FINS: Final = ("starboard_plane", "top_rudder", "port_plane", "bottom_rudder")
_FIN_SIGNS: Final = {"starboard_plane": 1.0, "top_rudder": 1.0, "port_plane": -1.0, "bottom_rudder": -1.0}
_FIN_ORDER: Final = ("top_rudder", "bottom_rudder", "starboard_plane", "port_plane")


def _fins_and_thrust(action: Array) -> Array:
    """Right, top, left, bottom fin [deg] and thrust [N] -> the native fins [rad], and the thrust."""
    given = dict(zip(_FINS, action, strict=False))
    return np.array([*(_FIN_SIGNS[n] * math.radians(given[n]) for n in _FIN_ORDER), action[4]])


def _torpedo(
    name: str,
    engine: str,
    native: str,
    *,
    drag_area: float,
    inertia: tuple[float, float, float],
    limits: tuple[float, float] | None,
    **more: Any,
) -> AgentType:
    full = np.array([45.0, 45.0, 45.0, 45.0, 100.0])
    thrust = {
        "type": "force_thruster", "position_m": [-0.8, 0, 0], "direction": [1, 0, 0], "low_n": -100, "high_n": 100,
        "time_constant_s": 0.1,
    }  # fmt: skip
    fins = {fin: {"limit_deg": 45} for fin in _FIN_ORDER}
    places = ((0.0, -1), (1, 0.0), (0.0, 1), (-1, 0.0))  # right, top, left, bottom: (z, y) FLU by 0.0707
    lifts = ((0.0, 0.0, -1.0), (0.0, 1.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))  # FRD
    made = [
        {"position_m": (-1.05, -0.0707 * y, -0.0707 * z), "lift": lift}
        for (z, y), lift in zip(places, lifts, strict=True)
    ]
    unused = ("depth_heading_speed", "depth_heading", "altitude_heading_speed", "line_of_sight")
    modes: dict[str, Any] = {"ho_acceleration": _world_acceleration(limits), **dict.fromkeys(unused)}
    return AgentType(
        name, engine,
        {
            "type": native, "actuators": {**fins, "propeller": thrust}, "modes": modes, "default_mode": "actuators",
            "as_published": {},
        },
        (
            Scheme(
                "[right_fin, top_fin, left_fin, bottom_fin, thrust]", 5, "actuators", -full, full, _fins_and_thrust,
                "engine_thrusters",
            ),
            _accel(limits),
        ),
        accel_limit=200.0,
        legacy=_engine(
            {"engine_thrusters": "thrusters"}, mass_kg=36, volume_m3=36 / 997, inertia_kg_m2=inertia,
            center_of_buoyancy_m=(0, 0, -0.01), drag_area_m2=drag_area, damping_1_s=0.75, turn_damping_1_s=0.5,
            half_height_m=0.1, fins=made,
            thrusters=[{"position_m": (-1.2, 0, 0), "direction": (1.0, 0.0, 0.0), "limit_n": 100.0}],
        ),
        constants={
            "mass": 36, "water_density": 997, "volume": 36 / 997, "cob": np.array([0, 0, 0.07]),
            "I": np.diag([2, 1.2, 1.2]), "thruster_p": np.array([-1.2, 0.0, 0.0]),
            "fin_p": np.array([[-1.05, -0.0707, 0], [-1.05, 0, 0.0707], [-1.05, 0.0707, 0], [-1.05, 0, -0.0707]]),
        },
        **more,
    )  # fmt: skip


_SV_LIMITS: Final = (20.0, 2.0)
_SURFACE: Final = AgentType(
    "SurfaceVessel", "SurfaceVessel",
    {
        "type": "surface_vessel",
        # heave: no leap when it comes up from below, as in HoloOcean
        "terms": {"linear_damping": {"diagonal": [60, 120, 5000, 700, 2600, 600]}},
        "actuators": {f"{s}_thruster": {"low_n": -1500, "high_n": 1500} for s in ("left", "right")},
        "modes": {
            "ho_acceleration": _world_acceleration(_SV_LIMITS),
            "ho_place": {
                "type": "place", "pull_n_m": 100, "brake_kg_s": 50, "pull_limit_n": 1000, "turn_n_m": 860,
                "turn_damping": 400, "turn_limit_n_m": 1000,
            },
        },
    },
    (
        _thrusters(2, 1500.0),
        Scheme("[des_x, des_y]", 2, "ho_place", legacy="engine_place"),
        _accel(_SV_LIMITS),
    ),
    (0, 2, 1),
    _sockets(Payload=(0, 0, 0, DOWN), Platform=(55, 0, 130), Viewport=(-500, 0, 400)),
    ((0.94, 0.0, 1.26),),
    400.0,
    _engine(
        {"engine_thrusters": "thrusters", "engine_place": "place"}, mass_kg=200, volume_m3=6 * 200 / 997,
        inertia_kg_m2=(110, 420, 1435), center_of_buoyancy_m=(0, 0, -0.10), drag_area_m2=0.8, damping_1_s=3.0,
        turn_damping_1_s=0.75, half_height_m=0.25,
        thrusters=[{"position_m": (-2.5, y, 0), "direction": (1.0, 0.0, 0.0), "limit_n": 1500.0} for y in (-1.0, 1.0)],
    ),
    {
        "mass": 200, "water_density": 997, "volume": 6 * 200 / 997, "cob": np.array([0, 0, 0.1]),
        "I": np.diag([2, 2, 1]), "thruster_p": np.array([[-2.5, -1, 0], [-2.5, 1, 0]]),
    },
)  # fmt: skip

_UAV_HIGH: Final = np.array([5.087, 6.508, 0.8, 5984.4])


def _uav_wrench(action: Array) -> Array:
    """Pitch, roll and yaw torques [N m] and thrust [N] -> a wrench FRD."""
    return np.array([0.0, 0.0, -action[3], action[1], -action[0], -action[2]])


_UAV: Final = AgentType(
    "UavAgent", "UAV",
    {
        "type": "quadrotor", "terms": {"drag": {"diagonal": [2.0, 2.0, 2.0, 0.01, 0.01, 0.01]}},
    },
    (
        Scheme("[pitch_torque, roll_torque, yaw_torque, thrust]", 4, "wrench", -_UAV_HIGH, _UAV_HIGH, _uav_wrench),
    ),
    sockets=_sockets(CameraSocket=(0, 0, 0), Viewport=(-130, 0, 120)),
    accel_limit=100.0,  # assumed: a fall from 10 m is beyond it
)  # fmt: skip


def _sphere_steps(world: Any, state: Any, scheme: int, action: Array) -> dict[str, Any]:
    forward, turn = SPHERE_MOVES[int(action[0])] if scheme == 0 else action
    return sphere_moved(world, state.position[0], state.attitude[0], forward_m=float(forward), turn_deg=float(turn))


def _husky_steps(world: Any, state: Any, scheme: int, action: Array) -> dict[str, Any]:
    return righted(state.position[0], state.attitude[0]) if action[2] > 0.5 else {}


_SPHERE: Final = AgentType(
    "SphereAgent", "SphereRobot", sphere_vehicle(),
    (
        Scheme("0: forward, 1: back, 2: left, 3: right", 1, "wrench", np.zeros(1), np.full(1, 3.0),
               lambda a: np.zeros(6), discrete=4),
        Scheme("[forward_movement, rotation]", 2, "wrench", -SPHERE_LIMITS, SPHERE_LIMITS, lambda a: np.zeros(6)),
    ),
    sockets=_sockets(CameraSocket=(0, 0, 0), Viewport=(-130, 0, 120)), steps=_sphere_steps,
)  # fmt: skip

_TURTLE: Final = AgentType(
    "TurtleAgent", "TurtleAgent", turtle_vehicle(),
    (Scheme("[forward_force, rot_force]", 2, "wrench", -TURTLE_LIMITS, TURTLE_LIMITS, turtle_wrench),),
    sockets=_sockets(CameraSocket=(30, 0, 5), Viewport=(-130, 0, 120)), accel_limit=250.0,
)  # fmt: skip

_HUSKY: Final = AgentType(
    "HuskyVehicle", "HuskyVehicle", husky_vehicle(),
    (Scheme("[left_force, right_force, flip_reset]", 3, "wrench", command=husky_wrench),),
    sockets=_sockets(CameraSocket=(-37, 0, 122.5), Viewport=(-147, 0, 71)), steps=_husky_steps,
)  # fmt: skip

AGENT_TYPES: Final[dict[str, AgentType]] = {
    a.name: a
    for a in (
        _hovering("HoveringAUV", "HoveringAUV", mass=31.02, limit=_HOVER_LIMIT, sockets=_HOVERING_SOCKETS, lamps=(
            (0.31, -0.25, 0.14), (0.31, 0.25, 0.14), (0.31, -0.25, -0.15), (0.31, 0.25, -0.15))),
        _hovering("FixedWing", "FixedWing", mass=31.02, limit=_HOVER_LIMIT),
        _hovering("ScubaDiver", "ScubaDiver", mass=100.0, limit=250.0),
        _BLUEROV2,
        _torpedo(
            "TorpedoAUV", "TorpedoAUV", "torpedo", drag_area=0.025, inertia=(25.0, 25.0, 11.3), limits=None,
            lamps=((1.05, 0.0, 0.0),),
            sockets=_sockets(
                SonarSocket=(0, 0, -7, DOWN), DVLSocket=(-30, 0, -7), IMUSocket=(86, -3, -3), DepthSocket=(95, 3, 3),
                CameraSocket=(30, 0, -7, DOWN), Viewport=(-400, 0, 300),
            ),
        ),
        _torpedo(
            "CougUV", "CougUV", "couguv", drag_area=0.15, inertia=(7.0, 7.1, 3.05), limits=_HOVER_ACCEL,
            lamps=((0.62, -0.002, 0.085),),
            sockets=_sockets(
                COM=(0, 0, 0), DVLSocket=(50.4, 0, -5.3, FLIPPED), IMUSocket=(50.4, 0, -5.3, FLIPPED),
                DepthSocket=(16.2, 0, 0), AcousticModemSocket=(37.85, 0, -9.85), CameraSocket=(10, 0, 0),
                Viewport=(-216, 0, 138),
            ),
        ),
        _SURFACE,
        _UAV,
        _SPHERE,
        _TURTLE,
        _HUSKY,
    )
}  # fmt: skip

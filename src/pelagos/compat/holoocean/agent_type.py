"""Description of one of HoloOcean's agents: limits, sockets, and the native modes that stand for control schemes.

Facts: HoloOcean 2.3 and its documentation (BYU FRoSt Lab, MIT licence); metres, forward-left-up from the agent's
origin.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

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
        low, high: limits of an action; None: none.
        enforced: actions are clipped to them.
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
    enforced: bool = True

    def within(self, action: Array) -> Array:
        """An action, clipped to the limits where they are enforced."""
        if self.low is None or not self.enforced:
            return action
        return np.asarray(np.fmin(np.fmax(action, self.low), self.high))


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


def sockets_of(**centimetres: Any) -> dict[str, Socket]:
    """Sockets from centimetres, with their turn behind where there is one."""
    found: dict[str, Socket] = {}
    for name, given in centimetres.items():
        place, turn = (given[:3], given[3]) if len(given) == 4 else (given, (0.0, 0.0, 0.0))
        found[name] = (tuple(c / 100 for c in place), turn)
    return found


def _degrees_last(action: Array) -> Array:
    """A pose whose three angles are in degrees."""
    return np.concatenate([action[:3], np.radians(action[3:6])])


def reordered(order: Sequence[int]) -> Callable[[Array], Array]:
    """Actions in another order."""
    index = list(order)
    return lambda a: a[index]


def acceleration(limits: tuple[float, float] | None) -> Scheme:
    """The scheme of accelerations in the world, with limits of its linear and angular axes."""
    low = None if limits is None else -np.repeat(limits, 3)
    return Scheme(
        "[lin_accel_x, lin_accel_y, lin_accel_z, ang_accel_x, ang_accel_y, ang_accel_x]", 6, "ho_acceleration",
        low, None if low is None else -low,
    )  # fmt: skip


_TURNS: Final = (180.0, 90.0, 180.0)
POSE: Final = Scheme(
    "[des_x, des_y, des_z, des_roll, des_pitch, des_yaw]", 6, "ho_pose",
    -np.array([np.nan, np.nan, np.nan, *_TURNS]), np.array([np.nan, np.nan, np.nan, *_TURNS]), _degrees_last,
    "engine_pose",
)  # fmt: skip


def thrusters(count: int, limit: float, mode: str = "actuators", **more: Any) -> Scheme:
    """The scheme of so many thrusts, up to a limit [N]."""
    full = np.full(count, limit)
    return Scheme(
        "[Control over each thruster, in newtons]", count, mode, -full, full, legacy="engine_thrusters", **more
    )


def world_acceleration_mode(limits: tuple[float, float] | None) -> dict[str, Any]:
    """The native mode of such a scheme."""
    made: dict[str, Any] = {"type": "world_acceleration"}
    if limits is not None:
        made |= {"limit_m_s2": limits[0], "turn_limit_rad_s2": limits[1]}
    return made


def engine_modes(commands: Mapping[str, str], *, thrusters: Sequence[Any], **body: Any) -> dict[str, Any]:
    """Native modes of the force model, by the set-points of each; a pose is held without thrusters."""
    pushed = {"thrusters": thrusters}
    return {
        name: {"type": "engine_forces", "command": kind, **body, **({} if kind == "pose" else pushed)}
        for name, kind in commands.items()
    }

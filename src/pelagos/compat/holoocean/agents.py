"""HoloOcean's agents: what a script holds in its hands."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.compat.holoocean.agent_type import AgentType, Scheme
from pelagos.compat.holoocean.agent_types import AGENT_TYPES
from pelagos.compat.holoocean.exceptions import HoloOceanException, three
from pelagos.compat.holoocean.frames import quaternion_of
from pelagos.compat.holoocean.names import identifier
from pelagos.compat.holoocean.spaces import ActionSpace, ContinuousActionSpace, DiscreteActionSpace
from pelagos.errors import did_you_mean
from pelagos.math.so3 import matrix_np

if TYPE_CHECKING:
    from pelagos.compat.holoocean.environments import HoloOceanEnvironment
    from pelagos.compat.holoocean.sensor import HoloOceanSensor
    from pelagos.compat.holoocean.sensors import SensorDefinition

_GONE: Final = ("AndroidAgent", "HandAgent")
_ENGINE_NAMES: Final = {"Sphere": "SphereAgent", "SphereRobot": "SphereAgent", "UAV": "UavAgent"}


class ControlSchemes:
    """Numbers of the control schemes, as scenarios write them."""

    AUV_THRUSTERS = 0
    AUV_CONTROL = 1
    AUV_FORCES = 2
    TAUV_FINS = 0
    TAUV_FORCES = 1
    SV_THRUSTERS = 0
    SV_CONTROL = 1
    SV_FORCES = 2
    UAV_TORQUES = 0
    UAV_ROLL_PITCH_YAW_RATE_ALT = 1
    SPHERE_DISCRETE = 0
    SPHERE_CONTINUOUS = 1
    NAV_TARGET_LOCATION = 0
    TURTLE_DIRECT_TORQUES = 0
    ANDROID_DIRECT_TORQUES = 0
    ANDROID_MAX_SCALED_TORQUES = 1
    HAND_AGENT_MAX_TORQUES = 0
    HAND_AGENT_MAX_SCALED_TORQUES = 1
    HAND_AGENT_MAX_TORQUES_FLOAT = 2


def kind_of(agent_type: Any) -> AgentType:
    """The agent type of a name or a class.

    Raises:
        KeyError: no such type, as HoloOcean; the message names the nearest.
    """
    name = agent_type if isinstance(agent_type, str) else getattr(agent_type, "__name__", str(agent_type))
    if name in AGENT_TYPES:
        return AGENT_TYPES[name]
    if name in _GONE:
        raise KeyError(f"{name} walks or grasps, which Pelagos does not simulate")
    hint = f"; did you mean '{_ENGINE_NAMES[name]}'?" if name in _ENGINE_NAMES else did_you_mean(name, AGENT_TYPES)
    raise KeyError(f"there is no agent type {name!r}{hint}")


class AgentDefinition:
    """Definition of an agent before it is built."""

    _type_keys: ClassVar[dict[str, type[HoloOceanAgent]]] = {}

    def __init__(
        self,
        agent_name: str,
        agent_type: Any,
        sensors: Sequence[SensorDefinition] | None = None,
        starting_loc: Sequence[float] = (0, 0, 0),
        starting_rot: Sequence[float] = (0, 0, 0),
        existing: bool = False,
        is_main_agent: bool = False,
    ) -> None:
        self.kind = kind_of(agent_type)
        self.name, self.type = agent_name, AgentDefinition._type_keys[self.kind.name]
        self.sensors = list(sensors or [])
        self.starting_loc, self.starting_rot = list(starting_loc), list(starting_rot)
        self.existing, self.is_main_agent = existing, is_main_agent
        self.legacy = False
        self.scheme: int | None = None


class HoloOceanAgent:
    """An agent in an environment.

    Attributes:
        name: its own.
        native_name: what it is called in `env.pelagos`.
        kind: its type.
        sensors: by name.
        agent_state_dict: values of its sensors at the last tick.
        scheme: number of the control scheme.
    """

    agent_type: ClassVar[str] = ""

    def __init__(self, env: HoloOceanEnvironment, definition: AgentDefinition) -> None:
        self.env, self.definition = env, definition
        self.name, self.kind = definition.name, definition.kind
        self.native_name = identifier(self.name)
        self.sensors: dict[str, HoloOceanSensor] = {}
        self.agent_state_dict: dict[str, Any] = {}
        self.scheme = 0
        self.action = np.zeros(max(s.size for s in self.kind.schemes))
        self.current: tuple[float, float, float] | None = None
        self.place: dict[str, Any] = {}
        self.changed = True
        self.told = False

    # what a script tells it

    def act(self, action: Any) -> None:
        """Hold an action until there is another.

        Raises:
            HoloOceanException: more numbers than the largest scheme takes.
        """
        given = np.atleast_1d(np.asarray(action, dtype=np.float64))
        if given.shape == self.action.shape and given.tobytes() == self.action.tobytes():
            self.told = True
            return
        if given.ndim != 1 or len(given) > len(self.action):
            raise HoloOceanException(
                f"{self.name}: an action of {self.kind.name} has at most {len(self.action)} numbers; given shape "
                f"{given.shape}"
            )
        if not np.isfinite(given).all():
            raise HoloOceanException(f"{self.name}: an action must be finite; given {given.tolist()}")
        self.told = True
        self.action[:] = 0.0
        self.action[: len(given)] = given
        self.changed = True

    def clear_action(self) -> None:
        """All zeros."""
        self.act(np.zeros(len(self.action)))
        self.told = False

    def set_control_scheme(self, index: int) -> None:
        """Another scheme, by its number (modulo their count)."""
        self.scheme = int(index) % len(self.kind.schemes)
        self.changed = True

    def teleport(self, location: Any = None, rotation: Any = None) -> None:
        """Be elsewhere from the next tick on; velocity in the world is kept. None keeps."""
        if location is not None:
            self.place["location"] = np.array(three(f"{self.name}: location", location))
        if rotation is not None:
            self.place["rotation"] = np.array(three(f"{self.name}: rotation", rotation))

    def set_physics_state(self, location: Any, rotation: Any, velocity: Any, angular_velocity: Any) -> None:
        """Be elsewhere and move otherwise: velocity in the world [m/s], angular velocity in body axes [deg/s]."""
        self.teleport(location, rotation)
        self.place["velocity"] = np.array(three(f"{self.name}: velocity", velocity))
        self.place["angular_velocity"] = np.array(three(f"{self.name}: angular_velocity", angular_velocity))

    def add_sensors(self, sensor_defs: Any) -> None:
        """Carry further sensors from the next tick on."""
        self.env._add_sensors(self, sensor_defs if isinstance(sensor_defs, list | tuple) else [sensor_defs])

    def remove_sensors(self, sensor_defs: Any) -> None:
        """Carry them no more."""
        self.env._remove_sensors(self, sensor_defs if isinstance(sensor_defs, list | tuple) else [sensor_defs])

    def has_camera(self) -> bool:
        """Whether it carries a camera. (HoloOcean always answers False.)"""
        return any("Camera" in s.sensor_type or s.sensor_type == "ViewportCapture" for s in self.sensors.values())

    def get_joint_constraints(self, joint_name: str) -> None:
        """None: no agent of Pelagos has HoloOcean's joints."""
        return None

    # what it is

    @property
    def action_space(self) -> ActionSpace:
        """Of the present scheme."""
        return _space(self.kind.schemes[self.scheme])

    @property
    def control_schemes(self) -> list[tuple[str, ActionSpace]]:
        """Description and space of each, in HoloOcean's order, in which some agents' second and third are swapped."""
        schemes = self.kind.schemes
        order = self.kind.listed or range(len(schemes))
        return [(schemes[i].description, _space(schemes[i])) for i in order]

    # how it goes over to the native simulation

    @property
    def mode(self) -> str:
        """Native control mode of the present scheme."""
        scheme = self.kind.schemes[self.scheme]
        return scheme.legacy if self.legacy and scheme.legacy else scheme.mode

    @property
    def legacy(self) -> bool:
        """Whether HoloOcean's own force model moves it."""
        return self.definition.legacy and bool(self.kind.legacy)

    def command(self) -> NDArray[np.float64]:
        """The action as the native command, within the limits that HoloOcean enforces."""
        scheme = self.kind.schemes[self.scheme]
        action = scheme.within(self.action[: scheme.size])
        if not (self.legacy and scheme.legacy):
            return scheme.command(action)
        return np.concatenate([action, self.current or (0.0, 0.0, 0.0)])

    def step_of_tick(self) -> dict[str, Any]:
        """Arguments of `Simulation.set_state` by which its action moves it in a tick; empty for nothing."""
        if self.kind.steps is None or not self.told:
            return {}
        scheme, sim = self.kind.schemes[self.scheme], self.env.pelagos
        action = scheme.within(self.action[: scheme.size])
        return self.kind.steps(sim.world, sim.state[self.native_name], self.scheme, action)

    def native_place(self) -> dict[str, Any]:
        """Arguments of `Simulation.set_state` for what was asked since the last tick."""
        asked, self.place = self.place, {}
        state = self.env.pelagos.state[self.native_name]
        turned = state.attitude[0]
        if "rotation" in asked:
            turned = quaternion_of(asked["rotation"])
        elif "location" in asked and "velocity" not in asked:
            return {"position": asked["location"]}
        before, after = matrix_np(state.attitude[0]), matrix_np(turned)
        made: dict[str, Any] = {"attitude": turned}
        if "location" in asked:
            made["position"] = asked["location"]
        velocity = asked.get("velocity", before @ state.velocity[0])
        made["velocity"] = after.T @ velocity
        made["angular_velocity"] = after.T @ (before @ state.angular_velocity[0])
        if "angular_velocity" in asked:
            made["angular_velocity"] = np.radians(asked["angular_velocity"])
        return made

    def __repr__(self) -> str:
        return f"<{self.kind.name} {self.name!r}>"


def _space(scheme: Scheme) -> ActionSpace:
    if scheme.discrete:
        return DiscreteActionSpace([1], 0, scheme.discrete)
    low = None if scheme.low is None else np.asarray(scheme.low, dtype=float).tolist()
    high = None if scheme.high is None else np.asarray(scheme.high, dtype=float).tolist()
    return ContinuousActionSpace([scheme.size], low=low, high=high)


def _make_classes() -> dict[str, type[HoloOceanAgent]]:
    """A class for every type, with the constants that scripts read from it."""
    made = {}
    for name, kind in AGENT_TYPES.items():
        body = {"__doc__": f"HoloOcean's {name}.", "agent_type": kind.engine, "__module__": __name__, **kind.constants}
        made[name] = type(name, (HoloOceanAgent,), body)
    return made


def _refused(name: str) -> type[HoloOceanAgent]:
    """A class that scripts may import, of an agent that `kind_of` refuses."""
    return type(name, (HoloOceanAgent,), {"__doc__": f"HoloOcean's {name}: refused.", "__module__": __name__})


AgentDefinition._type_keys = _make_classes()
globals().update(AgentDefinition._type_keys)
globals().update({name: _refused(name) for name in _GONE})
HolodeckAgent = HoloOceanAgent


class AgentFactory:
    """Builds agents from their definitions."""

    @staticmethod
    def build_agent(client: Any, agent_def: AgentDefinition) -> HoloOceanAgent:
        """The agent."""
        return agent_def.type(client, agent_def)

"""HoloOcean's `FossenInterface`: accelerations of Fossen's torpedo and Otter for agents in an acceleration scheme.

The vehicles are Pelagos's own (`torpedo`, `otter`); what this adds is HoloOcean's names and units.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from typing import Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.compat.holoocean.advice import Advice
from pelagos.compat.holoocean.torpedo_agents import FIN_AT
from pelagos.errors import did_you_mean
from pelagos.math.frames import flip_yz_np
from pelagos.math.so3 import matrix_np
from pelagos.vehicles.state import VehicleState
from pelagos.vehicles.vehicle import Vehicle

Array = NDArray[np.float64]
MODES: Final = (
    "manualControl", "depthHeadingAutopilot", "headingAutopilot", "depthAutopilot", "DPcontrol", "stepInput",
)  # fmt: skip
"""In HoloOcean's words; what a vehicle does not have is refused."""
_DYNAMICS: Final = {
    "rho": ("density_kg_m3",), "length": ("length_m",), "diam": ("diameter_m",),
    "r_bg": ("mass", "center_of_gravity_m"), "r_bb": ("mass", "center_of_buoyancy_m"),
    "area_fraction": ("terms", "lift_drag", "area_fraction"), "Cd": ("terms", "lift_drag", "frontal_drag"),
    "e": ("terms", "lift_drag", "oswald"), "T_surge": ("terms", "damping", "surge_s"),
    "T_sway": ("terms", "damping", "sway_s"), "T_yaw": ("terms", "damping", "yaw_s"),
    "zeta_roll": ("terms", "damping", "roll_ratio"), "zeta_pitch": ("terms", "damping", "pitch_ratio"),
    "r44": ("added_mass", "roll_factor"), "K_nomoto": ("modes", "depth_heading", "heading", "nomoto_gain"),
}  # fmt: skip
_PROPELLER: Final = {
    "nMax": "limit_rpm", "T_n": "time_constant_s", "D_prop": "diameter_m", "t_prop": "thrust_deduction", "KT_0": "KT_0",
    "KQ_0": "KQ_0", "KT_max": "KT_limit", "KQ_max": "KQ_limit", "w": "wake_fraction", "Ja_max": "J_limit",
}  # fmt: skip
_FIN: Final = {
    "fin_area": "area_m2", "CL_delta": "lift_coefficient", "deltaMax_fin_deg": "limit_deg",
    "T_delta": "time_constant_s", "fin_center": "radius_m",
}  # fmt: skip
_DEPTH: Final = {
    "wn_d_z": "reference_rad_s", "Kp_z": "kp_depth", "T_z": "integral_s", "Kp_theta": "kp_pitch",
    "Kd_theta": "kd_pitch", "Ki_theta": "ki_pitch", "K_w": "k_heave", "theta_max_deg": "pitch_limit_deg",
    "outer_loop_threshold": "dive_beyond_m",
}  # fmt: skip
_HEADING: Final = {
    "wn_d": "reference_rad_s", "zeta_d": "reference_damping", "lam": "bandwidth", "phi_b": "boundary",
    "K_d": "k_damping", "K_sigma": "k_switch",
}  # fmt: skip
_IDLE: Final = (
    "mass", "x_fin", "fin_speed_max", "fin_count", "fin_offset_deg", "wn_d_theta",
    "surge_threshold",
)  # fmt: skip
_FINS: Final = tuple(FIN_AT[place] for place in ("right", "bottom", "left", "top"))
_PER_TORQUE: Final = 0.1  # of a fin's angle, by HoloOcean's gains of pitch, which ask for a torque
_DEFAULTS: Final[dict[str, Any]] = {
    "actuator": {"fin_area": 0.00697, "CL_delta": 0.5, "deltaMax_fin_deg": 15, "T_delta": 0.1, "T_n": 1.0},
    "autopilot": {
        "depth": {
            "wn_d_z": 0.12, "Kp_z": 0.153, "T_z": 100, "Kp_theta": 39.78, "Kd_theta": 17.1, "Ki_theta": 0.5, "K_w": 0,
            "theta_max_deg": 15, "outer_loop_threshold": 2.91,
        },
        "heading": {"wn_d": 0.4, "zeta_d": 1, "r_max": 0.87, "lam": 0.1, "phi_b": 0.1, "K_d": 0.5, "K_sigma": 0.05},
    },
}  # fmt: skip
"""HoloOcean's own numbers, where the native vehicle has others."""


class _Fossen:
    """One vehicle: its equations, goals, and what it remembers between two steps."""

    def __init__(self, name: str, agent: Mapping[str, Any], dt: float, advice: Advice) -> None:
        self.name, self.kind, self._dt = name, agent["fossen_model"], dt
        if self.kind not in ("torpedo", "otter"):
            raise KeyError(f"fossen_model is 'torpedo' or 'otter', not {self.kind!r}")
        self.vehicle = Vehicle.from_dict({"type": self.kind, **changes(agent, advice)})
        self.u = np.zeros(self.dim_u)
        self.goals = {"depth": 0.0, "heading": 0.0, "rpm": 0.0}
        self.set_mode(str(agent.get("control_mode", "manualControl")))
        self._state: VehicleState | None = None
        self._step = jit.freeze(self._stepped)

    @property
    def dim_u(self) -> int:
        """Numbers of a manual command."""
        return len(self.vehicle.actuator_names)

    def set_mode(self, mode: str) -> None:
        """Another mode, in HoloOcean's words."""
        known = {"manualControl": "actuators", "stepInput": "actuators"}
        if self.kind == "torpedo":
            known |= dict.fromkeys(("depthHeadingAutopilot", "headingAutopilot", "depthAutopilot"), "depth_heading")
        else:
            known |= {"headingAutopilot": "heading"}
        if mode not in known:
            raise ValueError(f"{self.kind} has no mode {mode!r}{did_you_mean(mode, known)}; it has {', '.join(known)}")
        self.mode, self.native = mode, known[mode]

    @property
    def rpm_limit(self) -> float:
        """Largest rate of the propeller [1/min]."""
        return float(getattr(self.vehicle.config.actuators.get("propeller"), "limit_rpm", math.inf))

    def command(self) -> list[float]:
        """The set-points of the native mode."""
        if self.native == "actuators":
            if self.kind == "otter":
                return [float(v) for v in self.u]
            given = dict(zip(_FINS, self.u, strict=False))
            return [float(given.get(n, self.u[-1])) for n in self.vehicle.actuator_names]
        heading = math.radians(-self.goals["heading"])
        if self.native == "heading":
            return [heading, 120.0]  # the Otter's constant pull [N]
        return [self.goals["depth"], heading, self.goals["rpm"]]

    def accelerate(self, position: Array, q: Array, velocity: Array, turn: Array) -> Array:
        """`(6,)` accelerations in the world of the step from a state in the world NWU; q is (w, x, y, z)."""
        rotation = matrix_np(q)
        parts = {
            "position": position[None], "attitude": q[None],
            "velocity": (rotation.T @ velocity)[None], "angular_velocity": (rotation.T @ turn)[None],
        }  # fmt: skip
        if self._state is None:
            _ = self.vehicle.tables  # made now: a recording must not make them
            self._state = self.vehicle.initial_state(*parts.values())
        before = self._state
        placed = self.vehicle.place(before, **parts)
        placed.mode, placed.controller = before.mode, before.controller  # the autopilot goes on
        command = [dr.opaque(jit.Float64, float(v)) for v in self.command()]
        self._state = self._step(placed, command, dr.opaque(jit.Float64, self._dt))
        new = self._state
        linear = flip_yz_np(np.array(new.acceleration).ravel()) + np.cross(rotation.T @ turn, rotation.T @ velocity)
        angular = flip_yz_np(np.array(new.angular_acceleration).ravel())
        return np.concatenate([rotation @ linear, rotation @ angular])

    def _stepped(self, state: VehicleState, command: list[Any], h: Any) -> VehicleState:
        zero = jit.Array3f64(0.0), jit.Array3f64(0.0)
        return self.vehicle.step(state, command, None, jit.Float64(0.0), zero, h, self.native)


class FossenInterface:
    """Fossen's models for several agents.

    Args:
        vehicle_names: of the agents.
        scenario: of the environment; each agent has `fossen_model`, and a DynamicsSensor of that very name with
            `UseCOM: True` and `UseRPY: False`.
        multi_agent: states are nested, as those of several agents are.

    Raises:
        ValueError: an agent or its sensor is missing, or is another.
        KeyError: an unknown model.
    """

    def __init__(
        self, vehicle_names: Sequence[str] | str, scenario: Mapping[str, Any], multi_agent: bool = False
    ) -> None:
        names = [vehicle_names] if isinstance(vehicle_names, str) else list(vehicle_names)
        self._nested, advice = multi_agent or len(names) > 1, Advice()
        if "ticks_per_sec" not in scenario:
            advice.once("the scenario has no ticks_per_sec; 30 is taken")
        dt = 1.0 / float(scenario.get("ticks_per_sec", 30))
        agents = {agent["agent_name"]: agent for agent in scenario["agents"]}
        self.vehicles: dict[str, _Fossen] = {}
        for name in names:
            if name not in agents:
                raise ValueError(f"the scenario has no agent {name!r}{did_you_mean(name, agents)}")
            _check_sensor(name, agents[name])
            self.vehicles[name] = _Fossen(name, agents[name], dt, advice)

    def update(self, vehicle_name: str, state: Mapping[str, Any]) -> Array:
        """`(6,)` global accelerations [m/s^2], [rad/s^2] to give to the agent for the next tick."""
        seen = state[vehicle_name] if self._nested else state
        dynamics = np.asarray(seen["DynamicsSensor"], dtype=np.float64)
        if dynamics.shape != (19,):
            raise ValueError(f"{vehicle_name}: its DynamicsSensor needs UseRPY: False; its shape is {dynamics.shape}")
        x, y, z, w = -dynamics[15:19]
        return self._of(vehicle_name).accelerate(dynamics[6:9], np.array([w, x, y, z]), dynamics[3:6], dynamics[12:15])

    def _of(self, name: str) -> _Fossen:
        if name not in self.vehicles:
            raise KeyError(f"there is no vehicle {name!r}{did_you_mean(name, self.vehicles)}")
        return self.vehicles[name]

    def set_u_control(self, vehicle_name: str, u_control: Any) -> None:
        """Fins [rad] and propeller [1/min], or the Otter's propellers [rad/s]."""
        vehicle, given = self._of(vehicle_name), np.asarray(u_control, dtype=np.float64).reshape(-1)
        if len(given) != vehicle.dim_u:
            raise ValueError(f"{vehicle_name}: a command has {vehicle.dim_u} numbers, not {len(given)}")
        vehicle.u = given

    def get_u_control(self, vehicle_name: str) -> Array:
        """The manual command."""
        return self._of(vehicle_name).u

    def get_control_mode(self, vehicle_name: str) -> str:
        """The mode, in HoloOcean's words."""
        return self._of(vehicle_name).mode

    def set_control_mode(self, vehicle_name: str, control_mode: str) -> None:
        """Another mode."""
        self._of(vehicle_name).set_mode(control_mode)

    def set_goal(self, vehicle_name: str, depth: Any = None, heading: Any = None, rpm: Any = None) -> None:
        """Several goals at once; what is None stays."""
        for value, setter in ((depth, self.set_depth_goal), (heading, self.set_heading_goal), (rpm, self.set_rpm_goal)):
            if value is not None:
                setter(vehicle_name, value)

    def set_depth_goal(self, vehicle_name: str, depth: float) -> None:
        """Below the surface [m]."""
        if not depth >= 0:
            raise ValueError(f"a depth is from 0 on, positive down; given {depth!r}")
        self._of(vehicle_name).goals["depth"] = float(depth)

    def set_heading_goal(self, vehicle_name: str, heading: float) -> None:
        """From north to the left [deg], -180 to 180."""
        if not -180 <= heading <= 180:
            raise ValueError(f"a heading is -180 to 180 deg; given {heading!r}")
        self._of(vehicle_name).goals["heading"] = float(heading)

    def set_rpm_goal(self, vehicle_name: str, rpm: float) -> None:
        """Of the propeller [1/min]."""
        vehicle = self._of(vehicle_name)
        if not 0 <= rpm <= vehicle.rpm_limit:
            raise ValueError(f"a rate of the propeller is 0 to {vehicle.rpm_limit:g} 1/min; given {rpm!r}")
        vehicle.goals["rpm"] = float(rpm)


def _check_sensor(name: str, agent: Mapping[str, Any]) -> None:
    for sensor in agent["sensors"]:
        if (sensor.get("sensor_name") or sensor["sensor_type"]) == "DynamicsSensor":
            config = sensor.get("configuration") or {}
            if config.get("UseCOM") is True and not config.get("UseRPY", True):
                return
            raise ValueError(f"{name}: its DynamicsSensor needs UseCOM: True and UseRPY: False")
    raise ValueError(f"{name} needs a DynamicsSensor of that name")


def changes(agent: Mapping[str, Any], advice: Advice) -> dict[str, Any]:
    """Native changes of the vehicle's parameters for HoloOcean's blocks `dynamics`, `actuator` and `autopilot`."""
    made: dict[str, Any] = {}
    name = agent["agent_name"]
    if agent.get("fossen_model") != "torpedo":
        idle = [k for k in ("dynamics", "actuator", "autopilot") if agent.get(k)]
        if idle:
            advice.once(f"{name}: {', '.join(idle)} configure a torpedo only; they change nothing")
        return made
    dynamics = agent.get("dynamics", {})
    actuator = {**_DEFAULTS["actuator"], **agent.get("actuator", {})}
    given = agent.get("autopilot", {})
    autopilot = {block: {**keys, **given.get(block, {})} for block, keys in _DEFAULTS["autopilot"].items()}
    advice.unknown(f"{name}: dynamics", dynamics, [*_DYNAMICS, *_IDLE])
    advice.unknown(f"{name}: actuator", actuator, [*_PROPELLER, *_FIN, *_IDLE])
    for key, path in _DYNAMICS.items():
        if key in dynamics:
            _set(made, path, dynamics[key])
    for key, native in _PROPELLER.items():
        if key in actuator:
            _set(made, ("actuators", "propeller", native), actuator[key])
    for key, native in _FIN.items():
        if key in actuator:
            for fin in _FINS:
                _set(made, ("actuators", fin, native), actuator[key])
    for block, table in (("depth", _DEPTH), ("heading", _HEADING)):
        given = autopilot[block]
        advice.unknown(f"{name}: autopilot.{block}", given, [*table, *_IDLE, "r_max"])
        for key, native in table.items():
            if key in given:
                share = _PER_TORQUE if native in ("kp_pitch", "kd_pitch", "ki_pitch") else 1.0
                _set(made, ("modes", "depth_heading", block, native), share * given[key])
    _set(made, ("modes", "depth_heading", "heading", "rate_limit_deg_s"), math.degrees(autopilot["heading"]["r_max"]))
    idle = [k for k in _IDLE if k in dynamics or k in actuator]
    if idle:
        advice.once(f"{name}: {', '.join(idle)} change nothing here; some do nothing in HoloOcean either")
    return made


def _set(data: dict[str, Any], path: Sequence[str], value: Any) -> None:
    for key in path[:-1]:
        data = data.setdefault(key, {})
    data[path[-1]] = value

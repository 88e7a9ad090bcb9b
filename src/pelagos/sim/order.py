"""Requests from outside to a running simulation, as plain data: they are written down, and can be repeated.

Numbers are in Pelagos's own frames and units (world NWU, body FLU, SI): doors convert before.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any, Final, Literal, TypeAlias

from pelagos.errors import CommandError, LookupFailed
from pelagos.sim.bearable import check_command, check_current, check_motion
from pelagos.sim.simulation import Simulation
from pelagos.world.body import SHAPES, Prop

Kind: TypeAlias = Literal[
    "command", "setpoint", "velocity", "wrench", "pose", "waypoint", "mode", "state", "spawn", "remove", "ocean"
]
STREAMS: Final = ("command", "setpoint", "velocity", "wrench", "pose", "waypoint")
"""Kinds of which only the newest counts."""
LARGEST: Final = 1e9
"""Largest number of an order: the squares of larger ones are soon beyond single precision."""
FARTHEST_M: Final = 2.1e7
"""No place on Earth is farther from a world's origin, along the ground [m]."""
CRUISE_MPS: Final = 1.5
"""Speed towards a waypoint where none was commanded before; that of missions."""
LEAD_RAD: Final = math.radians(60)
"""A heading that moves on at a commanded rate of yaw is at most so far ahead of the vehicle's own."""
WATER: Final = ("current", "turbidity")
"""What an order may set of the ocean; see `Sea.set`."""
_BODY_AXES: Final = ("surge", "sway", "heave", "roll", "pitch", "yaw")


@dataclass(frozen=True)
class Order:
    """One thing to do at a boundary of steps.

    Attributes:
        kind: "command": `values` in the agent's control mode, or in `mode` where given;
            "setpoint": some channels of the present command, by name;
            "velocity": body FLU, three velocities [m/s] and three rates [rad/s] (`since_s`: time since the last one);
            "wrench": body FLU [N], [N m];
            "pose": world NWU, position [m], roll, pitch, yaw [rad]; "waypoint": world NWU [m]; "mode": a control mode;
            "state": position, attitude, velocity, angular_velocity, as in `Simulation.set_state`;
            "spawn", "remove": a body of the name `target`; "ocean": properties of the water.
        target: the agent, or the body.
        data: the numbers, JSON types only.
        source: who asked, for reports.
    """

    kind: Kind
    target: str = ""
    data: Mapping[str, Any] = field(default_factory=dict)
    source: str = ""

    @property
    def key(self) -> tuple[str, ...] | None:
        """Two orders with the same key: the newer replaces the older. None for what must not be lost."""
        if self.kind == "setpoint":
            return (self.kind, self.target, *sorted(self.data))
        return (self.kind, self.target) if self.kind in STREAMS else None


def check_finite(order: Order) -> None:
    """Refuse an order with a number that is not finite, or so large that nothing could be reckoned with it.

    Raises:
        CommandError: names the number.
    """
    for name, value in order.data.items():
        limit = FARTHEST_M if name == "position" else LARGEST
        for number in value if isinstance(value, list | tuple) else [value]:
            if isinstance(number, float) and not math.isfinite(number):
                raise CommandError(f"{order.target}: {name} of a {order.kind} order is {number}, not a finite number")
            if isinstance(number, float | int) and abs(number) > limit:
                raise CommandError(f"{order.target}: {name} of a {order.kind} order is {number}; at most {limit:g}")


def apply(order: Order, sim: Simulation) -> None:
    """Do it, now.

    Raises:
        InputError: it cannot be done; nothing has changed.
    """
    check_finite(order)
    _DO[order.kind](order, sim)


def _command(order: Order, sim: Simulation) -> None:
    _vehicle(sim, order.target)
    mode = order.data.get("mode") or sim.stepper.mode(order.target)
    _hold(sim, order.target, str(mode), list(order.data["values"]))


def _setpoint(order: Order, sim: Simulation) -> None:
    """Some channels; those of the same name go on, also where they call for another control mode."""
    agent, vehicle = order.target, _vehicle(sim, order.target)
    mode = sim.stepper.mode(agent)
    held = _held(sim, agent)
    if not set(order.data) <= set(vehicle.command_names(mode)):
        able = [m for m in vehicle.modes if set(order.data) <= set(vehicle.command_names(m))]
        if not able:
            raise CommandError(f"{agent}: no control mode takes {', '.join(order.data)}; modes: {_modes(vehicle)}")
        mode = able[0]
        check_command(agent, vehicle, mode, [float(order.data.get(n, 0.0)) for n in vehicle.command_names(mode)])
        sim.set_mode(agent, mode)
    held = {**_held(sim, agent), **{name: v for name, v in held.items() if name in vehicle.command_names(mode)}}
    held |= {name: float(value) for name, value in order.data.items()}
    _hold(sim, agent, mode, list(held.values()))


def _velocity(order: Order, sim: Simulation) -> None:
    vehicle = _vehicle(sim, order.target)
    steered = next((m for m in vehicle.modes if {"heading", "speed"} <= set(vehicle.command_names(m))), None)
    if "velocity" not in vehicle.modes and steered is not None:
        _steer(order, sim, steered)
        return
    values = _six(order)
    given = {
        f"{axis}_{'speed' if i < 3 else 'rate'}": v for i, (axis, v) in enumerate(zip(_BODY_AXES, values, strict=True))
    }
    _by_name(order, sim, "velocity", given)


def _steer(order: Order, sim: Simulation, mode: str) -> None:
    """A velocity for what steers by heading and speed: surge, and a heading that moves on at the rate of yaw.

    Raises:
        CommandError: another velocity or rate is asked for.
    """
    agent, (surge, *others, yaw_rate) = order.target, _six(order)
    if any(others):
        asked = ", ".join(name for name, value in zip(_BODY_AXES[1:5], others, strict=True) if value)
        raise CommandError(f"{agent}: this vehicle obeys linear.x and angular.z of a velocity alone, not {asked}")
    state, held, since_s = sim.state[agent], _held(sim, agent), float(order.data.get("since_s", 0.0))
    heading = -float(state.euler[0, 2])  # of the compass
    goes_on = sim.stepper.mode(agent) == mode and since_s > 0
    wanted = (held["heading"] if goes_on else heading) - yaw_rate * since_s
    ahead = min(max(_wrapped(wanted - heading), -LEAD_RAD), LEAD_RAD)
    kept = {"depth": held.get("depth", -float(state.position[0, 2])), "heading": _wrapped(heading + ahead)}
    _by_name(order, sim, mode, {**held, **kept, "speed": surge})


def _wrapped(angle: float) -> float:
    return math.remainder(angle, 2 * math.pi)


def _wrench(order: Order, sim: Simulation) -> None:
    flip = (1.0, -1.0, -1.0) * 2  # the mode takes forward-right-down
    _hold(sim, order.target, "wrench", [s * v for s, v in zip(flip, _six(order), strict=True)])


def _pose(order: Order, sim: Simulation) -> None:
    modes = _vehicle(sim, order.target).modes
    mode = next((m for m in ("pose", "position") if m in modes), "pose")
    given = dict(zip(("x", "y", "z", "roll", "pitch", "yaw"), _six(order), strict=True))
    _by_name(order, sim, mode, given)


def _waypoint(order: Order, sim: Simulation) -> None:
    """Go there: hold that place where the vehicle can hover, else follow the line from here."""
    agent, vehicle = order.target, _vehicle(sim, order.target)
    goal = dict(zip(("x", "y", "z"), (float(v) for v in order.data["values"]), strict=True))
    state, held = sim.state[agent], _held(sim, agent)
    here = state.position[0]
    euler = dict(zip(("roll", "pitch", "yaw"), (0.0, 0.0, float(state.euler[0, 2])), strict=True))
    line = {"from_x": here[0], "from_y": here[1], "to_x": goal["x"], "to_y": goal["y"], "depth": -goal["z"]}
    line["speed"] = float(order.data.get("speed", 0.0)) or held.get("speed", 0.0) or CRUISE_MPS
    for mode in ("pose", "position", "line_of_sight"):
        if mode in vehicle.modes:
            _by_name(order, sim, mode, {**goal, **euler, **line})
            return
    raise CommandError(f"{agent}: no control mode goes to a waypoint; modes: {_modes(vehicle)}")


def _held(sim: Simulation, agent: str) -> dict[str, float]:
    names = _vehicle(sim, agent).command_names(sim.stepper.mode(agent))
    return dict(zip(names, sim.held_command(agent)[0].tolist(), strict=True))


def _by_name(order: Order, sim: Simulation, mode: str, given: Mapping[str, float]) -> None:
    """A command of `mode`, of which each channel is found by its name."""
    _commands_of(sim, order.target, mode)
    _hold(sim, order.target, mode, [given[name] for name in _vehicle(sim, order.target).set_points(mode)])


def _mode(order: Order, sim: Simulation) -> None:
    sim.set_mode(order.target, str(order.data["mode"]))


def _state(order: Order, sim: Simulation) -> None:
    still = [0.0, 0.0, 0.0]
    moves = (order.data.get(part) or still for part in ("velocity", "angular_velocity"))
    check_motion(order.target, _vehicle(sim, order.target), *moves)
    sim.set_state(order.target, **{str(k): v for k, v in order.data.items()})


def _spawn(order: Order, sim: Simulation) -> None:
    known = [f.name for f in fields(Prop)]
    for key in order.data:
        if key not in known:
            raise LookupFailed("key of a prop", key, known)
    if "shape" not in order.data:
        raise CommandError(f"a prop needs a shape: {', '.join(SHAPES)}")
    sim.spawn(Prop(**order.data), name=order.target or None)


def _remove(order: Order, sim: Simulation) -> None:
    found = {body.name: body for body in sim.bodies.bodies}
    if order.target not in found:
        raise LookupFailed("body", order.target, found)
    sim.gate.settle()
    found[order.target].remove()


def _ocean(order: Order, sim: Simulation) -> None:
    for name in order.data:
        if name not in WATER:
            raise LookupFailed("property of the water", name, WATER)
    if "current" in order.data:
        check_current(sim, order.data["current"])
    with sim.gate.between_steps():
        sim.ocean.set(**order.data)


def _six(order: Order) -> list[float]:
    values = [float(v) for v in order.data["values"]]
    if len(values) != 6:
        raise CommandError(f"{order.target}: a {order.kind} order has six numbers, not {len(values)}")
    return values


def _hold(sim: Simulation, agent: str, mode: str, values: list[Any]) -> None:
    """A command in a control mode, which is entered; with its own set-points alone, what is carried stays as it is.

    Raises:
        CommandError: there is no such mode, or the vehicle could not bear it.
    """
    names, own = _commands_of(sim, agent, mode), len(_vehicle(sim, agent).set_points(mode))
    if len(values) == own < len(names):
        held = _held(sim, agent)
        values = [*values, *(held.get(name, 0.0) for name in names[own:])]
    check_command(agent, _vehicle(sim, agent), mode, values)
    if sim.stepper.mode(agent) != mode:
        sim.set_mode(agent, mode)
    sim.command({agent: values})


def _commands_of(sim: Simulation, agent: str, mode: str) -> tuple[str, ...]:
    vehicle = _vehicle(sim, agent)
    if mode not in vehicle.modes:
        raise CommandError(f"{agent}: this vehicle has no control mode {mode!r}; modes: {_modes(vehicle)}")
    return tuple(vehicle.command_names(mode))


def _modes(vehicle: Any) -> str:
    return "; ".join(f"{m} ({', '.join(vehicle.command_names(m)) or 'no numbers'})" for m in vehicle.modes)


def _vehicle(sim: Simulation, agent: str) -> Any:
    if agent not in sim.model.agents:
        raise LookupFailed("agent", agent, sim.model.agents)
    return sim.model.agents[agent].vehicle


_DO: Final = {
    "command": _command, "setpoint": _setpoint, "velocity": _velocity, "wrench": _wrench, "pose": _pose,
    "waypoint": _waypoint, "mode": _mode, "state": _state, "spawn": _spawn, "remove": _remove, "ocean": _ocean,
}  # fmt: skip

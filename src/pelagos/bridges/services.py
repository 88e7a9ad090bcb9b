"""Services of a running simulation: std_srvs, simulation_interfaces 2.1, HoloOcean's, and our own.

The same controls stand as topics under `/sim/` for clients that cannot reach our services (Fast DDS).
"""

from __future__ import annotations

import itertools
import json
import threading
from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any, Final

import numpy as np

from pelagos.bridges.inbox import ANSWER_S
from pelagos.bridges.ros_commands import ONE_SHOT, listen, pose_nwu, received
from pelagos.bridges.transport import Answer, Transport, Unsupported
from pelagos.math.frames import enu_to_nwu_np, nwu_to_enu_np, quaternion_nwu_to_enu_np
from pelagos.math.so3 import rotate_back_np, rotate_np
from pelagos.messages.store import deserialize, header, make, quaternion, serialize, vector3
from pelagos.sim.order import Order

if TYPE_CHECKING:
    from pelagos.bridges.exchange import Exchange

UNSUPPORTED, OK, NOT_FOUND, WRONG_STATE, FAILED = range(5)
NAME_NOT_UNIQUE, NAME_INVALID = 101, 102
"""Results of SpawnEntity."""
STOPPED, PLAYING, PAUSED, QUITTING = range(4)
FEATURES: Final = (0, 1, 9, 10, 11, 20, 24, 25, 26, 31, 32)
"""SimulatorFeatures: spawning, deleting, resource strings, entity states, reset, simulation states, pause, steps."""
HOLOOCEAN_MODES: Final = {
    0: ("actuators",), 1: ("depth_heading",), 2: ("heading", "depth_heading"), 3: ("depth_heading",),
}  # fmt: skip
STEPS_S: Final = 60.0
_SI: Final = "simulation_interfaces/srv/"
_WORLD: Final = ("", "map", "world")  # frames that mean the world's


def serve_topics(
    exchange: Exchange, transport: Transport, *, only: Sequence[str], commands: bool, services: bool, clock: bool = True
) -> None:
    """Open a transport to programs that choose their topics: messages out, commands and services in.

    Args:
        only: beginnings of the topics that are offered; all where empty.
        commands, services: accept them.
        clock: publish /clock.
    """
    from pelagos.bridges.door import TopicDoor

    exchange.add(TopicDoor(transport, clock=clock, only=only))
    made = Services(exchange)
    if commands:
        listen(transport, exchange.sim, exchange.inbox)
        made.listen(transport)
    if services:
        made.offer(transport)


class Services:
    """Answers for one run; the names stand below `prefix`."""

    def __init__(self, exchange: Exchange, *, prefix: str = "/pelagos") -> None:
        self._exchange, self._prefix = exchange, prefix
        self._sim, self._inbox = exchange.sim, exchange.inbox

    def offer(self, transport: Transport) -> bool:
        """Serve all of them; False where the transport has no services."""
        table: dict[str, tuple[str, Callable[[Any], dict[str, Any]]]] = {
            "reset": ("std_srvs/srv/Trigger", self._reset),
            "set_paused": ("std_srvs/srv/SetBool", self._set_paused),
            "set_control_mode": ("pelagos_msgs/srv/SetControlMode", self._set_mode),
            "set_ocean": ("pelagos_msgs/srv/SetOcean", self._set_ocean),
            "reset_simulation": (_SI + "ResetSimulation", self._reset_simulation),
            "step_simulation": (_SI + "StepSimulation", self._step),
            "get_simulation_state": (_SI + "GetSimulationState", self._get_state),
            "set_simulation_state": (_SI + "SetSimulationState", self._set_state),
            "get_simulator_features": (_SI + "GetSimulatorFeatures", self._features),
            "get_entities": (_SI + "GetEntities", self._entities),
            "get_entity_state": (_SI + "GetEntityState", self._entity_state),
            "set_entity_state": (_SI + "SetEntityState", self._set_entity_state),
            "spawn_entity": (_SI + "SpawnEntity", self._spawn),
            "delete_entity": (_SI + "DeleteEntity", self._delete),
        }
        try:
            for name, (type_name, answer) in table.items():
                transport.serve(f"{self._prefix}/{name}", type_name, answering(type_name, answer))
        except Unsupported:
            return False
        return True

    def offer_holoocean(self, transport: Transport, *, prefix: str = "/holoocean") -> None:
        """HoloOcean's two services."""
        mode = "holoocean_interfaces/srv/SetControlMode"
        transport.serve(f"{prefix}/reset", "std_srvs/srv/Trigger", answering("std_srvs/srv/Trigger", self._reset))
        transport.serve(f"{prefix}/control_mode", mode, answering(mode, self._holoocean_mode))

    def listen(self, transport: Transport) -> None:
        """The same as topics: /sim/reset, /sim/set_paused, /sim/step."""
        one_shots: dict[str, tuple[str, Callable[[Any], Any]]] = {
            "/sim/reset": ("std_msgs/msg/Empty", lambda m: self._exchange.reset()),
            "/sim/set_paused": ("std_msgs/msg/Bool", lambda m: self._pause(bool(m.data))),
            "/sim/step": ("std_msgs/msg/UInt64", lambda m: self._steps(int(m.data))),
        }
        for topic, (type_name, do) in one_shots.items():
            transport.subscribe(topic, type_name, self._does(topic, type_name, do), qos=ONE_SHOT)

    def _does(self, topic: str, type_name: str, do: Callable[[Any], Any]) -> Callable[[bytes], None]:
        def receive(cdr: bytes) -> None:
            try:
                do(deserialize(type_name, cdr))
            except Exception as error:
                self._inbox.refuse(f"{topic}: {type(error).__name__}: {error}")

        return receive

    # std_srvs, HoloOcean's, our own

    def _reset(self, request: Any) -> dict[str, Any]:
        self._exchange.reset()
        return {"success": True, "message": "the simulation begins anew"}

    def _set_paused(self, request: Any) -> dict[str, Any]:
        self._pause(bool(request.data))
        return {"success": True, "message": "paused" if request.data else "goes on"}

    def _set_mode(self, request: Any) -> dict[str, Any]:
        return self._told(Order("mode", request.agent, {"mode": request.mode}, "set_control_mode"))

    def _set_ocean(self, request: Any) -> dict[str, Any]:
        values = [float(v) for v in request.values]
        if request.name == "current" and len(values) == 3:
            values = enu_to_nwu_np(np.array(values)).tolist()
        value = values[0] if len(values) == 1 else values
        return self._told(Order("ocean", "", {request.name: value}, "set_ocean"))

    def _holoocean_mode(self, request: Any) -> dict[str, Any]:
        agent, wanted = request.vehicle_name, HOLOOCEAN_MODES.get(int(request.mode))
        if agent not in self._sim.model.agents or wanted is None:
            return {"success": False, "message": f"no agent {agent!r}, or no mode {request.mode}"}
        modes = self._sim.model.agents[agent].vehicle.modes
        mode = next((m for m in wanted if m in modes), wanted[0])
        return self._told(Order("mode", agent, {"mode": mode}, "control_mode"))

    def _told(self, order: Order) -> dict[str, Any]:
        refusal = self._inbox.put(order).wait()
        return {"success": not refusal, "message": refusal or "done"}

    # simulation_interfaces

    def _reset_simulation(self, request: Any) -> dict[str, Any]:
        scope = int(request.scope)
        if scope in (0, 255) or scope & 7 == 7:
            self._exchange.reset()
            return {"result": result(OK)}
        return {"result": result(UNSUPPORTED, "time, states and spawned bodies are reset together: scope 0 or 255")}

    def _step(self, request: Any) -> dict[str, Any]:
        if not self._sim.paused:
            return {"result": result(WRONG_STATE, "pause the simulation before stepping it")}
        try:
            done = self._steps(int(request.steps) or 1).wait(STEPS_S)
        except ValueError as error:
            return {"result": result(FAILED, str(error))}
        return {"result": result(OK) if done else result(FAILED, f"not done within {STEPS_S:g} s")}

    def _get_state(self, request: Any) -> dict[str, Any]:
        state = PAUSED if self._sim.paused else PLAYING
        return {"state": make("simulation_interfaces/msg/SimulationState", state=state), "result": result(OK)}

    def _set_state(self, request: Any) -> dict[str, Any]:
        wanted, present = int(request.state.state), PAUSED if self._sim.paused else PLAYING
        if wanted == present:
            return {"result": result(101, "already so")}
        if wanted == QUITTING:
            self._sim.stop()
        elif wanted == STOPPED:
            self._pause(True)
            self._exchange.reset()
        elif wanted in (PLAYING, PAUSED):
            self._pause(wanted == PAUSED)
        else:
            return {"result": result(103, f"there is no way to state {wanted}")}
        return {"result": result(OK)}

    def _features(self, request: Any) -> dict[str, Any]:
        features = make(
            "simulation_interfaces/msg/SimulatorFeatures",
            features=_array(FEATURES),
            spawn_formats=["json"],
            custom_info='spawn: resource_string is a prop as JSON, such as {"shape": "box", "size": [1, 2, 3]}',
        )
        return {"features": features}

    def _entities(self, request: Any) -> dict[str, Any]:
        return {"result": result(OK), "entities": self._names()}

    def _entity_state(self, request: Any) -> dict[str, Any]:
        found, reached = self._found(request.entity)
        if not reached:
            late = f"the simulation did not reach a boundary of steps within {ANSWER_S:g} s"
            return {"result": result(FAILED, late), "state": entity_state(None, 0)}
        if found is None:
            return {"result": result(NOT_FOUND, f"no entity {request.entity!r}"), "state": entity_state(None, 0)}
        return {"result": result(OK), "state": entity_state(found, self._sim.time_ns)}

    def _found(self, name: str) -> tuple[Any, bool]:
        """Position, attitude, velocity and angular velocity NWU of an agent or body, and whether it was looked."""
        box: list[Any] = []

        def look() -> None:
            if name in self._sim.model.agents:
                state = self._sim.state[name]
                twist = (rotate_np(state.attitude[0], v[0]) for v in (state.velocity, state.angular_velocity))
                box.extend([state.position[0], state.attitude[0], *twist])
            for body in self._sim.bodies.bodies:
                if body.name == name:
                    box.extend([body.position[0], body.attitude[0], body.velocity[0], body.angular_velocity[0]])

        reached = self._exchange.do(look)
        return box or None, reached

    def _set_entity_state(self, request: Any) -> dict[str, Any]:
        data: dict[str, Any] = {}
        frame, own = request.state.header.frame_id, f"{request.entity}/base_link"
        if frame not in (*_WORLD, own) or (frame == own and request.set_pose):
            words = f"the state is in {frame!r}; known: 'map', and for a twist alone {own!r}"
            return {"result": result(UNSUPPORTED, words)}
        if request.set_pose:
            try:
                data["position"], data["attitude"] = pose_nwu(request.state.pose)
            except ValueError as error:
                return {"result": result(101, str(error))}
        if request.set_twist:
            found = None if request.set_pose or frame == own else self._found(request.entity)[0]
            attitude = data.get("attitude") or (found[1].tolist() if found else None)
            twist = request.state.twist
            for key, told in (("velocity", twist.linear), ("angular_velocity", twist.angular)):
                vector = np.array([told.x, told.y, told.z], dtype=np.float64)
                if frame != own and attitude is not None:  # what is not found is refused below
                    vector = rotate_back_np(np.array(attitude), enu_to_nwu_np(vector))
                data[key] = vector.tolist()
        if request.set_acceleration or not data:
            return {"result": result(UNSUPPORTED, "set_pose and set_twist are supported")}
        return {"result": self._obeyed(Order("state", request.entity, data, "set_entity_state"))}

    def _spawn(self, request: Any) -> dict[str, Any]:
        try:
            text = request.entity_resource.resource_string
            data = dict(json.loads(text)) if text else {"shape": request.entity_resource.uri}
            data["position"], data["attitude"] = pose_nwu(request.initial_pose.pose)
        except (ValueError, TypeError) as error:
            return {"result": result(106, str(error)), "entity_name": ""}
        taken, name = self._names(), request.name
        if name and not name.isprintable():
            return {"result": result(NAME_INVALID, f"{name!r} is no name: it cannot be printed"), "entity_name": ""}
        if name in taken and not request.allow_renaming:
            return {"result": result(NAME_NOT_UNIQUE, f"there is an entity {name!r} already"), "entity_name": ""}
        if not name or name in taken:
            stem = f"{name}_" if name else "body"
            name = next(n for i in itertools.count(1) if (n := f"{stem}{i}") not in taken)
        told = self._obeyed(Order("spawn", name, data, "spawn_entity"))
        return {"result": told, "entity_name": name if told.result == OK else ""}

    def _names(self) -> list[str]:
        return [*self._sim.model.agents, *(b.name for b in self._sim.bodies.bodies)]

    def _delete(self, request: Any) -> dict[str, Any]:
        return {"result": self._obeyed(Order("remove", request.entity, {}, "delete_entity"))}

    def _obeyed(self, order: Order) -> Any:
        refusal = self._inbox.put(order).wait()
        return result(FAILED, refusal) if refusal else result(OK)

    def _pause(self, paused: bool) -> None:
        if paused:
            self._sim.pause()
        else:
            self._exchange.resume()

    def _steps(self, ticks: int) -> threading.Event:
        if not 1 <= ticks <= 1_000_000_000:
            raise ValueError(f"steps are 1 to 1e9, not {ticks}")
        return self._exchange.step(ticks)


def answering(type_name: str, answer: Callable[[Any], dict[str, Any]]) -> Answer:
    """A function of messages as one of bytes."""

    def respond(cdr: bytes) -> bytes:
        request = deserialize(f"{type_name}_Request", cdr)
        return serialize(f"{type_name}_Response", make(f"{type_name}_Response", **answer(request)))

    return respond


def result(code: int, message: str = "") -> Any:
    """simulation_interfaces/Result."""
    return make("simulation_interfaces/msg/Result", result=code, error_message=message)


def entity_state(found: Any, t_ns: int) -> Any:
    """simulation_interfaces/EntityState in `map`, pose and twist: EntityState.msg has both in the header's frame."""
    position, attitude, *twist = found or ((0, 0, 0), (1, 0, 0, 0), (0, 0, 0), (0, 0, 0))
    enu, velocity, spin = (nwu_to_enu_np(np.asarray(v, dtype=np.float64)).tolist() for v in (position, *twist))
    q = quaternion_nwu_to_enu_np(np.asarray(attitude, dtype=np.float64)).tolist()
    point = make("geometry_msgs/msg/Point", x=enu[0], y=enu[1], z=enu[2])
    return make(
        "simulation_interfaces/msg/EntityState",
        header=header("map", t_ns),
        pose=make("geometry_msgs/msg/Pose", position=point, orientation=quaternion(*q)),
        twist=make("geometry_msgs/msg/Twist", linear=vector3(*velocity), angular=vector3(*spin)),
        acceleration=make("geometry_msgs/msg/Accel", linear=vector3(), angular=vector3()),
    )


def _array(values: Any) -> Any:
    return np.array(values, dtype=np.uint16)


__all__ = ["Services", "answering", "entity_state", "received", "result", "serve_topics"]

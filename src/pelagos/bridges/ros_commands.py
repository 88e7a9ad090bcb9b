"""Commands as ROS 2 topics: what a team's stack publishes becomes orders.

Vectors of a body are forward-left-up (REP-103), poses are in `map` (ENU). For every agent, below its name:
`cmd_vel` (Twist), `cmd_vel_stamped`, `cmd_wrench` (WrenchStamped), `cmd_pose` (PoseStamped), `cmd_waypoint`
(PointStamped), `cmd_actuators` and `command` (Float64MultiArray), `cmd_mode` (String), `setpoint/<channel>` (Float64).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, Final

import numpy as np

from pelagos.bridges.inbox import Inbox
from pelagos.bridges.transport import COMMAND, Qos, Receive, Transport
from pelagos.config.swarm import topic_name
from pelagos.math.frames import enu_to_nwu_np, quaternion_enu_to_nwu_np
from pelagos.math.so3 import euler_np
from pelagos.messages.store import deserialize
from pelagos.sim.order import Order
from pelagos.sim.simulation import Simulation

DIRECT: Final = ("actuators", "wrench", "acceleration")
"""Control modes whose channels are no set-points."""
ONE_SHOT: Final = Qos(depth=10)


def command_topics(sim: Simulation, agent: str) -> Mapping[str, tuple[str, Callable[[Any], Order]]]:
    """Topic below the agent's name -> its type, and the order that a message stands for."""
    vehicle = sim.model.agents[agent].vehicle
    topics: dict[str, tuple[str, Callable[[Any], Order]]] = {
        "cmd_vel": ("geometry_msgs/msg/Twist", partial(_twist, agent)),
        "cmd_vel_stamped": ("geometry_msgs/msg/TwistStamped", lambda m: _twist(agent, m.twist)),
        "cmd_wrench": ("geometry_msgs/msg/WrenchStamped", partial(_wrench, agent)),
        "cmd_pose": ("geometry_msgs/msg/PoseStamped", partial(_pose, agent)),
        "cmd_waypoint": ("geometry_msgs/msg/PointStamped", partial(_waypoint, agent)),
        "cmd_actuators": ("std_msgs/msg/Float64MultiArray", partial(_values, agent, mode="actuators")),
        "command": ("std_msgs/msg/Float64MultiArray", partial(_values, agent, mode=None)),
        "cmd_mode": ("std_msgs/msg/String", lambda m: Order("mode", agent, {"mode": m.data})),
    }
    channels = {name for mode in vehicle.modes if mode not in DIRECT for name in vehicle.command_names(mode)}
    for channel in sorted(channels):
        topics[f"setpoint/{channel}"] = ("std_msgs/msg/Float64", partial(_setpoint, agent, channel))
    return topics


def listen(transport: Transport, sim: Simulation, inbox: Inbox) -> None:
    """Subscribe to the commands of every agent."""
    for agent in sim.model.agents:
        for suffix, (type_name, order) in command_topics(sim, agent).items():
            topic = f"/{topic_name(agent)}/{suffix}"
            qos = ONE_SHOT if suffix == "cmd_mode" else COMMAND
            transport.subscribe(topic, type_name, received(topic, type_name, order, inbox), qos=qos)


def received(topic: str, type_name: str, order: Callable[[Any], Order], inbox: Inbox) -> Receive:
    """Decodes one topic's messages into orders; what cannot be decoded is counted and dropped."""

    def receive(cdr: bytes) -> None:
        try:
            made = order(deserialize(type_name, cdr))
        except Exception as error:  # bytes from a network: anything may be wrong with them
            inbox.refuse(f"{topic}: malformed message ({type(error).__name__})")
            return
        inbox.put(Order(made.kind, made.target, made.data, topic))

    return receive


def _twist(agent: str, message: Any) -> Order:
    values = [getattr(part, axis) for part in (message.linear, message.angular) for axis in "xyz"]
    return Order("velocity", agent, {"values": [float(v) for v in values]})


def _wrench(agent: str, message: Any) -> Order:
    parts = (message.wrench.force, message.wrench.torque)
    return Order("wrench", agent, {"values": [float(getattr(part, axis)) for part in parts for axis in "xyz"]})


def _pose(agent: str, message: Any) -> Order:
    position, q = pose_nwu(message.pose)
    return Order("pose", agent, {"values": [*position, *euler_np(np.array(q)).tolist()]})


def _waypoint(agent: str, message: Any) -> Order:
    p = message.point
    x, y, z = enu_to_nwu_np(np.array([p.x, p.y, p.z], dtype=np.float64)).tolist()
    return Order("waypoint", agent, {"values": [x, y, z]})


def _values(agent: str, message: Any, *, mode: str | None) -> Order:
    data: dict[str, Any] = {"values": [float(v) for v in message.data]}
    if mode is not None:
        data["mode"] = mode
    return Order("command", agent, data)


def _setpoint(agent: str, channel: str, message: Any) -> Order:
    return Order("setpoint", agent, {channel: float(message.data)})


def pose_nwu(pose: Any) -> tuple[list[float], list[float]]:
    """geometry_msgs/Pose in ENU -> position NWU [m] and quaternion wxyz, FLU to NWU.

    Raises:
        ValueError: the quaternion is not of unit length (1 %).
    """
    p, o = pose.position, pose.orientation
    q = np.array([o.w, o.x, o.y, o.z], dtype=np.float64)
    length = float(np.linalg.norm(q))
    if not abs(length - 1.0) < 0.01:
        raise ValueError(f"the orientation has length {length:g}, not 1")
    position = enu_to_nwu_np(np.array([p.x, p.y, p.z], dtype=np.float64))
    return position.tolist(), quaternion_enu_to_nwu_np(q / length).tolist()

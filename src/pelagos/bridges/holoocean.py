"""Commands under the names of HoloOcean's ROS package, so that its nodes drive our vehicles.

`/holoocean/command/agent` (AgentCommand), `/holoocean/depth`, `heading` and `speed` (DesiredCommand); the agent's name
stands in header.frame_id. HoloOcean's heading is in degrees, counter-clockwise from north (NWU); its speed is a rate of
the propeller [1/min].
"""

from __future__ import annotations

import math
from typing import Any

from pelagos.bridges.inbox import Inbox
from pelagos.bridges.ros_commands import received
from pelagos.bridges.transport import COMMAND, Transport
from pelagos.sim.order import Order
from pelagos.sim.simulation import Simulation

AGENT_COMMAND = "holoocean_interfaces/msg/AgentCommand"
DESIRED = "holoocean_interfaces/msg/DesiredCommand"


def listen_holoocean(transport: Transport, sim: Simulation, inbox: Inbox, *, prefix: str = "/holoocean") -> None:
    """Subscribe to HoloOcean's command topics."""
    table = {
        "command/agent": (AGENT_COMMAND, _command),
        "depth": (DESIRED, lambda m: _desired(m, "depth", float(m.data))),
        "heading": (DESIRED, lambda m: _desired(m, "heading", -math.radians(m.data))),
        "speed": (DESIRED, lambda m: _desired(m, "rpm", float(m.data))),
    }
    for name, (type_name, order) in table.items():
        topic = f"{prefix}/{name}"
        transport.subscribe(topic, type_name, received(topic, type_name, order, inbox), qos=COMMAND)


def _command(message: Any) -> Order:
    return Order("command", message.header.frame_id, {"values": [float(v) for v in message.command]})


def _desired(message: Any, channel: str, value: float) -> Order:
    return Order("setpoint", message.header.frame_id, {channel: value})

"""Packets from a network with whatever may be wrong with them: every parser counts or refuses them, and goes on.

CI tries a few thousand for each parser; `python tests/fuzz/test_bridges.py 1000000` tries a million.
"""

from __future__ import annotations

import json
import socket
import struct
import sys
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.ardupilot_json import parse_servos
from pelagos.bridges.inbox import MOST_REASONS, Inbox
from pelagos.bridges.instruments import ping
from pelagos.bridges.instruments.a50 import WaterLinkedJson, WaterLinkedSerial
from pelagos.bridges.instruments.ping_devices import Ping1d, Ping360
from pelagos.bridges.lcm_transport import payload
from pelagos.bridges.mavlink import MavlinkConfig, MavlinkDoor
from pelagos.bridges.moos_wire import NOTIFY, MoosMessage, pack, unpack
from pelagos.bridges.px4 import Px4Config, Px4Link
from pelagos.bridges.ros_commands import command_topics, received
from pelagos.bridges.rosbridge import MOST_TROUBLES, RosbridgeTransport
from pelagos.bridges.rosbridge_client import Client
from pelagos.bridges.services import OK, answering, result
from pelagos.bridges.transport import STREAM
from pelagos.messages.lcm import encode
from pelagos.messages.store import make, serialize, vector3
from pelagos.sim.order import Order

PACKETS = 3000
Feed = Callable[[bytes], object]
OPEN: list[Any] = []
"""What parsers hold open, to be closed when an attack ends."""


def servos() -> tuple[Feed, list[bytes]]:
    return parse_servos, [
        struct.pack("<HHI16H", 18458, 400, 7, *range(1100, 1900, 50)),
        struct.pack("<HHI32H", 29569, 400, 7, *range(1100, 1900, 25)),
    ]


def moos() -> tuple[Feed, list[bytes]]:
    def feed(raw: bytes) -> None:
        try:
            unpack(raw)
        except ValueError:
            return

    return feed, [pack([MoosMessage(NOTIFY, "DESIRED_THRUST", 40.5, "text", "pHelm", 3.0)] * 3)]


def lcm() -> tuple[Feed, list[bytes]]:
    cdr = twist()
    message = {"t_ns": 5, "type": "geometry_msgs/msg/Twist", "size": len(cdr), "cdr": cdr}
    return lambda raw: payload(raw, "geometry_msgs/msg/Twist"), [encode("message_t", message)]


def ping_device(kind: Any) -> tuple[Feed, list[bytes]]:
    config = SimpleNamespace(range_min_m=0.5, range_max_m=40.0, rate_hz=8.0)
    device = kind(SimpleNamespace(config=config))
    rng = np.random.Generator(np.random.PCG64(5))
    device.hear(SimpleNamespace(data=rng.random((1, 60)), t_ns=0, extras={"angle": np.array([0.3])}))
    transducer = struct.pack("<BBHHHHHBB", 1, 2, 200, 30, 700, 750, 300, 1, 0)
    asked = [(n, b"") for n in (4, 5, 1200, 1203, 1204, 1207, 1210, 1211, 1212, 1300, 2300)]
    asked += [(1001, struct.pack("<II", 500, 9000)), (1002, struct.pack("<I", 1_480_000)), (1003, b"\1"), (1005, b"\2")]
    asked += [(1004, struct.pack("<H", 90)), (6, struct.pack("<H", 1300)), (1400, struct.pack("<H", 1300))]
    return device.answer, [ping.frame(number, data) for number, data in [*asked, (2601, transducer)]]


def a50() -> tuple[Feed, list[bytes]]:
    return WaterLinkedSerial(cast(Any, SimpleNamespace())).answer, [
        b"wcv\r\n",
        b"wcv*2d\r\nwcs\r\n",
        b"wcs,1450,,n,,auto,y\r\n",
        b"wcp,3\r\nwcr\r\n",
    ]


def commands() -> tuple[Feed, list[bytes]]:
    """Every command topic of a vehicle; what gets through is an order that waits, and no more than a few of them."""
    vehicle = SimpleNamespace(modes=("cruise",), command_names=lambda mode: ("depth", "heading", "speed"))
    agents = {"rov": SimpleNamespace(vehicle=vehicle)}
    sim = cast(Any, SimpleNamespace(model=SimpleNamespace(agents=agents), post=lambda action: None))
    inbox = Inbox(sim)
    doors = [received(name, kind, order, inbox) for name, (kind, order) in command_topics(sim, "rov").items()]

    def feed(raw: bytes) -> None:
        for door in doors:
            door(raw)
        assert len(inbox._waiting) <= 1000
        assert len(inbox.refused) <= 20 * len(doors)  # reasons, not packets: they do not fill memory

    return feed, [twist(), serialize("std_msgs/msg/Float64", make("std_msgs/msg/Float64", data=2.5))]


def twist() -> bytes:
    name = "geometry_msgs/msg/Twist"
    return bytes(serialize(name, make(name, linear=vector3(0.4, -0.3, 0.2), angular=vector3(0.1, 0.0, -0.5))))


def rosbridge() -> tuple[Feed, list[bytes]]:
    """A client of the server: what it says in JSON, answers included."""
    door, silent = (
        RosbridgeTransport(port=0),
        SimpleNamespace(send=lambda text: None, socket=SimpleNamespace(close=lambda: None)),
    )
    heard: list[bytes] = []
    door.subscribe("/rov/cmd_vel", "geometry_msgs/msg/Twist", lambda cdr: heard.append(cdr), qos=STREAM)
    door.advertise("/rov/truth", "nav_msgs/msg/Odometry", qos=STREAM)
    steps = "simulation_interfaces/srv/StepSimulation"
    door.serve("/pelagos/step_simulation", steps, answering(steps, lambda request: {"result": result(OK)}))
    client = Client(silent, door._operations(), door.troubles)
    OPEN.append(client)

    def feed(raw: bytes) -> None:
        heard.clear()
        client.take(raw)
        assert len(door.troubles) <= MOST_TROUBLES + 1  # a client's words do not fill memory
        assert not heard or len(heard[0]) == len(twist())

    OPEN.append(door)
    velocity = {"linear": {"x": 0.4, "y": -0.3}, "angular": {"z": -0.5}}
    said: list[dict[str, Any]] = [
        {"op": "publish", "topic": "/rov/cmd_vel", "type": "geometry_msgs/Twist", "msg": velocity},
        {"op": "subscribe", "topic": "/rov/truth", "throttle_rate": 50, "queue_length": 3, "compression": "none"},
        {"op": "unsubscribe", "topic": "/rov/truth"},
        {"op": "call_service", "service": "/pelagos/step_simulation", "id": "7", "args": {"steps": 40}},
        {"op": "call_service", "service": "/rosapi/topic_type", "args": {"topic": "/rov/truth"}},
        {"op": "advertise", "topic": "/rov/cmd_vel", "type": "geometry_msgs/Twist"},
    ]
    return feed, [json.dumps(one).encode() for one in said]


def a50_json() -> tuple[Feed, list[bytes]]:
    device = WaterLinkedJson(cast(Any, SimpleNamespace()))

    def feed(raw: bytes) -> None:
        for answer in device.answer(raw).splitlines():
            assert json.loads(answer)["type"] == "response"

    off = {"command": "set_config", "parameters": {"acoustic_enabled": False, "range_mode": "auto"}}
    return feed, [json.dumps(one).encode() + b"\r\n" for one in ({"command": "get_config"}, off)]


def mavlink() -> tuple[Feed, list[bytes]]:
    pytest.importorskip("pymavlink")
    from pymavlink.dialects.v20 import common

    sim = cast(Any, SimpleNamespace(model=SimpleNamespace(agents={"rov": None}), post=lambda action: None))
    inbox = Inbox(sim)
    config = MavlinkConfig(type="mavlink", port=9)
    door = MavlinkDoor(cast(Any, SimpleNamespace(sim=sim, inbox=inbox, at_least=lambda rate_hz: None)), config)
    sender = common.MAVLink(None, srcSystem=255, srcComponent=190)
    place = (0, 1, 1, 1, 0b110111111000, 4.0, -2.0, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    said = [
        common.MAVLink_manual_control_message(1, 500, -300, 600, 200, 0),
        common.MAVLink_set_position_target_local_ned_message(*place),
        common.MAVLink_command_long_message(1, 1, 400, 0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0),
        common.MAVLink_param_set_message(1, 1, b"SPEED_MPS", 2.0, 9),
        common.MAVLink_param_request_read_message(1, 1, b"SPEED_MPS", -1),
        common.MAVLink_mission_count_message(1, 1, 3),
    ]

    def feed(raw: bytes) -> None:
        door.take(raw)
        assert len(inbox.refused) <= MOST_REASONS + 1

    OPEN.append(door)
    return feed, [message.pack(sender) for message in said]


def px4() -> tuple[Feed, list[bytes]]:
    pytest.importorskip("pymavlink")
    from pymavlink.dialects.v20 import common

    sim = pl.Simulation.load({
        "world": {"type": "flat", "depth_m": 30},
        "agents": {"drone": {"vehicle": "quadrotor", "start": {"position_m": [0, 0, 1]}, "control": "actuators"}},
    })  # fmt: skip
    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        config = Px4Config(type="px4", port=free.getsockname()[1])
    obeyed: list[Order] = []
    link = Px4Link(cast(Any, SimpleNamespace(sim=sim, inbox=SimpleNamespace(obey=obeyed.append))), config)
    OPEN.append(link)
    sender = common.MAVLink(None, srcSystem=1, srcComponent=1)
    said = [
        common.MAVLink_hil_actuator_controls_message(4000, [0.5, 0.4, -0.3, 1.0] * 4, 128, 1),
        common.MAVLink_heartbeat_message(2, 12, 128, 0, 4, 3),
    ]

    def feed(raw: bytes) -> None:
        link.take(raw)
        assert all(np.isfinite(order.data["values"]).all() for order in obeyed)
        obeyed.clear()

    return feed, [message.pack(sender) for message in said]


PARSERS: dict[str, Callable[[], tuple[Feed, list[bytes]]]] = {
    "ardupilot": servos, "moos": moos, "lcm": lcm, "ping1d": lambda: ping_device(Ping1d),
    "ping360": lambda: ping_device(Ping360), "a50": a50, "a50_json": a50_json,
    "commands": commands, "mavlink": mavlink, "px4": px4, "rosbridge": rosbridge,
}  # fmt: skip


def damaged(good: bytes, rng: np.random.Generator) -> bytes:
    """A packet with bits turned, cut short, made longer, doubled, or nothing but noise."""
    raw, how = bytearray(good), int(rng.integers(0, 6))
    if how == 0:
        return bytes(rng.bytes(int(rng.integers(0, 80))))
    if how == 1:
        return bytes(raw[: int(rng.integers(0, len(raw) + 1))])
    if how == 2:
        return bytes(raw) + rng.bytes(int(rng.integers(1, 40)))
    if how == 3:
        return bytes(raw) * 2
    for _ in range(int(rng.integers(1, 5))):
        raw[int(rng.integers(0, len(raw)))] = int(rng.integers(0, 256)) if how == 4 else (0, 255, 127)[how % 3]
    return bytes(raw)


JUNK: list[Any] = [
    None, True, -1, 2**70, 0.5, 1e300, float("nan"), float("inf"), "", "x" * 300, "/rov/truth", [], {}, [[[1]]],
    {"a": {}},
]  # fmt: skip


def damaged_json(good: bytes, rng: np.random.Generator) -> bytes:
    """An object with a value that does not belong there, one too many or one too few; or damaged as bytes."""
    if rng.random() < 0.3:
        return damaged(good, rng)
    whole = json.loads(good)
    place = whole
    while rng.random() < 0.5 and (inner := [v for v in place.values() if isinstance(v, dict) and v]):
        place = inner[int(rng.integers(0, len(inner)))]
    key, how = list(place)[int(rng.integers(0, len(place)))], int(rng.integers(0, 5))
    if how == 0:
        del place[key]
    else:
        place[f"k{rng.integers(0, 10**6)}" if how == 1 else key] = JUNK[int(rng.integers(0, len(JUNK)))]
    return json.dumps(whole).encode()


DAMAGE = {"rosbridge": damaged_json, "a50_json": damaged_json}


def attack(name: str, packets: int, seed: int) -> None:
    feed, good = PARSERS[name]()
    rng = np.random.Generator(np.random.PCG64(seed))
    try:
        for number in range(packets):
            raw = DAMAGE.get(name, damaged)(good[number % len(good)], rng)
            try:
                feed(raw)
            except Exception as error:
                raise AssertionError(f"{name}, packet {number} of seed {seed}: {raw.hex()}") from error
    finally:
        while OPEN:
            OPEN.pop().close()


@pytest.mark.parametrize("name", sorted(PARSERS))
def test_damaged_packets_are_survived(name: str) -> None:
    attack(name, PACKETS, seed=11)


@pytest.mark.parametrize("name", ["ping1d", "ping360"])
def test_a_device_answers_after_noise(name: str) -> None:
    feed, good = PARSERS[name]()
    rng = np.random.Generator(np.random.PCG64(2))
    for number in range(500):
        feed(damaged(good[number % len(good)], rng))
    feed(bytes(ping.LONGEST + 12))  # whatever length a broken head has named is over
    assert feed(ping.frame(ping.PROTOCOL_VERSION, b"")) == ping.protocol_version()


if __name__ == "__main__":
    total = int(sys.argv[1]) if len(sys.argv) > 1 else 1_000_000
    for parser in PARSERS:
        attack(parser, total // len(PARSERS), seed=total)
        print(f"{parser}: {total // len(PARSERS)} packets")

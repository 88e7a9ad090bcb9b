"""Every registered door: it stands on this machine unless told, says plainly when it does not, and refuses numbers that
are not finite."""

from __future__ import annotations

import json
import os
import socket
import struct
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges import dds_loopback
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.moos_wire import HELLO, NOTIFY, MoosMessage, pack
from pelagos.bridges.ros_commands import command_topics, listen
from pelagos.bridges.rosbridge_client import Client
from pelagos.bridges.transport import BridgeError, MemoryTransport
from pelagos.config import registry
from pelagos.messages.json_form import from_json
from pelagos.messages.lcm import encode
from pelagos.messages.store import serialize

KINDS = sorted(registry.entries("bridge", plugins=False))
DOMAIN = 200 + os.getpid() % 30
OWN_PORT: dict[str, dict[str, Any]] = {
    "foxglove": {"port": 0}, "rosbridge": {"port": 0}, "ros2": {"transport": "dds", "domain_id": DOMAIN},
    "instrument": {"protocol": "waterlinked", "sensors": ["dvl"], "port": "tcp:0"},
    "px4": {"port": 14561}, "ardupilot": {"port": 19012},
}  # fmt: skip
"""What has no default, and ports that no other program has; addresses are the defaults."""
GROUP = "239.255.76.67"  # LCM's: receives what others on the network send there, and the door says so
NOT_FINITE = (float("nan"), float("inf"), -float("inf"))


@cache
def simulation(vehicle: str) -> pl.Simulation:
    dvl = {"dvl": {"type": "dvl", "device": "waterlinked_a50", "rate_hz": 5}}
    agent = {"vehicle": vehicle, "start": {"position_m": [3, -2], "depth_m": 4}, "sensors": dvl}
    return pl.Simulation.load({"tick_rate_hz": 100, "world": {"type": "flat", "depth_m": 20.0}, "agents": {"a": agent}})


@pytest.fixture
def exchange(request: pytest.FixtureRequest) -> Iterator[Exchange]:
    made = Exchange(simulation("remus100" if request.node.callspec.params["kind"] == "moos" else "bluerov2"))
    yield made
    made.close()


def opened(exchange: Exchange, kind: str, **keys: Any) -> str:
    config = registry.find("bridge", kind).config.model_validate({"type": kind, **OWN_PORT.get(kind, {}), **keys})
    try:
        return str(config.attach(exchange))
    except BridgeError as error:
        if "needs the extra" in str(error) or "multicast" in str(error):
            pytest.skip(str(error))
        raise


def bound() -> set[tuple[str, int, bool]]:
    """Address and port where this process listens (TCP) or receives (UDP), and whether from the loopback alone."""
    found = set()
    for entry in Path("/proc/self/fd").iterdir():
        with suppress(OSError):
            if not str(entry.readlink()).startswith("socket:"):
                continue
            with socket.socket(fileno=os.dup(int(entry.name))) as s:
                if s.family not in (socket.AF_INET, socket.AF_INET6):
                    continue
                host, port = s.getsockname()[:2]
                listens = s.getsockopt(socket.SOL_SOCKET, socket.SO_ACCEPTCONN)
                device = s.getsockopt(socket.SOL_SOCKET, dds_loopback.SO_BINDTODEVICE, 16)
                if port and (listens or s.type == socket.SOCK_DGRAM):
                    found.add((host, port, device == dds_loopback.LO))
    return found


@pytest.mark.skipif(sys.platform != "linux", reason="reads /proc")
@pytest.mark.parametrize("kind", KINDS)
def test_a_door_stands_on_this_machine_unless_told(kind: str, exchange: Exchange) -> None:
    before = bound()
    said = opened(exchange, kind)
    open_to_others = [
        (host, port)
        for host, port, alone in bound() - before
        if not (host.startswith("127.") or host == "::1" or alone)
    ]
    if kind == "lcm":
        assert {host for host, _ in open_to_others} <= {GROUP, "0.0.0.0"}
        assert "open to the network, without passwords" in said
    else:
        assert open_to_others == []
        assert "network" not in said


@pytest.mark.parametrize("kind", KINDS)
def test_a_door_that_is_open_to_the_network_says_so(kind: str, exchange: Exchange) -> None:
    """None of these protocols knows a token or a password."""
    elsewhere = {"mavlink": "192.0.2.7", "moos": "192.0.2.7"}  # clients: documentation's addresses
    keys: dict[str, Any] = {"host": elsewhere.get(kind, "0.0.0.0")}
    if kind == "ros2":
        keys = {"network": "open", "domain_id": DOMAIN + 1}
    elif kind in ("lcm", "instrument"):
        keys = {} if kind == "lcm" else {"port": "udp-server:0.0.0.0:0"}
    assert "without passwords" in opened(exchange, kind, **keys)


# numbers that are not finite


MARK = 7.25
SAID: dict[str, dict[str, Any]] = {
    "geometry_msgs/msg/Twist": {"linear": {"x": 0.1, "y": MARK}},
    "geometry_msgs/msg/TwistStamped": {"twist": {"angular": {"x": 0.1, "z": MARK}}},
    "geometry_msgs/msg/WrenchStamped": {"wrench": {"force": {"x": 1.0}, "torque": {"y": MARK}}},
    "geometry_msgs/msg/PoseStamped": {"pose": {"position": {"x": 1.0, "y": MARK}, "orientation": {"w": 1.0}}},
    "geometry_msgs/msg/PointStamped": {"point": {"x": 1.0, "z": MARK}},
    "std_msgs/msg/Float64MultiArray": {"data": [0.1, -0.2, MARK, 0.0, 0.1, 0.2]},
    "std_msgs/msg/Float64": {"data": MARK},
}


def commands(number: float) -> Iterator[tuple[str, str, bytes]]:
    """Topic, type and bytes of each command with one number that is not finite."""
    for name, (kind, _) in command_topics(simulation("bluerov2"), "a").items():
        if kind != "std_msgs/msg/String":
            raw = bytes(serialize(kind, from_json(kind, SAID[kind])))
            assert raw.count(struct.pack("<d", MARK)) == 1
            yield f"/a/{name}", kind, raw.replace(struct.pack("<d", MARK), struct.pack("<d", number))


def by_cdr(exchange: Exchange, number: float) -> int:
    """ROS 2, whatever carries it."""
    transport = MemoryTransport()
    listen(transport, exchange.sim, exchange.inbox)
    told = list(commands(number))
    for topic, _, raw in told:
        transport.say(topic, raw)
        exchange.inbox.drain()
    return len(told)


def by_lcm(exchange: Exchange, number: float) -> int:
    opened(exchange, "lcm", url="memq://")
    transport: Any = exchange.doors[0].transport  # type: ignore[attr-defined]
    told = list(commands(number))
    refused = exchange.inbox.refused
    for count, (topic, kind, raw) in enumerate(told, start=1):
        transport.lcm.publish(topic, encode("message_t", {"t_ns": 1, "type": kind, "size": len(raw), "cdr": raw}))
        for _ in range(500):
            exchange.inbox.drain()
            if refused.total() >= count:
                break
            threading.Event().wait(0.01)
    return len(told)


def by_foxglove(exchange: Exchange, number: float) -> int:
    opened(exchange, "foxglove")
    transport: Any = exchange.doors[0].transport  # type: ignore[attr-defined]
    told = list(commands(number))
    for topic, kind, raw in told:
        transport.heard(topic, "cdr", kind, raw)
        exchange.inbox.drain()
    return len(told)


def by_rosbridge(exchange: Exchange, number: float) -> int:
    """Python's JSON has the words NaN and Infinity, and other programs' too."""
    opened(exchange, "rosbridge")
    transport: Any = exchange.doors[0].transport  # type: ignore[attr-defined]
    silent: Any = SimpleNamespace(send=lambda text: None, socket=SimpleNamespace(close=lambda: None))
    client = Client(silent, transport._operations(), exchange.inbox.refused)
    said = [
        ("cmd_vel", {"linear": {"x": 0.1, "y": number}}), ("cmd_wrench", {"wrench": {"force": {"z": number}}}),
        ("setpoint/depth", {"data": number}), ("cmd_actuators", {"data": [0.1, number, 0, 0, 0, 0]}),
        ("cmd_waypoint", {"point": {"x": number}}),
    ]  # fmt: skip
    for name, message in said:
        client.take(json.dumps({"op": "publish", "topic": f"/a/{name}", "msg": message}))
        exchange.inbox.drain()
    client.close()
    return len(said)


def by_mavlink(exchange: Exchange, number: float) -> int:
    opened(exchange, "mavlink", port=14599)
    from pymavlink.dialects.v20 import common

    sender, door = common.MAVLink(None, srcSystem=255, srcComponent=190), exchange.doors[0]
    place = (0, 1, 1, 1, 0b110111111000, 4.0, number, 3.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
    speed = (0, 1, 1, 8, 0b010111000111, 0.0, 0.0, 0.0, 0.3, 0.1, number, 0.0, 0.0, 0.0, 0.0, 0.1)
    for given in (place, speed):
        door.take(common.MAVLink_set_position_target_local_ned_message(*given).pack(sender))  # type: ignore[attr-defined]
        exchange.inbox.drain()
    return 2


def by_px4(exchange: Exchange, number: float) -> int:
    opened(exchange, "px4")
    from pymavlink.dialects.v20 import common

    link: Any = exchange._drivers[0]
    sender = common.MAVLink(None, srcSystem=1, srcComponent=1)
    link.take(common.MAVLink_hil_actuator_controls_message(4000, [0.5, number] * 8, 128, 1).pack(sender))
    return 1


def by_moos(exchange: Exchange, number: float) -> int:
    """A database that greets, and tells the helm's thrust."""
    with socket.create_server(("127.0.0.1", 0)) as database:
        opened(exchange, "moos", port=database.getsockname()[1])
        database.settimeout(20)
        link, _ = database.accept()
        with link:
            link.settimeout(20)
            link.recv(len(HELLO) + 4096)
            link.sendall(pack([MoosMessage(NOTIFY, "WELCOME")]))
            link.recv(65536)
            link.sendall(pack([MoosMessage(NOTIFY, "DESIRED_THRUST", number)]))
            for _ in range(500):
                if exchange.inbox.refused:
                    break
                threading.Event().wait(0.01)
    return 1


NO_NUMBERS: dict[str, str] = {
    "ardupilot": "pulses are whole numbers of 16 bits",
    "instrument": "requests set an instrument, and no vehicle; texts of numbers that are not finite: its own tests",
}
ATTACKS: dict[str, Callable[[Exchange, float], int]] = {
    "ros2": by_cdr, "lcm": by_lcm, "foxglove": by_foxglove, "rosbridge": by_rosbridge, "mavlink": by_mavlink,
    "px4": by_px4, "moos": by_moos,
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("number", NOT_FINITE)
def test_a_number_that_is_not_finite_is_refused_and_reported(kind: str, number: float, exchange: Exchange) -> None:
    """Nothing is obeyed, the state stays, and the report at the end has one count for each that was sent."""
    if kind in NO_NUMBERS:
        return
    pytest.importorskip("pymavlink") if kind in ("mavlink", "px4") else None
    sim = exchange.sim
    sim.reset()
    before = sim.stepper.row("a").copy()
    sent = ATTACKS[kind](exchange, number)
    np.testing.assert_array_equal(sim.stepper.row("a"), before)
    assert not exchange.inbox.obeyed
    report = exchange.close()
    assert sum(count for reason, count in report.items() if "nobody" not in reason and "no talk" not in reason) >= sent


def test_every_door_is_attacked_or_says_why_not() -> None:
    assert set(KINDS) == set(ATTACKS) | set(NO_NUMBERS)

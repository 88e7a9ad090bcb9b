"""Packets from a network with whatever may be wrong with them: every parser counts or refuses them, and goes on.

CI tries a few thousand for each parser; `python tests/fuzz/test_bridges.py 1000000` tries a million.
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any, cast

import numpy as np
import pytest

from pelagos.bridges.ardupilot_json import parse_servos
from pelagos.bridges.inbox import Inbox
from pelagos.bridges.instruments import ping
from pelagos.bridges.instruments.ping_devices import Ping1d, Ping360
from pelagos.bridges.instruments.speakers import WaterLinkedSerial
from pelagos.bridges.lcm_transport import payload
from pelagos.bridges.moos_wire import NOTIFY, MoosMessage, pack, unpack
from pelagos.bridges.ros_commands import command_topics, received
from pelagos.messages.lcm import encode
from pelagos.messages.store import make, serialize, vector3

PACKETS = 3000
Feed = Callable[[bytes], object]


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
    config = SimpleNamespace(range_min_m=0.5, range_max_m=40.0)
    device = kind(SimpleNamespace(config=config))
    rng = np.random.Generator(np.random.PCG64(5))
    device.hear(SimpleNamespace(data=rng.random((1, 60)), t_ns=0, extras={"angle": np.array([0.3])}))
    transducer = struct.pack("<BBHHHHHBB", 1, 2, 200, 30, 700, 750, 300, 1, 0)
    asked = [(n, b"") for n in (4, 5, 1200, 1203, 1204, 1207, 1210, 1211, 1212, 1300, 2300)]
    asked += [(1001, struct.pack("<II", 500, 9000)), (1002, struct.pack("<I", 1_480_000)), (1003, b"\1"), (1005, b"\2")]
    asked += [(1004, struct.pack("<H", 90)), (6, struct.pack("<H", 1300)), (1400, struct.pack("<H", 1300))]
    return device.answer, [ping.frame(number, data) for number, data in [*asked, (2601, transducer)]]


def a50() -> tuple[Feed, list[bytes]]:
    return WaterLinkedSerial(cast(Any, SimpleNamespace())).answer, [b"wcv\r\n", b"wcv*2d\r\nwcs\r\n"]


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


PARSERS: dict[str, Callable[[], tuple[Feed, list[bytes]]]] = {
    "ardupilot": servos, "moos": moos, "lcm": lcm, "ping1d": lambda: ping_device(Ping1d),
    "ping360": lambda: ping_device(Ping360), "a50": a50, "commands": commands,
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


def attack(name: str, packets: int, seed: int) -> None:
    feed, good = PARSERS[name]()
    rng = np.random.Generator(np.random.PCG64(seed))
    for number in range(packets):
        raw = damaged(good[number % len(good)], rng)
        try:
            feed(raw)
        except Exception as error:
            raise AssertionError(f"{name}, packet {number} of seed {seed}: {raw.hex()}") from error


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

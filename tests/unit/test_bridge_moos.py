"""MOOS against a stand-in for the MOOSDB, written from core-moos's packets with its own packing."""

from __future__ import annotations

import contextlib
import math
import socket
import struct
import threading
import time
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.moos import MoosConfig, mixer_of, nav_of
from pelagos.bridges.moos_wire import NOTIFY, MoosMessage, pack, unpack
from pelagos.bridges.transport import BridgeError


def scenario(vehicle: str, z: float) -> dict[str, Any]:
    return {"tick_rate_hz": 100, "world": {"type": "flat", "depth_m": 50.0}, "agents": {"a": {
        "vehicle": vehicle, "start": {"position_m": [3, -2, z], "heading_deg": 30, "speed_mps": 1.0},
        "control": "actuators"}}}  # fmt: skip


class FakeDb:
    """Answers every packet with one; says what a helm wants, and keeps what it is told."""

    def __init__(self, desired: dict[str, float]) -> None:
        self.server = socket.create_server(("127.0.0.1", 0))
        self.port = self.server.getsockname()[1]
        self.desired, self.heard, self.registered = desired, {}, set()
        self.hello = b""
        self.thread = threading.Thread(target=self.run, daemon=True)
        self.thread.start()

    def text(self, value: bytes) -> bytes:
        return struct.pack("<i", len(value)) + value

    def message(self, kind: bytes, key: bytes, value: float) -> bytes:
        body = struct.pack("<i", 7) + kind + b"D" + self.text(b"pHelmIvP") + self.text(b"") + self.text(b"auv")
        body += self.text(key) + struct.pack("<ddd", 1.0, value, -1.0) + self.text(b"")
        return struct.pack("<i", len(body) + 4) + body

    def packet(self, *messages: bytes) -> bytes:
        body = b"".join(messages)
        return struct.pack("<iiB", len(body) + 9, len(messages), 0) + body

    def read(self, link: socket.socket) -> bytes:
        raw = link.recv(4, socket.MSG_WAITALL)
        if len(raw) < 4:
            return b""
        return raw + link.recv(struct.unpack("<i", raw)[0] - 4, socket.MSG_WAITALL)

    def take(self, packet: bytes) -> None:
        at = 9
        for _ in range(struct.unpack_from("<i", packet, 4)[0]):
            size, kind = struct.unpack_from("<i", packet, at)[0], packet[at + 8 : at + 9]
            place, key = at + 10, b""
            for _ in range(4):
                length = struct.unpack_from("<i", packet, place)[0]
                key = packet[place + 4 : place + 4 + length]
                place += 4 + length
            value = struct.unpack_from("<d", packet, place + 8)[0]
            if kind == b"N":
                self.heard[key.decode()] = value
            elif kind == b"R":
                self.registered.add(key.decode())
            at += size

    def run(self) -> None:
        link, _ = self.server.accept()
        with link:
            self.hello = link.recv(32, socket.MSG_WAITALL)
            self.read(link)
            link.sendall(self.packet(self.message(b"W", b"", 0.0)))
            while True:
                packet = self.read(link)
                if not packet:
                    break
                self.take(packet)
                link.sendall(self.packet(*(self.message(b"N", k.encode(), v) for k, v in self.desired.items())))
        self.server.close()


def test_a_helm_drives_a_vehicle() -> None:
    """East is minus west; a positive rudder turns to starboard; depth is positive down."""
    sim = pl.Simulation.load(scenario("remus100", -10.0))
    db = FakeDb({"DESIRED_THRUST": 80.0, "DESIRED_RUDDER": 10.0, "DESIRED_ELEVATOR": 0.0})
    exchange = Exchange(sim, realtime=4.0)
    MoosConfig(type="moos", port=db.port).attach(exchange)
    exchange.run(8.0)
    time.sleep(0.2)
    exchange.close()
    assert db.hello.rstrip(b"\0") == b"ELKS CAN'T DANCE 2/8/10"
    assert db.registered == {"DESIRED_THRUST", "DESIRED_RUDDER", "DESIRED_ELEVATOR"}
    state = sim.state["a"]
    assert db.heard["NAV_DEPTH"] == pytest.approx(-state.position[0, 2], abs=0.5)
    assert db.heard["NAV_X"] == pytest.approx(-state.position[0, 1], abs=1.5)
    assert db.heard["NAV_Y"] == pytest.approx(state.position[0, 0], abs=1.5)
    assert db.heard["NAV_YAW"] == pytest.approx(math.pi / 2 + state.euler[0, 2], abs=0.3)  # from east, to the left
    heading = math.degrees(-state.euler[0, 2])
    assert (heading - 30) % 360 < 180  # it turned to starboard
    assert (heading - 30) % 360 > 5
    assert db.heard["NAV_SPEED"] > 0.8


@pytest.mark.parametrize(("heading_deg", "yaw_deg"), [(0, 90), (70, 20), (135, -45), (190, -100), (300, 150)])
def test_nav_yaw_counts_from_east_against_the_clock(heading_deg: float, yaw_deg: float) -> None:
    """As MOOS-IvP's headingToRadians has it: -180 to 180 degrees."""
    yaw = math.radians(heading_deg)
    sim = pl.Simulation.load(scenario("remus100", -10.0))
    sim.set_state("a", attitude=[math.cos(yaw / 2), 0.0, 0.0, -math.sin(yaw / 2)])
    assert math.degrees(nav_of(sim, "a")["NAV_YAW"]) == pytest.approx(yaw_deg)
    assert nav_of(sim, "a")["NAV_HEADING"] == pytest.approx(heading_deg)


def test_a_positive_elevator_dives_and_boats_turn_by_two_thrusters() -> None:
    sim = pl.Simulation.load(scenario("remus100", -10.0))
    sim.command({"a": mixer_of(sim, "a")(80.0, 0.0, 8.0)})
    sim.run(6.0)
    dived = -sim.state["a"].position[0, 2]
    sim.reset()
    sim.command({"a": mixer_of(sim, "a")(80.0, 0.0, -8.0)})
    sim.run(6.0)
    assert dived > -sim.state["a"].position[0, 2] + 0.2
    boat = pl.Simulation.load(scenario("otter", 0.0))
    boat.command({"a": mixer_of(boat, "a")(40.0, 20.0, 0.0)})
    boat.run(4.0)
    assert boat.state["a"].angular_velocity[0, 2] < -0.02
    rov = pl.Simulation.load(scenario("bluerov2", -5.0))
    with pytest.raises(BridgeError, match="a helm needs"):
        mixer_of(rov, "a")


def test_packets_are_read_back_and_damaged_ones_refused() -> None:
    sent = [MoosMessage(NOTIFY, "A", 1.25, "", "me", 3.5, 4), MoosMessage(NOTIFY, "B", 0.0, "text", "me", 1.0, 5, True)]
    good = pack(sent)
    assert unpack(good) == sent
    rng = np.random.Generator(np.random.PCG64(5))
    for _ in range(20_000):
        bad = bytearray(good)
        bad[int(rng.integers(0, len(bad)))] = int(rng.integers(0, 256))
        with contextlib.suppress(ValueError):
            assert len(unpack(bytes(bad))) <= 2
    for cut in range(len(good)):
        with pytest.raises(ValueError, match=r"."):
            unpack(good[:cut])


def test_without_a_database_the_run_goes_on() -> None:
    sim = pl.Simulation.load(scenario("remus100", -10.0))
    exchange = Exchange(sim)
    MoosConfig(type="moos", port=1).attach(exchange)
    assert exchange.run(2.0).simulated_s == pytest.approx(2.0)
    assert any("no talk" in reason for reason in exchange.close())

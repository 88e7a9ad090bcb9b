"""rosbridge against roslibpy, a client of other people; and what a program that means harm may try."""

from __future__ import annotations

import base64
import json
import socket
import struct
import time
from collections.abc import Callable, Iterator
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.rosbridge import RosbridgeConfig, RosbridgeTransport
from pelagos.bridges.transport import LATCHED, Qos
from pelagos.errors import InputError
from pelagos.messages.json_form import from_json, to_json
from pelagos.messages.store import deserialize, header, make, serialize

roslibpy = pytest.importorskip("roslibpy")
client = pytest.importorskip("websockets.sync.client")

IMAGE, TWIST = "sensor_msgs/msg/Image", "geometry_msgs/msg/Twist"
SCENARIO: dict[str, Any] = {
    "tick_rate_hz": 50,
    "world": {"type": "flat", "depth_m": 50},
    "agents": {
        "rov": {
            "vehicle": "bluerov2",
            "start": {"position_m": [3, -4], "depth_m": 5, "heading_deg": 30},
            "control": "velocity",
            "sensors": {"depth": {"type": "depth", "rate_hz": 10}},
        }
    },
}


def until(true: Callable[[], object], seconds: float = 30.0) -> None:
    end = time.monotonic() + seconds
    while not true():
        assert time.monotonic() < end, "waited in vain"
        time.sleep(0.01)


@pytest.fixture
def door() -> Iterator[RosbridgeTransport]:
    made = RosbridgeTransport(port=0)
    yield made
    made.close()


def link(door: RosbridgeTransport, **options: Any) -> Any:
    return client.connect(f"ws://127.0.0.1:{door.port}", **options)


def ask(wire: Any, **message: Any) -> dict[str, Any]:
    wire.send(json.dumps(message))
    found: dict[str, Any] = json.loads(wire.recv(timeout=20))
    return found


@pytest.fixture(scope="module")
def ros() -> Iterator[Any]:
    """A run with the door open, and roslibpy at it: one for the file, its event loop starts once a process."""
    exchange = Exchange(pl.Simulation.load(SCENARIO), realtime=1.0)
    said = RosbridgeConfig(type="rosbridge", port=0).attach(exchange)
    peer = roslibpy.Ros("127.0.0.1", int(said.rpartition(":")[2]))
    peer.run(timeout=30)
    yield peer, exchange
    peer.close()
    exchange.close()


def test_roslibpy_sees_drives_and_asks(ros: Any) -> None:
    peer, exchange = ros
    odometry: list[Any] = []
    answers: list[Any] = []
    truth = roslibpy.Topic(peer, "/rov/truth", "nav_msgs/Odometry")
    command = roslibpy.Topic(peer, "/rov/cmd_vel", "geometry_msgs/Twist")
    truth.subscribe(odometry.append)

    def speak(sim: pl.Simulation) -> None:
        if sim.time_ns == 500_000_000:
            command.publish({"linear": {"x": 0.5, "y": -0.2}, "angular": {"z": -0.1}})
            service = roslibpy.Service(
                peer, "/pelagos/get_simulation_state", "simulation_interfaces/GetSimulationState"
            )
            service.call(roslibpy.ServiceRequest(), answers.append, answers.append)

    def enough(sim: pl.Simulation) -> None:
        if sim.held_command("rov")[0, 0] and answers and odometry:
            sim.stop()

    exchange.sim.on_tick(speak, rate_hz=2)
    exchange.sim.on_tick(enough, rate_hz=10)
    exchange.run(30.0)
    names = exchange.sim.model.agents["rov"].vehicle.command_names("velocity")
    held = dict(zip(names, exchange.sim.held_command("rov")[0], strict=True))
    assert held["surge_speed"] == 0.5
    assert abs(held["sway_speed"]) == pytest.approx(0.2)
    assert abs(held["yaw_rate"]) == pytest.approx(0.1)
    assert answers[0]["result"]["result"] == 1
    place = odometry[0]["pose"]["pose"]["position"]
    assert (place["x"], place["y"], place["z"]) == pytest.approx((4.0, 3.0, -5.0), abs=0.1)  # east, north, up
    assert "/rov/truth" in peer.get_topics()


@pytest.mark.parametrize(
    "name", [TWIST, IMAGE, "sensor_msgs/msg/Imu", "tf2_msgs/msg/TFMessage", "nav_msgs/msg/Odometry"]
)
def test_what_is_left_out_is_empty_and_the_rest_comes_back(name: str) -> None:
    empty = from_json(name, {})
    raw = serialize(name, empty)
    assert serialize(name, from_json(name, json.loads(json.dumps(to_json(deserialize(name, raw)))))) == raw


def test_what_is_said_has_the_fields_of_the_type_and_no_constants() -> None:
    """rosbridge sends fields alone; sensor_msgs/BatteryState defines 27 constants besides its 16 fields."""
    kind = "sensor_msgs/msg/BatteryState"
    said = to_json(deserialize(kind, bytes(serialize(kind, from_json(kind, {"voltage": 14.5, "present": True})))))
    assert list(said) == [
        "header", "voltage", "temperature", "current", "charge", "capacity", "design_capacity", "percentage",
        "power_supply_status", "power_supply_health", "power_supply_technology", "present", "cell_voltage",
        "cell_temperature", "location", "serial_number",
    ]  # fmt: skip
    assert (said["voltage"], said["present"], list(said["header"])) == (14.5, True, ["stamp", "frame_id"])


def test_pictures_are_base64_and_what_is_no_number_is_null() -> None:
    pixels = np.array([7, 250, 3, 0], dtype=np.uint8)
    about = {"height": 2, "width": 2, "encoding": "mono8", "is_bigendian": 0, "step": 2}
    said = to_json(make(IMAGE, header=header("c", 3_000_000_007), data=pixels, **about))
    assert (said["data"], said["header"]["stamp"]) == (
        base64.b64encode(b"\x07\xfa\x03\x00").decode(),
        {"sec": 3, "nanosec": 7},
    )
    assert from_json(IMAGE, said).data.tolist() == [7, 250, 3, 0]
    state = to_json(
        make("sensor_msgs/msg/Range", **{**vars(from_json("sensor_msgs/msg/Range", {})), "range": float("inf")})
    )
    assert state["range"] is None
    one_lost = np.array([1.5, np.nan, -np.inf, -2.0], dtype=np.float32)
    readings = make(
        "sensor_msgs/msg/LaserScan", **{**vars(from_json("sensor_msgs/msg/LaserScan", {})), "ranges": one_lost}
    )
    assert to_json(readings)["ranges"] == [1.5, None, None, -2.0]


@pytest.mark.parametrize(
    ("name", "data", "text"),
    [
        (TWIST, {"linea": {}}, "did you mean 'linear'"),
        (TWIST, {"linear": {"x": "fast"}}, "linear.*number is wanted"),
        (TWIST, {"linear": [1, 2, 3]}, "object of fields"),
        (IMAGE, {"data": "no base 64!"}, "base64"),
        (IMAGE, {"height": -1}, "from 0 to 4294967295"),
        (IMAGE, {"height": 1.5}, "whole number"),
        ("sensor_msgs/msg/Imu", {"orientation_covariance": [1, 2]}, "9 numbers are wanted, not 2"),
        ("tf2_msgs/msg/TFMessage", {"transforms": 3}, "list is wanted"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_said(name: str, data: Any, text: str) -> None:
    with pytest.raises(InputError, match=text):
        from_json(name, data)


def test_late_clients_get_what_is_latched_and_who_left_gets_nothing(door: RosbridgeTransport) -> None:
    text = "std_msgs/msg/String"
    write = door.advertise("/labels", text, qos=LATCHED)
    write(serialize(text, make(text, data="rock")), 0)
    with link(door) as wire:
        assert ask(wire, op="subscribe", topic="/labels") == {
            "op": "publish",
            "topic": "/labels",
            "msg": {"data": "rock"},
        }
        wire.send(json.dumps({"op": "unsubscribe", "topic": "/labels"}))
        assert ask(wire, op="subscribe", topic="/label")["level"] == "warning"
        write(serialize(text, make(text, data="sand")), 0)
        with pytest.raises(TimeoutError):
            wire.recv(timeout=0.3)


def test_nonsense_is_counted_and_the_door_stays_open(door: RosbridgeTransport) -> None:
    got: list[bytes] = []
    door.subscribe("/rov/cmd_vel", TWIST, got.append, qos=Qos())
    random = np.random.default_rng(3)
    with link(door) as wire:
        for said in (
            "{",
            "[]",
            "3",
            '{"op": 7}',
            '{"op": "fragment"}',
            '{"op": "call_service", "service": "/rosapi/topic_type", "args": [1]}',
            '{"op": "publish", "topic": "/rov/cmd_vel", "msg": {"linear": {"x": [Infinity]}}}',
            "[" * 50_000,
            '{"op":"publish","topic":"/rov/cmd_vel","msg":4}',
        ):
            wire.send(said)
            assert json.loads(wire.recv(timeout=20))["level"] == "error"
        for size in random.integers(1, 200, 100):
            wire.send(random.bytes(int(size)))
            assert json.loads(wire.recv(timeout=20))["op"] == "status"
        assert "did you mean" in ask(wire, op="publish", topic="/rov/cmd_ve", msg={})["msg"]
        assert "compression" in ask(wire, op="subscribe", topic="/rov/cmd_vel", compression="png")["msg"]
        wire.send(json.dumps({"op": "publish", "topic": "/rov/cmd_vel", "msg": {"linear": {"x": -1.5}}}))
        until(lambda: got)
    assert deserialize(TWIST, got[0]).linear.x == -1.5
    assert door.troubles["malformed packets"] > 90


def test_who_calls_gets_an_answer_and_another_type_is_refused(door: RosbridgeTransport) -> None:
    steps, got = "simulation_interfaces/srv/StepSimulation", list[bytes]()
    door.serve("/pelagos/step_simulation", steps, lambda request: request)
    door.subscribe("/rov/cmd_vel", TWIST, got.append, qos=Qos())
    door.advertise("/rov/truth", "nav_msgs/msg/Odometry", qos=Qos())
    with link(door) as wire:
        for wrong in (-1, 2.5, True, "7"):
            told = ask(wire, op="call_service", service="/pelagos/step_simulation", id="a", args={"steps": wrong})
            assert (told["op"], told["result"], told["id"]) == ("service_response", False, "a")
            assert "steps: a" in told["values"]
        for said in (
            {"op": "subscribe", "topic": "/rov/truth", "type": "std_msgs/String"},
            {"op": "advertise", "topic": "/rov/cmd_vel", "type": "std_msgs/msg/String"},
            {"op": "publish", "topic": "/rov/cmd_vel", "type": "std_msgs/String", "msg": {}},
        ):
            assert "not of 'std_msgs" in ask(wire, **said)["msg"]
        for said in ({"op": "subscribe"}, {"op": "subscribe", "topic": 5}, {"op": "publish", "topic": ""}):
            assert "a topic, such as '/name', is wanted" in ask(wire, **said)["msg"]
        assert "throttle_rate" in ask(wire, op="subscribe", topic="/rov/truth", throttle_rate=-5)["msg"]
        wire.send(json.dumps({"op": "subscribe", "topic": "/rov/truth", "type": "nav_msgs/Odometry"}))
        wire.send(json.dumps({"op": "publish", "topic": "/rov/cmd_vel", "type": "geometry_msgs/Twist"}))
        until(lambda: got)
        assert [list(client._wanted) for client in door._clients] == [["/rov/truth"]]


def test_who_breaks_off_or_speaks_something_else_says_nothing_to_the_user(
    door: RosbridgeTransport, caplog: pytest.LogCaptureFixture
) -> None:
    for said in (b"", b"GET / HTTP/1.0\r\n\r\n", bytes(range(256))):
        with socket.create_connection(("127.0.0.1", door.port)) as wire:
            wire.sendall(said)
    with link(door, close_timeout=0.1) as wire:
        wire.socket.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, struct.pack("ii", 1, 0))
        wire.socket.close()  # without a farewell
    until(lambda: not door._clients)
    assert not [r for r in caplog.records if r.name != "websockets.client"]  # the test's own, before websockets 17.4


def test_web_pages_of_other_machines_are_refused(door: RosbridgeTransport) -> None:
    from websockets.exceptions import InvalidStatus

    with pytest.raises(InvalidStatus), link(door, origin="https://elsewhere.example.org"):
        pass
    assert door.troubles["web pages of elsewhere.example.org refused"] == 1
    with link(door, origin="http://localhost:8000"):
        pass


@pytest.mark.parametrize(
    ("asked", "passed"),
    [
        ({"throttle_rate": 250}, [0, 260, 520]),  # a message is due again 250 ms after the last that was sent
        ({"throttle_rate": 90.5}, [0, 100, 249, 350, 501]),
        ({"throttle_rate": 0}, [0, 90, 100, 249, 260, 350, 501, 509, 520]),
        ({}, [0, 90, 100, 249, 260, 350, 501, 509, 520]),
    ],
)
def test_a_client_may_ask_for_messages_at_most_every_so_many_milliseconds(
    door: RosbridgeTransport, monkeypatch: pytest.MonkeyPatch, asked: dict[str, Any], passed: list[int]
) -> None:
    text, clock = "std_msgs/msg/String", SimpleNamespace(now=70.0)
    monkeypatch.setattr("pelagos.bridges.rosbridge_client.time", SimpleNamespace(monotonic=lambda: clock.now))
    write = door.advertise("/labels", text, qos=Qos())
    with link(door) as wire:
        wire.send(json.dumps({"op": "subscribe", "topic": "/labels", **asked}))
        until(lambda: any(c._wanted for c in door._clients))
        for ms in (0, 90, 100, 249, 260, 350, 501, 509, 520):
            clock.now = 70.0 + 1e-3 * ms
            write(serialize(text, make(text, data=str(ms))), 0)
        got = [int(json.loads(wire.recv(timeout=20))["msg"]["data"]) for _ in passed]
        assert got == passed
        assert ask(wire, op="subscribe", topic="/label")["level"] == "warning"  # nothing else had been sent before it


def test_a_client_that_does_not_read_slows_nobody_and_loses_the_oldest(door: RosbridgeTransport) -> None:
    write = door.advertise("/camera", IMAGE, qos=Qos(depth=5))
    about = {"height": 1024, "width": 1024, "encoding": "mono8", "is_bigendian": 0, "step": 1024}
    raw = serialize(IMAGE, make(IMAGE, header=header("c"), data=np.zeros(1 << 20, dtype=np.uint8), **about))
    with link(door, max_queue=1, close_timeout=0.1) as wire:
        wire.send(json.dumps({"op": "subscribe", "topic": "/camera", "queue_length": 3}))
        until(lambda: any(c._wanted for c in door._clients))
        for _ in range(60):  # ten times what sockets hold
            write(raw, 0)
        assert door.troubles["/camera: dropped"] >= 40

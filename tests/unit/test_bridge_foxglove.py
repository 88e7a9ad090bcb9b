"""Foxglove's WebSocket, read by a client written from the protocol's text on `websockets` alone."""

from __future__ import annotations

import json
import struct
import threading
import time
from typing import Any

import numpy as np
import pytest
from mcap_ros2._dynamic import generate_dynamic

import pelagos as pl
from pelagos.bridges.exchange import Exchange
from pelagos.messages.store import make, serialize, vector3

pytest.importorskip("foxglove")
client = pytest.importorskip("websockets.sync.client")

from pelagos.bridges.foxglove_transport import FoxgloveConfig  # noqa: E402

SCENARIO: dict[str, Any] = {
    "tick_rate_hz": 100, "world": {"type": "flat", "depth_m": 20.0},
    "agents": {"rov": {
        "vehicle": "bluerov2_heavy", "start": {"position_m": [3, -2], "depth_m": 5.0}, "control": "velocity",
        "sensors": {"imu": {"type": "imu", "rate_hz": 50}},
    }},
}  # fmt: skip


class Viewer:
    """What a viewer does: learn the channels, subscribe, decode."""

    def __init__(self, port: int) -> None:
        self.held = client.connect(f"ws://127.0.0.1:{port}", subprotocols=["foxglove.sdk.v1"], max_size=None,
                                   close_timeout=0.3)  # fmt: skip
        self.socket = self.held.__enter__()
        self.channels: dict[str, dict[str, Any]] = {}
        self.services: dict[str, dict[str, Any]] = {}
        self.got: dict[int, list[tuple[int, bytes]]] = {}
        self.answers: list[bytes] = []
        self.times: list[int] = []

    def read(self, seconds: float) -> None:
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            try:
                said = self.socket.recv(timeout=0.05)
            except TimeoutError:
                continue
            if isinstance(said, str):
                op = json.loads(said)
                if op["op"] == "advertise":
                    self.channels |= {c["topic"]: c for c in op["channels"]}
                elif op["op"] == "advertiseServices":
                    self.services |= {s["name"]: s for s in op["services"]}
            elif said[0] == 1:  # message data: subscription, log time, payload
                number, t_ns = struct.unpack_from("<IQ", said, 1)
                self.got.setdefault(number, []).append((t_ns, said[13:]))
            elif said[0] == 2:  # time
                self.times.append(struct.unpack_from("<Q", said, 1)[0])
            elif said[0] == 3:  # service response: service, call, encoding, payload
                length = struct.unpack_from("<I", said, 9)[0]
                self.answers.append(said[13 + length :])

    def subscribe(self, **numbers: str) -> None:
        wanted = [{"id": int(n[1:]), "channelId": self.channels[t]["id"]} for n, t in numbers.items()]
        self.socket.send(json.dumps({"op": "subscribe", "subscriptions": wanted}))

    def decode(self, topic: str, raw: bytes) -> Any:
        channel = self.channels[topic]
        text = channel["schema"]
        return generate_dynamic(channel["schemaName"], text)[channel["schemaName"]](raw)

    def publish(self, topic: str, type_name: str, payload: bytes, *, number: int = 9) -> None:
        channel = {"id": number, "topic": topic, "encoding": "cdr", "schemaName": type_name}
        self.socket.send(json.dumps({"op": "advertise", "channels": [channel]}))
        self.socket.send(b"\x01" + struct.pack("<I", number) + payload)

    def call(self, service: str, payload: bytes) -> None:
        number = self.services[service]["id"]
        self.socket.send(b"\x02" + struct.pack("<III", number, 1, 3) + b"cdr" + payload)


def test_a_viewer_sees_commands_and_calls() -> None:
    sim = pl.Simulation.load(SCENARIO)
    exchange = Exchange(sim, realtime=1.0)
    text = FoxgloveConfig(type="foxglove", port=0).attach(exchange)
    port = int(text.rpartition(":")[2])
    failure: list[BaseException] = []
    seen: dict[str, Any] = {}

    def script() -> None:
        try:
            while sim.time_ns < 1e8:
                time.sleep(0.01)
            viewer = Viewer(port)
            viewer.read(0.3)
            viewer.subscribe(_1="/rov/imu/data_raw", _2="/tf_static", _3="/rov/truth")
            twist = make("geometry_msgs/msg/Twist", linear=vector3(0.4, 0, 0), angular=vector3(0, 0, 0))
            viewer.publish("/rov/cmd_vel", "geometry_msgs/Twist", serialize("geometry_msgs/msg/Twist", twist))
            viewer.publish("/rov/cmd_vell", "geometry_msgs/msg/Twist", b"", number=11)
            viewer.publish("/rov/cmd_vel", "geometry_msgs/msg/Twist", b"rubbish", number=10)
            viewer.publish(
                "/rov/cmd_vel", "geometry_msgs/Wrench", serialize("geometry_msgs/msg/Twist", twist), number=12
            )
            viewer.call("/pelagos/set_paused", b"\0\1\0\0\0")
            viewer.read(1.5)
            seen["imu"] = [(t, viewer.decode("/rov/imu/data_raw", raw)) for t, raw in viewer.got[1]]
            seen["static"] = [viewer.decode("/tf_static", raw) for _, raw in viewer.got[2]]
            seen["truth"] = viewer.decode("/rov/truth", viewer.got[3][-1][1])
            seen["times"], seen["channels"] = viewer.times, viewer.channels
            seen["answers"] = viewer.answers
            viewer.socket.close()
        except BaseException as error:
            failure.append(error)
        finally:
            sim.resume()
            sim.stop()

    thread = threading.Thread(target=script)
    thread.start()
    exchange.run(60.0)
    thread.join()
    report = exchange.close()
    if failure:
        raise failure[0]
    assert len(seen["times"]) > 10
    assert all(0 < b - a < 1e9 for a, b in zip(seen["times"], seen["times"][1:], strict=False))  # the simulation's
    assert "/clock" not in seen["channels"]
    assert report["Foxglove: /rov/cmd_vel: messages of 'geometry_msgs/Wrench', not of 'geometry_msgs/msg/Twist'"] == 1
    nobody = "Foxglove: '/rov/cmd_vell': nobody takes messages on this topic (did you mean '/rov/cmd_vel'?)"
    assert report[nobody] == 1
    assert sum(count for reason, count in report.items() if "/rov/cmd_vel: malformed" in reason) == 1
    times = np.array([t for t, _ in seen["imu"]])
    assert len(times) > 10
    assert set(np.diff(times).tolist()) == {20_000_000}  # none missing, at the sensor's rate
    assert seen["imu"][0][1].header.frame_id == "rov/imu"
    assert seen["imu"][0][1].linear_acceleration.z == pytest.approx(9.81, abs=0.5)
    assert [t.child_frame_id for t in seen["static"][0].transforms] == ["rov/imu"]  # latched: it came late
    assert seen["truth"].twist.twist.linear.x > 0.2  # the panel's command moves it
    assert len(seen["answers"]) == 1


def test_a_viewer_that_does_not_read_slows_nobody() -> None:
    sim = pl.Simulation.load(SCENARIO)
    exchange = Exchange(sim)
    text = FoxgloveConfig(type="foxglove", port=0).attach(exchange)
    exchange.run(1.0)
    viewer = Viewer(int(text.rpartition(":")[2]))
    viewer.read(0.2)
    viewer.subscribe(_1="/rov/imu/data_raw")
    time.sleep(0.1)
    result = exchange.run(10.0)  # thousands of messages that nobody takes
    assert result.simulated_s == pytest.approx(10.0)
    viewer.socket.close()
    exchange.close()

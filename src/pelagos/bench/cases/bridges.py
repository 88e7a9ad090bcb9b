"""Doors to other software: what they cost a run, how late messages are, how much goes through."""

from __future__ import annotations

import json
import subprocess
import sys
import time
from pathlib import Path
from typing import Any, Final

import numpy as np

from pelagos.bench.case import Case, Measured, Reference
from pelagos.bench.cases.missions import REAL_TIME, harbour
from pelagos.bench.check import must
from pelagos.messages.store import header, make, serialize, stamp

DOMAIN: Final = 97
"""A ROS domain that nobody else uses."""
PEER: Final = Path(__file__).parents[1] / "ros2_peer.py"


class _Peer:
    """A subscriber in another process; it says what it received when it is told to stop."""

    def __init__(self, *topics: str) -> None:
        command = [sys.executable, str(PEER), str(DOMAIN), *topics]
        self._process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        must(self._line() == "ready", "the subscriber did not start")

    def stop(self) -> dict[str, Any]:
        """Its account."""
        assert self._process.stdin is not None
        self._process.stdin.write("stop\n")
        self._process.stdin.close()
        try:
            account: dict[str, Any] = json.loads(self._line())
        finally:
            self._process.kill()
            self._process.wait()
        return account

    def _line(self) -> str:
        assert self._process.stdout is not None
        return self._process.stdout.readline().strip()


def _transport() -> Any:
    from pelagos.bridges.dds import DdsTransport

    return DdsTransport(domain=DOMAIN, node="bench")


def ros2_harbour_rtf() -> Measured:
    """The demo mission with every topic going to another process, over the same without a bridge."""
    from pelagos.bridges.door import TopicDoor
    from pelagos.bridges.exchange import Exchange
    from pelagos.sim.simulation import Simulation

    sim = Simulation.load(harbour())
    seconds = 40.0
    sim.run(5.0)
    peer = _Peer(*_topics(sim))
    rates: dict[bool, list[float]] = {False: [], True: []}
    sent = 0
    for bridged in (False, True) * 2:
        sim.reset()
        exchange = Exchange(sim)
        if bridged:
            door = TopicDoor(_transport())
            exchange.add(door)
        rates[bridged].append((exchange.run(seconds) if bridged else sim.run(seconds)).real_time_factor)
        if bridged:
            sent += door.sent
            time.sleep(0.2)
        exchange.close()
    received = peer.stop()
    must(received["count"] > 0.5 * sent, f"the subscriber got {received['count']} of {sent} messages")
    alone, bridged_rate = max(rates[False]), max(rates[True])
    return Measured(
        bridged_rate / alone,
        reference=Reference(f"without a bridge: {alone:.1f} x real time", 1.0),
        detail=f"{bridged_rate:.1f} x real time, {received['count']} of {sent} messages received in another process",
    )


def _topics(sim: Any) -> list[str]:
    """topic=type of everything that a run publishes."""
    from pelagos.bridges.tap import Tap
    from pelagos.sim.run_log import open_recorder

    tap = Tap()
    open_recorder(Path(), sim, writer=tap)
    return [f"{c.topic}={c.type}" for c in tap.channels.values()]


def ros2_imu_latency_ms() -> Measured:
    """From the write of an Imu to its receipt in another process, at 1 kHz."""
    from pelagos.bridges.transport import Qos

    peer, transport = _Peer("/bench/imu=sensor_msgs/msg/Imu"), _transport()
    write = transport.advertise("/bench/imu", "sensor_msgs/msg/Imu", qos=Qos(depth=50))
    time.sleep(1.0)
    message = make(
        "sensor_msgs/msg/Imu",
        header=header("imu"),
        orientation=make("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=np.zeros(9),
        angular_velocity=make("geometry_msgs/msg/Vector3", x=1.0, y=2.0, z=3.0),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=make("geometry_msgs/msg/Vector3", x=1.0, y=2.0, z=3.0),
        linear_acceleration_covariance=np.zeros(9),
    )
    due, count = time.perf_counter(), 3000
    for _ in range(count):
        due += 0.001
        time.sleep(max(0.0, due - time.perf_counter()))
        message.header.stamp = stamp(time.monotonic_ns())
        write(serialize("sensor_msgs/msg/Imu", message), 0)
    time.sleep(0.2)
    transport.close()
    account = peer.stop()
    must(account["count"] == count, f"{account['count']} of {count} messages arrived")
    return Measured(account["p99_ms"], detail=f"{count} messages, none lost; median {account['p50_ms']:.2f} ms")


def ros2_image_mb_s() -> Measured:
    """Pictures of 1 MB that reach a subscriber in another process, as fast as it takes them."""
    from pelagos.bridges.dds_flow import WAITING
    from pelagos.bridges.transport import Qos

    peer, transport = _Peer("/bench/image=sensor_msgs/msg/Image"), _transport()
    write = transport.advertise("/bench/image", "sensor_msgs/msg/Image", qos=Qos(depth=5, large=True))
    time.sleep(1.0)
    image = make(
        "sensor_msgs/msg/Image", header=header("camera"), height=512, width=2048, encoding="mono8", is_bigendian=0,
        step=2048, data=np.arange(1 << 20).astype(np.uint8),
    )  # fmt: skip
    raw, count = serialize("sensor_msgs/msg/Image", image), 300
    for _ in range(count):
        while transport.waiting >= WAITING:
            time.sleep(0.0002)
        write(raw, 0)
    while transport.waiting:
        time.sleep(0.01)
    time.sleep(0.5)
    transport.close()
    account = peer.stop()
    got = account["count"]
    must(got > count // 4, f"{got} of {count} pictures arrived")
    delivered = (got - 1) * len(raw) * 1e-6 / account["span_s"]
    return Measured(delivered, detail=f"delivered to another process: {got} pictures, {count - got} lost")


def realtime_jitter_ms() -> Measured:
    """Delays of late steps in a real-time run of the demo's navigation sensors, at 200 Hz."""
    from pelagos.bridges.exchange import Exchange
    from pelagos.sim.simulation import Simulation

    scenario = harbour()
    for agent in scenario["agents"].values():
        agent["sensors"] = {k: v for k, v in agent["sensors"].items() if v["type"] in ("imu", "depth", "magnetometer")}
        agent["mission"], agent["control"], agent["command"] = [], "depth_heading_speed", [4.0, 0.0, 1.5]
    sim = Simulation.load(scenario)
    Exchange(sim, rate_hz=200, realtime=1.0).run(2.0)
    exchange = Exchange(sim, rate_hz=200, realtime=1.0)
    exchange.run(10.0)
    p50, p99, worst = exchange.pace.jitter_ms()
    must(len(exchange.pace.late) >= 2000, "too few boundaries")
    return Measured(p99, detail=f"{len(exchange.pace.late)} steps; median {p50:.3f} ms, worst {worst:.2f} ms")


SITL: Final = """
import socket, struct, sys
port, frames = int(sys.argv[1]), int(sys.argv[2])
link = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
link.connect(("127.0.0.1", port))
link.settimeout(1.0)
for count in range(1, frames + 1):
    pulses = [1500 + (count + 7 * i) % 50 for i in range(8)] + [0] * 8
    packet = struct.pack("<HHI16H", 18458, 1200, count, *pulses)
    while True:
        try:
            link.send(packet)
            link.recv(4096)
            break
        except (TimeoutError, ConnectionRefusedError):
            pass
"""


def ardupilot_lockstep_hz() -> Measured:
    """Frames in a second of lock-step with a stand-in for SITL in another process, every output changing."""
    import socket

    from pelagos.bridges.ardupilot import ArdupilotConfig
    from pelagos.bridges.exchange import Exchange
    from pelagos.sim.simulation import Simulation

    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    agent = {"vehicle": "bluerov2_heavy", "start": {"position_m": [0, 0], "depth_m": 5}, "control": "actuators"}
    sim = Simulation.load({"tick_rate_hz": 1000, "world": {"type": "flat", "depth_m": 50.0}, "agents": {"rov": agent}})
    frames = 12_000
    alone_us = _single_step_us(sim)
    sim.reset()
    exchange = Exchange(sim)
    ArdupilotConfig(type="ardupilot", port=port, patience_s=5.0).attach(exchange)
    sitl = subprocess.Popen([sys.executable, "-c", SITL, str(port), str(frames)])
    try:
        exchange.run(2.0)  # recording of kernels
        start = time.perf_counter()
        result = exchange.run((frames - 2500) * 1e-3)
        took = time.perf_counter() - start
    finally:
        sitl.kill()
        sitl.wait()
    done = result.simulated_s * 1000
    must(done >= frames - 2501, "the stand-in was not answered")
    exchange.close()
    alone_us = min(alone_us, _single_step_us(sim))
    return Measured(
        done / took,
        reference=Reference("the same steps, one at a time, without an autopilot", 1e6 / alone_us),
        detail=f"{1e6 * took / done:.0f} us a frame, of which a step of a BlueROV2 Heavy {alone_us:.0f} us",
    )


def _single_step_us(sim: Any) -> float:
    """A step, where something waits at every tick."""
    with sim.on_tick(lambda _: None):
        sim.run(0.5)
        steps = 1500
        start = time.perf_counter()
        sim.run(steps * sim.dt_ns * 1e-9)
        return 1e6 * (time.perf_counter() - start) / steps


CASES: Final = (
    Case(
        name="ardupilot_lockstep_hz",
        title="Lock-step with ArduPilot's JSON interface",
        measure=ardupilot_lockstep_hz,
        unit="frames/s",
        goal=5000.0,
        better="higher",
        reference=Reference("ArduPilot's own rate", 1200.0),
    ),
    Case(
        name="ros2_harbour_rtf",
        title="Demo mission with every topic published over DDS",
        measure=ros2_harbour_rtf,
        unit="of the run without",
        goal=0.8,
        better="higher",
        reference=REAL_TIME,
    ),
    Case(
        name="ros2_imu_latency_ms",
        title="Imu at 1 kHz to another process, 99th percentile",
        measure=ros2_imu_latency_ms,
        unit="ms",
        goal=1.0,
        better="lower",
        reference=Reference("the interval between two messages", 1.0),
    ),
    Case(
        name="ros2_image_mb_s",
        title="Pictures of 1 MB over DDS",
        measure=ros2_image_mb_s,
        unit="MB/s",
        goal=300.0,
        better="higher",
        reference=Reference("thirty pictures a second", 31.5),
    ),
    Case(
        name="realtime_jitter_ms",
        title="Steps of --realtime at 200 Hz, 99th percentile of lateness",
        measure=realtime_jitter_ms,
        unit="ms",
        goal=1.0,
        better="lower",
        reference=Reference("the step", 5.0),
    ),
)

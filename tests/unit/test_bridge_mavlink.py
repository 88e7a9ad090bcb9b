"""PX4's hardware-in-the-loop messages and the plain MAVLink vehicle, against stand-ins on pymavlink."""

from __future__ import annotations

import socket
import threading
import time
from collections.abc import Callable, Iterator
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.mavlink import MavlinkConfig, MavlinkDoor
from pelagos.bridges.px4 import ALL_FIELDS, Px4Config, pressure_hpa
from pelagos.bridges.transport import BridgeMismatch

mavlink = pytest.importorskip("pymavlink.dialects.v20.common")
mavutil = pytest.importorskip("pymavlink.mavutil")


def scenario(vehicle: str, z: float, **more: Any) -> dict[str, Any]:
    agent = {"vehicle": vehicle, "start": {"position_m": [3, -2, z], "heading_deg": 30}, **more}
    return {"tick_rate_hz": 250, "world": {"type": "flat", "depth_m": 20.0}, "agents": {"a": agent},
            "origin": {"latitude_deg": 45.0, "longitude_deg": 12.0}}  # fmt: skip


def free_port(kind: int) -> int:
    with socket.socket(socket.AF_INET, kind) as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


class FakePx4:
    """Connects as PX4 does; its clock is the time of HIL_SENSOR, and each one is answered once it has begun."""

    def __init__(self, port: int) -> None:
        self.socket = socket.create_connection(("127.0.0.1", port), timeout=10)
        self.mav = mavlink.MAVLink(None, srcSystem=1, srcComponent=1)
        self.queue: list[Any] = []
        self.send(mavlink.MAVLink_heartbeat_message(2, 12, 0, 0, 0, 3))

    def send(self, message: Any) -> None:
        self.socket.sendall(message.pack(self.mav))

    def until(self, kind: str) -> Any:
        while True:
            for i, message in enumerate(self.queue):
                if message.get_type() == kind:
                    del self.queue[: i + 1]
                    return message
            raw = self.socket.recv(4096)
            assert raw, "the simulator hung up"
            self.queue += self.mav.parse_buffer(raw) or []

    def controls(self, t_us: int, values: list[float], *, armed: bool = True) -> None:
        full = [*values, *[0.0] * (16 - len(values))]
        self.send(mavlink.MAVLink_hil_actuator_controls_message(t_us, full, 128 if armed else 0, 1))

    def close(self) -> None:
        self.socket.close()


def drive(sim: pl.Simulation, script: Callable[[FakePx4], None], **config: Any) -> dict[str, int]:
    port = free_port(socket.SOCK_STREAM)
    exchange = Exchange(sim)
    Px4Config(type="px4", port=port, **config).attach(exchange)
    failure: list[BaseException] = []

    def run() -> None:
        try:
            px4 = FakePx4(port)
            try:
                script(px4)
            finally:
                sim.stop()
                px4.close()
        except BaseException as error:
            failure.append(error)
            sim.stop()

    thread = threading.Thread(target=run)
    thread.start()
    exchange.run(60.0)
    thread.join()
    if failure:
        raise failure[0]
    return dict(exchange.close())


def test_px4_and_the_simulation_take_turns() -> None:
    sim = pl.Simulation.load(scenario("quadrotor", 5.0))
    times: list[int] = []
    motion: list[Any] = []

    def script(px4: FakePx4) -> None:
        for _ in range(5):  # before its first outputs PX4 only listens
            px4.until("HIL_SENSOR")
        first = px4.until("HIL_SENSOR")
        px4.controls(first.time_usec, [0.0] * 4, armed=False)
        for i in range(150):
            sensor = px4.until("HIL_SENSOR")
            times.append(sensor.time_usec)
            assert sensor.fields_updated == ALL_FIELDS == 0x1FFF
            px4.controls(sensor.time_usec, [0.95, 0.95, 0.95, 0.95], armed=i >= 1)
        motion.append(sensor)

    report = drive(sim, script)
    gaps = np.diff(times)
    assert set(gaps[5:].tolist()) == {4000}  # lock-step: no sensor message but after an answer
    assert sim.state["a"].velocity[0, 2] > 0  # it climbs
    assert (
        "PX4: sensor messages without an answer" not in report or report["PX4: sensor messages without an answer"] <= 1
    )


def test_sensors_are_in_the_units_of_mavlink() -> None:
    """At rest, heading 30 degrees, 5 m above the sea at 45 N 12 E."""
    sim = pl.Simulation.load(scenario("wamv", 0.0, control="actuators"))
    seen: dict[str, Any] = {}

    def script(px4: FakePx4) -> None:
        seen["sensor"] = px4.until("HIL_SENSOR")
        seen["gps"] = px4.until("HIL_GPS")
        seen["truth"] = px4.until("HIL_STATE_QUATERNION")

    drive(sim, script)
    s, g, t = seen["sensor"], seen["gps"], seen["truth"]
    assert s.zacc == pytest.approx(-9.81, abs=0.3)  # specific force, down
    assert s.abs_pressure == pytest.approx(1013.25, abs=0.2)  # hPa
    assert np.linalg.norm([s.xmag, s.ymag, s.zmag]) == pytest.approx(0.48, abs=0.02)  # gauss, in northern Italy
    assert s.zmag > 0.35  # the field points down there
    assert s.ymag < -0.05  # and north, which is to the left of a heading of 30 degrees
    x, y = sim.world.origin.to_xy(g.lat * 1e-7, g.lon * 1e-7)
    np.testing.assert_allclose([x, y], [3, -2], atol=0.02)
    assert (g.fix_type, g.eph) == (3, 100)
    assert g.cog == 65535  # no course while it rests
    w, _, _, z = t.attitude_quaternion
    assert np.degrees(2 * np.arctan2(z, w)) == pytest.approx(30, abs=0.5)


def test_outputs_that_lead_nowhere_are_refused_before_a_port_is_opened() -> None:
    sim = pl.Simulation.load(scenario("bluerov2", -5.0))
    first = sim.model.agents["a"].vehicle.actuator_names[0]
    Px4Config(type="px4").check(sim)
    for name, told in (("rudder", "px4: unknown actuator 'rudder'"), (first, "px4: no output moves")):
        with pytest.raises(BridgeMismatch, match=told):
            Px4Config(type="px4", outputs={name: 1}).check(sim)


def test_a_disarmed_vehicle_and_wild_outputs_do_nothing() -> None:
    sim = pl.Simulation.load(scenario("wamv", 0.0, control="actuators"))

    def script(px4: FakePx4) -> None:
        for _ in range(20):
            sensor = px4.until("HIL_SENSOR")
            px4.controls(sensor.time_usec, [1.0, 0.0, 1.0], armed=False)
        px4.controls(sensor.time_usec, [float("nan")] * 3)
        px4.until("HIL_SENSOR")
        px4.socket.sendall(b"\xfd rubbish \xfd\xfd" * 60)
        for _ in range(3):
            px4.until("HIL_SENSOR")

    report = drive(sim, script, answer_s=0.1)
    assert (sim.held_command("a") == 0).all()
    assert report["PX4: outputs that were not finite"] == 1
    assert report["PX4: malformed packets"] >= 1


def test_pressure_above_and_below_the_sea() -> None:
    """ISO 2533: 898.75 hPa at 1000 m; sea water adds about 100 hPa a metre and a decimetre at ten metres."""
    assert pressure_hpa(0) == pytest.approx(1013.25)
    assert pressure_hpa(-1000) == pytest.approx(898.75, abs=0.05)
    assert pressure_hpa(10) == pytest.approx(1013.25 + 1005.5, abs=0.1)


@pytest.fixture
def station() -> Iterator[Any]:
    """A ground station."""
    s = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
    s.bind(("127.0.0.1", 0))
    s.settimeout(5)
    yield s
    s.close()


def test_a_ground_station_sees_and_drives_a_vehicle(station: Any) -> None:
    sim = pl.Simulation.load(scenario("bluerov2_heavy", -5.0))
    exchange = Exchange(sim, realtime=1.0)
    MavlinkConfig(type="mavlink", port=station.getsockname()[1], system=7, speed_mps=0.5).attach(exchange)
    seen: dict[str, Any] = {}
    failure: list[BaseException] = []

    def script() -> None:
        try:
            mav = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
            peer, end = None, time.monotonic() + 20
            while sim.time_ns < 4e9 and time.monotonic() < end:
                raw, peer = station.recvfrom(2048)
                for message in mav.parse_buffer(raw) or ():
                    assert message.get_srcSystem() == 7
                    seen[message.get_type()] = message
                stick = mavlink.MAVLink_manual_control_message(7, 1000, 400, 300, 200, 0)
                station.sendto(stick.pack(mav), peer)
                station.sendto(b"\xfdnonsense" * 3, peer)
        except BaseException as error:
            failure.append(error)
        finally:
            sim.stop()

    thread = threading.Thread(target=script)
    thread.start()
    exchange.run(60.0)
    thread.join()
    report = exchange.close()
    assert not failure
    assert {"HEARTBEAT", "SYS_STATUS", "ATTITUDE", "LOCAL_POSITION_NED", "GLOBAL_POSITION_INT", "VFR_HUD"} <= set(seen)
    assert seen["HEARTBEAT"].type == 12
    assert mavutil.mavfile.probably_vehicle_heartbeat(None, seen["HEARTBEAT"])  # else wait_heartbeat finds no target
    velocity = sim.state["a"].velocity[0]
    np.testing.assert_allclose(velocity, [0.5, -0.2, -0.2], atol=0.08)  # ahead, to the right, down
    assert sim.state["a"].angular_velocity[0, 2] < -0.05  # and turns to the right
    place = seen["LOCAL_POSITION_NED"]
    assert place.z == pytest.approx(-sim.state["a"].position[0, 2], abs=0.2)
    assert report["MAVLink: malformed packets"] >= 1


def test_a_ground_stations_questions_are_answered(station: Any) -> None:
    """As a ground station asks at its start; pymavlink reads the answers."""
    sim = pl.Simulation.load(scenario("bluerov2_heavy", -5.0))
    exchange = Exchange(sim)
    MavlinkConfig(type="mavlink", port=station.getsockname()[1], speed_mps=0.75, turn_deg_s=20.0).attach(exchange)
    door: Any = exchange.doors[0]
    mav = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)

    def ask(question: Any, answers: int = 1) -> list[Any]:
        station.sendto(question.pack(mav), door._socket.getsockname())
        door._hear()
        return [message for _ in range(answers) for message in mav.parse_buffer(station.recv(2048))]

    first, second = ask(mavlink.MAVLink_param_request_list_message(1, 1), 2)
    assert (first.param_id, first.param_value, first.param_index, first.param_count) == ("SPEED_MPS", 0.75, 0, 2)
    assert (second.param_id, second.param_value, second.param_index) == ("TURN_DEG_S", 20.0, 1)
    (again,) = ask(mavlink.MAVLink_param_request_read_message(1, 1, b"TURN_DEG_S", -1))
    assert again.param_value == 20.0
    (kept,) = ask(mavlink.MAVLink_param_set_message(1, 1, b"SPEED_MPS", 9.0, 9))
    assert kept.param_value == 0.75
    (missions,) = ask(mavlink.MAVLink_mission_request_list_message(1, 1, 2))
    assert (missions.count, missions.target_system, missions.mission_type) == (0, 255, 2)
    (refusal,) = ask(mavlink.MAVLink_mission_count_message(1, 1, 4, 0))
    assert (refusal.get_type(), refusal.type) == ("MISSION_ACK", 3)
    (arm,) = ask(mavlink.MAVLink_command_long_message(1, 1, 400, 0, 1, 0, 0, 0, 0, 0, 0))
    assert (arm.command, arm.result, arm.target_component) == (400, 3, 190)
    station.sendto(mavlink.MAVLink_param_request_list_message(9, 1).pack(mav), door._socket.getsockname())
    door._hear()  # meant for another
    station.settimeout(0.1)
    with pytest.raises(TimeoutError):
        station.recv(2048)
    assert sum(exchange.inbox.refused.values()) == 3
    exchange.close()


def test_a_target_position_is_a_waypoint() -> None:
    sim = pl.Simulation.load(scenario("bluerov2_heavy", -5.0))
    exchange = Exchange(sim)
    config = MavlinkConfig(type="mavlink", port=free_port(socket.SOCK_DGRAM))
    config.attach(exchange)
    door: Any = exchange.doors[0]
    target = mavlink.MAVLink_set_position_target_local_ned_message
    door._target(target(0, 1, 1, 1, 0b110111111000, 4.0, 5.0, 6.0, 0, 0, 0, 0, 0, 0, 0, 0))
    exchange.inbox.drain()
    np.testing.assert_allclose(sim.held_command("a")[0, :3], [4, -5, -6])
    door._target(target(0, 1, 1, 8, 0b010111000111, 0, 0, 0, 0.3, 0.2, 0.1, 0, 0, 0, 0, 0.4))
    exchange.inbox.drain()
    np.testing.assert_allclose(sim.held_command("a")[0], [0.3, -0.2, -0.1, -0.4], atol=1e-6)
    door._target(target(0, 1, 1, 3, 0, 0, 0, 0, 0.3, 0.2, 0.1, 0, 0, 0, 0, 0.4))
    assert sum(exchange.inbox.refused.values()) == 1
    exchange.close()


def test_an_axis_that_a_ground_station_has_not_is_left_alone(station: Any) -> None:
    """MANUAL_CONTROL's INT16_MAX, "this axis is invalid": the others are obeyed."""
    sim = pl.Simulation.load(scenario("bluerov2_heavy", -5.0))
    exchange = Exchange(sim)
    door = MavlinkDoor(exchange, MavlinkConfig(type="mavlink", port=station.getsockname()[1], speed_mps=0.5))
    mav = mavlink.MAVLink(None, srcSystem=255, srcComponent=190)
    for axes, refused in (((1000, 32767, 500, 400), 0), ((1000, 2000, 500, 0), 1)):
        door.take(mavlink.MAVLink_manual_control_message(1, *axes, 0).pack(mav))
        assert exchange.inbox.refused.total() == refused
    (ticket,) = exchange.inbox._waiting
    assert ticket.order.data["values"] == pytest.approx([0.5, 0.0, 0.0, 0.0, 0.0, -0.4 * np.radians(30.0)])
    door.close()


def test_a_ground_station_sees_the_vehicle_where_it_is() -> None:
    """3 m north and 2 m east of 45 N 12 E, heading 30 degrees; 1e-7 degrees are a centimetre."""
    sim = pl.Simulation.load(scenario("wamv", 0.0, control="actuators"))
    door = MavlinkDoor(Exchange(sim), MavlinkConfig(type="mavlink", port=free_port(socket.SOCK_DGRAM)))
    found = next(m for m in door._state(sim) if m.get_type() == "GLOBAL_POSITION_INT")
    door.close()
    x, y = sim.world.origin.to_xy(found.lat * 1e-7, found.lon * 1e-7)
    np.testing.assert_allclose([x, y], [3, -2], atol=0.02)
    assert found.lat > 450_000_000
    assert found.lon > 120_000_000
    assert found.hdg == pytest.approx(3000, abs=50)

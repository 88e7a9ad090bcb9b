"""Everything that doors say of a vehicle off all axes, and what they make of commands of both signs: MAVLink, PX4,
ArduPilot, MOOS, instruments, ROS 2's topics and services, Foxglove, rosbridge, LCM. No door has a peer here: its
messages are taken where it hands them over."""

from __future__ import annotations

import json
import math
import socket
import struct
from collections.abc import Iterator
from datetime import UTC, datetime
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from pymavlink.dialects.v20 import common

import pelagos as pl
from known import check, on_one_scale
from pelagos.bridges.ardupilot import ArdupilotConfig, ArdupilotLink
from pelagos.bridges.ardupilot_json import level, parse_servos, state_text
from pelagos.bridges.autopilot import OUTPUTS, VehicleMotion, motion_of, outputs_of
from pelagos.bridges.door import TopicDoor
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.holoocean import listen_holoocean
from pelagos.bridges.inbox import Inbox, Ticket, order_text
from pelagos.bridges.instruments import nmea, ping, teledyne, vectornav, waterlinked
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.speaker import Place
from pelagos.bridges.instruments.speakers import SPEAKERS
from pelagos.bridges.mavlink import MavlinkConfig, MavlinkDoor
from pelagos.bridges.moos import DESIRED, MoosConfig, MoosDoor, mixer_of, nav_of
from pelagos.bridges.moos_wire import NOTIFY, MoosMessage, pack, unpack
from pelagos.bridges.px4 import Px4Config, Px4Link, pressure_hpa
from pelagos.bridges.ros_commands import command_topics
from pelagos.bridges.services import Services
from pelagos.bridges.tap import Tap
from pelagos.bridges.transport import MemoryTransport
from pelagos.bridges.zenoh_transport import qos_text
from pelagos.messages.json_form import from_json, to_json
from pelagos.messages.store import deserialize, serialize

NEAR = 2e-5  # share: readings in single precision, told with few digits
EPOCH = datetime(2027, 11, 30, 23, 59, 58, 250_000, tzinfo=UTC)
MOUNT = {"position_m": [0.3, -0.2, 0.1], "orientation_deg": [3.0, -4.0, 25.0], "rate_hz": 10}
FAN = {"bins": 48, "range_min_m": 0.8, "range_max_m": 31.0}
SENSORS: dict[str, Any] = {
    "imu": {"type": "imu", **MOUNT, "rate_hz": 20},
    "gps": {"type": "gps", **MOUNT},
    "depth": {"type": "depth", **MOUNT},
    "dvl": {"type": "dvl", **MOUNT},
    "altimeter": {"type": "altimeter", **MOUNT},
    "pose": {"type": "pose", **MOUNT},
    "magnetometer": {"type": "magnetometer", **MOUNT},
    "velocity": {"type": "velocity", **MOUNT},
    "single": {"type": "singlebeam", **MOUNT, **FAN, "orientation_deg": [3.0, 55.0, -40.0]},
    "scanner": {"type": "mechanical_scanning_sonar", **MOUNT, **FAN, "step_deg": 9.0},
}
OCEAN = {
    "currents": [{"type": "uniform", "speed_mps": 0.4, "towards_deg": 70.0, "up_mps": 0.05}],
    "wind": {"speed_mps": 5.0, "from_deg": 200.0},
}
STATES: dict[str, dict[str, Any]] = {
    "near the surface": {
        "position": [41.0, -73.0, 0.0],
        "attitude": [0.88, 0.21, -0.16, -0.39],
        "velocity": [1.3, -0.5, 0.35],
        "angular_velocity": [0.31, -0.23, 0.17],
    },
    "deep": {
        "position": [-37.0, 29.0, -7.5],
        "attitude": [-0.31, 0.12, 0.27, 0.9],
        "velocity": [-0.7, 0.6, -0.45],
        "angular_velocity": [-0.27, 0.19, -0.41],
    },
}
VEHICLES = {"bluerov2_heavy": -6.0, "remus100": -6.0, "otter": 0.0, "wamv": 0.0, "quadrotor": 9.0, "bluerov2": -6.0}
COMMANDED = ("bluerov2_heavy", "remus100", "otter")


def loaded(vehicle: str, sensors: dict[str, Any]) -> pl.Simulation:
    agent = {
        "vehicle": vehicle,
        "start": {"position_m": [3, -2, VEHICLES[vehicle]], "heading_deg": 35.0},
        "control": "actuators",
        "sensors": sensors,
    }
    world = {"type": "flat", "depth_m": 19.0, "latitude_deg": -33.25, "longitude_deg": -151.5}
    return pl.Simulation.load({"seed": 5, "tick_rate_hz": 100, "world": world, "ocean": OCEAN, "agents": {"a": agent}})


@pytest.fixture(scope="module")
def rov() -> pl.Simulation:
    return loaded("bluerov2_heavy", SENSORS)


@pytest.fixture(scope="module")
def others() -> dict[str, pl.Simulation]:
    return {name: loaded(name, {}) for name in VEHICLES if name != "bluerov2_heavy"}


def put(sim: pl.Simulation, state: str) -> None:
    """From the start to a state, and some ticks on, so that it is accelerated."""
    sim.reset()
    sim.set_state("a", **STATES[state])
    names = sim.model.agents["a"].vehicle.actuator_names
    sim.command({"a": [0.2 * (-1) ** k * (1 + 0.2 * k) for k in range(len(names))]})
    sim.step(ticks=3)


@pytest.fixture
def free_port() -> int:
    with socket.socket() as s:
        s.bind(("127.0.0.1", 0))
        return int(s.getsockname()[1])


class Kept:
    """An inbox that keeps what it is told."""

    def __init__(self) -> None:
        self.orders: list[Any] = []
        self.refused: list[str] = []

    def put(self, order: Any) -> Ticket:
        self.orders.append([order.kind, order.target, order.data, order.source])
        return Ticket(order)

    def obey(self, order: Any) -> None:
        self.put(order)

    def steer(self, agent: str, values: Any, source: str) -> None:
        self.orders.append([agent, list(values), source])

    def refuse(self, reason: str) -> None:
        self.refused.append(reason)

    def write_down(self) -> None:
        """Nothing."""


def fields_of(message: Any) -> Any:
    return {name: getattr(message, name) for name in message.get_fieldnames()}


@pytest.mark.parametrize("state", sorted(STATES))
def test_what_autopilots_are_told(rov: pl.Simulation, state: str, free_port: int) -> None:
    put(rov, state)
    exchange = Exchange(rov)
    motion = motion_of(rov, "a")
    px4 = Px4Link(exchange, Px4Config(type="px4", port=free_port))
    door = MavlinkDoor(exchange, MavlinkConfig(type="mavlink", system=7, rate_hz=10.0))
    said: list[Any] = []
    door._say = lambda raw: said.extend(common.MAVLink(None).parse_buffer(raw))  # type: ignore[method-assign]
    door.send(rov, ())
    rov.step(ticks=4)
    door.send(rov, ())  # too soon
    link = ArdupilotLink(exchange, ArdupilotConfig(type="ardupilot", port=free_port, rangefinder="altimeter"))
    link._peer, sent = ("", 0), []
    link._socket.close()
    link._socket = SimpleNamespace(sendto=lambda raw, peer: sent.append(raw), close=lambda: None)  # type: ignore[assignment]
    link.answer(rov)
    rov.step(ticks=8)
    link.answer(rov)
    door.send(rov, ())
    messages = [px4._sensor(motion, 4_000_123), px4._gps(motion, 4_000_123), px4._truth(motion, 4_000_123)]
    found = {
        "motion": [motion, motion.euler],
        "mavlink": [[m.get_type(), fields_of(m)] for m in said],
        "px4": [[m.get_type(), fields_of(m)] for m in messages],
        "ardupilot": [state_text(1.25, motion, {"rng_1": 4.5}), *sent],
        "moos": nav_of(rov, "a"),
    }
    found["ardupilot"] = [raw.decode() for raw in found["ardupilot"]]
    for one in (px4, door, link):
        one.close()
    check("doors", f"autopilots {state}", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


def controls(n: int = 16) -> list[float]:
    return [0.06 * (k + 1) * (-1) ** k for k in range(n)]


@pytest.mark.parametrize("vehicle", sorted(OUTPUTS))
def test_what_autopilots_steer(
    rov: pl.Simulation, others: dict[str, pl.Simulation], vehicle: str, free_port: int
) -> None:
    sim = rov if vehicle == "bluerov2_heavy" else others[vehicle]
    sim.reset()
    kept: Any = Kept()
    exchange: Any = SimpleNamespace(sim=sim, inbox=kept, at_least=lambda rate_hz: None)
    names = sim.model.agents["a"].vehicle.actuator_names
    own = {name: (3 * k + 2) * (-1) ** k for k, name in enumerate(names)}
    outputs = [outputs_of(sim, "a", given, "px4") for given in ({}, own)]
    levels = [[o.value(x) for x in (-1.3, -0.4, 0.0, 0.7, 1.2)] + [o.rests_at] for some in outputs for o in some]
    px4 = Px4Link(exchange, Px4Config(type="px4", port=free_port))
    peer = common.MAVLink(None, srcSystem=1, srcComponent=1)
    for armed, values in ((True, controls()), (False, controls()), (True, controls()[::-1])):
        px4.take(common.MAVLink_hil_actuator_controls_message(4000, values, 128 if armed else 0, 1).pack(peer))
    px4.close()
    link = ArdupilotLink(exchange, ArdupilotConfig(type="ardupilot", port=free_port, low_us=1050.0))
    for number, pulses in ((3, range(1120, 1760, 40)), (4, range(1720, 1080, -40)), (1, [0] * 16)):
        frame = parse_servos(struct.pack("<HHI16H", 18458, 400, number, *pulses))
        link._take(frame, "peer")  # type: ignore[arg-type]
    link.close()
    wide = parse_servos(struct.pack("<HHI32H", 29569, 400, 9, *range(1000, 1960, 30)))
    pulses = [level(us, rests, low_us=1050.0, high_us=1930.0) for us in (0, 1200, 1810) for rests in (0.0, -1.0)]
    found = {"outputs": [outputs, levels], "orders": kept.orders, "frame": wide, "levels": pulses}
    check("doors", f"steered {vehicle}", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


def test_what_ground_stations_ask(rov: pl.Simulation) -> None:
    rov.reset()
    kept: Any = Kept()
    exchange: Any = SimpleNamespace(sim=rov, inbox=kept, at_least=lambda rate_hz: None)
    door = MavlinkDoor(exchange, MavlinkConfig(type="mavlink", system=7, speed_mps=0.8, turn_deg_s=21.0))
    said: list[Any] = []
    door._say = lambda raw: said.extend(common.MAVLink(None).parse_buffer(raw))  # type: ignore[method-assign]
    mav, m = common.MAVLink(None, srcSystem=250, srcComponent=190), common
    target = m.MAVLink_set_position_target_local_ned_message
    for message in (
        m.MAVLink_manual_control_message(7, 800, -300, 900, 450, 0),
        m.MAVLink_manual_control_message(7, -700, 32767, 100, -250, 0),
        m.MAVLink_manual_control_message(7, 32767, 200, 32767, 32767, 0),
        m.MAVLink_manual_control_message(7, 1001, 0, 500, 0, 0),
        m.MAVLink_manual_control_message(8, 1, 2, 3, 4, 0),
        target(0, 7, 1, 1, 0b110111111000, 4.0, -5.0, 6.0, 0, 0, 0, 0, 0, 0, 0, 0),
        target(0, 7, 1, 8, 0b010111000111, 0, 0, 0, 0.3, -0.2, 0.1, 0, 0, 0, 0, -0.4),
        target(0, 7, 1, 8, 0b110111000111, 0, 0, 0, -0.3, 0.2, -0.1, 0, 0, 0, 0, 0.4),
        target(0, 7, 1, 3, 0, 1, 2, 3, 0.3, 0.2, 0.1, 0, 0, 0, 0, 0.4),
        m.MAVLink_param_request_list_message(7, 1),
        m.MAVLink_param_request_read_message(7, 1, b"", 1),
        m.MAVLink_param_request_read_message(7, 1, b"TURN_DEG_S", -1),
        m.MAVLink_param_set_message(7, 1, b"SPEED_MPS", 9.0, 9),
        m.MAVLink_mission_request_list_message(7, 1, 2),
        m.MAVLink_mission_count_message(7, 1, 4, 0),
        m.MAVLink_command_long_message(7, 1, 400, 0, 1, 2, 3, 4, 5, 6, 7),
        m.MAVLink_param_request_list_message(9, 1),
    ):
        door.take(message.pack(mav))
    door.take(b"\xfd rubbish \xfd\xfd" * 20)
    door.close()
    found = {
        "orders": kept.orders,
        "refused": len(kept.refused),
        "said": [[x.get_type(), fields_of(x)] for x in said],
        "troubles": [door.troubles["malformed packets"] > 0],
    }
    check("doors", "ground station", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


def test_pressures_and_bounds_of_px4() -> None:
    fast = VehicleMotion((1.0, 2.0, 30.0), (400.0, -500.0, 0.02), (1.0, 0, 0, 0), (0, 0, 0), (99.0, -400.0, 500.0))
    link = object.__new__(Px4Link)
    link._dialect, link._origin = common, SimpleNamespace(to_latlon=lambda x, y: (10.0, 20.0))  # type: ignore[assignment]
    still = fast._replace(velocity=(0.03, -0.05, 0.0), position=(0.0, 0.0, -3.0))
    messages = [m for one in (fast, still) for m in (link._gps(one, 5), link._truth(one, 5))]
    found = {
        "pressure": [pressure_hpa(z) for z in (-9000.0, -30.0, 0.0, 2.0, 400.0)],
        "messages": [fields_of(m) for m in messages],
    }
    check("doors", "px4 at its bounds", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


@pytest.mark.parametrize("vehicle", ["otter", "remus100", "wamv"])
def test_what_a_helm_steers(others: dict[str, pl.Simulation], vehicle: str) -> None:
    sim = others[vehicle]
    sim.reset()
    mix, kept = mixer_of(sim, "a"), Kept()
    wanted = [(60.0, 20.0, -9.0), (-45.0, -14.0, 11.0), (130.0, -80.0, 70.0), (-130.0, 80.0, -70.0), (0.0, 5.0, -3.0)]
    door = object.__new__(MoosDoor)
    door.agent, door._inbox, door._mix = "a", kept, mix  # type: ignore[assignment]
    door._desired = dict.fromkeys(DESIRED, 0.0)
    for key, value in zip((*DESIRED, DESIRED[0]), (70.0, -12.0, 7.0, -30.0), strict=True):
        door._obey(key, value)
    door._obey(DESIRED[1], math.nan)
    found = {"mixed": [mix(*w) for w in wanted], "orders": kept.orders, "refused": len(kept.refused)}
    check("doors", f"helm {vehicle}", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


def damaged(packet: bytes) -> Iterator[bytes]:
    """Cut off, and with each byte another."""
    for at in range(len(packet)):
        yield packet[:at]
        yield packet[:at] + bytes([packet[at] ^ 0x11]) + packet[at + 1 :]
        yield packet[:at] + bytes([packet[at] ^ 0x80]) + packet[at + 1 :]


def refused(packet: bytes) -> Any:
    try:
        return [[m.kind, m.key, m.text, m.source] for m in unpack(packet)]
    except ValueError:
        return 0


def test_packets_of_moos(others: dict[str, pl.Simulation], monkeypatch: pytest.MonkeyPatch) -> None:
    sim = others["remus100"]
    put(sim, "deep")
    kept: Any = Kept()
    monkeypatch.setattr(MoosDoor, "_work", lambda door: None)
    exchange: Any = SimpleNamespace(sim=sim, inbox=kept, at_least=lambda rate_hz: None)
    door = MoosDoor(exchange, MoosConfig(type="moos", name="us", rate_hz=20.0))
    door.open(sim, Tap())
    door.send(sim, ())
    door._nav.pop("NAV_X")
    sim.step(ticks=2)
    door.send(sim, ())  # too soon
    told = [[m.kind, m.key, m.value, m.source] for m in door._nav.values()]
    door.close()
    sent = [MoosMessage(NOTIFY, "A", -1.25, "", "me", 3.5, 4), MoosMessage("R", "BC", 0.5, "text", "us", -1.0, 5, True)]
    found = {"told": told, "packet": pack(sent), "read": unpack(pack(sent))}
    found["damaged"] = [refused(bad) for bad in damaged(pack(sent))]
    check("doors", "moos", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


# instruments


NAMED = {
    "gps": "gps",
    "altimeter": "altimeter",
    "depth": "depth",
    "dvl": "dvl",
    "imu": "imu",
    "singlebeam": "single",
    "mechanical_scanning_sonar": "scanner",
}
SPOKEN = [(protocol, kind) for protocol, kinds in SPEAKERS.items() for kind in kinds]


@pytest.fixture(scope="module")
def readings(rov: pl.Simulation) -> dict[str, list[tuple[str, Any]]]:
    """Of every sensor, in both states, each with the name of its state."""
    found: dict[str, list[tuple[str, Any]]] = {name: [] for name in SENSORS}
    for state in sorted(STATES, reverse=True):
        put(rov, state)
        heard = [
            rov.subscribe(f"a.{name}", lambda r, kept=found[name], state=state: kept.append((state, r)), invalid=True)
            for name in SENSORS
        ]
        rov.step(ticks=27)
        for one in heard:
            one.cancel()
    return found


def asked(protocol: str) -> list[bytes]:
    """Requests of a protocol, good ones and others."""
    if protocol == "waterlinked":
        said = [
            {"command": "get_config"},
            {"command": "set_config", "parameters": {"acoustic_enabled": False}},
            {"command": "reset_dead_reckoning"},
            {"command": "calibrate_gyro"},
            {"command": "trigger_ping"},
            {"command": "set_config", "parameters": {"range_mode": "=3"}},
        ]
        return [*(json.dumps(s).encode() + b"\n" for s in said), b"rubbish\n", b'{"command": "get']
    if protocol == "waterlinked_serial":
        return [
            b"wcv\r\nwcw\rwcc\n",
            b"wcs,,,n,,\n",
            b"wcs,1500,0.00,y,n,auto,n\r\n",
            b"wcs,1400,,,\n",
            b"wcs,1\n",
            b"wcp,3\nwcp,2\nwcx\nwcr\nwcg\n",
            b"wcv*00\nwcx",
            b"wcs,,,maybe,\n",
        ]
    if protocol == "ping1d":
        general = [
            ping.frame(ping.GENERAL_REQUEST, struct.pack("<H", n))
            for n in (
                4,
                5,
                1200,
                1201,
                1202,
                1203,
                1204,
                1205,
                1206,
                1207,
                1208,
                1210,
                1211,
                1212,
                1213,
                1214,
                1215,
                1300,
                1999,
            )
        ]
        sets = [
            (ping.SET_DEVICE_ID, "<B", 9),
            (ping.SET_SPEED_OF_SOUND, "<I", 1_430_000),
            (ping.SET_MODE_AUTO, "<B", 0),
            (ping.SET_PING_INTERVAL, "<H", 90),
            (ping.SET_GAIN, "<B", 5),
            (ping.SET_GAIN, "<B", 7),
            (ping.SET_MODE_AUTO, "<B", 2),
            (ping.SET_SPEED_OF_SOUND, "<I", 9),
            (ping.SET_GAIN, "<H", 1),
            (ping.CONTINUOUS_START, "<H", ping.PROFILE),
            (ping.CONTINUOUS_START, "<H", ping.DISTANCE_SIMPLE),
            (ping.CONTINUOUS_STOP, "<H", ping.DISTANCE_SIMPLE),
            (ping.CONTINUOUS_START, "<H", 5),
        ]
        ranges = [
            ping.frame(ping.SET_RANGE, struct.pack("<II", start, length)) for start, length in ((0, 0), (2000, 23_000))
        ]
        changed = [*(ping.frame(n, struct.pack(p, v)) for n, p, v in sets), *ranges]
        return [*general, *changed, *general, b"??" + general[3]]
    if protocol == "ping360":
        traced = [(1, 2, g, 9, 3000, 740, 90, 1, 0) for g in (0, 197, 203, 200, 350, 399, 400)]
        return [ping.frame(ping.TRANSDUCER, struct.pack("<BBHHHHHBB", *t)) for t in traced] + [
            ping.frame(n, b"") for n in (ping.DEVICE_DATA, ping.MOTOR_OFF, ping.DEVICE_INFORMATION, 77, 5)
        ]
    return []


def numbers_of(protocol: str, raw: bytes) -> Any:
    """An instrument's words, or its numbers where it speaks in numbers."""
    if not raw or protocol in ("nmea", "pd6", "nortek", "waterlinked", "waterlinked_serial", "vectornav"):
        return [line.partition("*")[0] for line in raw.decode("latin-1").split("\r\n")]
    if protocol == "pd0":
        shorts, at = np.frombuffer(raw[: len(raw) // 2 * 2 - 2], "<i2"), struct.unpack_from("<3H", raw, 6)
        return [shorts, struct.unpack_from("<4h", raw, at[2] + 24), struct.unpack_from("<HHHhh", raw, at[1] + 14)]
    if protocol == "mip":
        return struct.unpack_from(">2B3f", raw, 4) + struct.unpack_from(">2B3f", raw, 18) + (raw[:4],)
    if protocol == "vectornav_binary":
        return struct.unpack_from("<BHQ6f", raw, 1)
    return [[number, np.frombuffer(payload, np.uint8)] for number, payload in ping.Frames().feed(raw)]


@pytest.mark.parametrize(("protocol", "kind"), SPOKEN)
def test_what_instruments_say(
    rov: pl.Simulation, readings: dict[str, list[tuple[str, Any]]], protocol: str, kind: str
) -> None:
    config = rov.model.agents["a"].sensors[NAMED[kind]].config
    speaker = SPEAKERS[protocol][kind](Place(rov, "a", config, EPOCH))
    found: dict[str, list[Any]] = {"tells loss": [speaker.tells_loss]}
    before = ""
    for state, reading in readings[NAMED[kind]]:
        if state != before:
            put(rov, state)
            before = state
        found.setdefault(state, []).append(numbers_of(protocol, speaker.hear(reading)))
    requests = asked(protocol)
    if requests:
        found["answers"] = [numbers_of(protocol, speaker.answer(raw)) for raw in requests]
        last = readings[NAMED[kind]][-1][1]
        found["after"] = [numbers_of(protocol, speaker.hear(last)), getattr(speaker, "bad", 0)]
    speaker.begin()
    found["anew"] = [numbers_of(protocol, speaker.hear(readings[NAMED[kind]][0][1]))]
    share = 1e-3 if "ping" in protocol else NEAR  # levels of 8 bits
    check("doors", f"{protocol} {kind}", {name: on_one_scale(v) for name, v in found.items()}, share)


def test_sentences_and_ensembles() -> None:
    """From numbers of both signs, of both hemispheres, and unknown ones: to the byte."""
    dvl = DvlVelocity(
        3_250_000_000,
        (1.234, -0.567, 0.089),
        ((1e-4, 0.0, 2e-5), (0.0, 2e-4, 0.0), (2e-5, 0.0, 4e-4)),
        12.34,
        (13.1, 13.2, 13.3, 700.45),
        (0.4, -0.3, 0.2, -0.1),
        (True, True, False, True),
    )
    lost = DvlVelocity(dvl.t_ns, None, ((0.0,) * 3,) * 3, None, dvl.ranges_m, dvl.beam_velocity_mps, (False,) * 4)
    at, down = nmea.clock(3_256_789_000, EPOCH), (0.9, 0.8, 0.7, 0.5)
    attitudes = [teledyne.Attitude(271.5, -3.25, 4.75, 21.5), teledyne.Attitude(-35.25, 17.5, -8.25, 0.25)]
    ways = [teledyne.MadeGood((1.25, -2.5, 0.75), 9, 2.5), teledyne.MadeGood((-9.5, 4.25, -1.5), None, 5000.0)]
    found = {
        "nmea": [
            nmea.gga(at, -33.8567, 151.2153, -12.5, satellites=7),
            nmea.gga(at, 5.5, -0.25, 3.0),
            nmea.rmc(at, 45.5, -179.99, 2.5, -88.5),
            nmea.rmc(at, -0.5, 181.5, 1.5, 371.5),
            nmea.vtg(2.5, -10.0),
            nmea.hdt(-1.5),
            nmea.dbt(10.0),
            nmea.dbt(None),
            nmea.xdr_pressure(151_230.0),
            nmea.no_fix(at),
        ],
        "pd0": [teledyne.pd0(d, EPOCH, a, 1502.25, 0x12345, down) for d in (dvl, lost) for a in attitudes],
        "pd6": [
            teledyne.pd6(d, EPOCH, a, 1502.25, w) for d in (dvl, lost) for a, w in zip(attitudes, ways, strict=True)
        ],
        "enu": [teledyne.east_north_up((1.2, -0.7, 0.9), a) for a in attitudes],
        "a50": [
            waterlinked.report(d, 9_000_000)
            + waterlinked.serial_report(d, 9_000_000)
            + waterlinked.serial_transducers(d)
            for d in (dvl, lost)
        ],
        "crc": [vectornav.crc16(b"pelagos"), waterlinked.crc8(b"pelagos")],
    }
    check("doors", "sentences", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


def test_traces_of_pings() -> None:
    """Of echoes that are known, to the level of every sample."""
    trace = np.abs(np.sin(np.arange(64) * 0.9 + 0.3))[None] * np.linspace(1.1, 0.2, 64)
    config = SimpleNamespace(range_min_m=0.8, range_max_m=31.0, rate_hz=10.0)
    place: Any = SimpleNamespace(config=config)
    single, scanner = SPEAKERS["ping1d"]["singlebeam"](place), SPEAKERS["ping360"]["mechanical_scanning_sonar"](place)
    single.hear(SimpleNamespace(t_ns=0, data=trace))
    for degrees in (0.0, 4.0, -70.0, 133.0):
        angle = np.array([math.radians(degrees)])
        scanner.hear(SimpleNamespace(extras={"angle": angle}, data=trace * np.cos(degrees) ** 2))
    answers = [numbers_of("ping1d", single.answer(raw)) for raw in asked("ping1d")]
    answers += [numbers_of("ping360", scanner.answer(raw)) for raw in asked("ping360")]
    long = [payload for found in answers for _, payload in found if payload.size > 80]
    check("doors", "traces of pings", {str(k): on_one_scale(payload) for k, payload in enumerate(long)}, NEAR)


# ROS 2 and what goes its ways


def test_every_topic_of_a_run(rov: pl.Simulation) -> None:
    """As CDR through a transport, in JSON as rosbridge has it, in LCM; and how well each topic is served."""
    put(rov, "near the surface")
    exchange, transport = Exchange(rov, rate_hz=25.0), MemoryTransport()
    exchange.add(TopicDoor(transport, skip=("/tf_static",)))
    listed: list[Any] = []
    advertise = transport.advertise
    transport.advertise = lambda topic, kind, *, qos: (  # type: ignore[method-assign]
        listed.append([topic, kind, qos, qos_text(qos)]),
        advertise(topic, kind, qos=qos),
    )[1]
    exchange.run(0.12)
    begin = min(t for t, topic in transport.order if topic == "/a/truth")
    found: dict[str, Any] = {"topics": listed, "order": [[t - begin, topic] for t, topic in transport.order if t]}
    for topic, sent in transport.written.items():
        if topic in ("/outside/orders", "/labels") or not sent:
            continue
        messages = [deserialize(transport.types[topic], raw) for _, raw in sent]
        found[topic] = [messages, [to_json(m) for m in messages[-1:]]]
    exchange.close()
    check("doors", "topics", {name: on_one_scale(v) for name, v in found.items()}, 1e-4)


def test_structures_that_holoocean_hears(rov: pl.Simulation) -> None:
    lcm = pytest.importorskip("pelagos.bridges.lcm_transport")
    sent: list[tuple[str, bytes]] = []
    transport: Any = SimpleNamespace(publish=lambda channel, raw: sent.append((channel, raw)))
    put(rov, "deep")
    door = lcm.HoloOceanDoor(rov, transport)
    door.open(rov, Tap())
    rov.step(ticks=11)
    door.send(rov, ())
    door.close()
    floats = [[channel, np.frombuffer(raw[16 : 16 + len(raw[16:]) // 4 * 4], ">f4")] for channel, raw in sent]
    check(
        "doors",
        "structures",
        {
            "sent": on_one_scale(floats),
            "times": [raw[8:16].hex() for _, raw in sent] and [struct.unpack_from(">q", raw, 8)[0] for _, raw in sent],
        },
        1e-3,
    )


SAID: dict[str, list[dict[str, Any]]] = {
    "geometry_msgs/msg/Twist": [
        {"linear": {"x": 0.4, "y": -0.3, "z": 0.2}, "angular": {"x": -0.1, "y": 0.15, "z": -0.25}},
        {"linear": {"x": 0.6}, "angular": {"z": 0.2}},
    ],
    "geometry_msgs/msg/TwistStamped": [{"twist": {"linear": {"x": -0.4, "y": 0.2, "z": -0.1}, "angular": {"z": 0.3}}}],
    "geometry_msgs/msg/WrenchStamped": [
        {"wrench": {"force": {"x": 11, "y": -7, "z": 5}, "torque": {"x": -2, "y": 3, "z": -4}}}
    ],
    "geometry_msgs/msg/PoseStamped": [
        {"pose": {"position": {"x": 3.0, "y": -7.0, "z": -2.5}, "orientation": {"w": w, "x": x, "y": y, "z": z}}}
        for w, x, y, z in ((0.8, 0.36, -0.288, 0.384), (-0.48, 0.6, 0.64, 0.0), (0.5, 0.5, 0.5, 0.6))
    ],
    "geometry_msgs/msg/PointStamped": [{"point": {"x": 12.0, "y": -17.0, "z": -4.5}}],
    "std_msgs/msg/Float64MultiArray": [
        {"data": [0.1, -0.2, 0.3, -0.4, 0.25, -0.35, 0.45, -0.15]},
        {"data": [0.1, -0.2, 0.3]},
        {"data": [-0.2, 0.3]},
    ],
    "std_msgs/msg/Float64": [{"data": 0.37}, {"data": -0.23}],
    "std_msgs/msg/String": [{"data": "actuators"}],
}


@pytest.mark.parametrize("vehicle", COMMANDED)
def test_what_commands_do(rov: pl.Simulation, others: dict[str, pl.Simulation], vehicle: str) -> None:
    """Orders that messages stand for, and the command that the vehicle holds then."""
    sim = rov if vehicle == "bluerov2_heavy" else others[vehicle]
    sim.reset()
    sim.step()
    found: dict[str, Any] = {}
    for topic, (kind, make_order) in command_topics(sim, "a").items():
        done: list[Any] = []
        inbox = Inbox(sim)
        for said in SAID[kind]:
            sim.step(ticks=5)  # a heading moves on with the time between two velocities
            try:
                order = make_order(deserialize(kind, serialize(kind, from_json(kind, said))))
            except ValueError:
                done.append("refused")
                continue
            inbox.obey(order)
            held = sim.held_command("a")[0]
            done.append([order.kind, order.data, sim.stepper.mode("a"), held, inbox.refused.total(), str(order.key)])
            done.append(order_text(order, 50_000_000, 10_000_000, 7))
        found[topic] = done
        sim.set_mode("a", "actuators")
    check("doors", f"commands {vehicle}", {name: on_one_scale(v) for name, v in found.items()}, NEAR)


def test_holooceans_nodes_command(others: dict[str, pl.Simulation]) -> None:
    sim, kept, transport = others["remus100"], Kept(), MemoryTransport()
    listen_holoocean(transport, sim, kept)  # type: ignore[arg-type]
    for topic, kind in transport.types.items():
        about = {"header": {"frame_id": "a"}}
        for value in (35.0, -80.0):
            told = {"command": [value, -0.2, 0.3]} if "AgentCommand" in kind else {"data": value}
            transport.say(topic, serialize(kind, from_json(kind, about | told)))
    check("doors", "HoloOcean's nodes", {"orders": on_one_scale(kept.orders)}, NEAR)


SI = "simulation_interfaces/srv/"
POSED = {"position": {"x": 2.5, "y": 30.0, "z": -6.5}, "orientation": {"w": 0.8, "x": 0.36, "y": -0.288, "z": 0.384}}
TWIST = {"linear": {"x": 0.5, "y": 0.25, "z": -0.1}, "angular": {"x": 0.1, "y": -0.2, "z": 0.3}}
BOX = {"resource_string": '{"shape": "box", "size": [1, 2, 3]}'}
CALLS: list[tuple[str, dict[str, Any]]] = [
    ("get_simulator_features", {}),
    ("get_simulation_state", {}),
    ("step_simulation", {"steps": 4}),
    ("get_entities", {}),
    ("get_entity_state", {"entity": "a"}),
    ("get_entity_state", {"entity": "b"}),
    (
        "set_entity_state",
        {"entity": "a", "set_pose": True, "set_twist": True, "state": {"pose": POSED, "twist": TWIST}},
    ),
    ("get_entity_state", {"entity": "a"}),
    ("set_entity_state", {"entity": "a", "set_acceleration": True}),
    ("set_entity_state", {"entity": "a", "set_twist": True, "state": {"twist": TWIST}}),
    ("set_entity_state", {"entity": "a", "set_pose": True, "state": {"pose": {"orientation": {"w": 3.0}}}}),
    ("spawn_entity", {"name": "box", "entity_resource": BOX, "initial_pose": {"pose": POSED}}),
    ("spawn_entity", {"name": "box", "entity_resource": BOX, "initial_pose": {"pose": POSED}}),
    (
        "spawn_entity",
        {"name": "box", "allow_renaming": True, "entity_resource": {"uri": "sphere"}, "initial_pose": {"pose": POSED}},
    ),
    ("spawn_entity", {"name": "", "entity_resource": BOX, "initial_pose": {"pose": POSED}}),
    ("spawn_entity", {"name": "\x1b", "entity_resource": BOX, "initial_pose": {"pose": POSED}}),
    ("spawn_entity", {"name": "bad", "entity_resource": {"resource_string": "[1"}, "initial_pose": {"pose": POSED}}),
    ("get_entities", {}),
    ("get_entity_state", {"entity": "box"}),
    ("delete_entity", {"entity": "box"}),
    ("delete_entity", {"entity": "box"}),
    ("get_entities", {}),
    ("set_ocean", {"name": "current", "values": [0.3, -0.2, 0.1]}),
    ("set_ocean", {"name": "turbidity", "values": [2.5]}),
    ("set_ocean", {"name": "salt", "values": [2.5]}),
    ("set_control_mode", {"agent": "a", "mode": "velocity"}),
    ("set_control_mode", {"agent": "a", "mode": "none"}),
    ("set_paused", {"data": True}),
    ("get_simulation_state", {}),
    *(("set_simulation_state", {"state": {"state": s}}) for s in (2, 1, 0, 9, 1, 3)),
    ("set_paused", {"data": False}),
    *(("reset_simulation", {"scope": s}) for s in (0, 1, 7, 255)),
    ("reset", {}),
]


def test_services(rov: pl.Simulation, monkeypatch: pytest.MonkeyPatch) -> None:
    """Answers of the services of a run that stands at a boundary, and what is asked of it."""
    put(rov, "deep")
    exchange, transport, asks = Exchange(rov), MemoryTransport(), list[Any]()

    def at_once(order: Any) -> Ticket:
        ticket = Ticket(order)
        exchange.inbox._do(ticket)
        asks.append([ticket.order.kind, ticket.order.target, ticket.order.data, bool(ticket.refusal)])
        return ticket

    paused = {"now": False}
    monkeypatch.setattr(exchange.inbox, "put", at_once)
    monkeypatch.setattr(exchange, "do", lambda action: action() or True)
    monkeypatch.setattr(
        exchange, "step", lambda ticks: SimpleNamespace(wait=lambda s: asks.append(["step", ticks, s]) or True)
    )
    monkeypatch.setattr(exchange, "reset", lambda: asks.append("reset"))
    monkeypatch.setattr(exchange, "resume", lambda: paused.update(now=False))
    monkeypatch.setattr(rov, "pause", lambda: paused.update(now=True))
    monkeypatch.setattr(rov, "stop", lambda: asks.append("stop"))
    monkeypatch.setattr(type(rov), "paused", property(lambda sim: paused["now"]))
    services = Services(exchange)
    assert services.offer(transport)
    services.offer_holoocean(transport)
    services.listen(transport)
    told: list[Any] = []

    def call(service: str, request: dict[str, Any]) -> None:
        kind = transport.types[service]
        raw = transport.call(service, serialize(f"{kind}_Request", from_json(f"{kind}_Request", request)))
        answer = to_json(deserialize(f"{kind}_Response", raw))
        told.append([service, {name: v for name, v in answer.items() if name != "custom_info"}])

    for name, request in CALLS:
        call(f"/pelagos/{name}", request)
    call("/pelagos/set_paused", {"data": True})
    call("/pelagos/step_simulation", {"steps": 4})
    call("/pelagos/step_simulation", {"steps": 0})
    call("/pelagos/step_simulation", {"steps": 1 << 40})
    for mode in range(5):
        call("/holoocean/control_mode", {"vehicle_name": "a", "mode": mode})
    call("/holoocean/control_mode", {"vehicle_name": "b", "mode": 0})
    for topic, said in (("/sim/reset", {}), ("/sim/set_paused", {"data": False}), ("/sim/step", {"data": 6})):
        transport.say(topic, serialize(transport.types[topic], from_json(transport.types[topic], said)))
    transport.say("/sim/step", serialize("std_msgs/msg/UInt64", from_json("std_msgs/msg/UInt64", {"data": 0})))
    found = {"told": told, "asked": asks, "refused": exchange.inbox.refused.total(), "types": transport.types}
    rov.ocean.set(current=None)
    check("doors", "services", {name: on_one_scale(v) for name, v in found.items()}, NEAR)

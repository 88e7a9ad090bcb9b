"""Instruments' languages, read by public parsers or compared with makers' own examples; ports; whole runs."""

from __future__ import annotations

import json
import os
import re
import socket
import struct
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from datetime import UTC, datetime
from functools import cache
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos.bridges.door import TopicDoor
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.foxglove_transport import FoxgloveConfig
from pelagos.bridges.instrument import InstrumentConfig
from pelagos.bridges.instruments import mip, nmea, nortek, ping, teledyne, vectornav, waterlinked
from pelagos.bridges.instruments.a50 import WaterLinkedJson, WaterLinkedSerial
from pelagos.bridges.instruments.dvl_velocity import DvlVelocity
from pelagos.bridges.instruments.ping_devices import Ping1d
from pelagos.bridges.instruments.ports import PtyPort, TcpPort, UdpServerPort, open_port
from pelagos.bridges.instruments.speakers import Pd6
from pelagos.bridges.rosbridge import RosbridgeConfig
from pelagos.bridges.transport import BridgeMismatch, MemoryTransport
from pelagos.cli.doors import check_doors

EPOCH = datetime(2026, 6, 1, 23, 59, 58, tzinfo=UTC)
DVL = DvlVelocity(
    3_250_000_000, (1.234, -0.567, 0.089),
    ((1e-4, 0.0, 2e-5), (0.0, 2e-4, 0.0), (2e-5, 0.0, 4e-4)),
    12.34, (13.1, 13.2, 13.3, 700.45), (0.4, -0.3, 0.2, -0.1), (True, True, False, True),
)  # fmt: skip
LOST = DvlVelocity(DVL.t_ns, None, DVL.covariance, None, DVL.ranges_m, DVL.beam_velocity_mps, (False,) * 4)
DOWN = (0.9, 0.8, 0.9, 0.5)
ATTITUDE = teledyne.Attitude(271.5, -3.25, 4.75, 21.5)


def test_nmea_is_read_by_pynmea2() -> None:
    pynmea2 = pytest.importorskip("pynmea2")
    at = nmea.clock(3_250_000_000, EPOCH)  # past midnight

    def parsed(raw: bytes) -> Any:
        assert raw.endswith(b"\r\n")
        return pynmea2.parse(raw.decode().strip(), check=True)

    found = parsed(nmea.gga(at, -33.8567, 151.2153, 12.5))
    assert (found.latitude, found.longitude) == (pytest.approx(-33.8567, abs=2e-7), pytest.approx(151.2153, abs=2e-7))
    assert (found.altitude, found.gps_qual) == (12.5, 1)
    assert (found.timestamp.hour, found.timestamp.second, found.timestamp.microsecond) == (0, 1, 250_000)
    found = parsed(nmea.rmc(at, 45.5, -12.25, 2.5, 271.5))
    assert (found.latitude, found.longitude) == (pytest.approx(45.5), pytest.approx(-12.25))
    assert found.spd_over_grnd == pytest.approx(2.5 * 3600 / 1852, abs=1e-3)
    assert (found.true_course, str(found.datestamp), found.status) == (271.5, "2026-06-02", "A")
    found = parsed(nmea.vtg(2.5, -10.0))
    assert (float(found.true_track), float(found.spd_over_grnd_kmph)) == (350.0, 9.0)
    assert float(parsed(nmea.hdt(-1.0)).heading) == 359.0
    near_north = [float(parsed(nmea.hdt(h)).heading) for h in (359.996, -0.004, 359.994, 360.0)]
    assert near_north == [0.0, 0.0, 359.99, 0.0]
    found = parsed(nmea.dbt(10.0))
    assert (float(found.depth_meters), float(found.depth_feet)) == (10.0, pytest.approx(32.81))
    assert parsed(nmea.dbt(float("nan"))).depth_meters in (None, "")
    assert float(parsed(nmea.xdr_pressure(151_230.0)).get_transducer(0).value) == pytest.approx(1.5123)


def test_nmea_minutes_never_read_sixty() -> None:
    at = nmea.clock(0, EPOCH)
    raw = nmea.gga(at, 45.0 - 1e-10, -180.0, 0.0).decode()
    assert "4500.00000,N" in raw
    assert "18000.00000,W" in raw


def test_checksums_are_those_of_published_sentences() -> None:
    """From Water Linked's protocol page, Nortek's integrator's guide, and an NMEA receiver's manual."""
    wrz = "wrz,0.120,-0.400,2.000,y,1.30,1.855,1e-07;0;1.4;0;1.2;0;0.2;0;1e+09,7,14,123.00,1"
    assert waterlinked.serial_sentence(wrz) == f"{wrz}*50\r\n".encode()
    body = "PNORBT7,1452244916.7508,1.234,-1.234,0.1234,0.1234,0.1234,12.34,23.45,23.45,23.45,23.45"
    assert nmea.sentence(body) == f"${body}*39\r\n".encode()
    gga = "GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,"
    assert nmea.sentence(gga).endswith(b"*47\r\n")


def test_the_a50_speaks_json_and_serial() -> None:
    said = json.loads(waterlinked.report(DVL, DVL.t_ns - 100_000_000))
    assert (said["vx"], said["vy"], said["vz"], said["altitude"]) == (1.234, -0.567, 0.089, 12.34)
    assert (said["type"], said["format"], said["velocity_valid"]) == ("velocity", "json_v3.1", True)
    assert said["time"] == pytest.approx(100.0)  # ms since the report before
    assert [b["beam_valid"] for b in said["transducers"]] == [True, True, False, True]
    assert said["transducers"][1] == {
        "id": 1, "velocity": -0.3, "distance": 13.2, "rssi": -40, "nsd": -95, "beam_valid": True
    }  # fmt: skip
    assert said["fom"] == pytest.approx(0.02)
    lost = json.loads(waterlinked.report(LOST, 0))
    assert (lost["velocity_valid"], lost["altitude"]) == (False, -1.0)
    fields = waterlinked.serial_report(DVL, 0).decode().strip().partition("*")[0].split(",")
    assert fields[:7] == ["wrz", "1.234", "-0.567", "0.089", "y", "12.34", "0.020"]
    assert [float(v) for v in fields[7].split(";")] == [1e-4, 0, 2e-5, 0, 2e-4, 0, 2e-5, 0, 4e-4]
    assert fields[8] == "3250000"


def test_an_a50_answers_a_command_that_comes_in_parts() -> None:
    place: Any = SimpleNamespace()
    a50 = WaterLinkedSerial(place)
    assert a50.answer(b"wc") == b""
    assert a50.answer(b"v\r\nwc").startswith(b"wrv,2,5,0*")
    assert a50.answer(b"s\r") == waterlinked.serial_sentence("wr?")
    assert a50.answer(b"x" * 100_000) == b""
    assert len(a50._begun) < 1000


def test_an_a50_refuses_a_wrong_checksum() -> None:
    a50 = WaterLinkedSerial(SimpleNamespace())  # type: ignore[arg-type]
    check = b"%02x" % waterlinked.crc8(b"wcv")
    assert a50.answer(b"wcv*" + check.upper() + b"\r\n").startswith(b"wrv,2,5,0*")
    assert a50.answer(b"wcv*00\r\n") == waterlinked.serial_sentence("wr!")
    assert a50.answer(b"wxx\r\n") == waterlinked.serial_sentence("wr?")


def test_an_a50_answers_commands_in_json(monkeypatch: pytest.MonkeyPatch) -> None:
    a50 = WaterLinkedJson(SimpleNamespace(config=SimpleNamespace(beams=())))  # type: ignore[arg-type]
    monkeypatch.setattr(DvlVelocity, "of", lambda reading, beams: DVL)
    monkeypatch.setattr(a50, "turn", lambda: [1.0, 0.0, 0.0, 0.0])

    def ask(raw: bytes) -> dict[str, Any]:
        found: dict[str, Any] = json.loads(a50.answer(raw))
        assert (found["type"], found["format"]) == ("response", "json_v3.1")
        return found

    assert a50.answer(b'{"command": "get') == b""
    found = ask(b'_config"}')  # a driver's command without an end of line
    assert (found["response_to"], found["success"], found["result"]["acoustic_enabled"]) == ("get_config", True, True)
    same = {"command": "set_config", "parameters": {"speed_of_sound": 1500, "range_mode": "auto"}}
    assert ask(json.dumps(same).encode() + b"\n")["success"]
    other = {"command": "set_config", "parameters": {"acoustic_enabled": False, "mounting_rotation_offset": 20}}
    refused = ask(json.dumps(other).encode() + b"\n")
    assert (refused["success"], "mounting_rotation_offset" in refused["error_message"]) == (False, True)
    assert a50.hear(None)
    del other["parameters"]["mounting_rotation_offset"]  # type: ignore[attr-defined]
    assert ask(json.dumps(other).encode() + b"\r\n")["success"]
    assert a50.hear(None) == b""  # it is silent, and 0.2 s have not passed since its position was told
    assert not ask(b'{"command": "trigger_ping"}\n')["success"]
    assert (ask(b"rubbish\n")["success"], a50.bad) == (False, len(b"rubbish"))


def test_after_a_reset_a_log_counts_from_the_beginning(monkeypatch: pytest.MonkeyPatch) -> None:
    """No time before the last report is negative, no way made good and no number is that of the run before."""
    early, late = replace(DVL, t_ns=100_000_000), replace(DVL, t_ns=300_000_000)
    monkeypatch.setattr(DvlVelocity, "of", lambda reading, beams: reading)
    place: Any = SimpleNamespace(config=SimpleNamespace(beams=()), epoch=EPOCH)
    a50, pd6 = WaterLinkedJson(place), Pd6(place)
    monkeypatch.setattr(pd6, "attitude", lambda: ATTITUDE)
    monkeypatch.setattr(a50, "turn", lambda: [1.0, 0.0, 0.0, 0.0])
    first = pd6.hear(early)
    assert b":BD,+00000000.00" not in pd6.hear(late)
    a50.hear(late)
    for log in (a50, pd6):
        log.begin()
    assert (json.loads(a50.hear(early).splitlines()[0])["time"], a50.number) == (100.0, 1)
    assert pd6.hear(early) == first


def test_pd6_gives_the_ships_movement() -> None:
    """Transverse to starboard, longitudinal ahead, normal up; a heading of 271.5 degrees looks to the west."""
    made_good = teledyne.MadeGood((1.25, -2.5, 0.75), 0, 2.5)
    raw = teledyne.pd6(DVL, EPOCH, ATTITUDE, 1500.0, made_good)
    lines = dict(line.split(",", 1) for line in raw.decode().splitlines())
    assert lines[":SA"] == "-03.25,+04.75,271.50"
    assert lines[":TS"].split(",")[0] == "26060200000125"
    assert lines[":BS"] == "-00567,+01234,-00089,A"
    assert lines[":BI"].split(",")[:3] == ["-00567", "+01234", "-00089"]
    turn = Rotation.from_euler("ZYX", [271.5, -3.25, 4.75], degrees=True)
    north, east, down = turn.apply([1.234, -0.567, 0.089])
    assert [int(v) for v in lines[":BE"].split(",")[:3]] == [round(1000 * v) for v in (east, north, -down)]
    assert int(lines[":BE"].split(",")[0]) < -1200  # it goes west
    # Pathfinder DVL guide, table 50: +EEEEEEEE.EE, +NNNNNNNN.NN, +UUUUUUUU.UU, DDDD.DD, TTT.TT
    assert lines[":BD"] == "+00000001.25,-00000002.50,+00000000.75,0012.34,002.50"
    lost = teledyne.pd6(LOST, EPOCH, ATTITUDE, 1500.0, made_good).decode()
    assert ":BS,-32768,-32768,-32768,V" in lost
    assert ":BE,-32768,-32768,-32768,V" in lost


@pytest.mark.parametrize("angles", [(35.0, 20.0, -40.0), (-150.0, -35.0, 25.0), (110.0, 50.0, 15.0)])
def test_a_velocity_to_the_east_north_and_up(angles: tuple[float, float, float]) -> None:
    """SciPy's rotation Rz Ry Rx: each of the nine elements weighs."""
    north, east, down = Rotation.from_euler("ZYX", angles, degrees=True).apply([1.2, -0.7, 0.9])
    found = teledyne.east_north_up((1.2, -0.7, 0.9), teledyne.Attitude(*angles, 5.0))
    np.testing.assert_allclose(found, (east, north, -down), atol=1e-12)


def test_pd6_adds_up_the_way_and_counts_the_time_without_lock() -> None:
    """Ahead at 2 m/s with the nose 30 degrees up and north: sqrt(3) north and 1 up a second; two seconds are lost."""
    attitude, way = teledyne.Attitude(0.0, 30.0, 0.0, 5.0), teledyne.MadeGood()
    for t_s, velocity in ((7, (2.0, 0.0, 0.0)), (8, (2.0, 0.0, 0.0)), (9, None), (10, None), (11, (2.0, 0.0, 0.0))):
        way = way.after(replace(DVL, t_ns=t_s * 1_000_000_000, velocity=velocity), attitude)
        assert way.since_s == {9: 1.0, 10: 2.0}.get(t_s, 0.0)
    np.testing.assert_allclose(way.distance_m, [0.0, 4 * np.sqrt(3), 4.0], atol=1e-12)


def test_pd0_has_the_layout_of_the_manual() -> None:
    """Offsets of Teledyne's tables; the bottom moves opposite to the ship."""
    raw = teledyne.pd0(DVL, EPOCH, ATTITUDE, 1502.0, 0x12345, DOWN)
    assert raw[:2] == b"\x7f\x7f"
    size = struct.unpack_from("<H", raw, 2)[0]
    assert len(raw) == size + 2
    assert struct.unpack_from("<H", raw, size)[0] == sum(raw[:size]) & 0xFFFF
    offsets = struct.unpack_from(f"<{raw[5]}H", raw, 6)
    parts = {struct.unpack_from("<H", raw, o)[0]: raw[o:] for o in offsets}
    assert set(parts) == {0x0000, 0x0080, 0x0600}
    fixed, variable, bottom = parts[0x0000], parts[0x0080], parts[0x0600]
    assert fixed[8] == 4  # beams
    assert fixed[25] >> 3 & 3 == 2  # ship coordinates
    assert struct.unpack_from("<H", variable, 2)[0] + (variable[11] << 16) == 0x12345
    assert tuple(variable[4:11]) == (26, 6, 2, 0, 0, 1, 25)
    speed, depth, heading, pitch, roll = struct.unpack_from("<HHHhh", variable, 14)
    assert (speed, depth, heading, pitch, roll) == (1502, 215, 27150, -325, 475)
    starboard, ahead, up, _ = struct.unpack_from("<4h", bottom, 24)
    assert (starboard, ahead, up) == (567, -1234, 89)
    ranges = [lo + (hi << 16) for lo, hi in zip(struct.unpack_from("<4H", bottom, 16), bottom[77:81], strict=True)]
    # "Vertical range ... as determined by each beam": 100 * 13.1 * 0.9, 100 * 13.2 * 0.8, none, 100 * 700.45 * 0.5
    assert ranges == [1179, 1056, 0, 35022]
    lost = teledyne.pd0(LOST, EPOCH, ATTITUDE, 1502.0, 1, DOWN)
    at = struct.unpack_from(f"<{lost[5]}H", lost, 6)[2]
    assert struct.unpack_from("<4h", lost, at + 24) == (-32768,) * 4


@pytest.mark.parametrize(("angle_deg", "code"), [(15, 0), (20, 1), (25, 3), (30, 2)])
def test_pd0_states_the_angle_of_the_beams(angle_deg: int, code: int) -> None:
    """Table "system configuration", second byte, bits 1 and 0: 15, 20, 30 degrees or another one; byte 59 the angle."""
    raw = teledyne.pd0(DVL, EPOCH, ATTITUDE, 1502.0, 1, (np.cos(np.radians(angle_deg)),) * 4)
    fixed = raw[struct.unpack_from("<H", raw, 6)[0] :]
    assert fixed[5] == 0b0100_0000 | code
    assert fixed[58] == angle_deg


def test_nortek_gives_vertical_distances() -> None:
    raw = nortek.bottom_track(DVL, EPOCH, (0.9, 0.9, 0.9, 0.5)).decode()
    fields = raw.partition("*")[0].split(",")
    assert fields[0] == "$PNORBT7"
    assert float(fields[1]) == pytest.approx(EPOCH.timestamp() + 3.25)
    assert [float(v) for v in fields[4:7]] == [1.234, -0.567, 0.089]
    assert [float(v) for v in fields[8:12]] == [11.79, 11.88, 0.0, pytest.approx(350.225, abs=0.01)]
    assert "-32.7680,-32.7680,-32.7680" in nortek.bottom_track(LOST, EPOCH, (1.0,) * 4).decode()


def test_vectornav_messages() -> None:
    """The CRC of a message with its CRC is 0 (VectorNav's manual); CRC-16 XMODEM of "123456789" is 0x31C3."""
    assert vectornav.crc16(b"123456789") == 0x31C3
    raw = vectornav.binary(5_000_000_001, (1.5, -2.5, -9.81), (0.1, -0.2, 0.3))
    assert raw[:2] == b"\xfa\x01"
    assert vectornav.crc16(raw[1:]) == 0
    fields, t_ns, *values = struct.unpack_from("<HQ6f", raw, 2)
    assert (fields, t_ns) == (0x0121, 5_000_000_001)
    np.testing.assert_allclose(values, [0.1, -0.2, 0.3, 1.5, -2.5, -9.81], rtol=1e-6)
    text = vectornav.text((1.5, -2.5, -9.81), (0.1, -0.2, 0.3)).decode().strip()
    assert re.fullmatch(r"\$VNIMU(,[+-]\d+\.\d+){11}\*[0-9A-F]{2}", text)
    assert [float(v) for v in text[7:-3].split(",")][3:9] == [1.5, -2.5, -9.81, 0.1, -0.2, 0.3]


def test_ping_frames_survive_noise() -> None:
    rng = np.random.Generator(np.random.PCG64(3))
    frames, got = ping.Frames(), []
    good = ping.frame(ping.GENERAL_REQUEST, struct.pack("<H", ping.DISTANCE))
    stream = b"".join(rng.bytes(int(rng.integers(0, 30))) + good for _ in range(300)) + b"BR" + rng.bytes(40)
    at = 0
    while at < len(stream):
        step = int(rng.integers(1, 50))
        got += list(frames.feed(stream[at : at + step]))
        at += step
    assert sum(message == (ping.GENERAL_REQUEST, struct.pack("<H", ping.DISTANCE)) for message in got) > 290
    assert frames.bad > 100
    for _ in range(20_000):
        list(frames.feed(rng.bytes(7)))
    assert len(frames._waiting) < ping.LONGEST + 100


def ping1d() -> tuple[Ping1d, Callable[..., tuple[int, bytes]]]:
    """A device over 0.3 .. 50 m, and a way to ask it."""
    device = Ping1d(SimpleNamespace(config=SimpleNamespace(range_min_m=0.3, range_max_m=50.0, rate_hz=8.0)))  # type: ignore[arg-type]
    frames = ping.Frames()

    def ask(number: int, payload: bytes = b"") -> tuple[int, bytes]:
        (found,) = frames.feed(device.answer(ping.frame(number, payload)))
        return found

    return device, ask


def heard(*data: float, t_s: float = 0.0) -> Any:
    return SimpleNamespace(data=np.array([data]), t_ns=round(t_s * 1e9))


def test_a_ping1d_keeps_its_settings_and_refuses_what_it_does_not_know() -> None:
    device, ask = ping1d()
    assert ask(ping.SET_RANGE, struct.pack("<II", 500, 20_000)) == (ping.ACK, struct.pack("<H", ping.SET_RANGE))
    assert ask(ping.RANGE) == (ping.RANGE, struct.pack("<II", 500, 20_000))
    assert ask(ping.GENERAL_REQUEST, struct.pack("<H", ping.GAIN)) == (ping.GAIN, struct.pack("<I", 3))
    assert ask(ping.SET_GAIN, b"\5")[0] == ping.ACK  # set by 8 bits, told in 32
    assert ask(ping.GAIN)[1] == struct.pack("<I", 5)
    for number, payload in (
        (ping.SET_RANGE, b"\1"), (ping.SET_GAIN, b"\7"), (ping.SET_MODE_AUTO, b"\2"), (999, b"xx"),
        (ping.SET_SPEED_OF_SOUND, struct.pack("<I", 1500)), (ping.SET_RANGE, struct.pack("<II", 500, 0)),
        (ping.CONTINUOUS_START, struct.pack("<H", 77)),
    ):  # fmt: skip
        assert ask(number, payload)[0] == ping.NACK
    assert ask(ping.GAIN)[1] == struct.pack("<I", 5)
    assert ask(ping.CONTINUOUS_START, struct.pack("<H", ping.DISTANCE)) == (
        ping.ACK, struct.pack("<H", ping.CONTINUOUS_START),
    )  # fmt: skip
    ((number, payload),) = ping.Frames().feed(device.hear(heard(7.25)))
    assert (number, struct.unpack_from("<IH", payload)) == (ping.DISTANCE, (7250, 100))
    assert device.answer(b"rubbish") == b""


def test_the_settings_of_a_ping1d_change_what_it_reads() -> None:
    device, ask = ping1d()

    def distance() -> tuple[int, int]:
        return struct.unpack_from("<IH", ask(ping.DISTANCE)[1])  # type: ignore[return-value]

    device.hear(heard(7.25))
    ask(ping.SET_SPEED_OF_SOUND, struct.pack("<I", 1_450_000))
    assert distance() == (round(7250 * 1450 / 1500), 100)
    ask(ping.SET_RANGE, struct.pack("<II", 500, 5_000))
    assert distance()[0] == round(7250 * 1450 / 1500)  # auto: the device looks where it likes
    ask(ping.SET_MODE_AUTO, b"\0")
    assert distance() == (0, 0)  # beyond the range that was set
    ask(ping.SET_RANGE, struct.pack("<II", 500, 8_000))
    ask(ping.SET_PING_INTERVAL, struct.pack("<H", 300))
    device.hear(heard(3.0, t_s=0.2))  # too soon
    assert distance()[0] == round(7250 * 1450 / 1500)
    device.hear(heard(3.0, t_s=0.35))
    assert distance()[0] == 2900
    ask(ping.SET_PING_ENABLE, b"\0")
    device.hear(heard(4.0, t_s=9.0))
    assert distance()[0] == 2900
    ask(ping.SET_PING_ENABLE, b"\1")
    device.hear(heard(float("nan"), t_s=10.0))
    assert distance() == (0, 0)


def test_a_ping1d_tells_its_rate_and_its_temperature() -> None:
    _, ask = ping1d()
    assert struct.unpack("<H", ask(ping.PING_INTERVAL)[1]) == (125,)  # ms, of 8 Hz
    assert struct.unpack_from("<HHHH", ask(ping.GENERAL_INFO)[1])[3] == 125
    for number in (ping.PROCESSOR_TEMPERATURE, ping.BOARD_TEMPERATURE):
        assert struct.unpack("<H", ask(number)[1]) == (2500,)


def test_a_ping1ds_profile_lies_over_the_range_that_was_set() -> None:
    """One echo, in the bin at 10 m of a trace of 497 bins of 0.1 m."""
    device, ask = ping1d()
    trace = np.zeros(497)
    trace[97] = 0.8
    device.hear(heard(*trace))
    ask(ping.SET_MODE_AUTO, b"\0")
    ask(ping.SET_RANGE, struct.pack("<II", 5_000, 20_000))
    payload = ask(ping.PROFILE)[1]
    start, length = struct.unpack_from("<II", payload, 12)
    levels = np.frombuffer(payload[26:], dtype=np.uint8)
    assert (start, length, len(levels)) == (5_000, 20_000, 200)
    assert np.argmax(levels) == pytest.approx((10.05 - 5.0) / 20.0 * 200 - 0.5, abs=0.6)
    assert struct.unpack_from("<IH", payload) == (10_050, 80)


def test_mip_packets_have_fletchers_checksum() -> None:
    """The ping command and its checksum are the example of MicroStrain's manuals."""
    assert mip.packet(0x01, mip.field(0x01, b"")) == bytes.fromhex("75650102 0201 E0C6".replace(" ", ""))
    raw = mip.inertial(5_000_000_001, (1.5, -2.5, -9.80665), (0.1, -0.2, 0.3))
    assert raw[:4] == bytes([0x75, 0x65, 0x80, 14 + 14 + 10])
    fields, at = {}, 4
    while at < len(raw) - 2:
        fields[raw[at + 1]] = raw[at + 2 : at + raw[at]]
        at += raw[at]
    np.testing.assert_allclose(
        struct.unpack(">3f", fields[0x04]), [1.5 / 9.80665, -2.5 / 9.80665, -1.0], rtol=1e-6
    )  # in g
    np.testing.assert_allclose(struct.unpack(">3f", fields[0x05]), [0.1, -0.2, 0.3], rtol=1e-6)
    assert struct.unpack(">Q", fields[0xD5]) == (5_000_000_001,)


@pytest.mark.parametrize(
    ("protocol", "lost"),
    [("waterlinked", b'"velocity_valid": false'), ("waterlinked_serial", b",n,-1.00,"),
     ("pd6", b":BS,-32768,-32768,-32768,V"), ("nortek", b"-32.7680,-32.7680,-32.7680")],
)  # fmt: skip
def test_a_dvl_without_bottom_lock_says_so(protocol: str, lost: bytes, far: pl.Simulation) -> None:
    """400 m over the bottom, beyond the reach of its beams."""
    far.reset()
    exchange = Exchange(far)
    InstrumentConfig(type="instrument", protocol=protocol, sensors=("a.dvl",), port="tcp:0").attach(exchange)  # type: ignore[arg-type]
    door: Any = exchange.doors[0]
    with socket.create_connection(("127.0.0.1", door.port.port), timeout=10) as s:
        exchange.run(1.0)
        said = s.recv(65536)
    exchange.close()
    assert door.spoken == 6  # 0 to 1 s at 5 Hz
    assert said.count(lost) == 6


def test_a_receiver_without_a_fix_and_a_sounder_without_an_echo() -> None:
    pynmea2 = pytest.importorskip("pynmea2")
    lines = nmea.no_fix(nmea.clock(0, EPOCH)).decode().split()
    fix, minimum = (pynmea2.parse(line, check=True) for line in lines)
    assert (fix.gps_qual, fix.lat, fix.num_sats) == (0, "", "00")
    assert (minimum.status, str(minimum.datestamp)) == ("V", "2026-06-01")


@pytest.fixture(scope="module")
def far() -> pl.Simulation:
    agent = {"vehicle": "bluerov2_heavy", "start": {"position_m": [3, -2], "depth_m": 5.0},
             "sensors": {"dvl": {"type": "dvl", "device": "waterlinked_a50", "rate_hz": 5}}}  # fmt: skip
    return pl.Simulation.load({"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 405.0}, "agents": {"a": agent}})


SCENARIO: dict[str, Any] = {
    "tick_rate_hz": 100, "seed": 4, "world": {"type": "flat", "depth_m": 20.0},
    "agents": {"a": {
        "vehicle": "bluerov2_heavy", "start": {"position_m": [3, -2], "depth_m": 5.0, "heading_deg": 40},
        "control": "velocity", "command": [0.4, 0, 0, 0],
        "sensors": {
            "dvl": {"type": "dvl", "rate_hz": 10}, "altimeter": {"type": "altimeter", "rate_hz": 10},
            "depth": {"type": "depth", "rate_hz": 10}, "imu": {"type": "imu", "rate_hz": 50},
            "scanner": {"type": "mechanical_scanning_sonar", "rate_hz": 10, "bins": 64, "range_max_m": 25.0},
        },
    }},
}  # fmt: skip


@cache
def simulation() -> pl.Simulation:
    """One for all tests of this file, which begin with a reset; what is recorded at first takes long."""
    sim = pl.Simulation.load(SCENARIO)
    sim.run(0.2)
    return sim


def serve(script: Callable[[Any], None], seconds: float = 60.0, *, realtime: float = 1.0, **config: Any) -> Any:
    """Run a simulation with one instrument while a driver talks to it."""
    sim = simulation()
    sim.reset()
    exchange = Exchange(sim, realtime=realtime)
    InstrumentConfig(type="instrument", **config).attach(exchange)
    door: Any = exchange.doors[0]
    failure: list[BaseException] = []

    def run() -> None:
        try:
            script(door.port)
        except BaseException as error:
            failure.append(error)
        finally:
            sim.stop()

    thread = threading.Thread(target=run)
    thread.start()
    exchange.run(seconds)
    thread.join()
    report = exchange.close()
    if failure:
        raise failure[0]
    return sim, report


def test_a_driver_reads_a_dvl_over_tcp() -> None:
    lines: list[dict[str, Any]] = []

    def script(port: Any) -> None:
        with socket.create_connection(("127.0.0.1", port.port), timeout=120) as s, s.makefile("r") as file:
            while len(lines) < 15:
                said = json.loads(file.readline())
                if said["type"] == "velocity":
                    lines.append(said)

    serve(script, protocol="waterlinked", sensors=("dvl",), port="tcp:0")
    assert lines[-1]["velocity_valid"]
    assert lines[-1]["altitude"] == pytest.approx(15.0, abs=0.5)
    assert lines[-1]["vx"] == pytest.approx(0.4, abs=0.15)
    times = np.array([line["time_of_validity"] for line in lines])
    assert set(np.diff(times).tolist()) == {100_000}


def test_a_driver_reads_a_serial_port(tmp_path: Path) -> None:
    link, got = tmp_path / "sounder", bytearray()

    def script(port: Any) -> None:
        fd = os.open(link, os.O_RDWR | os.O_NOCTTY)
        end = time.monotonic() + 120
        while got.count(b"\n") < 6 and time.monotonic() < end:
            got.extend(os.read(fd, 1000))
        os.close(fd)

    serve(script, protocol="nmea", sensors=("altimeter", "depth"), port=f"pty:{link}")
    text = got.decode()
    assert "$SDDBT," in text
    pressure = re.search(r"\$YXXDR,P,([\d.]+),B,DEPTH", text)
    assert pressure is not None
    assert float(pressure[1]) == pytest.approx(1.01325 + 1025 * 9.81 * 5 / 1e5, abs=0.02)
    assert not link.exists()  # taken away at the end


def test_blue_robotics_own_library_reads_a_ping1d() -> None:
    brping = pytest.importorskip("brping")
    seen: dict[str, Any] = {}

    def script(port: Any) -> None:
        device = brping.Ping1D()
        device.connect_udp("127.0.0.1", port.port)
        assert any(device.initialize() for _ in range(20))  # the first steps of a simulation take long
        time.sleep(0.3)
        seen["distance"] = device.get_distance()
        seen["simple"] = device.get_distance_simple()
        seen["profile"] = device.get_profile()
        device.iodev.close()

    serve(script, protocol="ping1d", sensors=("altimeter",), port="udp-server:0")
    assert seen["distance"]["distance"] == pytest.approx(15_000, abs=300)
    assert seen["distance"]["confidence"] == 100
    assert seen["simple"]["distance"] == pytest.approx(15_000, abs=300)
    assert len(seen["profile"]["profile_data"]) == 200


def test_blue_robotics_own_library_reads_a_ping360() -> None:
    brping = pytest.importorskip("brping")
    seen: list[Any] = []

    def script(port: Any) -> None:
        device = brping.Ping360()
        device.connect_udp("127.0.0.1", port.port)
        assert any(device.initialize() for _ in range(20))
        time.sleep(1.5)
        device.set_number_of_samples(200)
        device.set_sample_period(8000)  # 25 ns each: 30 m in 200 samples
        seen.extend(device.transmitAngle(g) for g in range(0, 400, 4))
        device.iodev.close()

    serve(script, protocol="ping360", sensors=("scanner",), port="udp-server:0")
    assert all(len(m.data) == 200 for m in seen)
    assert any(max(m.data) > 0 for m in seen)


def test_a_driver_that_does_not_read_slows_nobody() -> None:
    sim = simulation()
    sim.reset()
    exchange = Exchange(sim)
    InstrumentConfig(type="instrument", protocol="pd0", sensors=("dvl",), port="tcp:0").attach(exchange)
    InstrumentConfig(type="instrument", protocol="vectornav", sensors=("imu",), port="pty:").attach(exchange)
    door: Any = exchange.doors[0]
    with socket.create_connection(("127.0.0.1", door.port.port)):
        assert exchange.run(5.0).simulated_s == pytest.approx(5.0)
    report = exchange.close()
    assert sum(k for reason, k in report.items() if "nobody read" in reason) > 0


def test_the_same_bytes_with_an_instrument_as_without() -> None:
    sim = simulation()
    sim.reset()
    sim.run(3.0)
    alone = sim.state["a"].position
    sim.reset()
    exchange = Exchange(sim)
    InstrumentConfig(type="instrument", protocol="pd6", sensors=("dvl",), port="udp:1").attach(exchange)
    exchange.run(3.0)
    exchange.close()
    assert (sim.state["a"].position == alone).all()
    assert not sim.listeners.any  # a closed door listens no more


def test_messages_own_their_memory() -> None:
    """Other threads let go of them, and must never be the last to hold an array of the device: they would wait for the
    device's lock with the interpreter's, for which the thread that steps may wait with the device's."""
    kept: dict[str, list[Any]] = {}

    class Keeping(MemoryTransport):
        def advertise(self, topic: str, type_name: str, *, qos: Any) -> Any:
            return lambda cdr, t_ns: kept.setdefault(topic, []).append(cdr)

    sim = simulation()
    sim.reset()
    exchange = Exchange(sim)
    exchange.add(TopicDoor(Keeping()))
    exchange.run(0.5)
    exchange.close()
    assert {"/clock", "/tf", "/a/imu/data_raw", "/a/dvl/dvl"} <= set(kept)
    assert any(topic.startswith("/a/scanner/") for topic in kept)
    for topic, messages in kept.items():
        for message in messages:
            owner = message
            while isinstance(owner, memoryview | np.ndarray):
                below = owner.obj if isinstance(owner, memoryview) else owner.base
                if below is None:
                    break
                owner = below
            assert type(owner) in (bytes, bytearray, np.ndarray), (topic, type(owner))


@pytest.mark.parametrize(
    ("config", "message"),
    [({"sensors": ("dvll",), "port": "tcp:0"}, "did you mean 'dvl'"),
     ({"sensors": ("a.dvll",), "port": "tcp:0"}, "did you mean 'dvl'"),
     ({"sensors": ("dvl",), "port": "tpc:1"}, "did you mean 'tcp'"),
     ({"sensors": ("dvl",), "port": "tcp:70000"}, "up to 65535"),
     ({"sensors": ("imu",), "port": "tcp:0"}, "spoken by dvl"),
     ({"sensors": ("dvl",), "port": "tcp:x"}, "give a number"),
     ({"sensors": ("dvl",), "port": "usb:1"}, "use pty:PATH")],
)  # fmt: skip
def test_what_cannot_be_is_said(config: dict[str, Any], message: str) -> None:
    found = InstrumentConfig(type="instrument", protocol="pd0", **config)
    with pytest.raises(BridgeMismatch, match=message):
        found.check(simulation())
    with pytest.raises(BridgeMismatch, match=message):
        found.attach(Exchange(simulation()))


def test_ports_drop_what_nobody_takes() -> None:
    for port in (PtyPort(), TcpPort(("127.0.0.1", 0)), UdpServerPort(("127.0.0.1", 0)), open_port("udp:9")):
        for _ in range(2000):  # a write that waited for somebody would never return
            port.write(b"x" * 100)
            assert not port.read()
        port.close()


def test_a_serial_line_that_filled_up_goes_on_with_whole_messages() -> None:
    port = PtyPort()
    message = bytes(range(1, 256)) * 4 + b"\0"  # a line takes some of them, and a part of one
    for _ in range(30):
        port.write(message)
    driver = os.open(port.where, os.O_RDONLY | os.O_NOCTTY)
    got = b""
    try:
        for _ in range(20):
            got += os.read(driver, 1 << 16)
            port.write(message)
    finally:
        os.close(driver)
        port.close()
    *whole, last = got.split(b"\0")
    assert len(whole) > 10
    assert set(whole) == {message[:-1]}
    assert message.startswith(last)
    assert port.troubles["messages that nobody read in time"] > 0


def test_datagrams_go_to_everybody_on_a_network() -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as plotter:
        plotter.bind(("0.0.0.0", 0))
        plotter.settimeout(20)
        port = open_port(f"udp:127.255.255.255:{plotter.getsockname()[1]}")
        port.write(b"$GPGGA")
        assert (plotter.recv(100), port.troubles.total()) == (b"$GPGGA", 0)
        port.close()


def test_a_name_that_another_run_has_taken_is_left_to_it(tmp_path: Path) -> None:
    first = PtyPort(f"{tmp_path}/gps")
    second = PtyPort(f"{tmp_path}/gps")
    first.close()
    assert os.readlink(tmp_path / "gps") == os.ttyname(second._theirs)
    second.close()
    assert not (tmp_path / "gps").is_symlink()


def test_a_port_in_use_names_the_door_and_leaves_no_folder(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The same command is taken once the port is free."""
    from pelagos.cli.main import main

    scenario, folder = tmp_path / "s.yaml", tmp_path / "results"
    with socket.create_server(("127.0.0.1", 0)) as taken:
        scenario.write_text(
            "world: {type: flat, depth_m: 20}\n"
            "agents: {a: {vehicle: bluerov2, start: {position_m: [0, 0], depth_m: 3},\n"
            "  sensors: {dvl: {type: dvl, rate_hz: 5}}}}\n"
            "bridges: {log: {type: instrument, protocol: pd6, sensors: [dvl],\n"
            f"  port: 'tcp:{taken.getsockname()[1]}'}}}}\n"
        )
        words = ["run", str(scenario), "--duration", "0.1", "--out", str(folder), "--no-report"]
        with pytest.raises(SystemExit) as end:
            main(words)
        assert end.value.code == 1
        assert "bridges.log: port" in " ".join(capsys.readouterr().err.split())
        assert not folder.exists()
    with pytest.raises(SystemExit) as end:
        main(words)
    assert end.value.code == 0
    assert (folder / "mission.mcap").exists()


def test_check_and_run_refuse_the_same_bridge_in_the_same_words(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    from pelagos.cli.main import main

    scenario, said = tmp_path / "s.yaml", []
    scenario.write_text(
        "world: {type: flat, depth_m: 20}\n"
        "agents: {a: {vehicle: bluerov2, start: {position_m: [0, 0], depth_m: 3}, sensors: {dvl: {type: dvl}}}}\n"
        "bridges: {log: {type: instrument, protocol: pd6, sensors: [a.dvvl], port: 'tcp:1'}}\n"
    )
    for words in (["check", str(scenario)], ["run", str(scenario), "--out", str(tmp_path / "out")]):
        with pytest.raises(SystemExit) as end:
            main(words)
        assert end.value.code == 2
        said.append(" ".join(capsys.readouterr().err.split()).partition("wrong input: ")[2])  # a run says what it loads
    assert "bridges.log: instrument of a: unknown sensor 'a.dvvl' (did you mean 'dvl'?); known: dvl" in said[0]
    assert said[0] == said[1]
    assert not (tmp_path / "out").exists()


def test_two_doors_at_one_port_are_refused() -> None:
    sim = simulation()

    def log(port: str) -> InstrumentConfig:
        return InstrumentConfig(type="instrument", protocol="pd6", sensors=("dvl",), port=port)

    pairs: list[tuple[Any, Any, str]] = [
        (log("tcp:16171"), log("tcp:localhost:16171"), "tcp 127.0.0.1:16171"),
        (log("pty:/tmp/dvl"), log("pty:/tmp/dvl"), "pty /tmp/dvl"),
        (RosbridgeConfig(type="rosbridge", port=16171), log("tcp:16171"), "tcp 127.0.0.1:16171"),
        (FoxgloveConfig(type="foxglove", port=99), RosbridgeConfig(type="rosbridge", port=99), "tcp 127.0.0.1:99"),
    ]
    for one, two, place in pairs:
        with pytest.raises(BridgeMismatch, match=re.escape(f"bridges.two: {place} is taken by bridges.one")):
            check_doors(sim, {"one": one, "two": two})
    free = {"a": RosbridgeConfig(type="rosbridge", port=0), "b": FoxgloveConfig(type="foxglove", port=0)}
    check_doors(sim, {**free, "c": log("tcp:7000"), "d": log("udp:7000"), "e": log("udp:7000")})


def test_a_damaged_frame_takes_none_with_it_that_began_within_its_length() -> None:
    good = ping.frame(ping.GENERAL_REQUEST, struct.pack("<H", ping.DISTANCE))
    damaged = bytearray(ping.frame(ping.DISTANCE, b"\x05" * 9 + good))
    damaged[-1] ^= 0x40
    frames = ping.Frames()
    assert list(frames.feed(bytes(damaged))) == [(ping.GENERAL_REQUEST, struct.pack("<H", ping.DISTANCE))]
    assert frames.bad > 0

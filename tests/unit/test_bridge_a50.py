"""An A50's dead reckoning and commands, by the description of its protocol (Water Linked, DVL protocol, 2.5 / v3.1)."""

from __future__ import annotations

import json
import math
import socket
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos.bridges.autopilot import motion_of
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.instrument import InstrumentConfig
from pelagos.bridges.instruments import waterlinked
from pelagos.bridges.instruments.a50 import WaterLinkedJson, WaterLinkedSerial
from pelagos.bridges.instruments.dvl_velocity import NO_MERIT_MPS, DvlVelocity
from pelagos.bridges.instruments.reckoning import Reckoning

SIGMA = 0.003


def ping(t_s: float, velocity: tuple[float, float, float] | None) -> DvlVelocity:
    spread = tuple(tuple(SIGMA**2 * (i == j) for j in range(3)) for i in range(3))
    return DvlVelocity(round(t_s * 1e9), velocity, spread, 7.5, (8.0,) * 4, (0.2, -0.1, 0.3, -0.4), (True,) * 4)


def attitude(roll: float, pitch: float, yaw: float) -> list[float]:
    x, y, z, w = Rotation.from_euler("ZYX", [yaw, pitch, roll], degrees=True).as_quat()
    return [w, x, y, z]


def test_sentences_have_the_checksums_of_the_description() -> None:
    for said in ("wrp,49056.809,0.41,0.15,1.23,0.4,53.9,13.0,19.3,0*de", "wru,1,-0.500,1.25,-62,-104*f0"):
        assert waterlinked.serial_sentence(said.partition("*")[0]) == f"{said}\r\n".encode()


@pytest.mark.parametrize("rate", [0.3, -0.2])
def test_the_way_of_a_turn_is_a_circle(rate: float) -> None:
    """v forward, w down and a turn r: x = v/r sin(r t), y = v/r (1 - cos(r t)), z = w t in the axes of the beginning,
    at whatever attitude it began. Each step of the trapezoidal rule lies within v r^2 h^3 / 12 of the arc."""
    u, w, h, steps = 1.5, -0.25, 0.1, 100
    first = Rotation.from_euler("ZYX", [130.0, -20.0, 35.0], degrees=True)
    way = Reckoning()
    for i in range(steps + 1):
        x, y, z, scalar = (first * Rotation.from_rotvec([0, 0, rate * i * h])).as_quat()
        way = way.after(ping(5.0 + i * h, (u, 0.0, w)), [scalar, x, y, z])
    t = steps * h
    exact = [u / rate * math.sin(rate * t), u / rate * (1 - math.cos(rate * t)), w * t]
    assert np.abs(np.subtract(way.position, exact)).max() < steps * u * rate**2 * h**3 / 12 + 1e-12
    np.testing.assert_allclose(way.euler, [0, 0, rate * t], atol=1e-9)
    assert way.std_m == pytest.approx(SIGMA * h * math.sqrt(steps))  # independent errors of 100 pings
    assert (way.locked, way.t_ns) == (True, 15_000_000_000)


def test_without_lock_the_last_velocity_goes_on_and_the_error_grows() -> None:
    way = Reckoning()
    for t, velocity in ((1.0, (0.8, -0.5, 0.2)), (1.2, (0.8, -0.5, 0.2)), (1.4, None), (1.7, None)):
        way = way.after(ping(t, velocity), attitude(5, -8, 200))
    np.testing.assert_allclose(way.position, [0.7 * 0.8, -0.7 * 0.5, 0.7 * 0.2], atol=1e-12)
    assert not way.locked
    spread = math.sqrt((SIGMA * 0.2) ** 2 + (NO_MERIT_MPS * 0.2) ** 2 + (NO_MERIT_MPS * 0.3) ** 2)
    assert way.std_m == pytest.approx(spread)
    said = json.loads(waterlinked.position(way))
    assert list(said) == ["ts", "x", "y", "z", "std", "roll", "pitch", "yaw", "type", "status", "format"]
    assert (said["type"], said["status"], said["format"], said["ts"]) == ("position_local", 1, "json_v3.1", 1.7)
    fields = waterlinked.serial_position(way).decode().strip().partition("*")[0].split(",")
    assert fields == ["wrp", "1.700", "0.560", "-0.350", "0.140", f"{spread:.3f}", *["0.00"] * 3, "1"]


SCENARIO: dict[str, Any] = {
    "tick_rate_hz": 50, "seed": 3, "world": {"type": "flat", "depth_m": 20.0},
    "agents": {"a": {
        "vehicle": "bluerov2_heavy", "start": {"position_m": [3, -2], "depth_m": 5.0, "heading_deg": 40},
        "control": "velocity", "command": [0.4, 0.2, 0.1, 0.25],
        "sensors": {"dvl": {"type": "dvl", "device": "waterlinked_a50", "rate_hz": 10, "orientation_deg": [0, 0, 90]}},
    }},
}  # fmt: skip


def test_a_run_is_reckoned_as_it_went() -> None:
    """Against the true motion, by a log that looks to port. Velocities err by some mm/s at random: after 12 s of ten
    pings each the reckoned place errs by the root of 120 times 0.1 s times that, some centimetres; the log sits at the
    vehicle's origin."""
    sim = pl.Simulation.load(SCENARIO)
    exchange = Exchange(sim)
    InstrumentConfig(type="instrument", protocol="waterlinked", sensors=("dvl",), port="tcp:0").attach(exchange)
    port: Any = exchange.doors[0]
    true: list[tuple[float, Any, Any]] = []

    def look(now: pl.Simulation) -> None:
        motion = motion_of(now, "a")
        true.append((now.time_ns * 1e-9, np.array(motion.position), motion.attitude))

    sim.on_tick(look, rate_hz=50)
    with socket.create_connection(("127.0.0.1", port.port.port), timeout=10) as s:
        exchange.run(12.0)
        s.settimeout(0.5)
        raw = b""
        try:
            while part := s.recv(1 << 16):
                raw += part
        except TimeoutError:
            pass
    exchange.close()
    said = [one for one in map(json.loads, raw.split(b"\r\n")[:-1]) if one["type"] == "position_local"]
    assert len(said) == 61  # 0 to 12 s at 5 Hz
    times = np.array([t for t, _, _ in true])

    def at(t: float) -> tuple[Any, Rotation]:
        _, place, (w, x, y, z) = true[int(np.argmin(np.abs(times - t)))]
        mount = Rotation.from_euler("z", -90, degrees=True)  # 90 degrees to port, forward-right-down
        return place, Rotation.from_quat([x, y, z, w]) * mount

    began, first = at(said[0]["ts"])
    for one in said[5::5]:
        place, turned = at(one["ts"])
        want = first.inv().apply(place - began)
        got = np.array([one["x"], one["y"], one["z"]])
        assert np.abs(got - want).max() < 5 * one["std"] + 0.02, one["ts"]
        angles = (first.inv() * turned).as_euler("ZYX", degrees=True)[::-1]
        np.testing.assert_allclose([one["roll"], one["pitch"], one["yaw"]], angles, atol=1.0)
    assert np.hypot(said[-1]["x"], said[-1]["y"]) > 1.0


def serial() -> WaterLinkedSerial:
    place: Any = SimpleNamespace(config=SimpleNamespace(beams=(), q_body_sensor=(1.0, 0.0, 0.0, 0.0)))
    return WaterLinkedSerial(place)


def test_the_serial_commands_of_an_a50() -> None:
    a50 = serial()
    for said, told in (
        (b"wcv", "wrv,2,5,0"), (b"wcw", "wrw,dvl-a50,2.5.2,0x0"), (b"wcc", "wrc,1500.00,0.00,y,n,auto,n"),
        (b"wcr", "wra"), (b"wcg", "wra"), (b"wcx", "wrn"), (b"wcp,3", "wra"), (b"wcp,2", "wrn"),
        (b"wcs,1500,,n,,,", "wra"), (b"wcc", "wrc,1500.00,0.00,n,n,auto,n"), (b"wcs,,,y,,", "wra"),
        (b"wcs,1450,,,,,", "wrn"), (b"wcs,x,,,,,", "wr?"), (b"wcs,nan,,,,,", "wr?"), (b"wcs,,,maybe,,,", "wr?"),
        (b"wcs,1,2", "wr?"), (b"wcs,,,,,,,", "wr?"), (b"wxy", "wr?"), (b"wcv*00", "wr!"), (b"\xff\xfe", "wr?"),
    ):  # fmt: skip
        assert a50.answer(said + b"\r\n") == waterlinked.serial_sentence(told), said
    assert a50.config()["acoustic_enabled"]


@pytest.mark.parametrize("kind", [WaterLinkedJson, WaterLinkedSerial])
def test_reckoning_begins_anew_where_a_driver_asks(kind: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    a50 = kind(SimpleNamespace(config=SimpleNamespace(beams=())))
    monkeypatch.setattr(DvlVelocity, "of", lambda reading, beams: reading)
    monkeypatch.setattr(a50, "turn", lambda: attitude(3, -4, 50))
    told = []
    for i in range(7):
        out = a50.hear(ping(0.1 * i, (2.0, -1.0, 0.5)))
        told.append(b"position_local" in out or b"wrp," in out)
    assert told == [True, False] * 3 + [True]  # 5 Hz of 10 pings a second
    assert a50._way.position == pytest.approx((1.2, -0.6, 0.3))
    reset = b'{"command": "reset_dead_reckoning"}\n' if kind is WaterLinkedJson else b"wcr\n"
    answer = a50.answer(reset)
    assert answer == waterlinked.serial_sentence("wra") or json.loads(answer)["success"]
    a50.hear(ping(0.7, (2.0, -1.0, 0.5)))
    assert (a50._way.position, a50._way.std_m) == ((0.0, 0.0, 0.0), 0.0)
    a50.set_config({"acoustic_enabled": False})
    silent = a50.hear(ping(0.8, (9.0, 9.0, 9.0)))
    assert b"velocity" not in silent
    assert b"wrz" not in silent
    assert a50._way.position == pytest.approx((0.2, -0.1, 0.05))  # with the last velocity that it had


def test_a_way_goes_on_from_a_loss_with_what_is_seen_after_it() -> None:
    """Unseen, the last velocity holds; the first one seen again holds for the step that it ends."""
    way = Reckoning()
    for t, velocity in ((1.0, (0.8, -0.5, 0.2)), (1.4, None), (1.6, (-0.3, 0.9, 0.7)), (1.7, (0.1, 0.5, -0.1))):
        way = way.after(ping(t, velocity), [1.0, 0.0, 0.0, 0.0])
    steps = 0.4 * np.array([0.8, -0.5, 0.2]) + 0.2 * np.array([-0.3, 0.9, 0.7])
    np.testing.assert_allclose(way.position, steps + 0.1 * np.array([-0.1, 0.7, 0.3]), atol=1e-12)

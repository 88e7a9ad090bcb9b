"""Refusals and second branches of doors, manoeuvres and views, without a network or a run."""

from __future__ import annotations

import copy
import pickle
import re
import sys
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.bridges import journal, ros2
from pelagos.bridges.autopilot import the_agent
from pelagos.bridges.extras import require
from pelagos.bridges.part import file_of
from pelagos.bridges.ros2 import Ros2Config, make_transport
from pelagos.bridges.transport import BridgeError, BridgeMismatch, MemoryTransport
from pelagos.errors import CommandError, InputError, PelagosError
from pelagos.manoeuvres import standard
from pelagos.manoeuvres.measures import OVERSHOOT_20, HalfCycles, _when, zigzag_measures
from pelagos.sim.later import Later
from pelagos.viewer import drive, film, server
from pelagos.viewer.session import view_of


def fleet(*names: str) -> Any:
    return SimpleNamespace(model=SimpleNamespace(agents=dict.fromkeys(names)))


GLIDER = SimpleNamespace(modes=("sawtooth", "actuators"), name="glider")


@pytest.mark.parametrize(
    ("ask", "told"),
    [
        (lambda p: the_agent(fleet("a", "b"), "", "mavlink"), "mavlink: which agent? give `agent`, one of a, b"),
        (lambda p: the_agent(fleet("auv0"), "auv", "px4"), "px4: unknown agent 'auv' (did you mean 'auv0'?)"),
        (lambda p: require("no_such_module", extra="lcm", purpose="LCM"), "LCM needs the extra 'lcm': pip install"),
        (lambda p: MemoryTransport().say("/a", b""), "unknown topic or service '/a'"),
        (lambda p: MemoryTransport().call("/a", b""), "unknown topic or service '/a'"),
        (lambda p: file_of(p), "this folder holds no recording (.mcap)"),
        (lambda p: film.make_film(p, p / "no" / "a.mp4", film.FilmOptions()), "give a file in a folder that exists"),
        (lambda p: film.make_film(p, p / "a.mp4", film.FilmOptions(rate_hz=0)), "--rate is 1 to 120 pictures in a"),
        (lambda p: film.make_film(p, p / "a.mp4", film.FilmOptions(rate_hz=121)), "--rate is 1 to 120 pictures in a"),
        (lambda p: film.make_film(p, p / "a.mp4", film.FilmOptions(speed=0.009)), "--speed 0.01 to 1000 times the"),
        (lambda p: film.make_film(p, p / "a.mp4", film.FilmOptions(speed=1000.1)), "--speed 0.01 to 1000 times the"),
        (lambda p: view_of("a simulation"), "a simulation is what can be viewed, not a str"),
    ],
)  # fmt: skip
def test_what_cannot_be_is_told(ask: Callable[[Path], Any], told: str, tmp_path: Path) -> None:
    with pytest.raises(PelagosError, match=re.escape(told)):
        ask(tmp_path)


def test_the_agent_of_a_door_is_the_one_asked_for_or_the_only_one() -> None:
    assert (the_agent(fleet("a"), "", "px4"), the_agent(fleet("a", "b"), "b", "px4")) == ("a", "b")


def test_packages_that_are_missing_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "av", None)
    with pytest.raises(InputError, match=re.escape("films need the package av: pip install 'pelagos[viewer]'")):
        film.make_film(tmp_path, tmp_path / "a.mp4", film.FilmOptions())
    monkeypatch.setattr(server, "find_spec", lambda name: None)
    with pytest.raises(InputError, match=re.escape("the view needs the package websockets: pip install 'pelagos[")):
        server.Server(port=0)


@pytest.mark.parametrize(
    ("installed", "rmw", "name", "why"),
    [
        ({"rclpy", "zenoh"}, "rmw_zenoh_cpp", "rclpy", "ROS is sourced"),
        ({"cyclonedds", "zenoh"}, "rmw_zenoh_cpp", "zenoh", "RMW_IMPLEMENTATION is rmw_zenoh_cpp"),
        ({"cyclonedds", "zenoh"}, "", "dds", "no ROS is sourced"),
        ({"zenoh"}, "rmw_fastrtps_cpp", "zenoh", "neither rclpy nor cyclonedds is installed"),
    ],
)
def test_ros_goes_by_what_is_installed(
    installed: set[str], rmw: str, name: str, why: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("RMW_IMPLEMENTATION", rmw)
    monkeypatch.setattr(ros2, "find_spec", lambda package: package in installed or None)
    for kind in ("rclpy", "dds", "zenoh"):
        monkeypatch.setattr(ros2, f"_{kind}", lambda config, kind=kind: kind)
    assert make_transport(Ros2Config(type="ros2")) == (name, why)
    monkeypatch.delenv("RMW_IMPLEMENTATION")
    monkeypatch.setattr(ros2, "find_spec", lambda package: None)
    with pytest.raises(BridgeError, match=re.escape("ROS 2 needs the extra 'ros2': pip install \"pelagos[ros2]\"")):
        make_transport(Ros2Config(type="ros2"))


@pytest.mark.parametrize("given", ["", "-1", "3.0", "two", "²"])
def test_a_domain_is_a_whole_number(given: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", given)
    with pytest.raises(BridgeMismatch, match=re.escape(f"ROS_DOMAIN_ID is {given!r}, not a whole number")):
        _ = Ros2Config(type="ros2").domain
    assert Ros2Config(type="ros2", domain_id=7).domain == 7
    monkeypatch.setenv("ROS_DOMAIN_ID", "42")
    assert Ros2Config(type="ros2").domain == 42


@pytest.mark.parametrize(("topics", "count"), [({}, 0), ({journal.TOPIC: None}, 0)])
def test_a_run_that_nobody_told_anything_has_no_orders(
    topics: dict[str, Any], count: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(journal, "Recording", lambda path: SimpleNamespace(channels=topics, count=lambda topic: count))
    assert journal.recorded_orders("a.mcap") == []


def test_a_glider_is_not_driven_by_hand() -> None:
    sim: Any = SimpleNamespace(model=SimpleNamespace(agents={"g": SimpleNamespace(vehicle=GLIDER)}))
    with pytest.raises(CommandError, match="g: a glider has no control mode to be driven by hand; modes: sawtoo"):
        drive.drive(sim, "g", {}, 0.1)


def test_an_address_that_is_none_is_refused_and_one_is_found_without_a_network(monkeypatch: pytest.MonkeyPatch) -> None:
    def nowhere(*_: Any, **__: Any) -> Any:
        raise OSError("no such network")

    def unknown(*_: Any) -> None:
        raise server.socket.gaierror(-2, "Name or service not known")

    with monkeypatch.context() as patch:
        patch.setattr(server.socket.socket, "bind", unknown)
        with pytest.raises(InputError, match=re.escape("--host no.such.host: this is no address of this machine")):
            server._free("no.such.host", 0)
    monkeypatch.setattr(server.socket, "socket", nowhere)
    assert (server._own_address("::"), server._own_address("0.0.0.0")) == ("::1", "127.0.0.1")


def test_only_a_zigzag_of_20_on_20_has_the_limit_of_20() -> None:
    """IMO MSC.137(76): 25 deg for the first overshoot of the 20/20, nothing for its second."""
    time = np.arange(0.0, 200.0)
    heading = 30 * np.sin(time / 20)
    keys: dict[str, Any] = {"length_m": 100.0, "speed_m_s": 7.0, "run_lengths": 2.0}
    switched = np.array([time[int(20 * np.arcsin(2 / 3))], 77.0, 140.0])
    for rudder, angle, first in ((20.0, 20.0, OVERSHOOT_20), (20.0, 15.0, None), (15.0, 20.0, None)):
        found = zigzag_measures(time, heading, switched, rudder_deg=rudder, angle_deg=angle, **keys)
        assert [m.limit for m in found if "overshoot" in m.name][:2] == [first, None]
    assert OVERSHOOT_20 == 25.0


def test_a_level_that_is_reached_from_the_start_is_reached_then() -> None:
    time, values = np.array([3.0, 4.0, 6.0]), np.array([2.0, 5.0, 9.0])
    assert [_when(time, values, level) for level in (1.0, 2.0, 3.5, 9.0)] == [3.0, 3.0, 3.5, 6.0]
    with pytest.raises(InputError, match=r"the heading reaches 9 deg of the 9\.5 deg that this number needs"):
        _when(time, values, 9.5)


@pytest.mark.parametrize(("count", "told"), [(1, False), (2, False), (3, True)])
def test_damping_is_carried_on_from_three_half_cycles_on(count: int, told: bool) -> None:
    """Two always lie on a line. Ratios 0.03 + 0.2 amplitude, all but exactly."""
    amplitude = np.array([0.3, 0.2, 0.1])[:count]
    cycles = HalfCycles(
        np.zeros(count + 1), np.zeros(count + 1), amplitude, 0.03 + 0.2 * amplitude + 1e-9 * amplitude**2
    )
    assert cycles.growth == (pytest.approx((0.03, 0.2), abs=1e-6) if told else None)


def test_readings_that_are_computed_later_are_computed_once() -> None:
    looks: list[int] = []

    def look() -> dict[str, Any]:
        looks.append(1)
        return {"a": {"x": 1}, "b": {}}

    later = Later(look)
    assert not looks
    assert (len(later), repr(later), list(later)) == (2, "{'a': {'x': 1}, 'b': {}}", ["a", "b"])
    for again in (pickle.loads(pickle.dumps(later)), copy.copy(later)):
        assert type(again) is dict
        assert again == {"a": {"x": 1}, "b": {}}
    assert len(looks) == 1


def test_what_has_no_thruster_is_told_what_it_has_and_what_pulls(monkeypatch: pytest.MonkeyPatch) -> None:
    """Actuators by type, in the order of the vehicle's file."""
    for kinds, own in (
        ({"port": "fin", "screw": "propeller", "starboard": "fin"},
         "port, starboard of the type fin; screw of the type propeller"),
        ({}, "none"),
    ):  # fmt: skip
        built = SimpleNamespace(actuators={name: object() for name in kinds})
        config = SimpleNamespace(actuators={name: SimpleNamespace(type=kind) for name, kind in kinds.items()})
        vehicle = SimpleNamespace(model=built, config=config, name="barge")
        monkeypatch.setattr(standard, "CalmRun", lambda *_, v=vehicle, **__: SimpleNamespace(vehicle=v))
        with pytest.raises(InputError) as told:
            standard.bollard({}, None)
        assert str(told.value) == (
            "barge has no actuators for bollard, which takes those of the types thruster, force_thruster, "
            f"curve_thruster, t200; its own: {own}"
        )

"""Actuators as JointState and batteries as BatteryState: fields, units, signs, and that no recording has them."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos as pl
from pelagos.bridges.door import TopicDoor
from pelagos.bridges.exchange import Exchange
from pelagos.bridges.machinery import Machinery, battery_message, joint_message, supply_of
from pelagos.bridges.tap import Tap
from pelagos.bridges.transport import MemoryTransport
from pelagos.messages.store import deserialize
from pelagos.sim.replay import Recording
from pelagos.sim.simulation import Simulation
from pelagos.vehicles.actuators.t200 import shaft_speed
from pelagos.vehicles.vehicle import Vehicle

T_NS = 12_345_678_901


def test_fins_have_angles_and_propellers_speeds() -> None:
    vehicle = Vehicle.from_catalogue("remus100")
    units = [a.unit for a in vehicle.model.actuators.values()]
    states = np.array([0.25, -0.5, 1200.0, 7.0, -3.0])[: len(units)]
    found = deserialize("sensor_msgs/msg/JointState", joint_message(vehicle, states, "auv/base_link", T_NS))
    assert (found.header.stamp.sec, found.header.stamp.nanosec) == (12, 345_678_901)
    assert (found.header.frame_id, found.name) == ("auv/base_link", list(vehicle.actuator_names))
    assert set(units) == {"rad", "rpm"}
    angle = [s if u == "rad" else math.nan for s, u in zip(states, units, strict=True)]
    speed = [s * math.pi / 30 if u == "rpm" else math.nan for s, u in zip(states, units, strict=True)]
    np.testing.assert_array_equal(found.position, angle)
    np.testing.assert_allclose(found.velocity, speed, rtol=1e-12)
    assert np.isnan(found.effort).all()


def test_a_battery_says_its_voltage_under_load() -> None:
    vehicle = Vehicle.from_catalogue("bluerov2")
    idle = supply_of(vehicle, np.zeros(6))
    laden = supply_of(vehicle, np.array([0.5, -0.4, 0.3, 0.2, -0.6, 0.1]))
    assert idle is not None
    assert laden is not None
    config = vehicle.config.battery
    assert config is not None
    assert laden[0] < idle[0] <= config.open_circuit_v
    # Ohm's law holds within the 0.2 % to which `Battery.voltage` solves it
    assert config.open_circuit_v - laden[0] == pytest.approx(config.resistance_ohm * laden[1], rel=2e-3)
    found = deserialize("sensor_msgs/msg/BatteryState", battery_message(*laden, "rov/base_link", T_NS))
    assert (found.voltage, found.current) == pytest.approx((laden[0], -laden[1]), rel=1e-6)
    assert (found.present, found.power_supply_status, found.header.frame_id) == (True, 2, "rov/base_link")
    assert math.isnan(found.percentage)
    assert supply_of(Vehicle.from_catalogue("remus100"), np.zeros(3)) is None


def test_a_t200_turns_as_its_maker_measured() -> None:
    """Rows of the maker's table: 1100 us at 10 V, and half way between 10 and 12 V."""
    assert shaft_speed(-1.0, 10.0) == pytest.approx(-2662.12 * math.pi / 30)
    assert shaft_speed(-1.0, 8.0) == shaft_speed(-1.0, 10.0)
    assert shaft_speed(-0.99, 10.0) == pytest.approx(-2666.99 * math.pi / 30)
    both = [shaft_speed(0.5, 10.0), shaft_speed(0.5, 12.0)]
    assert both[1] > both[0] > 0
    assert shaft_speed(0.5, 11.0) == pytest.approx(sum(both) / 2)


@pytest.fixture(scope="module")
def sim() -> Simulation:
    return pl.Simulation.load({
        "world": {"type": "flat", "depth_m": 30.0},
        "agents": {"rov": {
            "vehicle": "bluerov2", "start": {"position_m": [0, 0], "depth_m": 5}, "control": "actuators",
            "command": [0.3, -0.2, 0.25, 0.12, 0.15, 0.2],
        }},
    })  # fmt: skip


def test_doors_say_it_and_recordings_do_not(sim: Simulation, tmp_path: Path) -> None:
    transport = MemoryTransport()
    exchange = Exchange(sim, rate_hz=10.0)
    exchange.add(TopicDoor(transport))
    exchange.run(1.0, record=tmp_path / "a.mcap")
    said = [deserialize("sensor_msgs/msg/JointState", raw) for _, raw in transport.written["/rov/joint_states"]]
    battery = [deserialize("sensor_msgs/msg/BatteryState", raw) for _, raw in transport.written["/rov/battery"]]
    exchange.close()
    assert len(said) == len(battery) > 8
    assert (np.sign(said[-1].velocity) == [1, -1, 1, 1, 1, 1]).all()  # as commanded
    assert battery[-1].current < 0
    assert not [topic for topic in Recording(tmp_path / "a.mcap").channels if "joint" in topic or "battery" in topic]


def test_it_is_said_at_most_every_50_ms_and_of_every_copy() -> None:
    """At the first boundary in each twentieth of a second, whenever that comes, by the names of topics."""
    vehicle = Vehicle.from_catalogue("remus100")
    states = np.array([[0.25, -0.5, 1200.0], [-0.125, 0.375, -600.0]])
    said: Any = SimpleNamespace(
        n=2, time_ns=0, model=SimpleNamespace(agents={"auv[3]": SimpleNamespace(vehicle=vehicle)}),
        state={"auv[3]": SimpleNamespace(actuators=states)},
    )  # fmt: skip
    tap = Tap()
    machinery = Machinery(said, tap)
    topics = {c.number: c.topic for c in tap.channels.values()}
    assert sorted(topics.values()) == ["/env0/auv_3/joint_states", "/env1/auv_3/joint_states"]
    alone = Tap()
    Machinery(SimpleNamespace(**{**vars(said), "n": 1}), alone)  # type: ignore[arg-type]
    assert [c.topic for c in alone.channels.values()] == ["/auv_3/joint_states"]
    for ms in (0, 30, 70, 90, 100, 149, 170, 205):
        said.time_ns = ms * 1_000_000
        machinery.say(said)
    messages = tap.take()
    assert [m.t_ns // 1_000_000 for m in messages] == [t for t in (0, 70, 100, 170, 205) for _ in range(2)]
    for copy, message in enumerate(messages[:2]):
        found = deserialize("sensor_msgs/msg/JointState", bytes(message.data))
        assert topics[message.channel] == f"/{found.header.frame_id.removesuffix('base_link')}joint_states"
        assert found.header.frame_id == f"env{copy}/auv_3/base_link"
        assert np.nansum(found.position) == pytest.approx(states[copy, :2].sum())
        assert np.nansum(found.velocity) == pytest.approx(states[copy, 2] * math.pi / 30)

"""Twist for vehicles that steer by heading and speed: boats and torpedoes."""

from __future__ import annotations

import math
from typing import Any

import pytest

import pelagos as pl
from pelagos.bridges.inbox import Inbox
from pelagos.sim.order import LEAD_RAD, Order


def loaded(vehicle: str, depth_m: float, **keys: Any) -> pl.Simulation:
    start = {"position_m": [3, -2], "depth_m": depth_m, "heading_deg": 20}
    agent = {"vehicle": vehicle, "start": start, **keys}
    return pl.Simulation.load({"tick_rate_hz": 50, "world": {"type": "flat", "depth_m": 30}, "agents": {"a": agent}})


@pytest.fixture(scope="module")
def boat() -> pl.Simulation:
    return loaded("otter", 0.0)


@pytest.fixture(scope="module")
def torpedo() -> pl.Simulation:
    return loaded("remus100", 5.0)


def twist(surge: float, yaw_rate: float, **others: float) -> Order:
    axes = {"sway": 0.0, "heave": 0.0, "roll": 0.0, "pitch": 0.0, **others}
    return Order("velocity", "a", {"values": [surge, *axes.values(), yaw_rate]}, "/a/cmd_vel")


@pytest.mark.parametrize("yaw_rate", [0.15, -0.1])
def test_a_boat_turns_at_the_rate_that_a_stream_asks_for(boat: pl.Simulation, yaw_rate: float) -> None:
    """The heading moves on by rate times time; the vehicle follows behind, but the way that was asked for."""
    boat.reset()
    inbox, began = Inbox(boat), math.radians(20)
    for _ in range(40):
        inbox.put(twist(1.0, yaw_rate))
        inbox.drain()
        boat.run(0.1)
    turned = 39 * 0.1 * yaw_rate  # to port; the first one has nothing before it
    heading, speed = boat.held_command("a")[0]
    assert not inbox.refused
    assert heading == pytest.approx(began - turned, abs=1e-9)
    assert speed == 1.0
    assert boat.state["a"].velocity[0, 0] > 0.2
    assert boat.state["a"].angular_velocity[0, 2] * math.copysign(1, yaw_rate) > 0.02


def test_a_heading_does_not_run_away_from_a_vehicle_that_cannot_follow(boat: pl.Simulation) -> None:
    boat.reset()
    inbox = Inbox(boat)
    for _ in range(4):
        inbox.put(twist(0.5, 3.0))
        inbox.drain()
        boat.run(0.5)
    inbox.put(twist(0.5, 3.0))
    inbox.drain()
    heading = -float(boat.state["a"].euler[0, 2])
    assert math.remainder(heading - boat.held_command("a")[0, 0], 2 * math.pi) == pytest.approx(LEAD_RAD)


def test_a_torpedo_keeps_its_depth(torpedo: pl.Simulation) -> None:
    inbox = Inbox(torpedo)
    inbox.put(twist(1.25, 0.5))
    inbox.drain()
    assert not inbox.refused
    names = torpedo.model.agents["a"].vehicle.command_names("depth_heading_speed")
    held = dict(zip(names, torpedo.held_command("a")[0].tolist(), strict=True))
    assert held == pytest.approx({"depth": 5.0, "heading": math.radians(20), "speed": 1.25}, abs=1e-6)


def test_what_such_a_vehicle_cannot_do_is_refused(torpedo: pl.Simulation) -> None:
    inbox = Inbox(torpedo)
    before = torpedo.held_command("a").copy()
    inbox.put(twist(1.0, 0.1, sway=0.4, pitch=-0.2))
    inbox.drain()
    (reason,) = inbox.refused
    assert "linear.x and angular.z" in reason
    assert reason.endswith("not sway, pitch")
    assert (torpedo.held_command("a") == before).all()

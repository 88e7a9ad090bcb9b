"""HoloOcean's agents on land: what its own tests take for granted of turtle and sphere, and how a Husky drives."""

from __future__ import annotations

import numpy as np
import pytest

import pelagos as pl
import pelagos.compat.holoocean as holoocean
from pelagos.compat.holoocean.ground_agents import (
    SPHERE_MOVES,
    SPHERE_RADIUS_M,
    husky_vehicle,
    husky_wrench,
    righted,
    sphere_moved,
    sphere_vehicle,
    turtle_vehicle,
    turtle_wrench,
)  # fmt: skip
from pelagos.compat.holoocean.worlds import native_world

LEVEL = native_world("TestWorlds", "TestWorld")
SENSORS = {"v": {"type": "velocity", "rate_hz": 30}, "imu": {"type": "imu", "rate_hz": 30}}


@pytest.fixture(scope="module")
def sim():
    agents = {
        "turtle": {"vehicle": turtle_vehicle(), "start": {"position_m": [-10, 8, 0.3]}, "sensors": SENSORS},
        "husky": {"vehicle": husky_vehicle(), "start": {"position_m": [-25, -5, 0.4]}, "sensors": SENSORS},
        "sphere": {"vehicle": sphere_vehicle(), "start": {"position_m": [0.77, 0.9, 0.5]}},
    }
    return pl.Simulation.load({"name": "land", "tick_rate_hz": 30, **LEVEL, "agents": agents}, seed=3)


def drive(sim, ticks, **wrenches):
    still = {name: np.zeros(6) for name in ("turtle", "husky")}
    found = [sim.step(still | wrenches) for _ in range(ticks)]
    return {name: np.array([o[name]["v"].data[0] for o in found]) for name in still}, found[-1]


def yaw_of(attitude):
    w, x, y, z = attitude
    return np.degrees(np.arctan2(2 * (w * z + x * y), 1 - 2 * (y * y + z * z)))


@pytest.mark.parametrize("sign", [1, -1])
def test_a_turtle_speeds_up_all_the_while_it_is_pushed_and_comes_to_rest_after(sim, sign):
    sim.reset(seed=3)
    drive(sim, 30)
    speeds, _ = drive(sim, 30, turtle=turtle_wrench([sign * 100.0, 0.0]))
    along = sign * speeds["turtle"][:, 0]
    assert (np.diff(along) > 0).all()
    assert along[-1] == pytest.approx(100 / 40 * (1 - np.exp(-2.0)), rel=0.03)  # F/c (1 - exp(-c t / m)), 1 s
    assert np.abs(speeds["turtle"][:, 1]).max() < 0.01
    speeds, last = drive(sim, 100)
    assert np.abs(speeds["turtle"][-1]).max() < 1e-2
    assert last["turtle"]["imu"].truth[0][2] == pytest.approx(9.81, rel=0.01)


def test_a_turtle_turns_to_the_left_at_positive_torque(sim):
    sim.reset(seed=3)
    drive(sim, 30)
    drive(sim, 30, turtle=turtle_wrench([0.0, 25.0]))
    assert 60 < yaw_of(sim.state["turtle"].attitude[0]) < 150


def test_actions_beyond_the_limits_are_clipped():
    assert turtle_wrench([1000, -1000]).tolist() == [160, 0, 0, 0, 0, 35]


def test_a_husky_drives_straight_at_equal_forces_and_turns_towards_the_weaker_side(sim):
    sim.reset(seed=3)
    drive(sim, 30)
    before = sim.state["husky"].position[0].copy()
    speeds, _ = drive(sim, 60, husky=husky_wrench([750, 750]))
    assert speeds["husky"][-1][0] == pytest.approx(2.0, rel=0.03)
    moved = sim.state["husky"].position[0] - before
    assert abs(moved[1]) < 0.05 * moved[0]
    drive(sim, 30, husky=husky_wrench([300, 500]))  # the right side pushes more
    assert yaw_of(sim.state["husky"].attitude[0]) > 10


def test_a_husky_on_its_back_is_put_on_its_wheels(sim):
    sim.reset(seed=3)
    sim.set_state("husky", position=(-25, -5, 0.6), attitude=(0.0, np.cos(0.2), np.sin(0.2), 0.0))
    drive(sim, 20)
    state = sim.state["husky"]
    sim.set_state("husky", **righted(state.position[0], state.attitude[0]))
    drive(sim, 40)
    _, x, y, _ = sim.state["husky"].attitude[0]
    assert 1 - 2 * (x * x + y * y) > 0.999
    assert sim.state["husky"].position[0][2] == pytest.approx(0.03 + 0.195, abs=0.02)  # on wheels


def test_a_sphere_stays_steps_turns_and_stops_before_the_wall(sim):
    sim.reset(seed=3)
    drive(sim, 10)
    assert sim.state["sphere"].position[0] == pytest.approx((0.77, 0.9, 0.5), abs=1e-9)
    forward, turn = SPHERE_MOVES[0]
    for _ in range(3):
        state = sim.state["sphere"]
        move = sphere_moved(sim.world, state.position[0], state.attitude[0], forward_m=forward, turn_deg=turn)
        sim.set_state("sphere", **move)
        drive(sim, 1)
    assert sim.state["sphere"].position[0] == pytest.approx((0.77 + 3 * 0.185, 0.9, 0.5), abs=1e-9)
    state = sim.state["sphere"]
    far = sphere_moved(sim.world, state.position[0], state.attitude[0], forward_m=20.0, turn_deg=0.0)
    assert far["position"] == pytest.approx((2.77 - SPHERE_RADIUS_M, 0.9, 0.5), abs=1e-4)  # the wall's face
    left = sphere_moved(sim.world, (0, 0, 1), (1, 0, 0, 0), forward_m=-1.0, turn_deg=90.0)
    assert left["position"] == pytest.approx((0, -1, 1), abs=1e-12)


def test_they_act_as_holooceans_agents():
    def agent(name, kind, at, *sensors):
        return {"agent_name": name, "agent_type": kind, "sensors": list(sensors), "control_scheme": 0, "location": at}

    place, abuse = {"sensor_type": "LocationSensor"}, {"sensor_type": "AbuseSensor"}
    eye = {"sensor_type": "RangeFinderSensor", "configuration": {"LaserMaxDistance": 1}}
    agents = [
        agent("turtle", "TurtleAgent", [-1.5, -1.5, 0.4], place, abuse),
        agent("ball", "SphereAgent", [0.77, 0.9, 0.5], place, eye),
        agent("husky", "HuskyVehicle", [-20, 5, 0.5], place),
    ]
    scenario = {
        "name": "land",
        "world": "TestWorld",
        "package_name": "TestWorlds",
        "ticks_per_sec": 30,
        "agents": agents,
    }
    with holoocean.make(scenario_cfg=scenario, show_viewport=False) as env:
        still = env.tick()["ball"]["LocationSensor"]  # nobody has told it to go anywhere
        env.act("turtle", [100.0, 0.0])
        env.act("husky", [750.0, 750.0, 0.0])
        env.act("ball", 0)
        state = env.tick(5)
        assert state["ball"]["LocationSensor"] - still == pytest.approx([5 * 0.185, 0, 0], abs=1e-6)
        assert state["turtle"]["LocationSensor"][0] > -1.5
        assert state["husky"]["LocationSensor"][0] > -20
        assert state["turtle"]["AbuseSensor"] == [0]
        env.agents["ball"].clear_action()
        env.agents["ball"].teleport([2.78, 0.7, 0.5], [0, 0, 0])  # behind the wall's face
        env.agents["turtle"].teleport(None, [180, 0, 0])
        assert env.tick(2)["ball"]["RangeFinderSensor"] == [-1]
        assert env.tick(8)["turtle"]["AbuseSensor"] == [1]

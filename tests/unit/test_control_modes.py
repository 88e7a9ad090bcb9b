"""Every kind of control law reaches its set-points, in a current where there is water."""

from __future__ import annotations

import dataclasses
import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "verification"))
from vehicle_flight import Still, fly, quaternion

import pelagos as pl
from pelagos import jit
from pelagos.errors import ScenarioError
from pelagos.vehicles.control.feed_forward import holding_wrench
from pelagos.vehicles.control.line_of_sight import line_heading
from pelagos.vehicles.flow import make_flow, rotation_from_euler
from pelagos.vehicles.vehicle import Vehicle

CURRENT = Still((0.25, 0.2, 0.0))


def wrapped(angle):
    return np.angle(np.exp(1j * np.asarray(angle)))


@pytest.mark.parametrize("name", ["bluerov2_heavy", "hovering_auv"])
def test_six_degrees_of_freedom(name):
    """Set-points in NWU and FLU: the flight's NED and FRD mirror y and z."""
    flight = fly(
        Vehicle.from_catalogue(name),
        120.0,
        h=0.02,
        mode="pose",
        command=(1.0, 2.0, -51.0, 0.1, -0.15, 1.0),
        ocean=CURRENT,
    )
    assert flight.position[-1] == pytest.approx([1.0, -2.0, 51.0], abs=0.03)
    assert wrapped(flight.euler[-1] - [0.1, 0.15, -1.0]) == pytest.approx(0, abs=0.02)


@pytest.mark.parametrize("name", ["bluerov2", "bluerov2_heavy", "hovering_auv"])
def test_station_keeping_in_a_current(name):
    flight = fly(
        Vehicle.from_catalogue(name), 90.0, h=0.02, mode="station_keeping", ocean=CURRENT, attitude=quaternion(yaw=1.0)
    )
    assert np.linalg.norm(flight.position[-1] - [0, 0, 50]) < 0.03
    assert flight.euler[-1, 2] == pytest.approx(1.0, abs=0.02)


@pytest.mark.parametrize("name", ["bluerov2_heavy", "hovering_auv"])
def test_velocity_by_a_pilots_sticks(name):
    flight = fly(Vehicle.from_catalogue(name), 30.0, h=0.02, mode="velocity", command=(0.3, 0.1, 0.1, 0.2))
    assert flight.nu[-1, [0, 1, 2, 5]] == pytest.approx([0.3, -0.1, -0.1, -0.2], abs=0.02)
    assert np.abs(flight.euler[-1, :2]).max() < 0.1


@pytest.mark.parametrize(
    ("name", "heading", "speed"), [("otter", -3.0, 1.2), ("wamv", 2.2, 1.4), ("surface_vessel", -0.9, 1.1)]
)
def test_heading_and_speed_of_twin_thruster_craft(name, heading, speed):
    vehicle = Vehicle.from_catalogue(name)
    flight = fly(vehicle, 90.0, h=0.02, command=(heading, speed), position=(0, 0, 0), ocean=CURRENT)
    assert wrapped(flight.euler[-1, 2] - heading) == pytest.approx(0, abs=0.02)
    yaw = flight.euler[-1, 2]
    assert flight.nu[-1, 0] - (0.25 * np.cos(yaw) - 0.2 * np.sin(yaw)) == pytest.approx(speed, abs=0.02)


@pytest.mark.parametrize(("name", "rest"), [("remus100", (50.0, 1.5)), ("otter", (1.2,)), ("wamv", (1.2,))])
def test_a_line_is_followed_in_a_current_across_it(name, rest):
    """Line due west (NWU +y) with a current of 0.25 m/s northwards: the integral takes the offset to 0.5 m."""
    surface = name != "remus100"
    flight = fly(
        Vehicle.from_catalogue(name),
        400.0,
        h=0.05,
        mode="line_of_sight",
        command=(0.0, 0.0, 0.0, 100.0, *rest),
        position=(-8, 0, 0.0 if surface else 50.0),
        attitude=quaternion(yaw=-1.0),
        nu=(1.0, 0, 0, 0, 0, 0),
        ocean=Still((0.25, 0.0, 0.0)),
    )
    assert abs(flight.position[-1, 0]) < 0.5
    assert flight.position[-1, 1] < -100


def test_altitude_from_a_measured_altitude():
    """Too high by 3 m: it goes down, and keeps going while the measured altitude (a set-point, held here) stays."""
    vehicle = Vehicle.from_catalogue("remus100")
    flight = fly(
        vehicle, 60.0, h=0.05, mode="altitude_heading_speed", command=(5.0, 0.0, 1.8, 8.0), nu=(1.8, 0, 0, 0, 0, 0)
    )
    deeper = flight.position[-1, 2] - 50
    assert deeper > 3


def test_multirotor_in_wind():
    vehicle = Vehicle.from_catalogue("quadrotor")
    flight = fly(
        vehicle, 40.0, h=0.01, command=(4.0, -3.0, 12.0, 2.0), position=(0, 0, -5), ocean=Still(breeze=(2.0, 1.0, 0.0))
    )
    assert flight.position[-1] == pytest.approx([4.0, 3.0, -12.0], abs=0.05)
    assert wrapped(flight.euler[-1, 2] + 2.0) == pytest.approx(0, abs=0.02)
    assert np.abs(flight.euler[:, :2]).max() < np.deg2rad(35)


def test_a_multirotor_by_a_pilots_sticks():
    """Roll and pitch as asked, height kept against the tilt: FRD mirrors y and z of the set-points in FLU."""
    mode = {"type": "attitude", "frequency_rad_s": 1.0, "turn_frequency_rad_s": 5.0, "ratio": 0.8}
    vehicle = Vehicle.from_catalogue("quadrotor", modes={"sticks": mode})
    level = fly(vehicle, 25.0, h=0.01, mode="sticks", command=(0.12, -0.2, 0.0, 7.0), position=(0, 0, -5))
    assert level.euler[-1, :2] == pytest.approx([0.12, 0.2], abs=0.005)
    assert level.position[-1, 2] == pytest.approx(-7.0, abs=0.02)
    assert level.nu[-1, 0] < -0.5  # nose up: astern
    turning = fly(vehicle, 25.0, h=0.01, mode="sticks", command=(0.0, 0.0, 0.4, 3.0), position=(0, 0, -5))
    assert turning.nu[-1, 5] == pytest.approx(-0.4, abs=0.01)
    assert turning.position[-1, 2] == pytest.approx(-3.0, abs=0.02)


def test_aeroplane():
    vehicle = Vehicle.from_catalogue("fixed_wing")
    flight = fly(vehicle, 120.0, h=0.01, command=(130.0, 1.0, 26.0), position=(0, 0, -100), nu=(25.0, 0, 1.0, 0, 0, 0))
    assert -flight.position[-1, 2] == pytest.approx(130.0, abs=0.5)
    assert wrapped(flight.euler[-1, 2] - 1.0) == pytest.approx(0, abs=0.03)
    assert np.linalg.norm(flight.nu[-1, :3]) == pytest.approx(26.0, abs=0.1)


def test_ship():
    vehicle = Vehicle.from_catalogue("mariner")
    flight = fly(vehicle, 900.0, h=0.1, command=(1.0,), position=(0, 0, 0), nu=(7.7175, 0, 0, 0, 0, 0))
    assert flight.euler[-1, 2] == pytest.approx(1.0, abs=0.02)


def test_thrusters_that_cannot_do_it_are_refused():
    with pytest.raises(ScenarioError, match="cannot act on all axes"):
        Vehicle.from_catalogue(
            "otter", modes={"pose": {"type": "pose", "frequency_rad_s": 1.0, "turn_frequency_rad_s": 1.0}}
        )


@pytest.mark.parametrize("toward", [(0.5, 0.0, 0.0), (-0.35, 0.35, 0.0), (0.0, -0.5, 0.0)])
def test_station_keeping_knows_the_current_from_the_start(toward):
    """Half a metre a second from ahead, abeam and astern: drag is fed forward, so nothing drifts off while an integral
    fills (0.04 m measured; without feed-forward 0.7 m)."""
    vehicle = Vehicle.from_catalogue("bluerov2_heavy")
    flight = fly(vehicle, 40.0, h=0.02, mode="station_keeping", ocean=Still(toward))
    assert np.linalg.norm(flight.position - [0, 0, 50], axis=1).max() < 0.1


@pytest.mark.parametrize("toward", [(-0.8, 0.0, 0.0), (0.3, 0.742, 0.0)])
def test_the_heavy_holds_what_its_thrust_suffices_for(toward):
    """0.8 m/s from ahead with either published drag (0.13 m measured); from elsewhere with that of `wu_2018` alone
    (0.04 m): von Benzon's 217 V^2 abeam is 139 N, and the thrusters have 95 N."""
    ahead = toward[1] == 0
    vehicle = Vehicle.from_catalogue("bluerov2_heavy", **({} if ahead else {"variant": "wu_2018"}))
    flight = fly(vehicle, 25.0, h=0.02, mode="station_keeping", ocean=Still(toward))
    assert np.linalg.norm(flight.position - [0, 0, 50], axis=1).max() < (0.3 if ahead else 0.1)
    assert np.abs(flight.euler[:, :2]).max() < np.deg2rad(5)


def test_a_velocity_beyond_the_thrusters_keeps_the_vehicle_upright():
    """Yaw of 3 rad/s and 3 m/s ahead: what the thrusters give, level, and heading before way."""
    vehicle = Vehicle.from_catalogue("bluerov2_heavy")
    flight = fly(vehicle, 20.0, h=0.02, mode="velocity", command=(3.0, 0.0, 0.0, 3.0))
    assert np.abs(flight.euler[:, :2]).max() < np.deg2rad(15)
    assert flight.nu[-1, 5] < -2.5  # FLU 3 rad/s is FRD -3
    assert np.isfinite(flight.nu).all()


def test_no_integral_winds_up_at_saturation():
    """8 s against more than its top speed, then 0.2 m/s asked: no overshoot beyond the little that the lag gives."""
    vehicle = Vehicle.from_catalogue("bluerov2_heavy")
    fast = fly(vehicle, 8.0, h=0.02, mode="velocity", command=(3.0, 0.0, 0.0, 0.0))
    far = fly(vehicle, 60.0, h=0.02, mode="pose", command=(12.0, 0.0, -50.0, 0.0, 0.0, 0.0))
    assert fast.nu[-1, 0] > 0.75
    assert far.position[:, 0].max() < 12.05
    assert far.position[-1, 0] == pytest.approx(12.0, abs=0.03)


@pytest.mark.parametrize(("name", "mode"), [("bluerov2_heavy", "pose"), ("hovering_auv", "velocity")])
def test_thrusters_keep_a_vehicle_upright_in_waves(name, mode):
    """H 2 m, T 8 s, at 8 m: 0.4 m/s of water to and fro and up and down, whose Munk moment of up to 1 N m leans on an
    attitude loop of 3.3 N m/rad: 12 and 11 degrees measured; 97 and 37 while the feed-forward mixed two flows.
    """
    waves = [{"type": "regular", "height_m": 2.0, "period_s": 8.0, "towards_deg": 35}]
    agent = {"vehicle": name, "control": mode, "start": {"position_m": [0, 0, -8]}}
    sim = pl.Simulation.load({
        "tick_rate_hz": 25, "world": {"type": "flat", "depth_m": 60}, "ocean": {"waves": waves}, "agents": {"a": agent},
    })  # fmt: skip
    if mode == "pose":
        sim.command({"a": [0, 0, -8, 0, 0, 0.3]})
    for _ in range(24):
        sim.run(0.5)
        down = 1 - 2 * (sim.state["a"].attitude[0, 1:3] ** 2).sum()
        assert down > np.cos(np.deg2rad(15))


def test_feed_forward_is_of_the_flow_that_is_asked_about():
    """What holds a vehicle in a current that leans at rest: neither the way that the water really goes nor what an
    integrator foresees of the step has a part in it."""
    model = Vehicle.from_catalogue("bluerov2_heavy").model
    f64 = jit.Float64
    still, place = [f64(0.0)] * 3, [f64(0.0), f64(0.0), f64(9.0)]
    known = [f64(c) for c in (0.35, -0.2, 0.15)]
    lean = rotation_from_euler(f64(0.5), f64(-0.3), f64(0.4))

    def held(waves, midway=None):
        flow = make_flow(place, lean, [*still, *still], [k + f64(w) for k, w in zip(known, waves, strict=True)])
        flow.midway = midway
        return np.array([float(w[0]) for w in holding_wrench(model, flow, [*still, *still], known)])

    calm = held((0.0, 0.0, 0.0))
    assert np.abs(calm).min() > 1e-2
    assert held((0.4, -0.3, 0.5)) == pytest.approx(calm, rel=1e-12)
    foreseen = [f64(v) for v in (0.5, -0.4, 0.3, 0.2, -0.1, 0.3)]
    assert held((0.4, -0.3, 0.5), foreseen) == pytest.approx(calm, rel=1e-12)


@pytest.mark.parametrize("name", ["bluerov2", "bluerov2_heavy", "hovering_auv"])
def test_a_pose_that_moves_is_followed_without_lag(name):
    """The reference point stands ahead, its velocity at zero error decides: steady way at 0.3 m/s is a moving pose."""
    vehicle = Vehicle.from_catalogue(name)
    angles = {"roll": 0.0, "pitch": 0.0, "yaw": 0.0}
    given = {"x": 0.0, "y": 0.0, "z": -50.0, **angles, "x_speed": 0.0, "y_speed": 0.2, "z_speed": 0.0, "drive": 1.0}
    flight = fly(vehicle, 10.0, h=0.02, mode="path", command=[given[c] for c in vehicle.command_names("path")])
    assert 0.15 < -flight.position[-1, 1] < 0.45  # 0.2 m/s fed forward against 0.5/s of pull: 0.4 m apart at rest
    adrift = fly(
        vehicle, 30.0, h=0.02, mode="path", ocean=Still((0.3, 0.0, 0.0)),
        command=[{**given, "y_speed": 0.0, "drive": 0.0}[c] for c in vehicle.command_names("path")],
    )  # fmt: skip
    assert adrift.nu[-1, 0] == pytest.approx(0.3, abs=0.03)
    assert adrift.position[-1, 2] == pytest.approx(50.0, abs=0.05)


# what single numbers of a control law stand for


@pytest.mark.parametrize("course_deg", range(-180, 180, 45))
@pytest.mark.parametrize("across", [4.0, -6.0])
def test_the_heading_onto_a_line_does_not_depend_on_where_it_lies(course_deg, across):
    """NWU line, NED position: moved by (dx, dy) together, the heading and the integral stay (both signs of y0)."""
    course = np.deg2rad(course_deg)
    ahead = np.array([np.cos(course), -np.sin(course)])
    right = np.array([-np.sin(course), -np.cos(course)])
    expected = course - np.arctan((across + 0.1 * 2.0) / 10.0)
    for dx, dy in ((0.0, 0.0), (-70.0, 130.0), (25.0, -310.0)):
        start = np.array([dx, dy])
        end, here = start + 50 * ahead, start + 20 * ahead + across * right
        line = [jit.Float64(float(v)) for v in (*start, *end)]
        position = [jit.Float64(float(here[0])), jit.Float64(float(-here[1])), jit.Float64(3.0)]
        heading, integral = line_heading(10.0, 0.1, jit.Float64(2.0), line, position, 0.1)
        assert wrapped(float(heading[0]) - expected) == pytest.approx(0, abs=1e-12)
        assert float(integral[0]) == pytest.approx(2.0 + 0.1 * 10 * across / ((across + 0.2) ** 2 + 100), rel=1e-12)


def test_an_aeroplane_banks_and_coordinates_its_turn():
    """Beard and McLain (2012), Section 5.3: course rate g tan(bank) / V; the rudder acts on the rate that lacks."""
    vehicle = Vehicle.from_catalogue("fixed_wing")
    law, c = vehicle.controllers["height_heading_speed"], vehicle.controllers["height_heading_speed"].config
    still = make_flow(
        [0.0, 0.0, -50.0], rotation_from_euler(0.1, 0.05, 0.3), [25.0, 0.5, 0.8, 0.02, -0.03, 0.07], [0.0] * 3
    )
    flow = dataclasses.replace(
        still,
        position=[jit.Float64(v) for v in (0.0, 0.0, -50.0)],
        rotation=[[jit.Float64(float(v)) for v in row] for row in still.rotation],
        nu=[jit.Float64(v) for v in still.nu],
        nu_r=[jit.Float64(v) for v in still.nu_r],
    )
    command = [jit.Float64(v) for v in (52.0, 0.5, 26.0)]
    demand, kept = law.act([jit.Float64(1.0), jit.Float64(0.5)], flow, command, jit.Float64(0.01))
    bank = np.clip(c.kp_heading * (0.5 - 0.3), -np.deg2rad(c.bank_limit_deg), np.deg2rad(c.bank_limit_deg))
    pitch = c.kp_height * 2.0 + c.ki_height * 1.0
    speed = np.linalg.norm([25.0, 0.5, 0.8])
    given = {name: float(jit.Float64(v)[0]) for name, v in demand.actuators.items()}
    assert given[c.rudder] == pytest.approx(c.k_yaw_s * (0.07 - 9.81 * np.tan(bank) / 26.0), rel=1e-9)
    assert given[c.aileron] == pytest.approx(c.kp_roll * (bank - 0.1) - c.kd_roll_s * 0.02, rel=1e-9)
    assert given[c.elevator] == pytest.approx(-c.kp_pitch * (pitch - 0.05) + c.kd_pitch_s * -0.03, rel=1e-9)
    integral = 0.5 + 0.01 * (26.0 - speed)
    drive = c.trim_drive + c.kp_speed * (26.0 - speed) + c.ki_speed * integral
    assert given[c.propeller] == pytest.approx(drive, rel=1e-9)
    assert [float(k[0]) for k in kept] == pytest.approx([1.0 + 0.01 * 2.0, integral], rel=1e-9)


def test_pose_control_is_damped():
    """A step of half its reach overshoots by 6 % at most; undamped it would by 100 %."""
    flight = fly(Vehicle.from_catalogue("bluerov2_heavy"), 25.0, h=0.02, mode="pose", command=(0.4, 0, -50, 0, 0, 0.5))
    assert flight.position[:, 0].max() < 0.4 * 1.12
    assert flight.position[-1, 0] == pytest.approx(0.4, abs=0.01)
    assert -flight.euler[:, 2].min() < 0.5 * 1.12


def test_an_aeroplane_without_orders_flies_on():
    """At its height, with its cruising speed: it went down to the sea and let its propeller stand."""
    start = {"position_m": [0, 0, 60], "speed_mps": 25, "heading_deg": 30}
    world = {"type": "flat", "depth_m": 30}
    agents = {"it": {"vehicle": "fixed_wing", "start": start}}
    sim = pl.Simulation.load({"tick_rate_hz": 50, "world": world, "agents": agents})
    assert sim.held_command("it")[0] == pytest.approx([60.0, np.radians(30), 25.0])
    sim.run(20.0)
    state = sim.state["it"]
    assert state.position[0, 2] == pytest.approx(60.0, abs=8.0)
    assert np.linalg.norm(state.velocity[0]) > 20.0

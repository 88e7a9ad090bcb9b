"""Every kind of control law reaches its set-points, in a current where there is water."""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
import pytest

sys.path.append(str(Path(__file__).parents[1] / "verification"))
from vehicle_flight import Still, fly, quaternion

from pelagos.errors import ScenarioError
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


@pytest.mark.parametrize("name", ["otter", "wamv", "surface_vessel"])
def test_heading_and_speed_of_twin_thruster_craft(name):
    vehicle = Vehicle.from_catalogue(name)
    flight = fly(vehicle, 90.0, h=0.02, command=(-3.0, 1.2), position=(0, 0, 0), ocean=CURRENT)
    assert wrapped(flight.euler[-1, 2] + 3.0) == pytest.approx(0, abs=0.02)
    yaw = flight.euler[-1, 2]
    assert flight.nu[-1, 0] - (0.25 * np.cos(yaw) - 0.2 * np.sin(yaw)) == pytest.approx(1.2, abs=0.02)


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

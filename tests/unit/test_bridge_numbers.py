"""Numbers on wires, by hand: unequal in all axes, of both signs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.bridges.instruments.nmea import dbt, vtg
from pelagos.bridges.instruments.ping_devices import SOUND_MPS, Ping360
from pelagos.bridges.px4 import Px4Link, pressure_hpa
from pelagos.bridges.ros_commands import _pose
from pelagos.math import frames
from pelagos.sensors.comms.usbl import place_of


@pytest.mark.parametrize("angles", [(0.4, -0.3, 1.2), (-2.0, 0.6, 0.2)])
def test_attitudes_go_to_east_north_up_and_back(angles) -> None:
    """ENU is NWU turned by a quarter about up: R_enu = Z R_nwu."""
    nwu = Rotation.from_euler("ZYX", angles)
    quarter = Rotation.from_matrix([[0, -1, 0], [1, 0, 0], [0, 0, 1]])
    first = lambda rotation: np.roll(rotation.as_quat(), 1)
    found, expected = frames.quaternion_nwu_to_enu_np(first(nwu)), first(quarter * nwu)
    assert found * np.sign(found @ expected) == pytest.approx(expected, abs=1e-12)
    back = frames.quaternion_enu_to_nwu_np(expected)
    assert back * np.sign(back @ first(nwu)) == pytest.approx(first(nwu), abs=1e-12)
    vector = np.array([1.0, -2.0, 0.5])
    assert frames.enu_to_nwu_np(quarter.apply(vector)) == pytest.approx(vector)


@pytest.mark.parametrize("angles", [(0.4, -0.3, 1.2), (-2.0, 0.6, 0.2)])
def test_roll_pitch_and_yaw_of_a_command(angles) -> None:
    """Of a pose in ENU: its place and its turn, a quarter more than that in NWU, as roll, pitch, yaw."""
    nwu = Rotation.from_euler("ZYX", angles)
    x, y, z, w = (Rotation.from_matrix([[0, -1, 0], [1, 0, 0], [0, 0, 1]]) * nwu).as_quat()
    place, turn = SimpleNamespace(x=3.0, y=-7.0, z=-2.0), SimpleNamespace(w=w, x=x, y=y, z=z)
    made = _pose("auv0", SimpleNamespace(pose=SimpleNamespace(position=place, orientation=turn)))
    assert made.data["values"] == pytest.approx([-7.0, -3.0, -2.0, *angles[::-1]])


def test_depths_in_feet_metres_and_fathoms() -> None:
    """10 m are 32.81 feet and 5.47 fathoms; 2.5 m/s are 4.860 knots and 9 km/h."""
    assert dbt(10.0).startswith(b"$SDDBT,32.81,f,10.00,M,5.47,F")
    assert b",T,,M,4.860,N,9.000,K,A" in vtg(2.5, 275.5)


@pytest.mark.parametrize(("degrees", "gradian"), [(45.0, 150), (-90.0, 300), (0.0, 200)])
def test_a_ping360_turns_clockwise_in_gradians(degrees: float, gradian: int) -> None:
    """45 degrees to port are 50 gradians back from ahead; a sample of 25 ns ticks lies at half of sound's way."""
    device = Ping360(SimpleNamespace(config=SimpleNamespace(range_min_m=1.0, range_max_m=9.0)))
    trace = np.zeros((1, 400))
    trace[0, 200] = 1.0  # 5.01 m
    device.hear(SimpleNamespace(extras={"angle": np.array([math.radians(degrees)])}, data=trace))
    period = 400
    levels = np.frombuffer(device._trace(gradian, period, 1200), np.uint8)
    step = period * 25e-9 * SOUND_MPS / 2
    assert (levels.argmax() + 0.5) * step == pytest.approx(5.01, abs=step)
    assert not any(device._trace((gradian + 40) % 400, period, 1200))


class Dialect:
    """Keeps what a message is made of."""

    def MAVLink_hil_gps_message(self, *values):
        return values

    def MAVLink_hil_sensor_message(self, *values):
        return values


def autopilot() -> Px4Link:
    made = object.__new__(Px4Link)
    made._dialect, made._field = Dialect(), np.array([2e-5, -3e-6, -4.5e-5])
    made._origin = SimpleNamespace(to_latlon=lambda x, y: (45.0 + x * 1e-5, 13.0 - y * 1e-5))
    return made


@pytest.mark.parametrize(("velocity", "course"), [((2.0, 1.0, -0.3), 2657), ((-0.5, -1.5, 0.2), 25157)])
def test_course_and_place_of_a_gps_for_px4(velocity, course: int) -> None:
    """Course over ground clockwise from north [cdeg]; velocities north, east, down [cm/s]."""
    motion = SimpleNamespace(position=np.array([120.0, -45.0, -2.0]), velocity=np.array(velocity))
    got = autopilot()._gps(motion, 7)
    assert got[2:5] == (450012000, 129995500, 2000)
    assert got[7] == round(100 * math.hypot(*velocity[:2]))
    assert got[8:12] == (*(round(100 * v) for v in velocity), course)


def test_the_field_that_px4_feels_is_turned_into_the_body() -> None:
    """Heading east: what points north is felt to port, -y of FRD [gauss]; down stays down."""
    half = math.sqrt(0.5)
    motion = SimpleNamespace(
        position=np.array([0.0, 0.0, 3.0]), attitude=np.array([half, 0, 0, half]), force=np.zeros(3), gyro=np.zeros(3)
    )
    got = autopilot()._sensor(motion, 7)
    assert got[7:10] == pytest.approx((0.03, -0.2, 0.45), abs=1e-9)  # east 3e-6 T ahead, north 2e-5 T to port


def test_pressures_above_and_below_the_sea() -> None:
    """1013.25 hPa at the surface; 10 m of sea water add 1005.5 hPa or so; ISO 2533: 898.75 hPa at 1000 m."""
    assert pressure_hpa(0.0) == pytest.approx(1013.25)
    assert pressure_hpa(10.0) - 1013.25 == pytest.approx(1005.5, abs=1.5)
    assert pressure_hpa(-1000.0) == pytest.approx(898.75, abs=0.1)


def test_one_way_outputs_of_px4_are_controlled_from_0_to_1() -> None:
    assert [Px4Link._level(c, 0.0) for c in (-0.4, 0.7)] == [-0.4, 0.7]
    assert [Px4Link._level(c, -1.0) for c in (0.0, 0.25, 1.0)] == [-1.0, -0.5, 1.0]


def test_a_place_from_range_azimuth_to_port_and_elevation() -> None:
    packet = SimpleNamespace(range_m=10.0, azimuth_rad=math.radians(30), elevation_rad=math.radians(-20))
    level = 10 * math.cos(math.radians(20))
    expected = [level * math.cos(math.radians(30)), level * 0.5, -10 * math.sin(math.radians(20))]
    assert place_of(packet) == pytest.approx(expected)

"""Wire formats, sticks, and what other simulators and data sets have; each against a documented number or formula."""

from __future__ import annotations

import math
import struct
from datetime import UTC, datetime
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from pymavlink.dialects.v20 import common

from pelagos import jit
from pelagos.bridges.instruments import mip, nmea, ping, teledyne
from pelagos.bridges.instruments.ping_devices import Ping1d, Ping360
from pelagos.bridges.mavlink import MavlinkConfig, MavlinkDoor
from pelagos.bridges.pace import next_ns
from pelagos.compat.holoocean.native_scenario import sine_tide, sun_of
from pelagos.datasets.formats.kitti import _line
from pelagos.datasets.formats.yolo import Yolo
from pelagos.messages.image import encoding_name
from pelagos.ocean.tide import TideConfig, make_tide
from pelagos.sensors.camera.picture.annotations import Box


def stick(*axes):
    """What a door orders of MANUAL_CONTROL's x, y, z, r; full is 0.8 m/s, and 21 degrees a second."""
    put, refused = [], []
    inbox = Stub(put=put.append, refuse=refused.append)
    config = MavlinkConfig(type="mavlink", system=7, speed_mps=0.8, turn_deg_s=21.0)
    MavlinkDoor._stick(
        Stub(agent="rov", _config=config, _inbox=inbox), common.MAVLink_manual_control_message(7, *axes, 0)
    )
    return put, refused


@pytest.mark.parametrize(
    ("axes", "velocity", "turn_deg_s"),
    [
        ((0, 0, 500, 0), (0, 0, 0), 0),
        ((1000, -1000, 1000, -1000), (0.8, 0.8, 0.8), 21),
        ((-1000, 1000, 0, 1000), (-0.8, -0.8, -0.8), -21),
        ((350, 200, 300, 400), (0.28, -0.16, -0.32), -8.4),
        ((32767, 100, 600, -100), (0, -0.08, 0.16), 2.1),
        ((-250, 32767, 32767, 50), (-0.2, 0, 0), -1.05),
        ((-250, -700, 450, 32767), (-0.2, 0.56, -0.08), 0),
    ],
)
def test_a_ground_stations_stick_orders_a_velocity_of_the_body(axes, velocity, turn_deg_s):
    """x ahead, y and r to the right: so do QGroundControl, ArduPilot and PX4, and common.xml since 2025, which said the
    contrary of r before (mavlink pull request 2398). z is 0 to 1000, still at 500, as QGroundControl and ArduSub have
    it (ArduPilot issue 8818). An order is ahead, to port, up, and turns to port. INT16_MAX: the axis is not there.
    """
    (order,), refused = stick(*axes)
    assert not refused
    assert (order.kind, order.target) == ("velocity", "rov")
    assert order.data["values"] == pytest.approx([*velocity, 0, 0, math.radians(turn_deg_s)])


@pytest.mark.parametrize(
    "axes", [(1001, 0, 500, 0), (0, -1001, 500, 0), (0, 0, 1001, 0), (0, 0, -1, 0), (0, 0, 500, 1001)]
)
def test_a_stick_beyond_its_range_is_refused(axes):
    orders, (said,) = stick(*axes)
    assert not orders
    assert said == "MANUAL_CONTROL: x, y or r is not between -1000 and 1000, or z not between 0 and 1000"


def test_the_checksum_of_an_inertial_unit_is_that_of_its_manual():
    """The ping of LORD's MIP manual; sums run over modulo 256."""
    assert mip.fletcher(bytes.fromhex("756501020201")) == bytes.fromhex("e0c6")
    assert mip.fletcher(bytes([200, 100, 3])) == bytes([303 - 256, 200 + 300 + 303 - 3 * 256])


def test_the_next_reading_is_due_at_a_multiple_of_the_period():
    found = [next_ns(t, 8.0) for t in (0, 124_999_999, 125_000_000, 125_000_001)]
    assert found == [125_000_000, 125_000_000, 250_000_000, 250_000_000]


def test_degrees_and_minutes_of_nmea_are_rounded_before_they_are_split():
    """NMEA 0183: ddmm.mmmmm and a letter; longitudes beyond 180 degrees are those of the other half."""
    assert nmea._latitude(-33.9999999999) == "3400.00000,S"
    assert nmea._latitude(7.512345) == "0730.74070,N"
    assert nmea._longitude(-190.25) == "16945.00000,E"
    assert nmea._longitude(200.25) == "15945.00000,W"
    assert nmea._longitude(-5.05) == "00503.00000,W"


def test_an_ensemble_holds_far_ranges_and_large_numbers():
    """PD0 (Workhorse manual): vertical ranges in cm, 16 bits low and 8 high; velocities of the bottom, to starboard,
    ahead and up, in mm/s; depth in dm, angles in 0.01 degrees.
    """
    dvl = Stub(ranges_m=(1000.0, 700.0, math.nan, 12.3), beam_valid=(True, True, True, False),
               velocity=(1.234, -0.5, 40.0), t_ns=0)  # fmt: skip
    raw = teledyne._bottom_track(dvl, (0.9, 0.8, 0.7, 0.6))
    assert struct.unpack_from("<4H", raw, 16) == (90000 - 65536, 56000, 0, 0)
    assert tuple(raw[77:81]) == (1, 0, 0, 0)
    assert struct.unpack_from("<4h", raw, 24) == (500, -1234, 32767, 0)
    assert tuple(raw[32:44]) == (255, 255, 255, 0, 120, 120, 120, 20, 100, 100, 100, 0)
    attitude = teledyne.Attitude(-0.001, -3.21, 4.56, -0.4)
    raw = teledyne._variable_leader(dvl, datetime(2026, 5, 4, 3, 2, 1, 230_000, UTC), attitude, 1499.6, 3 * 65536 + 5)
    assert struct.unpack_from("<HHhh", raw, 14)[:2] == (1500, 0)
    assert struct.unpack_from("<Hhh", raw, 18) == (0, -321, 456)
    assert struct.unpack_from("<H", raw, 2) == (5,)
    assert tuple(raw[4:12]) == (26, 5, 4, 3, 2, 1, 23, 3)
    assert tuple(raw[57:65]) == (20, 26, 5, 4, 3, 2, 1, 23)
    attitude = teledyne.Attitude(271.26, 3.2, -4.5, 81.26)
    raw = teledyne._variable_leader(dvl, datetime(2026, 5, 4, tzinfo=UTC), attitude, 1480.4, 7)
    assert struct.unpack_from("<HHHhh", raw, 14) == (1480, 813, 27126, 320, -450)


def test_a_ping1d_tells_distances_by_its_speed_of_sound_and_cuts_its_scan():
    """3 % faster sound lies 3 % farther away; a scan that a driver sets holds no echo outside of it."""
    one = Ping1d(Stub(config=Stub(range_min_m=1.0, range_max_m=9.0, rate_hz=5.0)))
    echo, middles = np.array([0.2, 0.8, 0.4, 1.0]), np.array([2.0, 4.0, 6.0, 8.0])
    one._echo, one._distance_m, one._confidence, one._number = echo, 6.5, 40, 7
    one._kept[ping.SPEED_OF_SOUND] = (1_545_000,)
    assert one._seen() == (6695, 40, 7, 1000, 8000)
    one._kept |= {ping.MODE_AUTO: (0,), ping.RANGE: (2000, 5000)}
    assert one._seen() == (6695, 40, 7, 2000, 5000)
    at = (2.0 + (np.arange(200) + 0.5) * 5.0 / 200) / 1.03
    told = np.frombuffer(one._profile(), np.uint8)
    assert np.abs(told - 255 * np.interp(at, middles, echo, left=0.0)).max() <= 0.5 + 1e-9
    assert told[:3].tolist() == [0, 0, 51]  # the first two are nearer than the middle of the first bin
    for distance_m in (6.9, 1.9):
        one._distance_m = distance_m
        assert one._seen() == (0, 0, 7, 2000, 5000)


def ping360():
    """The head of a scanning sonar, between 1 and 9 m."""
    return Ping360(Stub(config=Stub(range_min_m=1.0, range_max_m=9.0, rate_hz=5.0)))


def test_a_ping360_answers_with_the_nearest_trace_within_two_gradians():
    """Samples lie half a period of 25 ns of the way to and fro apart, at 1500 m/s."""
    echo, middles = np.array([0.2, 0.8, 0.4, 1.0]), np.array([2.0, 4.0, 6.0, 8.0])
    head = ping360()
    head._traces = {12: echo, 9: echo[::-1]}
    distance = (np.arange(13) + 0.5) * 40000 * 25e-9 * 1500 / 2
    for gradian, trace in ((11, echo), (10, echo[::-1]), (7, echo[::-1]), (14, echo), (6, None), (15, None)):
        told = np.frombuffer(head._trace(gradian, 40000, 13), np.uint8).astype(int)
        level = np.zeros(13) if trace is None else 255 * np.interp(distance, middles, trace, left=0.0, right=0.0)
        assert np.abs(told - level).max() <= 0.5 + 1e-9
    head._traces = {1: echo}
    assert any(head._trace(399, 40000, 13))
    assert not any(head._trace(398, 40000, 13))


@pytest.mark.parametrize(
    ("angle_deg", "gradian"), [(0.0, 200), (0.9, 199), (-90.0, 300), (45.0, 150), (-179.9, 0), (179.9, 0)]
)
def test_a_ping360_counts_gradians_clockwise_from_astern(angle_deg, gradian):
    """400 a turn, 200 ahead; a sensor's own angles are positive to port."""
    head = ping360()
    head._traces = {77: np.ones(4)}
    head.begin()
    head.hear(Stub(extras={"angle": [math.radians(angle_deg)]}, data=[np.array([0.2, 1.4, -0.3, 0.5])]))
    assert list(head._traces) == [gradian]
    assert head._traces[gradian].tolist() == [0.2, 1.0, 0.0, 0.5]


@pytest.mark.parametrize(
    ("kind", "shape", "name"),
    [
        ("u1", (4, 5), "mono8"), ("u2", (4, 5, 1), "mono16"), ("u4", (4, 5), "32SC1"), ("f4", (4, 5), "32FC1"),
        ("i2", (4, 5, 2), "16SC2"), ("u1", (4, 5, 3), "8UC3"), ("u2", (4, 5, 2), "16UC2"), ("f8", (4, 5), "64FC1"),
    ],
)  # fmt: skip
def test_pixels_have_the_names_of_ros(kind, shape, name):
    """sensor_msgs/image_encodings.hpp, which has no unsigned pixels of 32 bits."""
    assert encoding_name(np.zeros(shape, kind)) == name


def test_the_sun_of_an_hour_is_up_at_6_and_highest_at_12():
    """15 degrees an hour; in the east before noon, in the west after."""
    found = [tuple(sun_of(hour).values()) for hour in (0.0, 9.0, 12.0, 15.0, 30.5, -3.0)]
    assert found == [(-90, 90), (45, 90), (90, 270), (45, 270), (7.5, 90), (-45, 270)]


@pytest.mark.parametrize(("amplitude", "turned"), [(0.7, 0.0), (-0.7, 0.1), (0.4, -0.3)])
def test_a_tide_of_hours_rises_as_a_sine(amplitude, turned):
    """A sin(2 pi (t / T - turned)), by the tide of the ocean."""
    t = np.linspace(0, 9000, 7)
    tide = make_tide((TideConfig(**sine_tide(amplitude, 5400.0, turned=turned)),))
    level = np.array(tide.level(jit.Float64(t)))
    assert np.allclose(level, amplitude * np.sin(2 * math.pi * (t / 5400 - turned)))


def test_a_line_of_kitti_is_a_box_in_the_cameras_axes():
    """Right, down, ahead; its place is the middle of the lower face, rotation_y 0 along the camera's x, and alpha that
    less the bearing (object development kit, readme.txt). The camera looks 0.7 rad to starboard from (1, 2, -3).
    """
    box = Box(3, 1, column=30, row=8, width=10, height=4, area=21)
    about_z = lambda a: np.array([[math.cos(a), -math.sin(a), 0], [math.sin(a), math.cos(a), 0], [0, 0, 1.0]])
    psi, eye, camera_turn = 1.5, np.array([1.0, 2.0, -3.0]), about_z(-0.7)
    centre, size = np.array([10.0, -2.0, 1.0]), np.array([4.0, 2.0, 1.5])  # ahead, left, up of the camera
    signs = np.array([(i, j, k) for i in (-1, 1) for j in (-1, 1) for k in (-1, 1)])
    corners = centre + (signs * size / 2) @ about_z(psi).T
    space = Stub(
        size=size, centre=eye + camera_turn @ centre, turn=camera_turn @ about_z(psi),
        corners=eye + corners @ camera_turn.T,
    )  # fmt: skip
    matrix = np.array([[50.0, 0, 50], [0, 50, 20], [0, 0, 1]])
    thing = Stub(box=box, name="pipe", space=space)
    name, cut, hidden, alpha, *numbers = _line(thing, eye, camera_turn, matrix, (60, 40)).split()
    assert (name, hidden) == ("pipe", "3")
    assert [float(v) for v in numbers[:4]] == [30, 8, 39, 11]
    about_y = math.atan2(-math.cos(psi), -math.sin(psi))
    assert np.allclose([float(v) for v in numbers[4:]], [1.5, 2.0, 4.0, 2.0, -1.0 + 0.75, 10.0, about_y], atol=1e-3)
    assert float(alpha) == pytest.approx(about_y - math.atan2(2.0, 10.0) + 2 * math.pi, abs=1e-4)
    across = 50 - 50 * corners[:, 1] / corners[:, 0]  # of 60 pixels
    assert across.min() < 60 < across.max()
    assert float(cut) == pytest.approx(1 - (60 - across.min()) / np.ptp(across), abs=0.005)
    behind = _line(
        Stub(box=box, name="pipe", space=space), eye + camera_turn @ [9.0, 0, 0], camera_turn, matrix, (60, 40)
    )
    assert behind.split()[1] == "-1.00"
    unknown = _line(Stub(box=box, name="pipe", space=None), eye, camera_turn, matrix, (60, 40))
    assert unknown == "pipe -1 3 -10 30.00 8.00 39.00 11.00 -1 -1 -1 -1000 -1000 -1000 -10\n"


def test_a_line_of_yolo_is_a_class_and_a_box_in_shares_of_the_picture(tmp_path):
    """Class, middle across and down, width and height (Ultralytics documentation)."""
    box = Box(3, 1, column=30, row=8, width=10, height=6, area=21)
    sample = Stub(
        file=lambda name: ("png", name.encode()), key="k", readings={"ids": np.zeros((40, 100))},
        things=[Stub(box=box, number=2)],
    )  # fmt: skip
    Yolo.add(Stub(_camera="eye", _instances="ids", _pictures=tmp_path, _labels=tmp_path), sample)
    assert (tmp_path / "k.txt").read_text() == "2 0.350000 0.275000 0.100000 0.150000\n"
    assert (tmp_path / "k.png").read_bytes() == b"eye"

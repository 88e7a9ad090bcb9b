"""Multibeams under way: where beams look that are sent in one attitude and heard in another.

Expected places are found without the program's formulas: the point of the bottom is sought (Newton) whose direction
from the place of transmission lies on the transmitter's cone, and from the place of reception, after the travel time,
on the receiver's.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError
from sonar_scenes import at, context, plane

from pelagos.acoustics.absorption import absorption
from pelagos.math.so3 import from_euler, rotate_np
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig
from pelagos.world.material import MATERIALS

SAND = (MATERIALS["sand"],)
C = 1500.0
DEPTH = 100.0  # of the bottom below the sounder
KEYS = {"beams": 31, "range_max_m": 400.0, "rate_hz": 1.0, "frequency_hz": 100e3, "bandwidth_hz": 10e3, "pulse_s": 2e-3,
        "attitudes": True}  # fmt: skip
Q0 = np.array([float(v) for v in from_euler(0.08, -0.05, 0.6)])
VELOCITY, SPIN = np.array([2.5, 0.4, -0.2]), np.radians([10.0, -4.0, 3.0])


def sonar(**options):
    return Multibeam(MultibeamConfig(**(KEYS | options)), context([plane(-DEPTH - 10.0, size=3000.0)], materials=SAND))


def ping(s, attitude=Q0, velocity=VELOCITY, spin=SPIN, tick=0):
    return s.sense(at(3.0, 4.0, -10.0, tick=tick, attitude=attitude, velocity=velocity, angular_velocity=spin))


def world(q, vectors):
    rows = np.atleast_2d(np.asarray(vectors, dtype=float))
    return rotate_np(np.tile(q, (len(rows), 1)), rows).reshape(np.shape(vectors))


def spun(q, spin, time):
    """The attitude after turning evenly."""
    angle, axis = np.linalg.norm(spin) * time, spin / np.linalg.norm(spin)
    w, v = math.cos(angle / 2), math.sin(angle / 2) * axis
    return np.concatenate([[q[0] * w - q[1:] @ v], q[0] * v + w * q[1:] + np.cross(q[1:], v)])


def met(sent, heard):
    """Point of the bottom from the place of transmission [m], and travel time [s], for sines of both steering angles.

    `heard` is a number, or a function of the attitude of reception.
    """
    velocity = world(Q0, VELOCITY)
    ahead = world(Q0, [1.0, 0.0, 0.0])

    def residual(u):
        x = np.array([u[0], u[1], -DEPTH])
        time = u[2] / 100.0
        back = x - velocity * time
        q = spun(Q0, SPIN, time)
        wanted = heard(q) if callable(heard) else heard
        out, home = np.linalg.norm(x), np.linalg.norm(back)
        return np.array([ahead @ x / out - sent, world(q, [0.0, 1.0, 0.0]) @ back / home - wanted,
                         100.0 * ((out + home) / C - time)])  # fmt: skip

    u = np.array([0.0, 0.0, 13.0])
    for _ in range(60):
        r = residual(u)
        slope = np.stack([(residual(u + e) - r) / 1e-5 for e in 1e-5 * np.eye(3)], axis=1)
        step = np.linalg.solve(slope, r)
        u = u - step * min(1.0, 40.0 / max(np.abs(step).max(), 1e-9))
    assert np.abs(residual(u)).max() < 1e-9
    return np.array([u[0], u[1], -DEPTH]), u[2] / 100.0


def test_axes_meet_the_bottom_where_both_cones_cross():
    """Truth is the range along each axis: to first order in v/c, within 0.01 m and 1e-4 of 100 to 250 m.

    The sounding lies there, as well as the detection is good: 0.5 m of a footprint of 2 m and more.
    """
    s = sonar()
    reading = ping(s)
    places = world(Q0, reading.extras["soundings"][0])
    for beam in (0, 5, 11, 15, 22, 30):
        point, time = met(0.0, math.sin(s.config.angles[beam]))
        assert reading.truth[0, beam] == pytest.approx(np.linalg.norm(point), rel=1e-4, abs=0.01), beam
        assert places[beam] == pytest.approx(point, abs=0.5), beam
        coupling = 100e3 * 2e-3 / 10e3 * (world(Q0, VELOCITY) @ point) / np.linalg.norm(point)
        assert reading.data[0, beam] == pytest.approx(C * time / 2 - coupling, abs=0.4), beam


def test_a_roll_of_ten_degrees_a_second_is_nine_metres_at_200_m():
    """Soundings by the attitude of transmission alone miss the bottom by 200 m times 2.67 deg; by both they do not."""
    s = sonar(beams=121)
    reading = ping(s, spin=(math.radians(10.0), 0.0, 0.0), velocity=(0.0, 0.0, 0.0), attitude=(1.0, 0.0, 0.0, 0.0))
    slant = np.abs(reading.data[0] - 200.0).argmin()
    naive = s.tables["direction"][slant] * reading.data[0, slant]
    both = reading.extras["soundings"][0, slant]
    missed = np.linalg.norm(naive - both)
    assert missed == pytest.approx(2 * reading.data[0, slant] ** 2 / C * math.radians(10.0), rel=0.01)  # 9.3 m at 200 m
    assert both[2] == pytest.approx(-DEPTH, abs=0.6)
    assert abs(naive[2] + DEPTH) > 7.0


def test_a_sounder_that_does_not_count_motion_hears_in_one_instant():
    still, instant = sonar(), sonar(doppler=False)
    a = ping(still, velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0))
    b = ping(instant)
    assert a.truth == pytest.approx(b.truth, rel=2e-5)
    assert np.abs(ping(still).truth - b.truth).max() > 3.0


def test_attitudes_are_those_of_sending_and_hearing():
    reading = ping(sonar())
    assert reading.extras["transmit_attitude"][0] == pytest.approx(Q0, abs=1e-6)
    for beam in (0, 15, 30):
        expected = spun(Q0, SPIN, 2.0 * reading.data[0, beam] / C)
        assert reading.extras["receive_attitude"][0, beam] == pytest.approx(expected, abs=1e-5)


class TestHeld:
    def course(self):
        v = world(Q0, VELOCITY)
        ahead = np.array([v[0], v[1], 0.0]) / np.hypot(v[0], v[1])
        return ahead, np.array([-ahead[1], ahead[0], 0.0])

    def test_all_axes_are_held_in_the_plane_square_to_the_course(self):
        """With 16 sectors each beam is at most 3.75 deg from the one that its sector is steered for."""
        ahead, port = self.course()
        spread = {}
        for sectors in (1, 16):
            s = sonar(stabilised=("roll", "pitch", "yaw"), sectors=sectors, swath_deg=100.0)
            places = world(Q0, ping(s).extras["soundings"][0])
            spread[sectors] = np.abs(places @ ahead).max()
            if sectors == 16:
                angle = np.arctan2(places @ port, -places[:, 2])
                assert angle == pytest.approx(s.config.angles, abs=math.radians(0.6))
        assert spread[16] < 0.25 * spread[1]
        assert np.abs(world(Q0, ping(sonar(swath_deg=100.0)).extras["soundings"][0]) @ ahead).max() > 1.2 * spread[1]

    def test_axes_of_a_held_roll_meet_the_bottom_where_the_cones_cross(self):
        s = sonar(stabilised=("roll",))
        heading = world(Q0, [1.0, 0.0, 0.0])
        heading = heading / np.hypot(heading[0], heading[1])
        port = np.array([-heading[1], heading[0], 0.0])
        reading = ping(s)
        for beam in (1, 20):
            a = s.config.angles[beam]
            wanted = math.sin(a) * port - np.array([0.0, 0.0, math.cos(a)])
            point, _ = met(0.0, lambda q, wanted=wanted: wanted @ world(q, [0.0, 1.0, 0.0]))
            assert reading.truth[0, beam] == pytest.approx(np.linalg.norm(point), rel=1e-4), beam

    def test_the_transmitter_steers_against_pitch(self):
        tilt = ping(sonar(stabilised=("pitch",))).extras["transmit_tilt"][0]
        assert np.sin(tilt) == pytest.approx(np.full(31, -world(Q0, [1.0, 0.0, 0.0])[2]), abs=1e-5)

    def test_a_sounder_that_looks_aside_is_not_held(self):
        with pytest.raises(ValidationError, match="looks straight down"):
            MultibeamConfig(stabilised=("roll",), orientation_deg=(30.0, 0.0, 0.0))


def test_two_swaths_lie_their_angle_apart():
    s = sonar(dual_swath_deg=4.0)
    reading = ping(s, attitude=(1.0, 0.0, 0.0, 0.0), velocity=(0.0, 0.0, 0.0), spin=(0.0, 0.0, 0.0))
    assert reading.data.shape == (1, 62)
    places = reading.extras["soundings"][0]
    fore, aft = places[s.tables["swath"] == 0], places[s.tables["swath"] == 1]
    apart = 2 * np.linalg.norm(fore, axis=1) * math.sin(math.radians(2.0))
    assert fore[:, 0] - aft[:, 0] == pytest.approx(apart, rel=0.02)
    assert fore[15, 0] == pytest.approx(DEPTH * math.tan(math.radians(2.0)), rel=0.02)


def test_each_sector_loses_what_its_own_frequency_does():
    """Outer sectors at 70 and 130 kHz about 100 kHz: levels of the window differ by 2 r (a(f) - a(f0))."""
    keys = {"doppler": False, "range_max_m": 250.0}
    one, three = sonar(**keys), sonar(sectors=3, sector_spacing_hz=30e3, **keys)
    told = [{n: v for n, v, _ in s.explain(at(0.0, 0.0, -10.0))} for s in (one, three)]
    rays = three.config.rays_per_beam
    level = [10 * np.log10(t["echo intensity of a ray re 1 m"].reshape(31, rays)[:, rays // 2]) for t in told]
    loss = [float(np.array(absorption(f, 10.0, 35.0, 0.0, 8.1))) for f in (70e3, 100e3, 130e3)]
    reach = told[0]["slant range"].reshape(31, rays)[:, rays // 2]
    for beam, sector in ((1, 0), (15, 1), (29, 2)):
        expected = -2.0 * reach[beam] * (loss[sector] - loss[1])
        assert level[1][beam] - level[0][beam] == pytest.approx(expected, rel=0.03, abs=1e-3)


def test_keys_that_contradict_are_refused():
    with pytest.raises(ValidationError, match="water_column_bins are of one swath"):
        MultibeamConfig(dual_swath_deg=2.0, water_column_bins=100)
    with pytest.raises(ValidationError, match="needs more than one of sectors"):
        MultibeamConfig(sector_spacing_hz=1e3)
    with pytest.raises(ValidationError, match="give a smaller sector_spacing_hz"):
        MultibeamConfig(sectors=5, sector_spacing_hz=200e3)


def test_lanes_together_are_lanes_alone():
    """Three attitudes at once and one after another, the same bytes."""
    s = sonar(stabilised=("roll", "yaw"), sectors=3)
    places = np.array([[0.0, 0.0, -10.0], [40.0, -7.0, -12.0]])
    turns = np.stack([Q0, np.array([float(v) for v in from_euler(-0.1, 0.03, -1.9)])])
    from sonar_scenes import DT_NS

    from pelagos.sensors.example_motion import lanes

    motion = {"dt_ns": DT_NS, "velocity": VELOCITY, "angular_velocity": SPIN}
    both = s.sense(lanes([7, 8], position=places, attitude=turns, **motion))
    for k in range(2):
        alone = s.sense(lanes([7 + k], position=places[k], attitude=turns[k], **motion))
        np.testing.assert_array_equal(both.data[k], alone.data[0])

"""Rare branches of guidance, fits, pictures and wire formats, each against a formula or a number of its own."""

from __future__ import annotations

import math
import struct
from datetime import UTC, datetime
from types import SimpleNamespace as Stub

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from pelagos.bridges.instruments import mip, nmea, ping, teledyne
from pelagos.bridges.instruments.ping_devices import Ping1d, Ping360
from pelagos.bridges.pace import next_ns
from pelagos.compat.holoocean.native_scenario import sine_tide, sun_of
from pelagos.datasets.formats.kitti import _line
from pelagos.datasets.formats.yolo import Yolo
from pelagos.drawing.sample import _colour, _flow
from pelagos.errors import ScenarioError
from pelagos.identification import beam_faults, noise
from pelagos.identification.allan_terms import _weighed, terms_of
from pelagos.identification.certainty import _memory
from pelagos.identification.doubts import _surely_larger
from pelagos.identification.plausibility import _descent
from pelagos.identification.problem import Problem
from pelagos.identification.shots import Shots, _directions
from pelagos.manoeuvres.picture import in_lengths
from pelagos.messages.image import encoding_name
from pelagos.messages.sonar_image import eight_bits
from pelagos.navigation.error_state import Lanes
from pelagos.report.movers import near_parts
from pelagos.report.sonar import _interest
from pelagos.report.soundings import _means
from pelagos.sensors.camera.picture.annotations import Box
from pelagos.sensors.sensor import Measurement
from pelagos.sim.guidance.aboard import Aboard, Fix
from pelagos.sim.guidance.follow import FollowAgent, FollowWall
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.guidance import level_depth
from pelagos.sim.guidance.orbit import Orbit
from pelagos.sim.guidance.outcome import _from_circle, _from_line
from pelagos.sim.guidance.outline import _circle
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.steering.cruise import Cruise
from pelagos.sim.guidance.steering.hover import Hover
from pelagos.sim.guidance.steering.steering import Crab, Lead, circle_rate
from pelagos.sim.guidance.steering.surface import Surface
from pelagos.sim.guidance.survey import Swath, _altitude, _cut
from pelagos.sim.guidance.task import Common, Level, Limit
from pelagos.sim.guidance.vertical import Land, Profile
from pelagos.sim.sampled import Sampled
from pelagos.viewer.chase import _seen
from pelagos.viewer.drive import _integrate
from pelagos.viewer.ground import _stitch
from pelagos.viewer.hull import Model3d
from pelagos.viewer.marks import _passed
from pelagos.viewer.scene import fan_mesh


def aboard(position, heading=0.0, velocity=(0.0, 0.0, 0.0), *, altitude=np.inf, t_s=20.0, dt_s=0.5, **more):
    position = np.atleast_2d(np.array(position, float))
    n = len(position)
    fix = Fix(position, np.broadcast_to(heading, n).astype(float), np.broadcast_to(velocity, (n, 3)).astype(float))
    return Aboard(fix, t_s, dt_s, np.broadcast_to(altitude, n).astype(float), np.zeros(n, bool), **more)


# guidance


def test_another_agent_is_followed_at_a_place_beside_it():
    own = [(4.0, 3.0, -2.0), (-60.0, 50.0, -2.0), (70.0, -60.0, -2.0), (4.0, 3.0, -2.0)]
    way = np.array([(0.8, -0.5, 0.1), (0.8, -0.5, 0.1), (0.8, -0.5, 0.1), (0.1, -0.1, 0.0)])
    other = Fix(np.tile([10.0, -4.0, -7.0], (4, 1)), np.full(4, 0.6), way)
    now = aboard(own, others={"lead": other})
    task = FollowAgent("lead", (-6.0, 2.0, -1.5), 12.0, 1.9, Common(speed_mps=1.1))
    progress = Progress.begin(now)
    goal = task.goal(now, progress)
    # compass 0.6 rad: ahead is (cos, -sin), to port (sin, cos) of north and west
    place = [10 - 6 * math.cos(0.6) + 2 * math.sin(0.6), -4 + 6 * math.sin(0.6) + 2 * math.cos(0.6)]
    unit = np.array([0.8, -0.5]) / math.hypot(0.8, 0.5)
    assert np.allclose(goal.start[:3], place - 50 * unit)
    assert np.allclose(goal.end[:3], place + 50 * unit)
    assert np.allclose(goal.end[3], place)
    assert np.allclose(goal.start[3], own[3][:2])
    expected = math.hypot(0.8, 0.5) + 0.15 * float((np.array(place) - own[0][:2]) @ unit)
    assert 0.05 < expected < 1.9
    assert np.allclose(goal.speed, [expected, 1.9, 0.05, 1.1])
    assert goal.path.tolist() == [Path.LINE] * 3 + [Path.POINT]
    assert goal.stops.tolist() == [False] * 3 + [True]
    assert np.allclose(goal.depth, 7.0 + 1.5)
    assert np.allclose(goal.face, 0.6)
    assert not task.moves(now, progress).any()
    assert task.moves(aboard(own, t_s=32.0), progress).all()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_direction_of_a_wall_follows_from_how_its_range_changes(side):
    """A range that grows abeam is a wall that turns away: to the side that the vehicle looks at."""
    velocity = [(0.6, -0.3, 0.0), (0.1, 0.05, 0.0), (0.6, -0.3, 0.0), (0.6, -0.3, 0.0), (0.2, 0.1, 0.0)]
    distance = np.array([6.1, 6.02, np.nan, 6.1, 3.0])
    now = aboard(np.zeros((5, 3)), 0.7, velocity, readings={"wall": distance[:, None]})
    progress = Progress.begin(now)
    progress.heading[:] = 0.4
    progress.memory[:, :3] = [(1, 0.5, 6.0), (1, 0.5, 6.0), (1, 0.5, 6.0), (0, 0.0, 0.0), (1, 0.5, 6.0)]
    task = FollowWall("wall", side, 5.0, None, Common())
    assert not task.moves(now, progress).any()
    course = math.atan2(0.3, 0.6)
    found = [
        0.5 + 0.125 * (course - side * math.asin(0.2 / math.hypot(0.6, 0.3)) - 0.5),
        0.5 + 0.125 * (0.7 - side * math.asin(0.04 / 0.15) - 0.5),  # too slow to have a course
        0.5,
        0.4,
        0.5 + 0.125 * (math.atan2(-0.1, 0.2) + side * math.asin(0.9) - 0.5),
    ]
    assert np.allclose(progress.memory[:, 1], found)
    assert np.allclose(progress.memory[:, 2], [6.1, 6.02, 0.0, 6.1, 3.0])
    assert (progress.memory[:, 0] == 1).all()
    goal = task.goal(now, progress)
    lean = np.array([1.1 / 5, 1.02 / 5, 0.4, 1.1 / 5, -0.4])  # unseen: as if 2 m too far
    assert np.allclose(goal.course, progress.memory[:, 1] - side * lean)
    assert np.allclose(goal.end, 50 * np.stack([np.cos(goal.course), -np.sin(goal.course)], -1))
    progress.memory[:, 2] = [20.0, 0.1, 5.0, 5.0, 5.0]
    lean = task.goal(now, progress).course - progress.memory[:, 1]
    assert np.allclose(lean, -side * np.array([0.7, -0.7, 0.0, 0.0, 0.0]))


def test_a_profile_turns_near_its_depths_and_counts_at_the_top():
    task = Profile(4.0, 30.0, cycles=2, point=(30.0, -40.0), acceptance_m=9.0)
    depth = np.array([29.4, 29.6, 4.6, 4.4, 4.4, 29.6])
    now = aboard(np.stack([0 * depth, 0 * depth, -depth], -1))
    progress = Progress.begin(now)
    progress.memory[:, :2] = [(0, 0), (0, 0), (1, 0), (1, 0), (1, 1), (1, 1)]
    assert task.moves(now, progress).tolist() == [0, 0, 0, 0, 1, 0]
    assert progress.memory[:, 0].tolist() == [0, 1, 1, 0, 0, 1]
    assert progress.memory[:, 1].tolist() == [0, 0, 0, 1, 2, 1]
    near = aboard([(30.0, -31.1, -9.0), (30.0, -30.9, -9.0)])
    assert task.moves(near, Progress.begin(near)).tolist() == [1, 0]
    goal = task.goal(now, progress)
    assert goal.depth.tolist() == [30, 4, 4, 30, 30, 4]


def test_a_vehicle_has_landed_when_it_has_hardly_sunk_for_a_while():
    task = Land((3.0, -5.0), 0.4)
    sinking = np.array([(0, 0, -0.11), (0, 0, -0.09), (0, 0, 0.2)])
    now = aboard([(1.0, 2.0, -6.0)] * 3, 0.3, sinking)
    progress = Progress.begin(now)
    progress.since_s[:] = [16.9, 16.9, 17.1]
    progress.memory[:, 0] = [2.9, 2.9, 2.9]
    assert task.moves(now, progress).tolist() == [0, 1, 0]
    assert np.allclose(progress.memory[:, 0], [0, 3.4, 0])
    goal = task.goal(now, progress)
    assert np.allclose(goal.depth, 8.0)
    assert np.allclose(goal.sink, 0.4)
    assert np.allclose(goal.end, (3.0, -5.0))


def test_altitude_is_held_by_a_ramp_of_the_depth():
    now = aboard([(0, 0, -10.0)] * 5 + [(0, 0, -0.6)], altitude=[7.0, 5.4, 2.0, 7.0, np.inf, 1.0])
    before = np.array([10.5, np.nan, 9.9, 11.95, 9.0, 0.6])
    # rates 0.25 (wanted - last), at most 0.35 m/s either way, over 0.5 s
    wanted = [10.5 + 0.175, 10.0 + 0.05, 9.9 - 0.175, 11.95 + 0.5 * 0.25 * 0.05, 9.0 + 0.175, 0.5]
    assert np.allclose(level_depth(Level(altitude_m=5.0), before, now), wanted)
    assert np.allclose(level_depth(Level(depth_m=3.5), before, now), 3.5)
    assert np.allclose(level_depth(Level(), before, now), [10.5, 10.0, 9.9, 11.95, 9.0, 0.6])


def test_a_reading_is_beyond_a_limit_on_either_side_only():
    readings = {"oxygen": np.array([[9.0, 2.0], [9.0, 5.0], [9.0, 3.0], [9.0, np.nan]])}
    now = aboard(np.zeros((4, 3)), readings=readings)
    assert Limit("oxygen", 1, 4.0, 2.5).met(now).tolist() == [True, True, False, False]
    assert Limit("oxygen", 1, 5.0, 2.0).met(now).tolist() == [False] * 4  # at the limits
    assert Limit("oxygen", 1, 3.5, None).met(now).tolist() == [False, True, False, False]
    assert not Limit("oxygen", 2, 3.5, 8.0).met(now).any()


def test_the_distance_from_a_line_and_from_a_circle_counts_where_they_are_held():
    start, end = np.array([2.0, 1.0]), np.array([14.0, -8.0])  # 15 m along (0.8, -0.6)
    place = lambda run, off: start + run * np.array([0.8, -0.6]) + off * np.array([0.6, 0.8])
    way = np.array([place(6.0, 5.0), place(8.0, -1.2), place(12.0, 0.7), place(15.1, 3.0)])
    assert _from_line(start, end, way) == pytest.approx(1.2)
    assert _from_line(start, end, way[[0, 3]]) == 0.0

    def round_(turn, *polar):
        angle, radius = np.radians([a for a, _ in polar]) * turn, np.array([r for _, r in polar])
        return np.array([3.0, -2.0]) + radius[:, None] * np.stack([np.cos(angle), np.sin(angle)], -1)

    polar = [(170, 20.0), (170, 13.4), (200, 12.0), (255, 10.7), (265, 9.4), (340, 9.5), (420, 9.1)]
    for turn in (1, -1):
        assert _from_circle(Orbit((3.0, -2.0), 10.0, 2.0, 1.0), round_(turn, *polar)) == pytest.approx(0.9)
        assert _from_circle(Orbit((3.0, -2.0), 10.0, 2.0, 1.0), round_(turn, *polar[:4])) == 0.0
        assert _from_circle(Orbit((3.0, -2.0), 10.0, 0.5, 1.0), round_(turn, *polar[:4])) == pytest.approx(0.7)
    assert _from_circle(Orbit((3.0, -2.0), 10.0, 1.0, 1.0), round_(1, (20, 15.0), (50, 13.6))) == pytest.approx(3.6)


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_a_planned_circle_begins_where_the_vehicle_comes_from(turn):
    found = np.array(_circle(Orbit((3.0, -2.0), 5.0, 1.25, turn), (9.0, 4.0)))
    assert len(found) == 46  # 450 degrees in steps of 10
    angle = math.pi / 4 - turn * np.radians(10.0) * np.arange(46)  # clockwise from above: x north, y west
    assert np.allclose(found, np.array([3.0, -2.0]) + 5 * np.stack([np.cos(angle), np.sin(angle)], -1))
    assert len(_circle(Orbit((3.0, -2.0), 5.0, 0.01, turn), (9.0, 4.0))) == 2


def test_crab_angles_are_seen_under_way_and_forgotten_otherwise():
    velocity = np.array([(0.6, -0.8, 0), (0.6, 0.8, 0), (-0.6, -0.8, 0), (0.3, -0.4, 0), (0.6, -0.8, 0)])
    now = aboard(np.zeros((5, 3)), [0.5, -0.4, 0.5, 0.5, 0.5], velocity, dt_s=2.0)
    crab = Crab(np.full(5, 0.2))
    found = crab.see(now, np.array([2.4, 1.0, 1.0, 1.3, 0.0]))
    share = 1 - math.exp(-2.0 / 5.0)
    course = math.atan2(0.8, 0.6)
    seen = [course - 0.5, -course + 0.4, 1.0]  # the third goes astern of its course: kept to one radian
    expected = [0.2 + share * (s - 0.2) for s in seen] + [0.2 * (1 - share)] * 2
    assert np.allclose(found, expected)


def test_the_lag_of_headings_is_learned_on_circles_alone():
    n = 4
    now = aboard([(12.0, 1.0, 0)] * n, [1.9, 1.9, 4.5, 1.9], (0.3, -1.2, 0.0))
    goal = Goal.stay(now)
    goal.path[:] = [Path.CIRCLE, Path.POINT, Path.CIRCLE, Path.LINE]
    goal.end[:], goal.radius[:], goal.turn[:] = (2.0, -1.0), [9.0, np.nan, 9.0, 9.0], [1.0, -1.0, 1.0, 1.0]
    wanted, lag = np.array([1.8, 2.1, 1.8, 1.8]), np.array([1.5, 0.4, 1.5, 1.5])
    lead = Lead(lag.copy())
    found = lead.turning(wanted, goal, now, 5.0, 7.0)
    radius = np.array([9.0, 7.0, 9.0, 9.0])
    rate = circle_rate(goal.end, radius, goal.turn, now.xy, now.own.velocity[:, :2], 5.0)
    assert np.abs(rate[:2]).min() > 0.03
    assert np.allclose(found, np.where([1, 1, 1, 0], wanted + lag * rate, wanted))
    error = np.array([wanted[k] + lag[k] * rate[k] - 1.9 - lag[k] * rate[k] for k in (0, 1)])
    share = 0.5 / 6.0 * rate[:2] / (rate[:2] ** 2 + 0.02**2)
    assert np.allclose(lead.lag_s[:2], np.maximum(lag[:2] + share * error, 0))
    assert np.allclose(lead.lag_s[2:], lag[2:])  # one turns towards its circle, one has none


def test_a_reference_point_sinks_no_faster_than_it_may_and_waits():
    hover = Hover(0.2, 1.0)
    hover.point = np.array([(0, 0, 2.0), (0, 0, 8.0), (0, 0, 3.0), (0, 0, 5.0), (0, 0, 5.0), (0, 0, 4.0)])
    here = np.array([(0, 0, 2.0), (0, 0, 8.0), (0, 0, 3.0), (0, 0, 3.5), (0, 0, 6.7), (0, 0, 4.0)])
    goal = Goal.stay(aboard(here))
    goal.depth[:] = [10.0, 2.0, 3.02, 10.0, 1.0, 3.8]
    goal.sink[:] = [np.nan, 0.6, np.nan, np.nan, np.nan, np.nan]
    rate = hover._sink(goal, here, 0.5)
    assert np.allclose(rate, [0.3, -0.6, 0.04, 0.15, -0.09, -math.sqrt(0.2 * 0.2)])
    assert np.allclose(hover.point[:, 2], [2.15, 7.7, 3.02, 5.075, 4.955, 3.9])
    hover.speed, hover.heading = np.array([0.3, 0.04, 0.3, 0.3]), np.array([0.2, 0.2, 3.1, 0.2])
    face = Goal.stay(aboard(np.zeros((4, 3))))
    face.face[:] = [np.nan, np.nan, -3.1, 0.3]
    velocity = np.array([(-1.0, 2.0), (-1.0, 2.0), (1.0, 0.0), (1.0, 0.0)])
    assert np.allclose(hover._face(face, velocity, 0.5), [-0.05, 0.2, -3.1, 0.3])


def test_a_craft_that_stays_keeps_its_heading_at_rest_and_backs():
    surface = Surface(8.0, 2.0, 1.5, Crab(np.zeros(4)), Lead(np.zeros(4)))
    surface.held, surface.current = np.full(4, 0.3), np.array([(0.2, -0.1), (0.0, 0.0), (0.0, 0.0), (0.2, -0.1)])
    to = np.array([(40.0, -30.0), (-0.3, 0.0), (-4.0, 0.0), (4.0, 3.0)])
    now = aboard(np.zeros((4, 3)), 0.3)
    held, speed = surface._keep(to, np.full(4, 1.2), now, np.array([True, True, True, False]))
    far = 1.2 / 50 * to[0] - surface.current[0]
    bearing = math.atan2(-far[1], far[0])
    slow = -0.15 * 0.3 * math.cos(0.3)  # astern, since it is to go slower than 0.08 m/s
    last = 0.15 * to[3] - surface.current[3]
    along = math.hypot(*last) * math.cos(math.atan2(-last[1], last[0]) - 0.3)
    assert np.allclose(held, [bearing, 0.3, math.pi, 0.3]) or np.allclose(held, [bearing, 0.3, -math.pi, 0.3])
    assert np.allclose(speed, [min(math.hypot(*far) * math.cos(bearing - 0.3), 1.2), slow, 0.0, along])


def test_a_glider_turns_between_depths_and_stays_afloat():
    n = 6
    now = aboard([(1.0, 2.0, -3.0)] * n, 0.3, (0.5, -0.2, 0.0))
    goal = Goal.stay(now)
    goal.path[:] = [Path.COURSE] * 4 + [Path.DRIFT, Path.OVER]
    goal.depth[:], goal.upper[:] = [2.0, 20.0, 5.0, 0.0, 9.0, 9.0], [np.nan, np.nan, 8.0, np.nan, np.nan, np.nan]
    goal.glide[:], goal.speed[:] = [np.nan, 0.3, 0.3, 0.3, 0.3, 0.3], 0.7
    entered = np.zeros(n, bool)
    make = lambda kind: Cruise(kind, 8.0, 20.0, 15.0, Crab(np.full(n, 0.1)), Lead(np.zeros(n)))
    found = make("glider").command(goal, now, entered)
    assert np.allclose(found["upper_depth"], [1.0, 3.0, 8.0, -6.0, -6.0, -6.0])
    assert np.allclose(found["depth"], [2.0, 20.0, 9.0, -5.0, -5.0, -5.0])
    assert np.allclose(found["glide_pitch"], [0.44, 0.3, 0.3, 0.3, 0.3, 0.3])
    assert np.allclose(found["heading"], 0.3)
    torpedo = make("torpedo").command(goal, now, entered)
    assert np.allclose(torpedo["depth"], [2.0, 20.0, 5.0, 0.0, 9.0, 0.0])
    assert np.allclose(torpedo["speed"], [0.7] * 4 + [0.0, 0.0])
    goal.speed[5] = 0.0
    airplane = make("airplane").command(goal, now, entered)
    assert np.allclose(airplane["airspeed"], [0.7] * 4 + [15.0, 15.0])
    assert np.allclose(airplane["height"], [-2.0, -20.0, -5.0, 0.0, -9.0, -9.0])


def test_lines_are_cut_from_areas_with_bays_and_keep_clear_of_the_seabed():
    area = np.array([(0.0, 0), (10, 0), (12, 6), (7, 6), (7, 2), (3, 2), (3, 6), (1, 6)])
    pieces = _cut(area, np.array([1.0, 0.0]), np.array([0.0, -1.0]), -4.0)  # along y = 4
    assert np.allclose(pieces, [[(2 / 3, 4), (3, 4)], [(7, 4), (10 + 4 / 3, 4)]])
    swath = Swath(None, math.radians(120), 0.25)
    assert swath.half_width(10.0) == pytest.approx(0.75 * 10 * math.sqrt(3))
    line = [(np.array([0.0, 3.0]), np.array([30.0, 3.0])), (np.array([0.0, -4.0]), np.array([10.0, -4.0]))]
    height = lambda x, y: np.where(y > 0, -20 + 0.1 * x, np.where(x > 6, np.nan, -22.0))
    clear = lambda depth, altitude: _altitude(line, height, depth, altitude, swath, "leg")
    assert clear(5.0, None) == pytest.approx(12.0)
    assert clear(None, None) == pytest.approx(17.0)
    assert clear(5.0, 3.5) == 3.5
    with pytest.raises(ScenarioError, match=r"x 0\.0, y 3\.0 to x 30\.0, y 3\.0 m runs into the seabed, 17\.0 m deep"):
        clear(17.5, None)
    nothing = lambda x, y: np.full(x.shape, np.nan)
    with pytest.raises(ScenarioError, match="no seabed below"):
        _altitude(line, nothing, 5.0, None, swath, "leg")
    assert _altitude(line, nothing, 5.0, None, Swath(4.0, 1.0, 0.0), "leg") == 0.0


# fits


def test_an_allan_curve_is_weighed_by_its_clusters():
    terms, clusters = np.ones((4, 1)), np.array([900.0, 90.0, 30.0, 9.0])
    deviation = np.array([1.0, 1.3, 0.8, 1.7])
    # a constant known to 1/sqrt(clusters) of itself: the mean weighed by clusters
    assert _weighed(terms, deviation, clusters) == pytest.approx((clusters @ deviation**2) / clusters.sum())
    tau = np.geomspace(0.01, 100, 25)
    columns = np.stack([1 / tau, np.full(25, 0.44), tau / 3], axis=-1)
    many = np.geomspace(1e5, 10, 25)
    squares, seen = terms_of(columns, np.sqrt(columns @ [4.0, 0.0, 1e-6]), many)
    assert seen.tolist() == [True, False, False]
    assert squares == pytest.approx([4.0, 0.0, 0.0], rel=1e-3)
    squares, seen = terms_of(columns, np.sqrt(columns @ [4.0, 0.0, 0.09]), many)
    assert seen.tolist() == [True, False, True]
    assert squares == pytest.approx([4.0, 0.0, 0.09], rel=1e-9, abs=1e-9)
    # visible to a quarter, but not beyond what nine clusters tell: 2 sqrt(2/8) = 1
    _, seen = terms_of(columns, np.sqrt(columns @ [4.0, 0.0, 0.09]), np.full(25, 9.0))
    assert not seen[2]


def test_squares_are_weighed_by_their_own_expectation():
    off = np.array([0.2, 1.7, 0.4, 3.1, 0.9])
    squares, unsure = noise._reweighted(np.full((5, 1), 4.0), off)
    assert squares == pytest.approx(off.mean() / 4)
    assert unsure == pytest.approx(off.mean() / 4 * math.sqrt(2 / 5))
    speed = np.linspace(0, 3, 40) ** 2
    basis = np.stack([np.full(40, 4.0), speed], axis=-1)
    squares, unsure = noise._reweighted(basis, basis @ [0.3, 0.02])
    assert squares == pytest.approx([0.3, 0.02])
    whitened = basis / (basis @ [0.3, 0.02])[:, None]
    assert unsure == pytest.approx(np.sqrt(2 * np.diag(np.linalg.inv(whitened.T @ whitened))))
    terms = np.array([[2.0, 1.0, 0.5], [1.0, 1.0, 2.0]])
    freedoms, deviation = np.array([4.0, 1.0]), np.array([0.8, 0.5])
    # chi^2 of 1 % probability below it, of 4 and 1 degrees of freedom (tables): 0.29711 and 0.00015709
    highest = deviation**2 * freedoms / [0.2971095, 0.000157088]
    expected = [math.sqrt(min(highest[0] / terms[0, k], highest[1] / terms[1, k])) for k in range(3)]
    assert noise._most(terms, deviation, freedoms) == pytest.approx(expected, rel=1e-4)


def janus(n=1500):
    """Four beams at 30 degrees of a log that moves slowly in every way."""
    t = np.linspace(0, 60, n)
    u, v, w = 1.1 * np.sin(0.31 * t), 0.9 * np.cos(0.43 * t), 0.7 * np.sin(0.57 * t + 1)
    s, c = 0.5, math.sqrt(0.75)
    return np.stack([u * s + w * c, v * s + w * c, -u * s + w * c, -v * s + w * c], -1)


def test_pings_stand_out_against_those_of_about_the_same_speed():
    random = np.random.default_rng(5)
    speed = random.permutation(np.concatenate([np.linspace(0.1, 0.2, 300), np.linspace(4, 5, 300)]))
    left = np.where(speed > 1, 0.1, 0.001) * np.tile([1.0, -1.0, 0.5, -0.5], 150)
    whole = np.stack([-1.1 * speed, np.full(600, 0.01), speed, np.full(600, -0.01)], axis=-1)
    slow, fast = np.flatnonzero(speed < 1)[7], np.flatnonzero(speed > 1)[7]
    left[slow], left[fast] = -0.05, 0.4
    whole[slow, 0] = 60.0  # one wrong beam makes no fast ping
    assert np.flatnonzero(beam_faults.standing_out(whole, left)).tolist() == [slow]


def test_a_descent_without_the_depth_is_taken_from_what_there_is():
    pitch, roll, heading = np.array([0.3, -0.4]), np.array([-0.5, 0.7]), np.array([1.1, -2.0])
    u, v, w = np.array([1.2, -0.7]), np.array([0.5, 0.4]), np.array([-0.3, 0.6])
    nu = np.stack([u, v, w], -1)
    turn = Rotation.from_euler("ZYX", np.stack([heading, pitch, roll], -1))  # body FRD to NED
    down = turn.apply(nu)[:, 2]
    measured = {"pitch": pitch, "roll": roll, "u": u, "v": v, "w": w}
    assert np.allclose(_descent(measured, {}), down)
    assert np.allclose(_descent({"w": w}, {}), w)
    assert _descent({"w": w, "u": u}, {}) is None
    assert np.allclose(_descent({"pitch": pitch, "u": u}, {}), -u * np.sin(pitch))
    assert _descent({"pitch": pitch + 0.8, "u": u}, {}) is None  # steep
    # by a way that has no rate of depth, of a vehicle that goes ahead along its pitch
    flat = turn.apply(np.stack([u, 0 * u, 0 * u], -1)) * [1, 1, 0]
    slopes = dict(zip("uvw", turn.inv().apply(flat).T, strict=True))
    place = {"north": u, "east": u, "heading": heading}
    assert np.allclose(_descent({"pitch": pitch, "roll": roll, **place}, slopes), -u * np.sin(pitch))


def test_the_memory_of_residuals_is_their_integrated_correlation():
    random = np.random.default_rng(11)
    white = random.normal(size=(402, 2))
    off = np.stack([white[2:, 0] + white[1:-1, 0] + white[:-2, 0], white[2:, 1]], -1)
    off[7, 0] = np.nan
    totals = []
    for x in np.nan_to_num(off).T:
        sums = np.correlate(x, x, "full")[399:]
        rho = sums / (400 - np.arange(400)) / (sums[0] / 400)
        few = int(np.argmax(rho[1:] < 2 / math.sqrt(400)))
        totals.append(1 + 2 * rho[1 : 1 + few].sum())
    assert totals[0] > 2
    assert _memory(off) == pytest.approx(np.mean(totals))
    assert _memory(np.zeros((30, 1))) == 1.0


def test_squares_have_grown_beyond_chance_or_not():
    before, spread = np.full(5, 1.0), 0.01 * np.array([-2.0, 1.0, 0.0, -1.0, 2.0])
    # Student's t(4) of 95 %: 2.1318, of a mean over five with the deviation 0.015811
    edge = 2.1318 * 0.0158114 / math.sqrt(5)
    assert _surely_larger(before + spread + 1.01 * edge, before)
    assert not _surely_larger(before + spread + 0.99 * edge, before)
    assert not _surely_larger(before - 0.3, before)
    few = np.array([3.0, 0.0, 0.0, 0.0, 0.0])
    assert not _surely_larger(before + 0.8 * few, before)
    assert _surely_larger(before + 0.9 * few, before)  # by more than half in all
    assert _surely_larger(np.array([0.5]), np.array([1.0]))


def test_gaps_between_shots_go_the_short_way_round():
    seen = np.zeros((3, 12, 2))
    seen[-1, [0, 5], 0], seen[0, [0, 5], 1] = (2.0, -3.0), (0.5, 3.1)
    seen[-1, :, 1] = 9.0
    found = Problem._mismatch(Stub(meet=[(0, 0.5), (5, 0.1)]), seen, 1)
    assert found == pytest.approx([3.0, (2 * math.pi - 6.1) / 0.1])
    off = np.array([0.5, -2.0, np.nan, 3.0])
    assert Problem._rho(Stub(plan=Stub(loss="huber"), huber=1.5), off) == pytest.approx(0.125 + 1.875 + 3.375)
    assert Problem._rho(Stub(plan=Stub(loss="squares")), off) == pytest.approx(0.5 * 13.25)


def test_tangents_of_initial_states():
    q = np.array([[0.5, -0.1, 0.7, 0.5], [0.2, 0.6, -0.3, 0.71]])
    shots = Shots(np.arange(2), 4, np.zeros(2, int), np.zeros((2, 3)), q, np.zeros((2, 6)), np.zeros(2, bool))
    found = _directions(shots, 2, [1, 3, 4, 5, 7, 11], 3, 10)
    expected = np.zeros((21, 2, 10))
    expected[1, :, 3] = expected[8, :, 7] = expected[12, :, 8] = 1.0
    for k, axis in enumerate(np.eye(3)):  # half of the quaternion's product with (0, axis)
        expected[3, :, 4 + k] = -0.5 * q[:, 1:] @ axis
        expected[4:7, :, 4 + k] = 0.5 * (q[:, :1] * axis + np.cross(q[:, 1:], axis)).T
    assert np.allclose(found, expected)


def test_errors_of_the_filter_go_into_the_state():
    q = np.array([[0.5, -0.1, 0.7, 0.5]]) / math.sqrt(1.0)
    std = np.linspace(0.1, 2.2, 22)
    lanes = Lanes.at(np.array([[1.0, -2, 3]]), np.array([[0.1, 0.2, -0.3]]), q, std)
    lanes.covariance += 0.01 * np.outer(std, std[::-1]) + 0.01 * np.outer(std[::-1], std)
    before, error = lanes.covariance[0].copy(), np.linspace(-0.3, 0.54, 22)
    lanes._inject(error[None])
    turned = Rotation.from_quat(np.roll(q, -1)) * Rotation.from_rotvec(error[None, 6:9])
    assert abs((np.roll(turned.as_quat(), 1) @ lanes.attitude.T)[0, 0]) == pytest.approx(1.0, abs=1e-12)
    assert np.allclose(lanes.position, np.array([1.0, -2, 3]) + error[:3])
    assert np.allclose(lanes.velocity, np.array([0.1, 0.2, -0.3]) + error[3:6])
    assert np.allclose([lanes.gyroscope[0], lanes.accelerometer[0]], [error[9:12], error[12:15]])
    assert np.allclose(lanes.slow, error[15:])
    x, y, z = error[6:9]
    g = np.eye(22)
    g[6:9, 6:9] -= 0.5 * np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    assert np.allclose(lanes.covariance[0], g @ before @ g.T)


def test_readings_of_some_members_are_cut_out_of_every_tick():
    data = np.arange(12.0)[:, None]  # two ticks of three members of two copies
    whole = Measurement(data=data, truth=-data, valid=np.arange(12) % 5 > 0, extras={"no": np.arange(12)})
    some = Sampled(("a", "b", "c"), Stub(), range(7, 9), whole).some([2, 0], 2)
    assert some.members == ("c", "a")
    assert some.measurement.data.ravel().tolist() == [4, 5, 0, 1, 10, 11, 6, 7]
    assert some.measurement.extras["no"].tolist() == [4, 5, 0, 1, 10, 11, 6, 7]
    assert some.measurement.valid.tolist() == [True, False, False, True, False, True, True, True]
    middle = Sampled(("a", "b", "c"), Stub(), range(7, 9), whole).of(1, 2)
    assert middle.measurement.data.ravel().tolist() == [2, 3, 8, 9]


# wire formats


def test_checksums_clocks_and_angles_of_instruments():
    assert mip.fletcher(bytes.fromhex("756501020201")) == bytes.fromhex("e0c6")  # the ping of LORD's MIP manual
    assert [next_ns(t, 8.0) for t in (0, 124_999_999, 125_000_000, 125_000_001)] == [125_000_000] * 2 + [
        250_000_000
    ] * 2
    assert nmea._latitude(-33.9999999999) == "3400.00000,S"
    assert nmea._latitude(7.512345) == "0730.74070,N"
    assert nmea._longitude(-190.25) == "16945.00000,E"
    assert nmea._longitude(200.25) == "15945.00000,W"
    assert nmea._longitude(-5.05) == "00503.00000,W"


def test_an_ensemble_holds_far_ranges_and_large_numbers():
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


def test_sonars_that_answer_cut_and_scale_their_traces():
    place = Stub(config=Stub(range_min_m=1.0, range_max_m=9.0, rate_hz=5.0))
    echo, middles = np.array([0.2, 0.8, 0.4, 1.0]), np.array([2.0, 4.0, 6.0, 8.0])
    one = Ping1d(place)
    one._echo, one._distance_m, one._confidence, one._number = echo, 6.5, 40, 7
    one._kept[ping.SPEED_OF_SOUND] = (1_545_000,)  # 3 % faster than 1500 m/s
    assert one._seen() == (6695, 40, 7, 1000, 8000)
    one._kept |= {ping.MODE_AUTO: (0,), ping.RANGE: (2000, 5000)}
    assert one._seen() == (6695, 40, 7, 2000, 5000)
    at = (2.0 + (np.arange(200) + 0.5) * 5.0 / 200) / 1.03
    level = np.round(255 * np.interp(at, middles, echo, left=0.0))
    assert np.abs(np.frombuffer(one._profile(), np.uint8) - level).max() <= 1  # where rounding falls
    one._distance_m = 6.9
    assert one._seen() == (0, 0, 7, 2000, 5000)
    one._distance_m = 1.9
    assert one._seen()[0] == 0
    head = Ping360(place)
    head._traces = {12: echo, 9: echo[::-1]}
    distance = (np.arange(13) + 0.5) * 40000 * 25e-9 * 1500 / 2
    for gradian, trace in ((11, echo), (10, echo[::-1]), (7, echo[::-1]), (14, echo), (6, None), (15, None)):
        told = np.frombuffer(head._trace(gradian, 40000, 13), np.uint8).astype(int)
        level = np.zeros(13) if trace is None else 255 * np.interp(distance, middles, trace, left=0.0, right=0.0)
        assert np.abs(told - level).max() <= 0.5 + 1e-9
    head._traces = {1: echo}
    assert any(head._trace(399, 40000, 13))
    assert not any(head._trace(398, 40000, 13))
    for angle, gradian in ((0.0, 200), (0.9, 199), (-90.0, 300), (-179.9, 0), (179.9, 0)):
        head.begin()
        head.hear(Stub(extras={"angle": [math.radians(angle)]}, data=[echo]))
        assert list(head._traces) == [gradian]


def test_names_and_levels_of_pictures():
    kinds = [("u1", (4, 5)), ("u2", (4, 5, 1)), ("u4", (4, 5)), ("f4", (4, 5)), ("i2", (4, 5, 2)), ("u1", (4, 5, 3))]
    names = [encoding_name(np.zeros(shape, kind)) for kind, shape in kinds]
    assert names == ["mono8", "mono16", "32SC1", "32FC1", "16SC2", "8UC3"]
    config = Stub(scale="db", floor_db=-70.0, dynamic_range_db=40.0)
    assert eight_bits(config, np.array([-75.0, -60.0, -25.0])).tolist() == [0, 64, 255]
    config.scale = "linear"
    assert eight_bits(config, np.array([0.0, 1e-6, 1.0])).tolist() == [0, 64, 255]
    config.scale = "unit"
    assert eight_bits(config, np.array([0.0, 0.25, 1.0])).tolist() == [0, 64, 255]
    flow = np.array([[(2.0, 0), (0, 2), (-2, 0), (0, -2), (1, 0), (np.nan, 0)]])
    wheel = [[255, 0, 0], [127, 255, 0], [0, 255, 255], [127, 0, 255], [127, 0, 0], [0, 0, 0]]  # hues of HSV
    assert _flow(flow)[0].tolist() == wheel
    assert _colour(np.array([[[0xABCD]]], np.uint16)).tolist() == [[[0xAB] * 3]]
    assert _colour(np.array([[0.5, 1.5, -1.0]])).tolist() == [[[186] * 3, [255] * 3, [0] * 3]]


def test_the_sun_and_the_tide_of_hours():
    found = [tuple(sun_of(hour).values()) for hour in (0.0, 9.0, 12.0, 15.0, 30.5, -3.0)]
    assert found == [(-90, 90), (45, 90), (90, 270), (45, 270), (7.5, 90), (-45, 270)]
    t = np.linspace(0, 9000, 7)
    for amplitude, turned in ((0.7, 0.0), (-0.7, 0.1), (0.4, -0.3)):
        tide = sine_tide(amplitude, 5400.0, turned=turned)
        phase = 2 * math.pi * t / (3600 * tide["period_h"]) - math.radians(tide["phase_deg"])
        wanted = amplitude * np.sin(2 * math.pi * (t / 5400 - turned))
        assert np.allclose(tide["amplitude_m"] * np.cos(phase), wanted)


def test_boxes_of_kitti_and_yolo(tmp_path):
    box = Box(3, 1, column=30, row=8, width=10, height=4, area=21)
    psi = 0.4
    turn = np.array([[math.cos(psi), -math.sin(psi), 0], [math.sin(psi), math.cos(psi), 0], [0, 0, 1.0]])
    corners = np.array([(10.0, -2.0, 1.0)]) + np.array([(-2, -1, -0.75), (2, 1, 0.75)]) @ turn.T
    space = Stub(size=np.array([4.0, 2.0, 1.5]), centre=np.array([10.0, -2.0, 1.0]), turn=turn, corners=corners)
    camera = np.array([[50.0, 0, 50], [0, 50, 20], [0, 0, 1]])
    line = _line(Stub(box=box, name="pipe", space=space), np.zeros(3), np.eye(3), camera, (100, 40)).split()
    assert [float(v) for v in line[4:8]] == [30, 8, 39, 11]
    about = math.atan2(-math.cos(psi), -math.sin(psi))  # a box along x of the camera has 0
    numbers = [float(v) for v in line[8:]]
    assert np.allclose(numbers, [1.5, 2.0, 4.0, 2.0, -1.0 + 0.75, 10.0, about], atol=1e-3)
    alpha = about - math.atan2(2.0, 10.0)
    assert float(line[3]) == pytest.approx((alpha + math.pi) % (2 * math.pi) - math.pi, abs=1e-4)
    sample = Stub(file=lambda name: ("png", b""), key="k", readings={"ids": np.zeros((40, 100))},
                  things=[Stub(box=box, number=2)])  # fmt: skip
    Yolo.add(Stub(_camera="eye", _instances="ids", _pictures=tmp_path, _labels=tmp_path), sample)
    assert (tmp_path / "k.txt").read_text() == "2 0.350000 0.250000 0.100000 0.100000\n"


# pictures


def test_corners_are_passed_in_order_and_once():
    corners = np.array([(0.0, 0), (100, 0), (100, 20), (0, 20)])
    track = np.array([(0, 0), (79, 0), (85, 0), (97, 1), (97, 3), (103, 14), (101, 19), (100, 20.5), (60, 20),
                      (19, 20), (8, 24), (3, 21), (-25, 21), (0, 20)])  # fmt: skip
    assert _passed(corners, track.astype(float)) == [3, 7, 11]
    assert _passed(corners, track[:6].astype(float)) == [3, None, None]
    assert _passed(corners[:2], np.array([(0, 0), (79.9, 0)])) == [None]
    assert _passed(corners[1:3], np.array([(100, 0), (100, 15.1)])) == [1]  # at least 5 m of a short leg


def test_edges_of_ground_turning_parts_and_fans():
    z = np.array([1.0, 9.0, 4.0, 9.0, 7.0, 9.0, 8.0])
    _stitch(np.array([0.0, 2.0, 3.0, 4.0, 4.0, 4.0, 4.0]), z)
    assert np.allclose(z, [1, 3, 4, 7, 7, 7, 8])
    parts = [Stub(actuator=1, spins=True), Stub(actuator=0, spins=False), Stub(actuator=5, spins=True)]
    model = Model3d([], parts, 2.0)
    angles = model.turned(np.array([0.3, -60.0]), np.array([1.0, 9.0, 2.0]), 0.25)
    assert np.allclose(angles, [(1.0 - 0.12 * 60 * 0.25) % (2 * math.pi), 0.3, 2.0])
    config = Stub(azimuths=np.array([0.6, 0.1, -0.5]), range_min_m=2.0, range_max_m=20.0)
    vertices, faces = fan_mesh(config)
    ends = [(2 * math.cos(0.6), 2 * math.sin(0.6), 0), (20 * math.cos(0.5), -20 * math.sin(0.5), 0)]
    assert np.allclose(vertices[[0, -1]], ends, atol=1e-5)
    a, b, c = np.swapaxes(vertices[faces].astype(float), 0, 1)
    area = 0.5 * np.cross(b - a, c - a)[:, 2]
    assert (area < 0).all() or (area > 0).all()
    assert abs(area.sum()) == pytest.approx(0.5 * (20**2 - 2**2) * 1.1, rel=(1.1 / 63) ** 2)  # chords for arcs


def test_places_on_a_sheet_from_behind():
    basis = np.array([(0.6, 0.8, 0.0), (0.0, 0.0, 1.0), (0.8, -0.6, 0.0)])  # right, up, along the sight
    eye = np.array([1.0, 2.0, 3.0])
    points = eye + np.array([(1.5, -0.5, 8.0), (-1.5, 0.5, -2.0)]) @ basis
    found = _seen(Stub(width=600, height=400), points, eye, basis)
    assert np.allclose(found[0], [300 + 400 * 1.5 / 8, 200 + 400 * 0.5 / 8, 8.0])
    assert found[1, 2] == pytest.approx(-2.0)


@pytest.mark.parametrize("held", [True, False])
def test_a_stick_turns_what_was_ordered(held):
    sent = []
    names = ["height", "heading", "airspeed"] if not held else ["depth", "heading", "speed"]
    vehicle = Stub(command_names=lambda mode: names, config=Stub(envelope=Stub(top_mps=3.0)))
    state = Stub(velocity=np.array([[1.2, 0, 0]]), euler=np.array([[0, 0, -3.1]]), depth=np.array([-0.1]))
    sim = Stub(model=Stub(agents={"a": Stub(vehicle=vehicle)}), state={"a": state}, command=sent.append,
               stepper=Stub(mode=lambda agent: "mode" if held else "other"), set_mode=lambda agent, mode: None,
               held_command=lambda agent: np.array([[0.1, -3.0, 2.95]]))  # fmt: skip
    _integrate(sim, "a", "mode", Stub(yaw=0.8 if held else -0.8, heave=0.5 if held else -0.75, surge=0.9), 0.5)
    turn = math.radians(25) * 0.8 * 0.5
    # compass headings: a turn to the left goes down, past -pi to the other side
    if held:
        assert np.allclose(sent[0]["a"], [0.0, -3.0 - turn + 2 * math.pi, 3.0])
    else:
        from pelagos.viewer.drive import SPEED_MPS2

        wanted = [0.0, 3.1 + turn - 2 * math.pi, min(3.0, 1.2 + SPEED_MPS2 * 0.45)]
        assert np.allclose(sent[0]["a"], wanted)


def test_means_contrasts_and_ways_of_reports():
    points = np.array([(0.9, 4.1, -3.0), (1.6, 4.2, -5.0), (1.1, 5.9, -2.0), (2.9, 7.9, -9.0), (0.4, 5, -1),
                       (3.1, 5, -1), (2, 3.9, -1), (2, 8.1, -1)])  # fmt: skip
    mean, count = _means(points, np.array([1.0, 2.0, 3.0]) - 0.0, np.array([4.5, 5.5, 6.5, 7.5]), 1.0)
    assert count.shape == (3, 4)
    assert count.sum() == 5
    assert count[0, 0] == 1
    assert mean[1, 0] == -5.0
    assert mean[0, 1] == -2.0
    assert mean[2, 3] == -9.0
    assert mean[2, 1] == -1.0
    cells = np.array([[10.0, 20.0, 60.0], [5.0, 5.0, 5.0]])
    picture = np.full((19, 29), 200, np.uint8)  # what no whole cell holds does not count
    picture[:16, :24] = np.kron(cells, np.ones((8, 8)))
    assert _interest(picture) == pytest.approx(math.sqrt((20**2 + 10**2 + 30**2) / 6))
    own = np.array([(0.0, -10.0), (100.0, 10.0), (50.0, 0.0)])
    track = np.array(
        [(-99.0, 0, 5), (-101.0, 0, 5), (199.0, 109.0, 5), (199.0, 111.0, 5), (0.0, -109.0, 5), (0, -111, 5)]
    )
    assert np.allclose(near_parts([Stub(position=track)], own)[0], track[[0, 2, 4], :2])
    still = near_parts([Stub(position=track)], np.array([(-62.0, 0.0), (-61.0, 0.0)]))[0]
    assert np.allclose(still, track[:2, :2])  # 40 m about a vehicle that stands
    t = np.array([0.0, 2.0, 4.0])
    trial = Stub(track=Stub(time=t, position=np.array([(0.0, 0, 0), (4, 2, 0), (6, 10, 0)]),
                            attitude=np.array([(0, 0, 0.2), (0, 0, 0.6), (0, 0, 2.0)])),
                 switched_s=np.array([1.0]), length_m=5.0)  # fmt: skip
    found = in_lengths(trial)
    place = np.array([(-2.0, -1.0), (2.0, 1.0), (4.0, 9.0)]) / 5
    expected = place[:, 0] + 1j * place[:, 1]
    expected = expected * np.exp(-0.4j)  # at the order, halfway: 0.4 rad
    assert np.allclose(found[:, 0] + 1j * found[:, 1], expected)

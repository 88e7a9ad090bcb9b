"""Guidance: tasks, steering, outlines and outcomes of missions, each against a formula of its own.

World axes are x north, y west, z up (NWU); compass angles count clockwise from north, so that (cos h, -sin h) is ahead.
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from pelagos.errors import ScenarioError
from pelagos.sim.guidance.aboard import Aboard, Fix
from pelagos.sim.guidance.follow import FollowAgent, FollowWall
from pelagos.sim.guidance.goal import Goal, Path
from pelagos.sim.guidance.guidance import level_depth
from pelagos.sim.guidance.orbit import Orbit
from pelagos.sim.guidance.outcome import _from_circle, _from_line
from pelagos.sim.guidance.outline import _circle
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.route import _thinned
from pelagos.sim.guidance.steering.cruise import Cruise
from pelagos.sim.guidance.steering.hover import Hover
from pelagos.sim.guidance.steering.steering import Crab, Lead, circle_rate
from pelagos.sim.guidance.steering.surface import Surface
from pelagos.sim.guidance.survey import Swath, _altitude, _cut
from pelagos.sim.guidance.task import Common, Level, Limit
from pelagos.sim.guidance.vertical import Land, Profile


def aboard(position, heading=0.0, velocity=(0.0, 0.0, 0.0), *, altitude=np.inf, t_s=20.0, dt_s=0.5, **more):
    """Vehicles at 20 s whose guidance is asked every half second; one row a lane."""
    position = np.atleast_2d(np.array(position, float))
    n = len(position)
    fix = Fix(position, np.broadcast_to(heading, n).astype(float), np.broadcast_to(velocity, (n, 3)).astype(float))
    return Aboard(fix, t_s, dt_s, np.broadcast_to(altitude, n).astype(float), np.zeros(n, bool), **more)


def test_another_agent_is_followed_at_a_place_beside_it():
    """A line through the place along its way, faster by 0.15 /s of the distance behind; the place, where it lies still.

    Compass 0.6 rad: ahead is (cos, -sin), to port (sin, cos) of north and west.
    """
    own = [(4.0, 3.0, -2.0), (-60.0, 50.0, -2.0), (70.0, -60.0, -2.0), (4.0, 3.0, -2.0)]
    way = np.array([(0.8, -0.5, 0.1), (0.8, -0.5, 0.1), (0.8, -0.5, 0.1), (0.1, -0.1, 0.0)])
    other = Fix(np.tile([10.0, -4.0, -7.0], (4, 1)), np.full(4, 0.6), way)
    now = aboard(own, others={"lead": other})
    task = FollowAgent("lead", (-6.0, 2.0, -1.5), 12.0, 1.9, Common(speed_mps=1.1))
    progress = Progress.begin(now)
    goal = task.goal(now, progress)
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
    assert not task.moves(aboard(own, t_s=31.9), progress).any()
    assert task.moves(aboard(own, t_s=32.0), progress).all()
    given = FollowAgent("lead", (-6.0, 2.0, -1.5), None, 1.9, Common(Level(depth_m=4.0), face_rad=-2.0))
    assert np.isnan(given.goal(now, progress).depth).all()  # as the leg's level says
    assert np.allclose(given.goal(now, progress).face, -2.0)
    assert not given.moves(aboard(own, t_s=1e9), progress).any()


@pytest.mark.parametrize("side", [1.0, -1.0])
def test_the_direction_of_a_wall_follows_from_how_its_range_changes(side):
    """A range that grows abeam is a wall that turns away: to the side that the vehicle looks at.

    sin(angle between course and wall) = rate of the range / speed, at most 0.9, averaged over 4 s: 0.5 s is 1/8 of it.
    """
    velocity = [
        (0.6, -0.3, 0.0),
        (0.1, 0.05, 0.0),
        (0.6, -0.3, 0.0),
        (0.6, -0.3, 0.0),
        (0.2, 0.1, 0.0),
        (0.6, -0.3, 0.0),
    ]
    distance = np.array([6.1, 6.02, np.nan, 6.1, 3.0, 6.1])
    now = aboard(np.zeros((6, 3)), 0.7, velocity, readings={"wall": distance[:, None]})
    progress = Progress.begin(now)
    progress.heading[:] = 0.4
    progress.memory[:, :3] = (1, 0.5, 6.0)
    progress.memory[3:6:2, :3] = [(0, 0.0, 0.0), (1, 0.5, 0.0)]  # at its beginning; and out of sight before
    task = FollowWall("wall", side, 5.0, None, Common())
    assert not task.moves(now, progress).any()
    course = math.atan2(0.3, 0.6)
    found = [
        0.5 + 0.125 * (course - side * math.asin(0.2 / math.hypot(0.6, 0.3)) - 0.5),
        0.5 + 0.125 * (0.7 - side * math.asin(0.04 / 0.15) - 0.5),  # too slow to have a course
        0.5,
        0.4,
        0.5 + 0.125 * (math.atan2(-0.1, 0.2) + side * math.asin(0.9) - 0.5),
        0.5,
    ]
    assert np.allclose(progress.memory[:, 1], found)
    assert np.allclose(progress.memory[:, 2], [6.1, 6.02, 0.0, 6.1, 3.0, 6.1])
    assert (progress.memory[:, 0] == 1).all()
    goal = task.goal(now, progress)
    lean = np.array([1.1 / 5, 1.02 / 5, 0.4, 1.1 / 5, -0.4, 1.1 / 5])  # unseen: as if 2 m too far
    assert np.allclose(goal.course, progress.memory[:, 1] - side * lean)
    assert np.allclose(goal.end, 50 * np.stack([np.cos(goal.course), -np.sin(goal.course)], -1))
    assert np.allclose(goal.face, progress.memory[:, 1])
    assert not goal.stops.any()
    progress.memory[:, 2] = [20.0, 0.1, 5.0, 5.0, 5.0, 5.0]
    lean = task.goal(now, progress).course - progress.memory[:, 1]
    assert np.allclose(lean, -side * np.array([0.7, -0.7, 0.0, 0.0, 0.0, 0.0]))


def test_a_profile_turns_near_its_depths_and_counts_at_the_top():
    """Half a metre before each depth; done after its cycles, or within 9 m of its point."""
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
    assert (goal.upper == 4).all()
    assert (goal.end == (30, -40)).all()
    assert (goal.start == 0).all()
    turning = Profile(4.0, 30.0, heading_rad=-0.7, glide_rad=0.3).goal(near, Progress.begin(near))
    assert np.allclose(turning.course, -0.7)
    assert np.allclose(turning.glide, 0.3)
    assert np.allclose(turning.end, near.xy)


def test_a_vehicle_has_landed_when_it_has_hardly_sunk_for_a_while():
    """Slower than a quarter of 0.4 m/s for 3 s, which count from 3 s after the task began."""
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
    assert np.allclose(goal.face, 0.3)
    assert np.allclose(Land(None, 0.4).goal(now, progress).end, (1.0, 2.0))


def test_altitude_is_held_by_a_ramp_of_the_depth():
    """The depth that gives the altitude is depth + altitude - 5 m; no set-point is shallower than 0.5 m."""
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


def test_the_distance_from_a_line_counts_on_its_second_half():
    start, end = np.array([2.0, 1.0]), np.array([14.0, -8.0])  # 15 m along (0.8, -0.6)
    place = lambda run, off: start + run * np.array([0.8, -0.6]) + off * np.array([0.6, 0.8])
    way = np.array([place(6.0, 5.0), place(8.0, -1.2), place(12.0, 0.7), place(15.1, 3.0)])
    assert _from_line(start, end, way) == pytest.approx(1.2)
    assert _from_line(start, end, way[[0, 3]]) == 0.0


def test_the_distance_from_a_circle_counts_from_a_quarter_turn_on_it():
    """On it: within 1 m and a quarter of the radius, here 3.5 m. Of half a turn, from an eighth on."""

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
    here = (9.0, -10.0)
    found = np.array(_circle(Orbit((3.0, -2.0), 5.0, 1.25, turn), here))
    assert len(found) == 46  # 450 degrees in steps of 10
    angle = math.atan2(-8.0, 6.0) - turn * np.radians(10.0) * np.arange(46)  # clockwise from above: x north, y west
    assert np.allclose(found, np.array([3.0, -2.0]) + 5 * np.stack([np.cos(angle), np.sin(angle)], -1))
    assert len(_circle(Orbit((3.0, -2.0), 5.0, 0.01, turn), here)) == 2


def test_crab_angles_are_seen_under_way_and_forgotten_otherwise():
    """The angle from heading to course, averaged over 5 s, from 0.4 of the wanted speed on."""
    velocity = np.array([(0.6, -0.8), (0.6, 0.8), (-0.6, -0.8), (-0.8, 0.6), (0.3, -0.4), (0.6, -0.8)])
    now = aboard(np.zeros((6, 3)), [0.5, -0.4, 0.5, 3.1, 0.5, 0.5], np.c_[velocity, np.zeros(6)], dt_s=2.0)
    crab = Crab(np.full(6, 0.2))
    found = crab.see(now, np.array([2.4, 1.0, 1.0, 1.0, 1.3, 0.0]))
    share = 1 - math.exp(-2.0 / 5.0)
    course, astern = math.atan2(0.8, 0.6), 1.0  # kept to one radian
    across_south = 2 * math.pi - (math.pi - math.atan2(0.6, 0.8)) - 3.1  # from 3.1 rad, the short way
    seen = [course - 0.5, -course + 0.4, astern, across_south]
    expected = [0.2 + share * (s - 0.2) for s in seen] + [0.2 * (1 - share)] * 2
    assert np.allclose(found, expected)
    assert found is crab.angle


def test_the_lag_of_headings_is_learned_on_circles_alone():
    """Least mean squares over 6 s: what is left of the heading's error is rate times the lag that is not known yet."""
    path = [Path.CIRCLE, Path.POINT, Path.CIRCLE, Path.CIRCLE, Path.CIRCLE, Path.LINE]
    now = aboard([(12.0, 1.0, 0)] * 6, [1.9, 1.9, 1.9, 2.0, 4.5, 1.9], (0.3, -1.2, 0.0))
    goal = Goal.stay(now)
    goal.path[:] = path
    goal.end[:], goal.radius[:], goal.turn[:] = (2.0, -1.0), 9.0, [1.0, -1.0, 1.0, 1.0, 1.0, 1.0]
    goal.radius[1] = np.nan
    wanted, lag = np.array([1.8, 2.1, 1.4, 1.9, 1.8, 1.8]), np.array([1.5, 0.4, 0.1, 9.0, 1.5, 1.5])
    lead = Lead(lag.copy())
    found = lead.turning(wanted, goal, now, 5.0, 7.0)
    radius = np.where(np.isnan(goal.radius), 7.0, goal.radius)
    rate = circle_rate(goal.end, radius, goal.turn, now.xy, now.own.velocity[:, :2], 5.0)
    assert rate[0] > 0.09
    assert np.allclose(found - wanted, [1.5 * rate[0], 0.4 * rate[1], 0.1 * rate[2], 0.8, 1.5 * rate[4], 0.0])
    error = np.array([1.8 - 1.9, 2.1 - 1.9, 1.4 - 1.9, 1.9 + 0.8 - 2.0 - 9.0 * rate[3]])
    learned = lag[:4] + 0.5 / 6.0 * rate[:4] * error / (rate[:4] ** 2 + 0.02**2)
    assert learned[2] < 0  # no lag is
    assert np.allclose(lead.lag_s[:4], [learned[0], learned[1], 0.0, learned[3]])
    assert np.allclose(lead.lag_s[4:], lag[4:])  # one turns towards its circle, one has none


def test_a_reference_point_sinks_no_faster_than_it_may_and_waits():
    """0.3 m/s or the goal's own, sqrt(0.2 m/s^2 x way) near its end; less 1 m ahead of the vehicle, none at 2 m."""
    hover = Hover(0.2, 1.0)
    hover.point = np.array([(0, 0, 2.0), (0, 0, 8.0), (0, 0, 3.0), (0, 0, 5.0), (0, 0, 5.0), (0, 0, 4.0)])
    here = np.array([(0, 0, 2.0), (0, 0, 8.0), (0, 0, 3.0), (0, 0, 3.5), (0, 0, 6.7), (0, 0, 4.0)])
    goal = Goal.stay(aboard(here))
    goal.depth[:] = [10.0, 2.0, 3.02, 10.0, 1.0, 3.8]
    goal.sink[:] = [np.nan, 0.6, np.nan, np.nan, np.nan, np.nan]
    rate = hover._sink(goal, here, 0.5)
    assert np.allclose(rate, [0.3, -0.6, 0.04, 0.15, -0.09, -math.sqrt(0.2 * 0.2)])
    assert np.allclose(hover.point[:, 2], [2.15, 7.7, 3.02, 5.075, 4.955, 3.9])


def test_the_heading_of_a_hovering_vehicle_turns_the_short_way_and_waits_at_rest():
    """At 0.5 rad/s, along the way from 0.05 m/s on, where the goal asks for none."""
    hover = Hover(0.2, 1.0)
    hover.speed, hover.heading = np.array([0.3, 0.04, 0.3, 0.3]), np.array([0.2, 0.2, 3.1, 0.2])
    face = Goal.stay(aboard(np.zeros((4, 3))))
    face.face[:] = [np.nan, np.nan, -3.1, 0.3]
    velocity = np.array([(-1.0, 2.0), (-1.0, 2.0), (1.0, 0.0), (1.0, 0.0)])
    assert np.allclose(hover._face(face, velocity, 0.5), [-0.05, 0.2, -3.1, 0.3])


def test_a_craft_that_stays_keeps_its_heading_at_rest_and_backs():
    """Through the water, 0.15 /s of the way less the current; slower than 0.08 m/s it keeps its heading."""
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
    assert np.allclose(np.cos(held - [bearing, 0.3, math.pi, 0.3]), 1.0, rtol=0, atol=1e-12)
    assert np.allclose(speed, [min(math.hypot(*far) * math.cos(bearing - 0.3), 1.2), slow, 0.0, along])


def test_a_glider_turns_between_depths_and_stays_afloat():
    """From 3 m, or half of a shallow depth, at 0.44 rad; a lower depth lies 1 m below the upper one at least."""
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


@pytest.mark.parametrize("turned", [0.0, 0.7, -2.1])
def test_lines_are_cut_from_areas_with_bays(turned):
    """Along y = 4 of a shape with a bay, which may lie any way round."""
    area = np.array([(0.0, 0), (10, 0), (12, 6), (7, 6), (7, 2), (3, 2), (3, 6), (1, 6)])
    pieces = np.array([[(2 / 3, 4), (3, 4)], [(7, 4), (10 + 4 / 3, 4)]])
    c, s = math.cos(turned), math.sin(turned)
    turn = np.array([[c, s], [-s, c]])  # of row vectors
    along, right = np.array([(1.0, 0.0), (0.0, -1.0)]) @ turn
    assert np.allclose(_cut(area @ turn, along, right, -4.0), pieces @ turn)
    assert _cut(area @ turn, along, right, -6.1) == []


def test_lines_of_a_survey_keep_clear_of_the_seabed():
    """A swath of 120 degrees is tan(60 degrees) of the least altitude wide to each side, less a quarter."""
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


def distance(point, line):
    """From a point to the nearest piece of a line."""
    far = []
    for a, b in pairwise(line):
        length = np.hypot(*(b - a))
        run = (point - a) @ (b - a) / length if length else 0.0
        far.append(np.hypot(*(point - a)) if run <= 0 else np.hypot(*(point - b)))
        if 0 < run < length:
            far[-1] = abs((b - a)[0] * (point - a)[1] - (b - a)[1] * (point - a)[0]) / length
    return min(far)


@pytest.mark.parametrize("seed", range(4))
def test_no_point_of_a_line_is_farther_than_30_cm_from_the_thinned_one(seed):
    """A random way that turns as it likes; what is left are some of its points, in order, the ends among them."""
    random = np.random.default_rng(seed)
    smooth = np.cumsum(random.normal(size=(60, 2)) * [0.4, 1.1], axis=0)
    back = np.array([(0.0, 0.0), (-3.0, 0.1), (8.0, -0.2), (8.1, 0.1), (5.0, 0.2)])  # beyond its ends, and to and fro
    loop = np.array([(1.0, 2.0), (6.0, -1.0), (4.0, 4.0), (1.0, 2.0)])
    for line in (smooth, back, loop):
        kept = _thinned(line)
        assert max(distance(p, kept) for p in line) <= 0.3 + 1e-9
        at = [int(np.flatnonzero((line == p).all(axis=1))[0 if k < len(kept) - 1 else -1]) for k, p in enumerate(kept)]
        assert at == sorted(at)
        assert (at[0], at[-1]) == (0, len(line) - 1)


def test_points_are_left_out_where_a_line_stays_within_30_cm_without_them():
    line = np.array([(0.0, 0.0), (2.0, 0.29), (4.0, -0.29), (6.0, 0.0), (8.0, -3.0), (8.2, -6.0)])
    assert _thinned(line).tolist() == line[[0, 3, 4, 5]].tolist()
    bent = line * [1.0, -1.1]  # 0.319 m off
    assert _thinned(bent).tolist() == bent.tolist()
    assert _thinned(line[:2]).tolist() == line[:2].tolist()

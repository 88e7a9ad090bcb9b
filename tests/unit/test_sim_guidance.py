"""Guidance: lines, altitude hold, and the order of tasks, on a point that obeys perfectly."""

from __future__ import annotations

import math
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import TypeAdapter

from pelagos.config.mission import Leg
from pelagos.errors import InputError, LookupFailed, ScenarioError
from pelagos.math.geodesy import GeoOrigin
from pelagos.sim.guidance.aboard import Aboard, Fix, wrapped
from pelagos.sim.guidance.guidance import DEPTH_RATE_MPS, Guidance, Step
from pelagos.sim.guidance.line import Line
from pelagos.sim.guidance.orbit import Orbit, on_circle
from pelagos.sim.guidance.plan import Planner, lawnmower
from pelagos.sim.guidance.progress import Progress
from pelagos.sim.guidance.route import middle_line
from pelagos.sim.guidance.steering.choice import steering_of
from pelagos.sim.guidance.steering.steering import circle_course, circle_rate, line_course
from pelagos.sim.guidance.survey import Swath, survey_lines
from pelagos.sim.guidance.task import Common, Level
from pelagos.sim.guidance.vertical import Dive
from pelagos.sim.guidance.wait import GpsFix
from pelagos.vehicles.envelope import EnvelopeConfig
from pelagos.vehicles.family import FAMILIES

TORPEDO = next(f for f in FAMILIES if f.name == "torpedo")
HOVER = next(f for f in FAMILIES if f.name == "hover")
NAMES = ("depth", "heading", "speed")


def legs(*given):
    return [TypeAdapter(Leg).validate_python(leg) for leg in given]


def aboard(x=0.0, y=0.0, depth=0.0, heading=0.0, *, altitude=np.inf, fixed=False, t=0.0, velocity=(0, 0, 0), **more):
    rows = np.broadcast_arrays(np.atleast_1d(np.asarray(x, float)), y, depth, heading)
    x, y, depth, heading = (np.array(r, dtype=float) for r in rows)
    n = len(x)
    fix = Fix(np.stack([x, y, -depth], axis=-1), heading, np.tile(np.array(velocity, float), (n, 1)))
    return Aboard(fix, t, 0.1, np.full(n, float(altitude)), np.full(n, fixed), **more)


def guidance(tasks, now, family=TORPEDO, names=NAMES, length=1.5, envelope=None):
    steering = steering_of(family, envelope or EnvelopeConfig(), length, len(now))
    return Guidance([Step(t, i + 1) for i, t in enumerate(tasks)], steering, names, now)


@pytest.mark.parametrize("heading_deg", [90.0, -35.0, 160.0])
@pytest.mark.parametrize("corner", [(0.0, 0.0), (12.0, -7.0)])
def test_lawnmower_lines_alternate_and_grow_to_starboard(heading_deg, corner):
    """Along the heading and back, each line 25 m to starboard of the last; north is x, east is -y."""
    leg = SimpleNamespace(heading_deg=heading_deg, length_m=100.0, width_m=55.0, spacing_m=25.0)
    lines = lawnmower(leg, corner)
    assert len(lines) == 3
    north, east = math.cos(math.radians(heading_deg)), math.sin(math.radians(heading_deg))
    for k, (start, end) in enumerate(lines):
        near = np.add(corner, 25.0 * k * np.array([-east, -north]))  # starboard of north is east
        far = near + 100.0 * np.array([north, -east])
        assert np.allclose([start, end], [near, far] if k % 2 == 0 else [far, near])


@pytest.mark.parametrize(("y", "sign"), [(5.0, 1.0), (-5.0, -1.0)])
def test_a_vehicle_beside_its_line_steers_towards_it(y, sign):
    line = Line((100.0, 0.0), (0.0, 0.0), common=Common(Level(3.0)))
    depth, heading, speed = guidance([line], aboard()).command(aboard(10.0, y))[0]
    lookahead = 18.0 * (0.5 + 0.5 * math.exp(-5.0 / 9.0))  # twelve lengths on the line, half of that far from it
    assert heading == pytest.approx(sign * math.atan2(5.0, lookahead))  # west of a northward line: turn to the right
    assert (depth, speed) == (3.0, 1.5)


@pytest.mark.parametrize("course_deg", range(-180, 180, 45))
@pytest.mark.parametrize("across", [3.0, -7.0])
@pytest.mark.parametrize("origin", [(0.0, 0.0), (-321.0, 654.0)])
def test_the_way_back_onto_a_line_is_the_same_at_every_course_and_place(course_deg, across, origin):
    """course - atan(e / lookahead), e positive to starboard, e placed by hand: right = ahead turned clockwise."""
    course = math.radians(course_deg)
    ahead = np.array([math.cos(course), -math.sin(course)])
    right = np.array([-math.sin(course), -math.cos(course)])
    start = np.array([origin])
    found = line_course(start, start + 80 * ahead, start + 30 * ahead + across * right, 12.0)
    assert np.angle(np.exp(1j * (found[0] - course + math.atan2(across, 12.0)))) == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("across", [0.7, -4.0, 55.0])
def test_far_from_its_line_a_vehicle_aims_nearer_ahead(across):
    """Delta = 12 (0.4 + 0.6 exp(-|e| / 6)); the line heads north-west, starboard of it is north-east."""
    start, right = np.array([[7.0, -3.0]]), np.array([1.0, -1.0]) / math.sqrt(2)
    ahead = np.array([1.0, 1.0]) / math.sqrt(2)
    found = line_course(start, start + 80 * ahead, start + 30 * ahead + across * right, 12.0, 0.4)[0]
    lookahead = 12.0 * (0.4 + 0.6 * math.exp(-abs(across) / 6.0))
    assert found == pytest.approx(-math.pi / 4 - math.atan2(across, lookahead), abs=1e-12)


@pytest.mark.parametrize(("depth", "speed"), [(0.1, 0.0), (0.34, 0.0), (0.4, 1.2), (2.0, 1.2)])
def test_who_sinks_while_it_waits_for_a_fix_drives_up(depth, speed):
    task = GpsFix(30.0, rises=True, common=Common(Level(0.0), 1.2))
    asked = guidance([task], aboard(3.0, -4.0, depth)).command(aboard(3.0, -4.0, depth))[0]
    assert asked.tolist() == pytest.approx([0.0, 0.0, speed])
    assert guidance([GpsFix(30.0)], aboard()).command(aboard(3.0, -4.0, depth))[0][2] == 0.0


@pytest.mark.parametrize(("approach", "lines"), [(10.0, 3), (300.0, 2)])
def test_who_cannot_go_sideways_comes_onto_the_axis_of_a_dock_in_time(approach, lines):
    """Heading 120 degrees in: eight radii of 25 m are 200 m back along (cos 120, -sin 120), from x 7, y -3 NWU."""
    leg = legs({"type": "dock", "point": [7, -3, -6], "heading_deg": 120, "approach_m": approach})
    tasks = [s.task for s in planner(envelope=EnvelopeConfig(turn_radius_m=25, slow_mps=0.8)).plan(leg)]
    far = max(approach, 200.0)
    assert len(tasks) == lines
    assert tasks[0].end == pytest.approx((7 + 0.5 * far, -3 + math.sqrt(0.75) * far))
    assert tasks[-1].again == lines - 1  # who misses begins anew
    assert [t.common.speed_mps for t in tasks[1:]] == [0.8] * (lines - 1)


@pytest.mark.parametrize(
    ("short", "side", "deeper", "docked"),
    [(0.0, 0.3, -0.35, True), (0.0, -0.3, 0.45, False), (0.3, 0.2, 0.3, True), (0.3, 0.2, -0.4, False)],
)
def test_docked_is_within_the_distance_of_the_point_in_space(short, side, deeper, docked):
    """Within 0.5 m: 0.46 and 0.47 m are, 0.54 m are not, though each of their parts is."""
    line = Line((30.0, -4.0), (10.0, -4.0), 0.5, again=True, common=Common(Level(9.0)))
    place = aboard(30.0 - short, -4.0 + side, 9.0 + deeper)
    assert line.moves(place, Progress.begin(aboard()))[0] == docked


@pytest.mark.parametrize("turn", [1.0, -1.0])
@pytest.mark.parametrize("angle", [0.3, 2.0, -2.5])
def test_the_way_onto_a_circle(turn, angle):
    """On the circle along the tangent, far outside to the centre, far inside away from it."""
    center = np.array([[4.0, -3.0]])
    out = np.array([[math.cos(angle), math.sin(angle)]])
    tangent = turn * np.array([out[0, 1], -out[0, 0]])  # clockwise from above: north, then east (y negative)

    def ahead(r):
        course = circle_course(center, np.array([10.0]), np.array([turn]), center + r * out, 5.0)[0]
        return np.array([math.cos(course), -math.sin(course)])

    assert ahead(10.0) == pytest.approx(tangent, abs=1e-12)
    assert ahead(1e6) == pytest.approx(-out[0], abs=1e-4)
    assert ahead(1.0) @ out[0] > 0.5


def test_crab_angle_takes_the_drift_off_a_line():
    """A point that goes where it heads plus 0.3 m/s across: without the crab angle it would stay 3.5 m off."""
    line = Line((900.0, 0.0), (0.0, 0.0), common=Common(Level(3.0)))
    position, heading, t = np.array([0.0, 4.0]), 0.0, 0.0
    g = guidance([line], aboard(0.0, 4.0))
    for _ in range(3000):
        way = 1.5 * np.array([math.cos(heading), -math.sin(heading)]) + [0.0, 0.3]
        heading = g.command(aboard(*position, 3.0, heading, t=t, velocity=(*way, 0)))[0, 1]
        position, t = position + 0.1 * way, t + 0.1
    assert abs(position[1]) < 0.05


def test_altitude_hold_ramps_the_depth_set_point():
    line = Line((100.0, 0.0), (0.0, 0.0), common=Common(Level(altitude_m=5.0)))
    g = guidance([line], aboard(depth=2.0))
    depths = [g.command(aboard(depth=2.0, altitude=15.0))[0, 0] for _ in range(3)]
    assert np.allclose(np.diff([2.0, *depths]), DEPTH_RATE_MPS * 0.1)
    held = [g.command(aboard(depth=12.0, altitude=5.0))[0, 0] for _ in range(600)]
    assert held[-1] == pytest.approx(12.0, abs=1e-3)
    assert max(held) <= 12.0


def test_tasks_follow_each_other_and_the_mission_ends():
    level = Common(Level(5.0))
    up = Common(Level(0.0))
    tasks = [Dive(common=level), Line((10.0, 0.0), common=level), Dive(True, up), GpsFix(30.0, common=up)]
    g = guidance(tasks, aboard())
    assert g.command(aboard())[0, 0] == 5.0
    g.command(aboard(depth=4.5, t=10.0))
    assert g.progress.task[0] == 1
    g.command(aboard(10.5, depth=5.0, t=20.0))
    assert g.progress.task[0] == 2
    g.command(aboard(12.0, depth=0.1, t=30.0))
    assert g.progress.task[0] == 3
    for k in range(3):
        g.command(aboard(12.0, fixed=True, t=31.0 + k))
    assert g.done


def test_copies_are_each_at_their_own_task_and_equal_a_mission_alone():
    tasks = [Line((10.0, 0.0), common=Common(Level(2.0))), Line((10.0, -30.0), common=Common(Level(4.0)))]
    x, y = np.array([0.0, 9.0, 10.5, 3.0]), np.array([1.0, 0.5, -28.5, -2.0])
    together = guidance(tasks, aboard(np.zeros(4)))
    alone = [guidance(tasks, aboard(0.0)) for _ in range(4)]
    for k in range(3):
        rows = together.command(aboard(x, y, t=0.1 * k))
        each = [g.command(aboard(x[i], y[i], t=0.1 * k))[0] for i, g in enumerate(alone)]
        assert (rows == np.array(each)).all()
    assert together.progress.task.tolist() == [0, 1, 2, 0]


def test_a_fix_that_never_comes_times_out():
    g = guidance([GpsFix(30.0)], aboard())
    g.command(aboard(t=29.0))
    assert not g.done
    g.command(aboard(t=30.0))
    assert g.done


EVERY = [
    {"type": "dive", "depth_m": 3},
    {"type": "waypoints", "points": [[1, 2], [3, 4]], "depth_m": 3, "speed_mps": 2, "acceptance_m": 4},
    {"type": "lawnmower", "corner": [0, 0], "length_m": 9, "width_m": 0, "spacing_m": 5, "altitude_m": 5},
    {"type": "hold", "seconds": 4},
    {"type": "surface"},
    {"type": "gps_fix", "timeout_s": 20},
    {"type": "repeat", "times": 2, "last": 2},
]
ALTIMETER = {"alt": SimpleNamespace(type="altimeter", q_body_sensor=(1.0, 0.0, 0.0, 0.0))}


def planner(family=TORPEDO, **more):
    where = lambda number: f"a.yaml: mission.{number}"
    return Planner("auv0", "remus100", family, **{"sensors": ALTIMETER, "where": where, **more})


def test_plan_gives_the_tasks_of_legs():
    steps = planner().plan(legs(*EVERY))
    kinds = [type(s.task).__name__ for s in steps]
    assert kinds == ["Dive", *["Line"] * 4, "Hold", "Dive", "GpsFix", *["Dive", "GpsFix"] * 2]
    assert steps[2].task.start == (1.0, 2.0)
    assert steps[2].task.common.speed_mps == 2.0
    assert steps[4].task.common.level == Level(None, 5.0)
    assert [s.behind for s in steps[:5]] == [1, 3, 3, 5, 5]
    assert steps[-1].behind == len(steps)


def test_a_reading_ends_a_leg():
    until = {"sensor": "alt", "below": 4.0}
    mission = legs({"type": "waypoints", "points": [[50, 0], [90, 0]], "depth_m": 3, "until": until}, EVERY[3])
    steps = planner().plan(mission)
    g = Guidance(steps, steering_of(TORPEDO, EnvelopeConfig(), 1.5, 2), NAMES, aboard(np.zeros(2)))
    for altitude in (np.array([[9.0], [np.nan]]), np.array([[9.0], [3.5]])):
        g.command(aboard(np.zeros(2), readings={"alt": altitude}))
    assert g.progress.task.tolist() == [0, 2]


def test_places_on_earth():
    world = SimpleNamespace(origin=GeoOrigin(45.0, 13.0))
    mission = legs({"type": "waypoints", "points": [{"latitude_deg": 45.01, "longitude_deg": 13.0}], "depth_m": 2})
    line = planner(world=world).plan(mission)[0].task
    assert line.end == pytest.approx((1111.3, 0.0), abs=1.0)  # a hundredth of a degree of latitude at 45 deg: 1111.3 m
    with pytest.raises(ScenarioError, match=r"mission\.0: a place on Earth needs a world that lies there"):
        planner(world=SimpleNamespace(origin=GeoOrigin(0.0, 0.0))).plan(mission)


@pytest.mark.parametrize("at", [(0.0, -25.0), (51.0, 0.0), (-33.5, 151.25)])
def test_places_on_earth_west_and_north_of_an_origin_on_equator_or_meridian(at):
    """By the radii of curvature of WGS84: 1e-4 of 2 km, what the tangent plane's curvature makes of it."""
    latitude, longitude = at
    place = {"latitude_deg": latitude + 0.01, "longitude_deg": longitude - 0.02}
    line = (
        planner(world=SimpleNamespace(origin=GeoOrigin(latitude, longitude)))
        .plan(legs({"type": "waypoints", "points": [place], "depth_m": 2}))[0]
        .task
    )
    phi, e2 = math.radians(latitude + 0.005), 0.00669438
    flat = 1 - e2 * math.sin(phi) ** 2
    north = 6378137.0 * (1 - e2) / flat**1.5 * math.radians(0.01)
    west = 6378137.0 / flat**0.5 * math.cos(math.radians(latitude + 0.01)) * math.radians(0.02)
    assert line.end == pytest.approx((north, west), abs=0.5)


REFUSED = [
    ({"type": "land"}, "remus100 cannot do the leg 'land'; it can do dive"),
    ({"type": "goto", "points": [[1, 2, -3]], "heading_deg": 3}, "leave out 'heading_deg'"),
    ({"type": "goto", "points": [[1, 2, 3]]}, "does not fly: z is 3 m above the surface"),
    ({"type": "orbit", "center": [1, 2], "radius_m": 9, "look": "center"}, "cannot circle sideways"),
    ({"type": "orbit", "center": [1, 2], "radius_m": 9}, "at 1.5 m/s has a radius of 25 m, not 9"),
    ({"type": "station_keeping", "seconds": 9, "radius_m": 24.9}, "at 1.5 m/s has a radius of 25 m, not 24.9"),
    ({"type": "dive", "depth_m": 300}, "goes at most 100 m deep, not 300"),
    ({"type": "dive", "height_m": 30}, "does not fly: leave out height_m"),
    ({"type": "surface", "speed_mps": 9}, "goes at most 2.5 m/s, not 9"),
    ({"type": "repeat", "times": 2}, "there is no leg before this one"),
    ({"type": "follow", "agent": "auv1", "seconds": 3}, "unknown agent to follow 'auv1'"),
    ({"type": "follow", "wall": "alt", "seconds": 3}, "does not look sideways"),
    ({"type": "hold", "seconds": 3, "until": {"sensor": "at", "above": 3}}, "did you mean 'alt'"),
]


@pytest.mark.parametrize(("leg", "message"), REFUSED)
def test_legs_that_cannot_be_say_why(leg, message):
    envelope = EnvelopeConfig(top_mps=2.5, depth_m=100, turn_radius_m=25)
    with pytest.raises((ScenarioError, LookupFailed), match=r"a\.yaml: mission\.0") as caught:
        planner(envelope=envelope, agents=("auv0",)).plan(legs(leg))
    assert message in str(caught.value)


def test_a_banked_circle_grows_with_the_square_of_the_speed():
    """Of 130 m at 30 m/s: 231.1 m at 40 and 57.8 m at 20, V^2 / (g tan(bank))."""
    banked = EnvelopeConfig(cruise_mps=20, top_mps=40, turn_radius_m=130, turn_speed_mps=30)
    assert banked.smallest_circle_m(40) == pytest.approx(130 * 16 / 9)
    orbit = {"type": "orbit", "center": [1, 2], "radius_m": 60}
    assert planner(envelope=banked).plan(legs(orbit))
    with pytest.raises(ScenarioError, match=r"mission\.0\.radius_m: .* at 40 m/s has a radius of 231\.1 m, not 60"):
        planner(envelope=banked).plan(legs({**orbit, "speed_mps": 40}))


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_an_orbit_counts_only_what_is_on_the_circle(turn):
    """Half a turn on a circle of 20 m, a whole one 6.1 m outside, the other half on it again."""
    orbit, step = Orbit((3.0, -7.0), 20.0, 1.0, turn), math.radians(5)
    progress, done = Progress.begin(aboard(23.0, -7.0)), []
    for k in range(146):  # two turns
        far = 20.0 if k <= 36 or k > 108 else 20.0 + on_circle(20.0) + 0.1
        at = 3.0 + far * math.cos(k * step), -7.0 - turn * far * math.sin(k * step)
        done.append(int(orbit.moves(aboard(*at), progress)[0]))
    assert done[-1]
    assert not any(done[:-2])


def test_altitude_needs_a_sensor_that_looks_down():
    aside = SimpleNamespace(type="altimeter", q_body_sensor=(math.sqrt(0.5), math.sqrt(0.5), 0.0, 0.0))
    with pytest.raises(ScenarioError, match="carries nothing that measures altitude"):
        planner(sensors={"aside": aside}).plan(legs(EVERY[2]))


UNFIT = [
    ({"type": "station_keeping"}, "give 'seconds' or 'until'"),
    ({"type": "profile", "lower_depth_m": 9}, "give 'cycles', 'point' or 'until'"),
    ({"type": "profile", "lower_depth_m": 2, "cycles": 1}, "upper_depth_m 3.0 must be above lower_depth_m 2.0"),
    ({"type": "follow", "seconds": 3}, "give one of 'agent', 'wall' and 'pipeline'; none given"),
    ({"type": "follow", "agent": "b", "distance_m": 2.5, "seconds": 3}, "'distance_m' is kept from 'wall'"),
    ({"type": "follow", "wall": "side", "offset_m": [-2, 0, 0], "seconds": 3}, "'offset_m' is kept from 'agent'"),
    ({"type": "follow", "pipeline": "pipe", "distance_m": 2.5}, "'distance_m' is kept from 'wall'; leave it out"),
    ({"type": "survey", "area": [[0, 0], [1, 0], [1, 1]]}, "give either 'spacing_m' or 'swath_deg'; neither given"),
    (
        {"type": "survey", "area": [[0, 0], [1, 0], [1, 1]], "spacing_m": 3, "swath_deg": 70},
        "give either 'spacing_m' or 'swath_deg'; both given",
    ),
    ({"type": "goto", "points": [[1, 2, -3]], "depth_m": 3}, "leave out 'depth_m'"),
    ({"type": "goto", "points": [[1, 2]], "heading_deg": 3, "face": [1, 2]}, "give either 'heading_deg' or 'face'"),
    ({"type": "hold", "seconds": 3, "until": {"sensor": "a"}}, "give 'above', 'below' or both"),
    ({"type": "land", "depth_m": 3}, "lands where the ground is"),
]


@pytest.mark.parametrize(("leg", "message"), UNFIT)
def test_keys_that_do_not_fit_together(leg, message):
    with pytest.raises((ValueError, InputError), match=message):
        legs(leg)


# the plan of a survey


def slope(x, y):
    """A seabed from 10 m at x = 0 to 30 m at x = 100."""
    return -10.0 - 0.2 * np.asarray(x, dtype=float) + 0 * np.asarray(y, dtype=float)


AREA = np.array([[0.0, 0.0], [100.0, 0.0], [100.0, -80.0], [0.0, -80.0]])


def test_lines_lie_as_far_apart_as_the_swath_at_the_depth_there():
    """Lines across the slope (heading east): half a swath is altitude times tan(45 deg), less the overlap."""
    swath = Swath(None, math.radians(90), 0.25)
    lines = survey_lines(AREA, swath, height=slope, depth_m=None, altitude_m=None, heading_rad=math.pi / 2)
    at = np.sort([a[0] for a, b in lines])
    assert all(a[0] == pytest.approx(b[0]) for a, b in lines)
    half = 0.75 * -slope(at, 0)
    assert (at[:-1] + half[:-1] >= at[1:] - half[1:] - 1e-6).all()  # no gap between two lines
    assert at[0] - half[0] <= 1e-6
    assert at[-1] + half[-1] >= 100 - 1e-6
    assert np.diff(at)[1] > 1.2 * np.diff(at)[0] or len(at) < 4  # deeper: wider
    along = {round(b[1] - a[1]) for a, b in lines}
    assert along == {80, -80}  # each against the last


@pytest.mark.parametrize("bearing", [30.0, -25.0])
def test_lines_go_along_the_longest_side_unless_told(bearing):
    """A rectangle of 100 x 40 m whose long side bears 30 degrees; its mirror bears another way."""
    along = np.array([math.cos(math.radians(bearing)), -math.sin(math.radians(bearing))])
    across = np.array([along[1], -along[0]])
    area = np.array([[105.0, -3.0] + a * 100 * along + b * 40 * across for a, b in ((0, 0), (1, 0), (1, 1), (0, 1))])
    lines = survey_lines(area, Swath(10.0, 0.0, 0.0), height=slope, depth_m=None, altitude_m=3.0)
    assert len(lines) == 4
    for a, b in lines:
        assert abs(np.subtract(b, a)[:2] @ along) == pytest.approx(100.0, abs=1e-6)


def test_lines_stay_inside_an_area_that_is_not_convex():
    notch = np.array([[0, 0], [60, 0], [60, -60], [40, -60], [40, -20], [20, -20], [20, -60], [0, -60]], dtype=float)
    lines = survey_lines(
        notch, Swath(10.0, 0.0, 0.0), height=slope, depth_m=None, altitude_m=3.0, heading_rad=0.0
    )  # lines along x: beyond y = -20 the notch cuts them in two
    cut = [(a, b) for a, b in lines if a[1] < -21]
    assert cut
    for a, b in cut:
        assert abs(b[0] - a[0]) == pytest.approx(20.0)


def test_a_line_into_the_seabed_is_refused():
    with pytest.raises(ScenarioError, match=r"at 15 m depth a line from x .* runs into the seabed"):
        survey_lines(AREA, Swath(20.0, 0.0, 0.0), height=slope, depth_m=15.0, altitude_m=None)
    with pytest.raises(ScenarioError, match="lie on one line"):
        survey_lines(AREA[[0, 1, 0]], Swath(20.0, 0.0, 0.0), height=slope, depth_m=1.0, altitude_m=None)


def test_the_middle_line_of_a_pipe():
    s = np.linspace(0, 120, 400)
    middle = np.stack([10 + 0.8 * s, -5 + 0.6 * s + 3 * np.sin(s / 20)], axis=-1)
    ring = 0.4 * np.stack([np.cos(np.arange(12) * np.pi / 6), np.sin(np.arange(12) * np.pi / 6)], axis=-1)
    vertices = np.concatenate([np.c_[middle + r, np.zeros(400)] for r in ring])
    line = middle_line([SimpleNamespace(name="pipe", vertices=vertices)], "pipe", where="m")
    ends = [line[0], line[-1]]
    assert min(np.hypot(*(e - middle[0])) for e in ends) < 1.5
    assert 3 < len(line) < 30
    for p in line:
        assert np.hypot(*(middle - p).T).min() < 0.8
    for seed in range(6):  # in whatever order a body's corners stand
        mixed = np.random.default_rng(seed).permutation(vertices)
        again = middle_line([SimpleNamespace(name="pipe", vertices=mixed)], "pipe", where="m")
        np.testing.assert_allclose(again, line, rtol=0, atol=1e-9)
    with pytest.raises(LookupFailed, match="did you mean 'pipe'"):
        middle_line([SimpleNamespace(name="pipe", vertices=vertices)], "pip", where="m")
    cube = SimpleNamespace(name="cube", vertices=np.random.default_rng(1).uniform(-20, 20, (200, 3)))
    with pytest.raises(ScenarioError, match="no middle line"):
        middle_line([cube], "cube", where="m")


@pytest.mark.parametrize(
    ("corners", "place"),
    [
        ([(-40, -4), (10, -4), (-10, 4), (40, 4)], r"x -?\d+\.\d, y -?[0-4]\.\d m, where it takes 8\.\d m across"),
        ([(-40, -4), (3, -4), (3, 4), (40, 4)], r"x [234]\.\d, y -?[0-4]\.\d m, where it takes 8\.\d m across"),
    ],
)
def test_a_pipe_that_turns_back_or_steps_aside_has_no_one_middle_line(corners, place):
    """Legs 8 m apart, and a step of 8 m, of a pipe 0.5 m thick; the axis of its corners is turned by some degrees."""
    points = np.array(corners, float)
    way = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(points)])
    turn = np.arange(12) * np.pi / 6
    ring = 0.25 * np.stack([np.cos(turn), np.sin(turn)], axis=-1)
    vertices = np.concatenate([np.c_[way + r, np.zeros(len(way))] for r in ring])
    with pytest.raises(ScenarioError, match=place):
        middle_line([SimpleNamespace(name="pipe", vertices=vertices)], "pipe", where="m")


def test_the_rate_of_a_circles_course_is_its_derivative_along_the_way() -> None:
    """Both turns, outside and inside, coming and going.

    A central difference over 2 h is off by h^2 times a sixth of the third derivative, which is below 6 rad/s^3 here.
    """
    rng = np.random.default_rng(4)
    n, h = 60, 1e-4
    center, place = rng.uniform(-30, 30, (n, 2)), rng.uniform(-90, 90, (n, 2))
    radius, turn = rng.uniform(5, 40, n), rng.choice([-1.0, 1.0], n)
    velocity, ahead = rng.uniform(-3, 3, (n, 2)), rng.uniform(4, 30, n)
    place = center + (place - center) * np.maximum(1.0, 8.0 / np.hypot(*(place - center).T))[:, None]
    after, before = (circle_course(center, radius, turn, place + s * h * velocity, ahead) for s in (1, -1))
    expected = wrapped(after - before) / (2 * h)
    rate = circle_rate(center, radius, turn, place, velocity, ahead)
    np.testing.assert_allclose(rate, expected, atol=h**2 + 1e-11 / h)
    assert (np.abs(expected) > 0.01).sum() > 30


def test_a_level_is_reached_from_either_side() -> None:
    there = SimpleNamespace(altitude=np.array([2.0, 4.5, 5.9, 9.0]), depth=np.array([-3.0, 6.5, 7.9, 12.0]))
    assert Level(altitude_m=5.0).reached(there, 1.0).tolist() == [False, True, True, False]
    assert Level(depth_m=7.0).reached(there, 1.0).tolist() == [False, True, True, False]


def test_a_line_ends_lane_by_lane_by_its_distance_its_depth_and_its_way():
    """From (2, -1) to (14, 8): 15 m along (0.8, 0.6). Lanes: near before the end, far before it, far past it, near it
    but deeper by 4 m than asked, near it but shallower, and far aside."""
    x, y = np.array([13.0, 10.0, 18.0, 14.5, 13.5, 12.0]), np.array([7.0, 5.0, 11.0, 8.5, 8.5, -4.0])
    lanes = aboard(x, y, [6.2, 5.9, 6.1, 10.0, 2.0, 6.0])
    progress = Progress.begin(lanes)
    way = {"end": (14.0, 8.0), "start": (2.0, -1.0), "acceptance_m": 3.0, "common": Common(level=Level(depth_m=6.0))}
    assert Line(**way).moves(lanes, progress).tolist() == [1, 0, 1, 1, 1, 0]
    assert Line(**way, exact=True).moves(lanes, progress).tolist() == [1, 0, 0, 0, 0, 0]
    assert Line(**way, again=2).moves(lanes, progress).tolist() == [1, 0, -2, -2, 0, 0]


@pytest.mark.parametrize("turn", [1.0, -1.0])
def test_turns_on_a_circle_count_only_what_was_swept_on_it(turn):
    """Lanes about (3, -2): on the circle, too far out, on it the other way round, too far in; bearings across pi."""
    task = Orbit((3.0, -2.0), 8.0, 0.25, turn)
    radius, sense = np.array([8.5, 12.0, 6.0, 2.0]), np.array([1, 1, -1, 1])
    progress, done = None, []
    for swept in (0.0, 0.7, 1.5, 1.6):
        bearing = 2.9 + turn * sense * swept
        now = aboard(3.0 + radius * np.cos(bearing), -2.0 - radius * np.sin(bearing))
        progress = progress or Progress.begin(now)
        done.append(task.moves(now, progress).tolist())
        np.testing.assert_allclose(progress.memory[:, 2], [swept, 0.0, -swept, 0.0], atol=1e-12)
        assert progress.memory[:, 0].tolist() == [1.0, 0.0, 1.0, 0.0]  # within a quarter of the radius and a metre
    assert done == [[0, 0, 0, 0]] * 3 + [[1, 0, 0, 0]]

"""Documented places of HoloOcean's worlds (holoocean-docs, 2026): free, and within sight of what their pages show."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.compat.holoocean.worlds import native_world
from pelagos.world.build import build_world, world_config
from pelagos.world.label import label_number as number

OPEN_WATER = [
    (620, 170, -291), (35, -40.5, -292.5), (555, 236, -285), (205, 457, -280), (553, 251, -282), (0, 20, -280),
    (140, 30, -280), (170, 10, -276), (175, -92, -266), (10, 10, -5),
]  # fmt: skip
SIMPLE = [(0, 0, -10), (5, -5, -15), (-5, -5, -15), (0, 100, -5), (25, 0, -5), (25, 25, 0), (-25, -25, 0)]
HARBOR = [(-20, 10, -10), (0, -500, 0), (0, -700, -3)]
AHEAD, BELOW = 0.0, np.pi / 2  # pitch of a sonar's axis, nose down [rad]


@pytest.fixture(scope="module")
def world_of():
    made = {}

    def build(name):
        if name not in made:
            made[name] = build_world(world_config(native_world("", name)["world"]))
        return made[name]

    return build


def fan(azimuth, elevation, pitch, yaw=0.0):
    """Directions `(r, 3)` over +-azimuth, +-elevation [deg] about an axis of this pitch (nose down) and yaw [rad]."""
    a, e = np.radians(np.meshgrid(np.linspace(-azimuth, azimuth, 61), np.linspace(-elevation, elevation, 15)))
    rays = np.stack([np.cos(e) * np.cos(a), np.cos(e) * np.sin(a), np.sin(e)], axis=-1).reshape(-1, 3)
    cp, sp, cy, sy = np.cos(pitch), np.sin(pitch), np.cos(yaw), np.sin(yaw)
    turn = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    return rays @ turn.T


def seen(world, at, rays, reach):
    hits = world.cast(np.broadcast_to(np.array(at, dtype=float), rays.shape), rays, reach)
    return {int(v) for v in np.unique(hits.label[hits.valid])}


def carries(world, names):
    return {number(name) for name in names.split()} <= {g.label for g in world.geometries}


@pytest.mark.parametrize("place", OPEN_WATER)
def test_places_in_open_water_are_free(world_of, place):
    assert world_of("OpenWater").inside(place, 1.5) is None


@pytest.mark.parametrize(
    ("at", "rays", "reach", "label"),
    [
        ((620, 170, -291), fan(65, 10, AHEAD), 40, "sub"),
        ((35, -40.5, -292.5), fan(60, 0.5, BELOW), 60, "sub"),
        ((555, 236, -285), fan(85, 0.13, BELOW), 40, "sub"),
        ((553, 251, -282), fan(15, 15, BELOW), 30, "sub"),
        ((205, 457, -280), fan(15, 15, BELOW), 30, "plane"),
    ],
)
def test_sonars_in_open_water_see_wrecks_and_ground(world_of, at, rays, reach, label):
    world = world_of("OpenWater")
    assert {number(label), number("landscape")} <= seen(world, at, rays, reach)


def test_the_way_between_the_documented_waypoints_is_free(world_of):
    way = np.array([(0, 20, -280), (140, 30, -280), (170, 10, -276), (175, -92, -266)], dtype=float)
    legs = np.diff(way, axis=0)
    length = np.linalg.norm(legs, axis=1)
    assert not world_of("OpenWater").cast(way[:-1], legs / length[:, None], length).valid.any()


def test_the_dam_stands_before_the_vehicle_and_the_yard_under_the_husky(world_of):
    world = world_of("Dam")
    assert world.inside((0, 0, -10), 2.0) is None
    assert world.inside((110, -166, 6), 0.6) is None
    facing = fan(65, 10, AHEAD, yaw=np.pi)  # yaw 180
    assert number("wall") in seen(world, (0, 0, -10), facing, 40)
    below = world.cast((110, -166, 6), (0, 0, -1), 20)
    assert below.label[0] == number("asphalt")
    assert 0.3 < below.t[0] < 1.2  # a drop that a ground vehicle survives, onto ground above the water
    ahead = np.array([110, -166, 0]) + np.outer(np.arange(0, 40, 4), [-np.sqrt(0.5), np.sqrt(0.5), 0])  # yaw 135
    assert (world.height(ahead[:, 0], ahead[:, 1]) > 4).all()
    assert carries(world, "pipe pipe_cover vent_cover asphalt rock building railing concrete")


@pytest.mark.parametrize("place", SIMPLE)
def test_places_in_the_basin_are_free(world_of, place):
    world = world_of("SimpleUnderwater")
    assert world.inside(place, 1.0) is None
    assert number("wall") in seen(world, place, fan(180, 1, AHEAD), 300)


@pytest.mark.slow
def test_places_in_the_harbour_are_free_and_a_pier_is_near(world_of):
    world = world_of("PierHarbor")
    for place in HARBOR:
        assert world.inside(place, 1.0) is None
    assert number("pier") in seen(world, (-20, 10, -10), fan(65, 10, AHEAD), 40)
    assert carries(world, "pier wall container_boat boat yacht buoy building trash rock seaweed")


def test_the_campus_is_dry_and_its_houses_can_be_entered(world_of):
    world = world_of("BusinessCampus")
    low, high = world.bounds
    assert (high - low)[:2] == pytest.approx([200, 200], abs=8)
    assert world.inside((0, 0, 1.5), 1.0) is None
    for middle, door in (((45, 35), -1), ((45, -35), 1), ((-10, 60), -1)):
        assert world.inside((*middle, 1.7), 0.4) is None
        street = (middle[0], middle[1] + door * 25, 1.2)
        assert not world.cast(street, (0, -door, 0), 25 - 2).valid[0]  # through the door
        assert world.cast((*middle, 1.7), (0, 0, 1), 5).label[0] == number("ceiling")
    grid = np.stack(np.meshgrid(np.arange(-99, 99, 7.0), np.arange(-99, 99, 7.0)), axis=-1).reshape(-1, 2)
    assert (world.height(grid[:, 0], grid[:, 1]) > 0).all()
    wanted = (
        "building ceiling floor table desk chair car bus semi_truck tree bush bench cone stop_sign asphalt sidewalk"
    )
    assert carries(world, wanted)


def test_the_example_level_fills_its_bounds(world_of):
    world = world_of("ExampleLevel")
    assert world.cast((0, 0, 4), (0, 0, -1), 10).t[0] == pytest.approx(3.95, abs=1e-4)
    assert world.cast((-4.9, 4.9, 4), (0, 0, -1), 10).t[0] == pytest.approx(3.95, abs=1e-4)


class TestTestWorld:
    """The level of HoloOcean's own tests: what they take for granted."""

    @pytest.fixture
    def level(self, world_of):
        return world_of("TestWorld")

    def test_the_floor_is_at_zero_where_agents_land(self, level):
        for x, y in ((0, 0), (-1.5, -1.5), (-10, 7), (-10, 10), (0.95, -1.75)):
            assert level.cast((x, y, 2), (0, 0, -1), 3).t[0] == pytest.approx(2.0, abs=0.05)

    @pytest.mark.parametrize("place", [(0, 0, -10), (18.5, -25.5, -10), (10, 10, 0.15), (0, -50, 0), (10, -30, 0.1)])
    def test_vehicles_start_in_free_water(self, level, place):
        assert level.inside(place, 0.8) is None

    def test_the_wall_is_two_metres_before_the_camera(self, level):
        assert level.cast((0.77, 0.9 - 0.05, 0.5), (1, 0, 0)).t[0] == pytest.approx(2.0, abs=1e-4)
        assert level.cast((0.77, 0.5 + 0.05, 0.5), (1, 0, 0)).t[0] == pytest.approx(2.0, abs=1e-4)

    def test_nothing_stands_within_a_metre_of_the_range_finder(self, level):
        turn = np.linspace(0, 2 * np.pi, 48, endpoint=False)
        rays = np.stack([np.cos(turn), np.sin(turn), 0 * turn], axis=-1)
        assert not level.cast(np.broadcast_to((0.95, -1.75, 0.5), rays.shape), rays, 1.0).valid.any()

    @pytest.mark.parametrize(
        ("one", "other", "free"),
        [((10, -30, 0.1), (-6.5, -30, 0.1), False), ((-10, 10, 0.25), (-10, 7, 0.25), True),
         ((-10, 10, 0.25), (-8, 10, 0.25), True)],
    )  # fmt: skip
    def test_lines_of_sight(self, level, one, other, free):
        way = np.subtract(other, one)
        length = float(np.linalg.norm(way))
        assert bool(level.cast(one, way / length, length).valid[0]) is not free

    def test_a_vessel_grounds_on_the_shoal(self, level):
        assert level.cast((0, -50, 0), (0, 0, -1), 20).t[0] == pytest.approx(3.0, abs=0.01)

    def test_three_layers_lie_side_by_side_near_the_lidar_site(self, level):
        below = [level.cast((47, y, -1), (0, 0, -1), 20) for y in (-66, -58, -50)]
        assert len({int(h.material[0]) for h in below}) == 3
        assert {int(h.label[0]) for h in below} == {number("landscape")}
        rays = fan(180, 20, AHEAD)
        assert level.cast(np.broadcast_to((-6.5, -30, 5.0), rays.shape), rays, 200.0).valid.mean() > 0.1

    def test_far_away_is_empty(self, level):
        rays = fan(180, 80, AHEAD)
        assert not level.cast(np.broadcast_to((-100.0, -100.0, -100.0), rays.shape), rays, 15.0).valid.any()

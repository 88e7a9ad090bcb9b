"""Rays of sonars through water that changes from place to place and in time: fronts, closed forms and integration."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import drjit as dr
import numpy as np
import pytest
from sonar_scenes import DT_NS, StillWater, at, box, context, plane, sphere

from pelagos import jit
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.sensors.sonar.ping.fan import cast_fan
from pelagos.sensors.sonar.ping.ping_spec import Mounting
from pelagos.sensors.sonar.ping.sounder import Sounder, Waters
from pelagos.sensors.sonar.ping.water_around import STATIONS, profiles_around
from pelagos.world.material import MATERIALS

DEEP = -60.0
REACH = 1200.0


@dataclass
class FrontAhead(StillWater):
    """1480 m/s; beyond x = `through` [m], over `width` [m], by `step` [m/s] faster and with a gradient; a struct."""

    through: Any = None
    step: Any = None
    slope: Any = None
    width: float = 0.0

    def sound_speed(self, position, t):
        ahead = position[0] - self.through
        if self.width == 0.0:
            beyond = dr.select(ahead > 0.0, jit.Float64(1.0), 0.0)
        else:
            beyond = 0.5 * (1.0 + dr.tanh(ahead * (2.0 / self.width)))
        return self.speed + beyond * (self.step + self.slope * (position[2] - DEEP))

    def numbers(self, x: float, z: float) -> float:
        """The same with NumPy."""
        beyond = 0.5 * (1.0 + math.tanh((x - float(self.through[0])) * 2.0 / self.width))
        return 1480.0 + beyond * (float(self.step[0]) + float(self.slope[0]) * (z - DEEP))


def water(*, through: float, step: float = 0.0, slope: float = 0.0, width: float = 0.0) -> FrontAhead:
    of = lambda value: dr.opaque(jit.Float64, value)
    return FrontAhead(of(1480.0), of(through), of(step), of(slope), width)


def hits(ocean, geometry, *angles, yaw=0.0, refraction=True):
    """Reduced ranges and places `(rays,)`, `(rays, 3)` of rays at some angles above the horizon [rad]."""
    c, s = np.cos(angles), np.sin(angles)
    rows = len(angles)
    rays = {
        "direction": np.stack([c * math.cos(yaw), c * math.sin(yaw), s], axis=-1),
        "along": np.stack([-s * math.cos(yaw), -s * math.sin(yaw), c], axis=-1),
        "aside": np.zeros((rows, 3)), "lower": np.full(rows, -1e-3), "upper": np.full(rows, 1e-3),
        "weight": np.ones(rows), "beam": np.arange(rows),
    }  # fmt: skip
    sounder = Sounder(Mounting(), context([geometry], ocean=ocean), rays,
                      Waters(100e3, 8.1, refraction=refraction, reach=REACH))  # fmt: skip
    lanes, fan, surfaces, _ = sounder.arguments(at(0.0, 0.0, DEEP))
    view = cast_fan(sounder._context.scene.caster, fan, lanes, surfaces, max_range=REACH)
    return np.array(view.hits.t), np.array(view.hits.position).T, sounder


def wall(x: float, y: float = 0.0):
    return box((x + 0.5, y, DEEP), (1.0, 800.0, 800.0))


@pytest.mark.parametrize("step", [24.0, -17.0])
def test_times_add_up_across_a_front(step):
    """c0 (d/c0 + (D - d)/c1), with the front placed by the nearest station's share: half a spacing times dc/c."""
    t, place, _ = hits(water(through=620.0, step=step), wall(900.0), 0.0)
    exact = 1480.0 * (620.0 / 1480.0 + 280.0 / (1480.0 + step))
    assert t[0] == pytest.approx(exact, abs=0.5 * REACH / STATIONS * abs(step) / 1480.0)
    assert abs(t[0] - 900.0) > 3.0
    assert place[0, 0] == pytest.approx(900.0, abs=0.1)


@pytest.mark.parametrize("degrees", [-1.5, 1.0])
def test_snells_law_across_a_vertical_front(degrees):
    """Along the boundary sin(theta)/c stays: beyond it the ray is steeper where the water is faster."""
    sine = math.sin(math.radians(degrees))
    _, place, _ = hits(water(through=300.0, step=45.0), wall(1000.0), math.radians(degrees))
    beyond = math.asin(sine * 1525.0 / 1480.0)
    edge = (math.floor(300.0 / 75.0) + 0.0) * 75.0  # a station's share ends at a multiple of the spacing
    exact = edge * math.tan(math.radians(degrees)) + (1000.0 - edge) * math.tan(beyond)
    slack = 75.0 * abs(math.tan(beyond) - math.tan(math.radians(degrees)))
    assert place[0, 2] - DEEP == pytest.approx(exact, abs=slack + 0.02)
    assert abs(place[0, 2] - DEEP) > abs(1000.0 * math.tan(math.radians(degrees))) + 2 * slack


@pytest.mark.parametrize(("yaw", "degrees"), [(0.0, 0.5), (0.0, -2.0), (0.26, 1.0)])
def test_rays_through_a_front_are_those_of_the_integrated_equations(yaw, degrees):
    """d theta = -(cos(theta) c_z - sin(theta) c_r)/c ds in the ray's vertical plane, by Runge-Kutta steps of 0.5 m.

    A front 600 m off, 200 m wide, behind which a gradient of 0.12 1/s bends rays by up to 12 m over the rest. Stations
    75 m apart take the water of their middle: second order, (75/200)^2/24 of that, and the plane of a way at 15 deg
    is that of the nearest sector: a level of cm, taken as 3 % of the bend.
    """
    ocean = water(through=600.0, slope=0.12, step=-6.0, width=200.0)
    t, place, _ = hits(ocean, wall(1000.0 * math.cos(yaw)), math.radians(degrees), yaw=yaw)
    state = np.array([0.0, DEEP, math.radians(degrees), 0.0])

    def rate(s):
        r, z, theta, _ = s
        c = lambda r, z: ocean.numbers(r * math.cos(yaw), z)
        slope_z = (c(r, z + 0.01) - c(r, z - 0.01)) / 0.02
        slope_r = (c(r + 0.01, z) - c(r - 0.01, z)) / 0.02
        turn = -(math.cos(theta) * slope_z - math.sin(theta) * slope_r) / c(r, z)
        return np.array([math.cos(theta), math.sin(theta), turn, 1480.0 / c(r, z)])

    h = 0.5
    while state[0] < 1000.0:
        k1 = rate(state)
        k2 = rate(state + h / 2 * k1)
        k3 = rate(state + h / 2 * k2)
        k4 = rate(state + h * k3)
        state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
    state = state + (1000.0 - state[0]) / rate(state)[0] * rate(state)
    straight = DEEP + 1000.0 * math.tan(math.radians(degrees))
    bend = abs(state[1] - straight)
    assert bend > 3.0
    assert place[0, 2] == pytest.approx(state[1], abs=0.03 * bend + 0.05)
    assert t[0] == pytest.approx(state[3], abs=0.05)


def test_water_behind_a_sonar_is_not_ahead_of_it():
    """Looking away from the front a ray goes straight; the water at the sonar has no gradient."""
    ocean = water(through=600.0, slope=0.12, width=200.0)
    _, place, sounder = hits(ocean, wall(-900.0), 0.01, yaw=math.pi)
    assert sounder._varied
    assert place[0, 2] - DEEP == pytest.approx(900.0 * math.tan(0.01), abs=0.15)


@dataclass
class LaterWater(StillWater):
    """Even water until `since` [s], layered afterwards; a struct."""

    since: Any = None

    def sound_speed(self, position, t):
        return self.speed + dr.select(t >= self.since, 0.8 * (position[2] - DEEP), 0.0 * position[2])


@pytest.mark.parametrize(("since", "bent"), [(3 * 3600.0, True), (80 * 3600.0, False)])
def test_refraction_is_switched_on_by_water_at_any_time_of_the_day(since, bent):
    ocean = LaterWater(dr.opaque(jit.Float64, 1500.0), dr.opaque(jit.Float64, since))
    config = ImagingSonarConfig(beams=8, bins=64, rays_per_beam=8, range_max_m=120.0)
    sonar = ImagingSonar(config, context([plane(-100.0)], ocean=ocean))
    assert sonar._pinger._sounder.bent is bent
    assert not sonar._pinger._sounder._varied


def test_even_and_layered_water_cost_no_stations():
    still = hits(StillWater(dr.opaque(jit.Float64, 1500.0)), wall(900.0), 0.0)[2]
    assert still.bent
    assert not still._varied
    assert not hits(water(through=620.0, step=0.3), wall(900.0), 0.0, refraction="auto")[2].bent
    assert hits(water(through=620.0, step=24.0), wall(900.0), 0.0, refraction="auto")[2]._varied


def test_auto_sees_a_front_one_kilometre_off_without_any_world():
    """Open water has no bounds: twice the reach around the origin is looked at."""
    found = hits(water(through=1000.0, slope=0.12, width=100.0), wall(50.0), 0.0, refraction="auto")[2]
    assert found.bent
    assert found._varied


def test_each_lane_has_the_water_of_its_own_place():
    """Two places and moments in one call are what each alone is: nearer to the front, and later."""
    config = ImagingSonarConfig(
        beams=8, bins=256, rays_per_beam=16, range_max_m=400.0, rate_hz=1.0, horizontal_aperture_deg=20.0,
        frequency_hz=60e3, bandwidth_hz=4e3, vertical_beamwidth_deg=6.0,
    )  # fmt: skip
    sonar = ImagingSonar(config, context([plane(-75.0)], ocean=water(through=260.0, slope=0.5, step=9.0, width=60.0)))
    places = np.array([[0.0, 3.0, DEEP], [140.0, -8.0, DEEP + 4.0]])
    both = sonar.sense(lanes([3, 4], dt_ns=DT_NS, position=places)).truth
    for k in range(2):
        assert np.array_equal(both[k], sonar.sense(at(*places[k], tick=3 + k)).truth[0])
    assert np.abs(both[0] - both[1]).max() > 0.1


def test_nearly_level_rays_over_deep_water_bend_as_their_arc_says():
    """g x^2/(2 c) with 1.2 km of water below, whose integral of the sound speed is 8 000 times that of the rise."""
    ocean = water(through=-1e5, slope=0.12)
    _, place, _ = hits(ocean, wall(600.0), 0.013)
    exact = 600.0 * math.tan(0.013) - 600.0**2 * 0.12 / (2 * 1480.0) / math.cos(0.013) ** 2
    assert place[0, 2] - DEEP == pytest.approx(exact, abs=0.01 + 75.0**2 * 0.12 / 1480.0 / 8)


@dataclass
class SlopingWater(StillWater):
    """Sound speed that differs along all axes; a struct."""

    def sound_speed(self, position, t):
        return self.speed + 0.01 * position[0] - 0.03 * position[1] + 0.2 * (position[2] + 50.0)


def test_stations_stand_where_rays_go():
    """Every 15 deg of the compass, at the middles of 16 parts of the reach, about each of two places."""
    places = jit.Array3f64([5.0, -70.0], [-3.0, 40.0], [-50.0, -60.0])
    around = profiles_around(
        SlopingWater(dr.opaque(jit.Float64, 1500.0)), places, jit.Float64([0.0, 9.0]), reach=320.0, bottom=-200.0
    )
    for lane, (x, y, z) in enumerate(np.array(places).T):
        for azimuth, away in ((0.05, 4.0), (1.35, 111.0), (-2.6, 319.0), (3.13, 250.0)):
            direction = jit.Array3f(math.cos(azimuth), math.sin(azimuth), 0.0)
            row = int(around.row(jit.UInt32(lane), direction, jit.Float(away))[0])
            sector, station = round(azimuth / (math.pi / 12)) * math.pi / 12, (away // 20.0 + 0.5) * 20.0
            there = x + station * math.cos(sector), y + station * math.sin(sector)
            exact = 1500.0 + 0.01 * there[0] - 0.03 * there[1] + 0.2 * (z + 50.0)
            assert float(np.array(around.profile.speed)[row]) == pytest.approx(exact, abs=1e-3)


def test_small_and_smooth_things_come_at_the_time_of_their_way():
    """A steel sphere of 0.5 m and a smooth wall behind a front 250 m off: c0 (d/c0 + (D - d)/c1), as rays have it.

    Bins of 0.1 m; the front counts from the nearest of 16 stations a way, half of 25 m times 2 %.
    """
    keys = {"beams": 9, "horizontal_aperture_deg": 9.0, "vertical_beamwidth_deg": 3.0, "bins": 4000, "iq": True,
            "range_max_m": 400.0, "rate_hz": 1.0, "frequency_hz": 100e3, "bandwidth_hz": 8e3, "rays_per_beam": 32,
            "self_noise_db": -100.0, "source_level_db": 230.0}  # fmt: skip
    ocean = water(through=250.0, step=30.0)
    for thing, near in ((sphere((350.0, 0.0, DEEP), 0.5), 349.5), (wall(350.0), 350.0)):
        for refraction in (True, False):
            scene = context([thing], materials=(MATERIALS["steel"],), ocean=ocean)
            s = ImagingSonar(ImagingSonarConfig(**keys, refraction=refraction), scene)
            heard = np.abs(s.sense(at(0.0, 0.0, DEEP)).extras["iq"][0, 4])
            found = float(s.tables["range"][heard.argmax()])
            exact = 250.0 + (near - 250.0) * 1480.0 / 1510.0 if refraction else near
            assert found == pytest.approx(exact, abs=0.4), (thing.instance, refraction)

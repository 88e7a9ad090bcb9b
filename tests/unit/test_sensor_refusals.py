"""What sensors refuse, what they say of a reading, and branches that few settings take."""

from __future__ import annotations

import math
import sys
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from pydantic import ValidationError

from pelagos import jit
from pelagos.acoustics.bearing import direction_from_phases
from pelagos.acoustics.channel import delay_spread, impulse_response
from pelagos.acoustics.section import Section, _levels
from pelagos.config import registry
from pelagos.contact.broad_phase import close_pairs
from pelagos.contact.impulse import _collide_island
from pelagos.errors import KernelError, LookupFailed, ScenarioError, ValidityWarning
from pelagos.navigation.error_state import Lanes
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.optics.film import FilmCurve, film
from pelagos.optics.light_field import seen_through
from pelagos.sensors.camera.picture.camera_rays import project_points
from pelagos.sensors.comms.hydrophone import HydrophoneConfig
from pelagos.sensors.comms.lbl import LblConfig
from pelagos.sensors.comms.link.budget import NOTHING
from pelagos.sensors.comms.link.carrier import Light, _stands_between
from pelagos.sensors.comms.link.medium import SharedMedium
from pelagos.sensors.comms.link.transponders import _check_carrier
from pelagos.sensors.comms.link.water_paths import WaterPaths
from pelagos.sensors.comms.modem import ModemConfig
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.lidar.range_finder import RangeFinderConfig
from pelagos.sensors.navigation.magnetometer import MagnetometerConfig, earth_field_of
from pelagos.sensors.noise import BatchPath, part_path
from pelagos.sensors.ray_sensor import RaySensor, _spread
from pelagos.sensors.sensor import Reading, SensorConfig, SensorContext
from pelagos.sensors.sonar.incidence_sonar import IncidenceSonarConfig
from pelagos.sensors.sonar.multibeam import MultibeamConfig
from pelagos.sensors.sonar.ping.elements import steering_speed
from pelagos.sensors.sonar.ping.interference import Neighbours
from pelagos.sensors.sonar.ping.listener import _edge_angle
from pelagos.sensors.sonar.ping.medium import medium_of
from pelagos.sensors.sonar.ping.multibeam_column import Column
from pelagos.sensors.sonar.ping.targets import Band, _form
from pelagos.world.build import build_world, world_config
from pelagos.world.material import MATERIALS

DT = 100_000_000


def sensor(name: str):
    return registry.find("sensor", name).load()


PINGER = {"position_m": [0, 0, -5], "frequency_hz": 900.0}


@pytest.mark.parametrize(("kind", "keys", "said"), [
    (HydrophoneConfig, {"pingers": {"p": {**PINGER, "pulse_s": 0.6, "period_s": 0.5}}},
     r"pinger 'p': pulse_s 0\.6 is longer than period_s 0\.5"),
    (HydrophoneConfig, {"pingers": {"p": {**PINGER, "pulse_s": 0.5, "period_s": 0.5}}}, ""),
    (LblConfig, {"frequency_hz": 1e4, "bandwidth_hz": 2e4}, "bandwidth_hz 20000 does not fit around frequency_hz 1"),
    (LblConfig, {"frequency_hz": 1e4, "bandwidth_hz": 1.99e4}, ""),
    (ModemConfig, {"frequency_hz": 1e4, "bandwidth_hz": 2e4}, "bandwidth_hz 20000 does not fit around frequency_hz 1"),
    (ModemConfig, {"beacon_bytes": 33, "packet_max_bytes": 32}, "beacon_bytes 33 is more than packet_max_bytes 32"),
    (ModemConfig, {"beacon_bytes": 32, "packet_max_bytes": 32}, ""),
    (RangeFinderConfig, {"azimuth_deg": [0, 10], "elevation_deg": [0]},
     "azimuth_deg and elevation_deg are of the same rays; given 2 and 1"),
    (IncidenceSonarConfig, {"range_min_m": 10, "range_max_m": 10}, "range_min_m 10 must be below range_max_m 10"),
    (IncidenceSonarConfig, {"range_min_m": 9.9, "range_max_m": 10}, ""),
])  # fmt: skip
def test_settings_that_cannot_be_are_refused(kind, keys, said):
    needed = {"transponders": {"a": {"position_m": [40.0, 20.0, -6.0]}}} if kind is LblConfig else {}
    needed |= {"sample_rate_hz": 4000.0} if kind is HydrophoneConfig else {}
    if said:
        with pytest.raises(ValidationError, match=said):
            kind(**needed, **keys)
    else:
        kind(**needed, **keys)


def test_a_modem_is_a_mapping():
    with pytest.raises(ValidationError, match="valid dictionary or instance of ModemConfig"):
        ModemConfig.model_validate(3)


def test_ais_needs_its_package(monkeypatch):
    ais = sensor("ais")
    monkeypatch.setitem(sys.modules, "pyais", None)
    with pytest.raises(ScenarioError, match=r"ais needs the package pyais; pip install 'pelagos\[communication\]'"):
        ais(ais.Config(), SensorContext.alone())


def test_instruments_of_the_earth_need_a_place_on_it():
    gps = sensor("gps")
    nowhere = replace(SensorContext.alone(), world=SimpleNamespace(origin=None))
    with pytest.raises(
        ScenarioError, match="a gps needs a world with a geographic origin; give the scenario an 'origin'"
    ):
        gps(gps.Config(), nowhere)
    field = {"intensity_t": 5e-5, "declination_deg": 30.0, "inclination_deg": 60.0}
    found = earth_field_of(MagnetometerConfig(**field), None)
    north = 2.5e-5
    np.testing.assert_allclose(found, [north * math.cos(math.pi / 6), -north / 2, -5e-5 * math.sin(math.pi / 3)])
    with pytest.raises(
        ScenarioError, match="a magnetometer needs a world with a geographic origin, or the field: inten"
    ):
        earth_field_of(MagnetometerConfig(), None)


def test_a_target_that_is_carried_needs_a_simulation():
    alone = SensorContext.alone("auv0.usbl")
    with pytest.raises(
        ScenarioError, match="'buoy' is carried by 'boat': it needs a simulation, with that vehicle in it"
    ):
        _check_carrier(alone, "targets", "buoy", "boat")
    together = replace(alone, medium=SimpleNamespace(agents=("auv0", "boat")))
    _check_carrier(together, "targets", "buoy", "boat")
    with pytest.raises(LookupFailed, match=r"agents\.auv0\.sensors\.usbl\.targets.*'boot' .did you mean 'boat'"):
        _check_carrier(together, "targets", "buoy", "boot")


def test_a_modem_is_found_by_path_vehicle_and_address():
    ports = {"a.x": 1, "a.y": 2, "b.x": 3}
    medium = SimpleNamespace(modems={path: SimpleNamespace(address=k) for path, k in ports.items()})
    assert [SharedMedium.find(medium, n) for n in ("a.y", "b", "1", "3")] == ["a.y", "b.x", "a.x", "b.x"]
    for name in ("a", "4"):
        with pytest.raises(LookupFailed, match=f"unknown modem '{name}'"):
            SharedMedium.find(medium, name)


def test_sonars_to_be_heard_are_known_by_name():
    near = SimpleNamespace(paths=("a.sonar", "b.sonar", "b.dvl"))
    chosen = lambda names: Neighbours.chosen(near, names, "a.sonar")
    assert (chosen("others"), chosen("none"), chosen(["b.dvl"])) == (["b.sonar", "b.dvl"], [], ["b.dvl"])
    said = r"agents\.a\.sensors\.sonar\.hears: unknown sonar that can be heard 'b\.sonr' .did you mean 'b\.sonar'"
    with pytest.raises(LookupFailed, match=said):
        chosen(["b.dvl", "b.sonr"])


def test_packets_are_those_of_modems():
    reading = lambda **extras: SimpleNamespace(extras=extras, frame="auv0/imu")
    with pytest.raises(AttributeError, match="the reading of auv0/imu has no packets; modems have"):
        Reading.packets.fget(reading())
    assert Reading.packets.fget(reading(packets=[("p", "q")])) == ["p", "q"]
    assert Reading.packets.fget(reading(packets=[("p",), ()])) == [["p"], []]


class PatternConfig(SensorConfig):
    type: str = "pattern"


class Reaching(PatternConfig):
    range_max_m: float = 30.0


class Bare(RaySensor):
    Config = PatternConfig


@pytest.mark.parametrize(("pattern", "said"), [
    ([1.0, 0, 0], r"Bare\.pattern gives directions of shape \(r, 3\), not \(3,\)"),
    ([[1.0, 0]], r"of shape \(r, 3\), not \(1, 2\)"),
    (np.zeros((0, 3)), r"of shape \(r, 3\), not \(0, 3\)"),
    ([[1.0, 0, 0], [0, 0, 0]], r"Bare\.pattern: direction 1 is \[0\.0, 0\.0, 0\.0\], which points nowhere"),
    ([[np.nan, 0, 1]], r"direction 0 is \[nan, 0\.0, 1\.0\], which points nowhere"),
])  # fmt: skip
def test_rays_of_ones_own_sensor_point_somewhere(pattern, said):
    bare = Bare.__new__(Bare)
    with pytest.raises(KernelError, match=said):
        bare._unit_directions(pattern)
    np.testing.assert_allclose(bare._unit_directions([[0, 3, -4]]), [[0, 0.6, -0.8]])


def test_a_sensor_of_ones_own_says_what_it_lacks():
    bare = Bare.__new__(Bare)
    with pytest.raises(
        NotImplementedError, match=r"Bare needs pattern\(self, config\): directions \(r, 3\) of its rays"
    ):
        bare.pattern(None)
    with pytest.raises(
        NotImplementedError, match=r"Bare needs read\(self, hits, medium, draw, rays\): results by name"
    ):
        bare.read(None, None, None, 1)
    with pytest.raises(KernelError, match=r"PatternConfig has no key range_max_m: give it one, or Bare a method reach"):
        bare.reach(PatternConfig(rate_hz=1))
    assert bare.reach(Reaching(rate_hz=1)) == 30
    found = _spread([jit.Float64(2.0), 3, (jit.Float64(4.0), "a")], 2)
    assert [np.array(found[0]).tolist(), found[1], np.array(found[2][0]).tolist(), found[2][1]] == [
        [2, 2],
        3,
        [4, 4],
        "a",
    ]


def test_a_part_of_a_batch_has_the_noise_of_each_members_part():
    batch = BatchPath.of(("a.sonar", "b.sonar"), range(3))
    assert part_path(batch, "port").members == ("a.sonar.port", "b.sonar.port")
    assert part_path(batch, "port").environments == range(3)
    assert part_path("a.sonar", "port") == "a.sonar.port"


def test_one_beam_looks_ahead_and_has_the_whole_swath():
    one = MultibeamConfig(beams=1, swath_deg=20)
    np.testing.assert_array_equal(one.swath_angles, [0])
    sectors = Column.sectors.fget
    np.testing.assert_array_equal(sectors(SimpleNamespace(angles=np.array([0.1]), swath=0.35)), [0.35])
    np.testing.assert_allclose(sectors(SimpleNamespace(angles=np.array([0.3, 0.1, -0.2]), swath=9)), [0.2, 0.25, 0.3])


def test_a_direction_beyond_the_plane_of_its_elements_lies_in_it():
    """Of an array in the xy plane; phases of a wave that would be shorter than it is."""
    elements = np.array([[0.1, 0.1, 0.0], [-0.1, 0.1, 0.0], [-0.1, -0.1, 0.0], [0.1, -0.1, 0.0]])
    towards = lambda v: np.exp(1j * 2 * np.pi / 0.5 * elements @ np.array(v))
    found = direction_from_phases(elements, towards([0.72, 0.96, 0.0]), 0.5, np.array([0.6, 0.8, 0.0]))
    np.testing.assert_allclose(found, [0.6, 0.8, 0.0], atol=1e-9)
    up = direction_from_phases(elements, towards([0.48, 0.36, 0.0]), 0.5, np.array([0.5, 0.4, 0.7]))
    np.testing.assert_allclose(up, [0.48, 0.36, 0.8], atol=1e-9)


def test_no_paths_are_no_channel():
    none = np.zeros(0)
    for keys, start, taps in (({}, 0.0, 0), ({"start": 0.2, "taps": 5}, 0.2, 5)):
        began, made = impulse_response(none, none.astype(complex), carrier=1e4, sample_rate=4e3, **keys)
        assert began == start
        np.testing.assert_array_equal(made, np.zeros(taps))
    assert delay_spread(none, none) == 0
    assert delay_spread(np.array([0.1, 0.3]), np.zeros(2)) == 0
    assert delay_spread(np.array([0.1, 0.3]), np.array([1.0, 1j])) == pytest.approx(0.1)
    assert delay_spread(np.array([0.1, 0.3]), np.array([-2.0, 1j])) == pytest.approx(0.08)  # powers 4 and 1


def test_one_body_meets_nobody():
    pairs = close_pairs(np.zeros((1, 3)), np.ones(1), np.zeros(1, np.int64))
    assert pairs.shape == (0, 2)
    assert close_pairs(np.zeros((2, 3)), np.ones(2), np.zeros(2, np.int64)).tolist() == [[0, 1]]


def test_nothing_stands_between_antennas_that_touch():
    class Wall:
        def cast(self, *_, **__):
            return SimpleNamespace(valid=np.array([True]))

    between = lambda d: _stands_between(Wall(), np.zeros(3), np.array([d, 0, 0]), 0, 1)
    found = [between(d) for d in (0.0, 0.01, 50.0)]
    assert found == [False, False, True]


@pytest.fixture(scope="module")
def ground() -> SensorContext:
    return SensorContext.alone("auv0.it", world={"type": "flat", "depth_m": 8.0}, dt_ns=DT)


EXPLAINED = {  # by name: which of a reading's data it is, and its settings
    "thermal_camera": ({"apparent temperature": "truth"}, {"width_px": 32, "height_px": 32}),
    "event_camera": ({}, {"width_px": 32, "height_px": 32}),
    "lidar": ({}, {"channels": 3, "points_per_second": 240}),
    "semantic_lidar": ({}, {"channels": 3, "points_per_second": 240}),
    "incidence_sonar": ({}, {}),
    "hydrophone": ({"pressure": "data", "pressure without noise": "truth"},
                   {"sample_rate_hz": 4000.0, "pingers": {"p": PINGER}}),
    "lbl": ({"range": "data"}, {"transponders": {"a": {"position_m": [40.0, 20.0, -6.0]}}}),
    "range_bearing": ({}, {"targets": {"a": {"position_m": [40.0, 20.0, -6.0]}}}),
    "collision": ({}, {}),
    "modem": ({}, {}), "optical_modem": ({}, {}), "radio": ({}, {}), "ais": ({}, {}),
}  # fmt: skip


@pytest.mark.parametrize("name", EXPLAINED)
def test_sensors_explain_a_reading(name, ground):
    same, keys = EXPLAINED[name]
    kind = sensor(name)
    up = name in ("thermal_camera", "radio", "ais", "lidar", "semantic_lidar")
    motion = lanes([7], dt_ns=DT, position=[(0.0, 0.0, 3.0 if up else -4.0)])
    made = kind(kind.Config(rate_hz=10, **keys), ground)
    told = made.explain(motion)
    assert told
    for what, values, unit in told:
        assert isinstance(what, str)
        assert isinstance(unit, str)
        assert np.asarray(values).size
    found = {what: np.asarray(values, float) for what, values, _ in told}
    if name == "event_camera":  # whole thresholds, from a phase below one on, and one of the background
        crossed = found["change of log luminance"] / found["threshold"]
        assert found["change of log luminance"].std() > 0
        assert (np.abs(found["events"] - crossed) <= 2).all()
        return
    again = made.sense(motion)
    for what, part in same.items():
        read = np.asarray(getattr(again, part), float)
        np.testing.assert_allclose(
            np.unique(found[what].ravel()), np.unique(read), rtol=1e-5
        )  # pixels in another order
    if name == "range_bearing":
        np.testing.assert_array_equal(np.stack([found[k] for k in ("range", "azimuth", "elevation")], -1), again.data)
    if name in ("lidar", "semantic_lidar"):
        assert np.isfinite(found["range"]).any()
        assert (found["range"][np.isfinite(found["range"])] > 0).all()
    if name == "modem":
        chance = found["probability of a full packet"]
        assert (np.diff(found["snr"]) > 0).all()
        assert (np.diff(chance) >= 0).all()
        assert chance[0] < 0.01 < 0.99 < chance[-1]
    if name == "collision":
        assert not found["contact force"].any()


@pytest.mark.parametrize("name", ["modem", "optical_modem", "radio"])
def test_a_link_without_a_simulation_is_silent(name, ground):
    kind = sensor(name)
    read = kind(kind.Config(rate_hz=10), ground).sense(lanes([1, 2, 3], dt_ns=DT, position=[(0, 0, -4.0)] * 3))
    assert read.data.shape == (3, 5)
    assert not read.data.any()
    assert [list(p) for p in read.extras["packets"]] == [[], [], []]


def test_a_world_that_is_built_serves_a_sensor_alone():
    world = build_world(world_config({"type": "flat", "depth_m": 8.0}))
    assert SensorContext.alone(world=world).world is world


def test_a_probe_drifts_as_its_time_says():
    """A Gauss-Markov process: its deviation, and exp(-dt/T) between readings T apart."""
    oxygen = sensor("oxygen")
    ocean = {"tracers": {"oxygen": 240.0}}
    keys = {"noise_density": 0, "bias_std": 0, "resolution": 0, "drift_std": 0.5, "drift_time_s": 0.1}
    probe = oxygen(oxygen.Config(**keys), SensorContext.alone(ocean=ocean, dt_ns=DT))
    ticks = range(20_000)
    off = probe.sense(lanes(ticks, dt_ns=DT, position=[(0, 0, -4.0)] * len(ticks))).data.ravel() - 240
    assert off.std() == pytest.approx(0.5, rel=0.04)  # straight between knots, which are closer than T
    assert np.corrcoef(off[1:], off[:-1])[0, 1] == pytest.approx(math.exp(-1), abs=0.04)


def test_scatterers_without_scattering_are_warned_of(ground):
    sonar = sensor("imaging_sonar")
    keys = {"beams": 16, "bins": 32, "volume_scatterers_per_m3": 20.0}
    with pytest.warns(
        ValidityWarning, match=r"auv0\.it: 'volume_scatterers_per_m3' changes nothing without 'volume_scat"
    ):
        sonar(sonar.Config(**keys), ground)
    sonar(sonar.Config(**keys, volume_scattering_db=-50.0), ground)


def test_a_standard_sphere_of_tungsten_carbide_rings():
    """38.1 mm at 38 kHz: -42.4 dB (K. G. Foote et al., ICES Coop. Res. Rep. 144, 1987)."""
    sphere = SimpleNamespace(solid=SimpleNamespace(kind="sphere", radius=0.01905))
    band = Band(38_000.0, 1000.0, 100.0, 50.0)
    strength = lambda name: 20 * math.log10(_form(sphere, MATERIALS[name], band))
    assert strength("tungsten_carbide") == pytest.approx(-42.4, abs=0.5)
    rigid = 20 * math.log10(0.01905 / 2)
    assert abs(strength("steel") - rigid) < 6
    box = SimpleNamespace(solid=SimpleNamespace(kind="box", radius=0.01905))
    assert _form(box, MATERIALS["steel"], band) == 0


def test_a_film_keeps_middle_grey_with_a_long_toe_too():
    for toe in (0.5, 0.8, 0.81, 0.9):
        seen = np.array(film(jit.Float([0.01, 0.18, 1.0]), FilmCurve(toe=toe)))
        assert seen[1] == pytest.approx(0.18, abs=2e-3)
        assert (np.diff(seen) > 0).all()


def test_a_light_field_without_local_water_is_the_same_everywhere():
    field = SimpleNamespace(local=None)
    assert seen_through(field, None, None, None) is field


def test_water_that_is_alike_and_flat_needs_no_tables():
    sea = build_ocean(OceanConfig())
    place, t = jit.Array3f64(0.0, 0.0, -5.0), jit.Float64(0.0)
    assert sea.heaviness(place, t) is None
    assert sea.waves_along(tuple(place), (1.0, 0.0, 0.0), 2.0, t) is None
    wavy = build_ocean(OceanConfig.model_validate({"waves": {"type": "regular", "height_m": 1, "period_s": 6}}))
    assert wavy.waves_along(tuple(place), (1.0, 0.0, 0.0), 2.0, t) is not None


def test_things_that_nothing_moves_push_nobody():
    zero = np.zeros((2, 6, 6))
    impulses = np.zeros((2, 6))
    contacts = SimpleNamespace(first=np.array([0]), second=np.array([1]))
    _collide_island(contacts, SimpleNamespace(inverse_mass=zero), np.array([0, 1]), 0.01, impulses)
    assert not impulses.any()


def test_a_scene_without_moving_things_takes_no_poses(ground):
    scene = ground.scene
    scene.move(np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), np.zeros((1, 3)), np.zeros((1, 3)))
    assert scene.moving is None
    assert scene._poses is None


def test_light_in_the_air_is_lost():
    light = SimpleNamespace(ocean=build_ocean(OceanConfig()))
    pose = lambda z: SimpleNamespace(position=np.array([[0.0, 0.0, z]]))
    for a, b in ((0.5, -3.0), (-3.0, 0.5)):
        heard = Light.hear(light, (0, 1, 0), {0: pose(a), 1: pose(b)}, 0.0, light)
        assert (heard.lost, heard.level_db) == ("in air", NOTHING)


def test_the_profile_of_a_section_reaches_the_surface():
    """As its first level: with that level given at the surface too, the table is the same."""
    depth, speed = np.array([5.0, 20.0]), np.array([[1500.0, 1480.0], [1510.0, 1470.0]])
    loss, begins = 1e-3 * speed - 1.4, np.array([0.0, 300.0])
    deep = _levels(Section(depth, speed, absorption=loss, begins=begins), 2)
    whole = lambda a: np.concatenate([a[:, :1], a], axis=1)
    full = _levels(Section(np.array([0.0, 5.0, 20.0]), whole(speed), absorption=whole(loss), begins=begins), 2)
    for a, b in zip(deep, full, strict=True):
        np.testing.assert_array_equal(a, b)
    assert deep[0][0] == 0


def test_lanes_of_a_filter_are_replaced():
    row = lambda k, n: [np.full((n, 3), k)] * 3 + [np.full(22, k)]
    lanes_of = Lanes.at(*row(1.0, 3))
    lanes_of.put(np.array([2, 0]), Lanes.at(*row(2.0, 2)))
    for key, values in vars(lanes_of).items():
        one, two = (vars(Lanes.at(*row(k, 1)))[key][0] for k in (1.0, 2.0))
        np.testing.assert_array_equal(values, [two, one, two], err_msg=key)


def test_a_point_is_seen_at_its_angle_through_a_fisheye():
    config = sensor("camera").Config(lens="fisheye", width_px=64, height_px=48, horizontal_fov_deg=90.0)
    angle = np.array([0.1, 0.2, 0.4])
    seen = project_points(np.stack([5 * np.cos(angle), 5 * np.sin(angle), 0 * angle], -1), config)
    middle = project_points(np.array([[3.0, 0.0, 0.0]]), config)[0]
    off = middle[0] - seen[:, 0]
    np.testing.assert_allclose(off / off[0], [1, 2, 4], rtol=1e-6)
    np.testing.assert_allclose(seen[:, 1], middle[1])


def test_water_at_a_sonar_alone_is_that_along_rays_of_no_length():
    sea = build_ocean(OceanConfig.model_validate({"temperature_c": {"depth_m": [0, 50], "value": [20, 10]}}))
    place, t = jit.Array3f64(0.0, 0.0, -25.0), jit.Float64(0.0)
    alone, along = (medium_of(200e3, 8.0, reach=r, bottom=-60.0)(sea, place, t) for r in (0.0, 30.0))
    assert alone.column is None
    assert along.column is not None
    assert np.array(alone.absorption) == pytest.approx(np.array(along.absorption), rel=1e-3)
    assert np.array(alone.sound_speed) == pytest.approx(np.array(along.sound_speed))
    for given, speed in ((None, np.array(alone.sound_speed)), (1480.0, [1480.0])):
        assert np.array(steering_speed(SimpleNamespace(sound_speed_mps=given), alone)) == pytest.approx(speed)


def test_nothing_is_met_where_nothing_is():
    water = SimpleNamespace(_scene=SimpleNamespace(static=None, moving=None))
    met = WaterPaths._ask(water, *(np.zeros((3, 3)),) * 2, np.ones(3), np.zeros(3, int), np.zeros(3, np.uint32))
    assert np.isinf(met["t"]).all()
    assert not met["label"].any()


def test_a_single_beam_is_all_around():
    index = jit.UInt32([0, 1])
    found = np.array(_edge_angle(None, None, None, index, 1))
    np.testing.assert_allclose(found, [np.pi, -np.pi], rtol=1e-6)

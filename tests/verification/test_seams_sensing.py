"""Signs, factors and axes at the seams of sensors and their physics: closed forms, inputs of both signs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import drjit as dr
import numpy as np
import pytest

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.bottom_detection import amplitude_error
from pelagos.acoustics.doppler import echo_margin_db
from pelagos.optics.caustics import focusing, ripple, waves_at
from pelagos.optics.interface import refract
from pelagos.optics.lamp import Beam, axis_intensity, lamp_beam_at
from pelagos.optics.roughness import long_mean_square_slope, mean_square_slope
from pelagos.optics.swell import swell_around
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.sensors.lidar.lidar import LidarConfig
from pelagos.sensors.lidar.scan.laser import scan_pattern
from pelagos.sensors.sonar.sidescan import SidescanConfig, side_rays


@pytest.mark.parametrize("depression", [15.0, 30.0, 65.0])
def test_a_sidescan_sends_most_where_its_axis_points(depression: float) -> None:
    """`depression_deg` is from the horizon downwards: the ray that weighs most looks that far down, to either side."""
    rays = side_rays(SidescanConfig(depression_deg=depression, vertical_beamwidth_deg=20.0, rays_per_side=2048))
    share = rays["weight"] / (rays["across"] * (rays["upper"] - rays["lower"]))  # without the spread along the track
    for side, half in ((1.0, slice(0, 2048)), (-1.0, slice(2048, None))):
        _, y, z = rays["direction"][half][share[half].argmax()]
        assert np.sign(y) == side
        assert math.degrees(math.asin(-z)) == pytest.approx(depression, abs=0.5)


def test_a_bottom_echo_falls_with_30_log_r_and_absorption_both_ways() -> None:
    """Urick 1983, Section 8.12: from 25 m to 100 m 30 log10(4) + 2 0.02 75 dB."""
    margin = echo_margin_db(jit.Float([25.0, 100.0, 200.0]), jit.Float(100.0), jit.Float(0.02))
    expected = [30 * math.log10(4) + 3.0, 0.0, -30 * math.log10(2) - 4.0]
    np.testing.assert_allclose(np.array(margin), expected, atol=1e-4)


def test_the_centre_of_a_speckled_echo_is_known_to_its_width_over_the_root_of_its_samples() -> None:
    """sqrt(w^2 + dr^2/12) / sqrt(1 + 2 sqrt(3) w/dr), times sqrt(1 + 1/snr); and by drawing such echoes."""
    found = amplitude_error(jit.Float([0.5, 0.0]), jit.Float(0.1), jit.Float([1e9, 4.0]))
    expected = [math.sqrt((0.25 + 0.01 / 12) / (1 + 20 * math.sqrt(3) * 0.5)), math.sqrt(0.01 / 12 * 1.25)]
    np.testing.assert_allclose(np.array(found), expected, rtol=1e-4)
    rng, width, step = np.random.default_rng(5), 0.5, 0.1
    bins = np.arange(-math.sqrt(3) * width, math.sqrt(3) * width, step)  # an even echo of that rms width
    power = rng.exponential(size=(4000, len(bins)))
    centres = (power * bins).sum(axis=1) / power.sum(axis=1)
    assert centres.std() == pytest.approx(expected[0], rel=0.12)


@pytest.mark.parametrize("angle_deg", [30.0, 100.0, 160.0])
def test_all_the_light_of_a_lamp_is_its_flux(angle_deg: float) -> None:
    """The integral of intensity over the cone is the flux; the constant 0.62 of the fading edge holds within 9 %."""
    half = math.radians(angle_deg) / 2
    candela = axis_intensity(1500.0, 2 * half)
    lamp = Beam(
        jit.Array3f(0),
        jit.Array3f(1, 0, 0),
        jit.Array3f(candela),
        jit.Float(math.cos(half / 2)),
        jit.Float(math.cos(half)),
    )
    off = np.linspace(0, math.pi, 4001)[1:]
    point = jit.Array3f(
        2 * np.cos(off).astype(np.float32), 2 * np.sin(off).astype(np.float32), dr.zeros(jit.Float, 4000)
    )
    irradiance = np.array(lamp_beam_at(lamp, jit.Array3f(0), point)[0])[0]
    flux = (irradiance * 4.0 * 2 * math.pi * np.sin(off)).sum() * (off[1] - off[0])
    assert flux == pytest.approx(1500.0, rel=0.09)


def test_roughness_is_what_cox_and_munk_measured() -> None:
    """Their clean and slick surfaces (1954, Table 1, fits on p. 847): 0.003 + 0.00512 W and 0.008 + 0.00156 W."""
    assert mean_square_slope(10.0) == pytest.approx(0.0542, rel=1e-3)
    assert mean_square_slope(3.0) == pytest.approx(0.01836, rel=1e-3)
    assert long_mean_square_slope(10.0) == pytest.approx(0.0236, rel=1e-3)


@pytest.mark.parametrize(("a", "b"), [(0.08, -0.03), (-0.05, 0.09)])
def test_a_tilted_sea_moves_its_pattern_of_light_as_snell_says(a: float, b: float) -> None:
    """Under a plane z = a x + b y a vertical ray lands depth (1 - 1/n) (a, b) further: so does the whole pattern."""
    sea, sun = ripple(0.004), jit.Array3f(0, 0, 1)
    t, here = jit.Float64([12.0]), jit.Array3f64(0.0, 0.0, -5.0)
    plane = lambda x, y, t: a * x + b * y
    tilted = waves_at(sea, t, sun, 1, swell_around(plane, here, t, 1))
    level = waves_at(sea, t, sun, 1)
    depth = 3.0
    ray = refract(jit.Array3f(0, 0, -1), dr.normalize(jit.Array3f(-a, -b, 1)), jit.Float(1 / REFRACTIVE_INDEX))
    dx, dy = (float(np.array(c / -ray.z)[0]) * depth for c in (ray.x, ray.y))
    assert (dx, dy) == pytest.approx(
        (depth * (1 - 1 / REFRACTIVE_INDEX) * a, depth * (1 - 1 / REFRACTIVE_INDEX) * b), rel=0.02
    )
    rng = np.random.default_rng(1)
    x, y = (rng.uniform(-2, 2, 500) for _ in range(2))
    light = lambda waves, x, y: np.array(
        focusing(waves, jit.Float(x), jit.Float(y), dr.full(jit.Float, depth, 500), sun, dr.zeros(jit.UInt32, 500))
    )
    moved, wrong = light(level, x - dx, y - dy), light(level, x + dx, y + dy)
    found = light(tilted, x, y)
    assert np.corrcoef(found, moved)[0, 1] > 0.99
    assert np.corrcoef(found, wrong)[0, 1] < 0.9


def test_a_turning_lidar_has_the_oldest_points_at_the_start_of_its_sweep() -> None:
    """A sweep of 180 of 360 degrees at 10 Hz takes 50 ms; the point k of n was fired (1 - k/n) of that ago."""
    config = LidarConfig(pattern="rotating", rotation_hz=10.0, rate_hz=20.0)
    _, _, age = scan_pattern(config)
    steps = age.shape[1]
    whole = config.swept_deg / config.horizontal_fov_deg / config.rotation_hz
    np.testing.assert_allclose(age[0], whole * (1 - np.arange(steps) / steps))
    assert age[0, 0] > age[0, -1] > 0


def test_dark_current_grows_with_the_time_of_exposure() -> None:
    """Electrons without light: variance dark t, over the full well: EMVA 1288; the lens cap is night under water."""
    spread = []
    for shutter in (0.05, 0.4):
        camera = {
            "type": "camera", "rate_hz": 2, "width_px": 64, "height_px": 48, "exposure": "manual", "shutter_s": shutter,
            "iso": 100, "bits": 16, "tone": "linear", "dark_current_e_per_s": 40_000.0, "read_noise_e": 10.0,
            "full_well_e": 20_000.0, "bloom": 0.0, "mosaic": "rggb",
        }  # fmt: skip
        auv = {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 900.0}, "sensors": {"it": camera}}
        world = {"type": "flat", "depth_m": 1500.0}
        scenario = {"world": world, "ocean": {"sun": {"elevation_deg": -30}}, "agents": {"auv": auv}}
        data = pl.Simulation.load(scenario).reset()["auv"]["it"].data[0].astype(float)
        seen = data[data > 0]  # noise below black is cut off
        spread.append(math.sqrt((seen**2).mean()) / 65535 * 20_000)
    electrons = [math.sqrt(10.0**2 + 40_000.0 * t) for t in (0.05, 0.4)]
    assert spread[1] / spread[0] == pytest.approx(electrons[1] / electrons[0], rel=0.1)


def test_a_dvl_measures_the_water_of_its_layer() -> None:
    """Through sheared water the layer 12 m below counts: velocity over ground minus the current there."""
    profile = {"type": "profile", "depth_m": [0, 50], "speed_mps": [0.1, 0.6], "towards_deg": [60, 60]}
    dvl = {"type": "dvl", "rate_hz": 5, "water_layer_m": 12.0, "noise_mps": 0.0, "noise_relative": 0.0}
    start = {"position_m": [0, 0], "depth_m": 8.0, "heading_deg": 0.0}
    auv = {"vehicle": "remus100", "start": start, "sensors": {"it": dvl}}
    world = {"type": "flat", "depth_m": 40.0}
    sim = pl.Simulation.load({"world": world, "ocean": {"currents": profile}, "agents": {"auv": auv}})
    found = sim.reset()["auv"]["it"].extras["water_velocity"][0]
    speed = 0.1 + 0.5 * (8.0 + 12.0) / 50
    north, east = speed * math.cos(math.radians(60)), speed * math.sin(math.radians(60))
    np.testing.assert_allclose(found, [-north, east, 0.0], atol=2e-3)  # at rest over ground: body axes are north, west


def test_the_surface_under_a_hull_rolls_and_pitches_as_a_plane_does() -> None:
    """Elevation h(north, east): roll is positive where port is higher, pitch where the bow is; at any heading."""
    from pelagos.vehicles.wave_flow import surface_under

    up_ahead, up_port = 0.07, -0.04
    heading = math.radians(35.0)
    cos, sin = math.cos(heading), math.sin(heading)

    def elevation(north, east):
        ahead, starboard = north * cos + east * sin, -north * sin + east * cos
        return 0.3 + up_ahead * ahead - up_port * starboard

    one = jit.Float64(1.0)
    rotation = [[cos * one, -sin * one, 0 * one], [sin * one, cos * one, 0 * one], [0 * one, 0 * one, one]]
    position = [jit.Float64(0.0)] * 3
    mean, (roll, pitch) = surface_under(elevation, position, rotation, 8.0, 2.5)
    assert float(np.array(mean)[0]) == pytest.approx(0.3, abs=1e-9)
    assert float(np.array(roll)[0]) == pytest.approx(math.atan(up_port), rel=1e-6)
    assert float(np.array(pitch)[0]) == pytest.approx(math.atan(up_ahead), rel=1e-6)


def test_hydrostatics_right_a_hull_towards_the_surface_it_floats_on() -> None:
    """-G (angle - that of the surface): at the surface's own tilt nothing acts, on either side opposite moments."""
    from pelagos.vehicles.terms.floating import Hydrostatic, numbers

    term = Hydrostatic(numbers(np.diag([0.0, 0.0, 900.0, 50.0, 400.0, 0.0])), vertical=False)
    flow = SimpleNamespace(immersion=0.02, roll=0.10, pitch=-0.06, surface=(0.25, -0.11), down=[0.0, 0.0, 1.0])
    load = [float(v) for v in term.wrench(flow)]
    np.testing.assert_allclose(load[2:5], [-900 * 0.02, -50 * (0.10 - 0.25), -400 * (-0.06 + 0.11)], rtol=1e-6)


def test_a_glider_feels_twice_the_speed_fourfold() -> None:
    """Lift, drag, side force and moments at one attitude grow with the square of speed; rates damp with it too."""
    term = next(t for t in pl.Vehicle.from_catalogue("glider").model.terms.values() if type(t).__name__ == "Glide")

    def wrench(scale: float) -> np.ndarray:
        nu = [0.5 * scale, -0.08 * scale, 0.11 * scale, 0.05, -0.03, 0.04]
        return np.array([np.array(v)[0] for v in term.wrench(SimpleNamespace(nu_r=[jit.Float64(v) for v in nu]))])

    slow, fast = wrench(1.0), wrench(2.0)
    assert (np.abs(slow) > 1e-6).all()
    np.testing.assert_allclose(fast, 4 * slow, rtol=1e-6)


@pytest.mark.parametrize("sun", [-30.0, -10.0, 40.0])
def test_far_below_all_light_a_camera_sees_black(sun: float) -> None:
    """At 900 m nothing of the sun is left: no glow, no number that is none, at night nor by day."""
    camera = {"type": "camera", "rate_hz": 2, "width_px": 64, "height_px": 48, "exposure": "manual", "bits": 16}
    auv = {"vehicle": "remus100", "start": {"position_m": [0, 0], "depth_m": 900.0}, "sensors": {"it": camera}}
    world, ocean = {"type": "flat", "depth_m": 1500.0}, {"sun": {"elevation_deg": sun}}
    reading = pl.Simulation.load({"world": world, "ocean": ocean, "agents": {"auv": auv}}).reset()["auv"]["it"]
    assert reading.truth.max() == 0

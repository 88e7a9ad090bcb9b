"""Signs, factors and axes of the sea, of places in it, and of sound in it: closed forms, inputs of both signs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import pelagos as pl
from pelagos import jit
from pelagos.acoustics.target_strength import cylinder
from pelagos.contact.broad_phase import BoundedBodies, _near_box, close_pairs
from pelagos.errors import CommandError
from pelagos.math.constants import GRAVITY
from pelagos.ocean.analytic_current import TidalCurrentConfig
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.ocean.curvilinear import _at_depths, _even_levels
from pelagos.ocean.grid_data import GriddedData
from pelagos.ocean.gridded import _lacking
from pelagos.ocean.plume import PlumeConfig, _advance
from pelagos.ocean.wind import gust_spectrum
from pelagos.raycast.geometry import Geometry
from pelagos.world.clearance import Clearance
from pelagos.world.path import CirclePath
from pelagos.world.placement import _below_ground


def numbers(values) -> np.ndarray:
    return np.array([np.array(v)[0] for v in values])


def point(x: float, y: float, z: float):
    return jit.Array3f64(float(x), float(y), float(z))


@pytest.mark.parametrize(("towards", "z"), [(30.0, -1.5), (-110.0, -0.4)])
def test_waves_carry_water_along_with_stokes_drift(towards: float, z: float) -> None:
    """a^2 omega k exp(2 k z) in deep water, the way that the waves go."""
    wave = {"type": "regular", "height_m": 1.0, "period_s": 5.0, "towards_deg": towards}
    waves = build_ocean(OceanConfig(waves=[wave], waves_depth_m=500.0)).waves
    omega = 2 * math.pi / 5
    k = omega**2 / GRAVITY
    speed = 0.25 * omega * k * math.exp(2 * k * z)
    way = math.radians(towards)
    found = numbers(waves.drift(jit.Float64(z)))
    assert found == pytest.approx([speed * math.cos(way), -speed * math.sin(way), 0.0], rel=1e-4)


def test_gusts_scale_with_the_wind() -> None:
    """ISO 19901-1, A.8: 16.77 m^2/s^2/Hz at 0.01 Hz and 10 m/s, 10 m up; frequencies go with speed to the 3/4."""
    assert gust_spectrum(np.array(0.01), 10.0) == pytest.approx(320 / (1 + 1.72**0.468) ** (5 / 1.404), rel=1e-9)
    f = np.array([0.004, 0.05])
    assert gust_spectrum(f * 2**0.75, 20.0) / 4 == pytest.approx(gust_spectrum(f, 10.0), rel=1e-9)


@pytest.mark.parametrize("towards", [25.0, -140.0])
def test_a_plume_lies_along_its_stream(towards: float) -> None:
    """On the axis the concentration is largest, and it falls alike to both sides, by the Gaussian of its width."""
    keys = {"speed_mps": 0.4, "spread_m2ps": 0.08, "spread_up_m2ps": 0.01, "initial_m": 0.5, "rate": 2.0}
    plume = PlumeConfig(source_m=(12.0, -7.0, -9.0), towards_deg=towards, **keys).build(None)
    way = math.radians(towards)
    along, left = np.array([math.cos(way), -math.sin(way)]), np.array([math.sin(way), math.cos(way)])

    def level(far: float, aside: float) -> float:
        x, y = np.array([12.0, -7.0]) + far * along + aside * left
        return float(numbers([plume.value(point(x, y, -9.0), jit.Float64(0.0))])[0])

    width2 = 0.25 + 2 * 0.08 * 20.0 / 0.4
    for aside in (3.0, -3.0):
        assert level(20.0, aside) == pytest.approx(level(20.0, 0.0) * math.exp(-4.5 / width2), rel=1e-6)
    assert level(-20.0, 0.0) == 0.0


def test_puffs_go_round_an_eddy_with_order_four() -> None:
    """One step of 0.5 rad about an axis: off by its fifth power over 120, 2.6e-4 of the radius."""
    spin = SimpleNamespace(velocity=lambda p, t: jit.Array3f64(-p[1], p[0], 0.0))
    one = jit.Float64(0.5)
    found = numbers(_advance([spin], None, point(2.0, 0.0, -5.0), jit.Float64(0.0), jit.Float64(0.0), one))
    assert found == pytest.approx([2 * math.cos(0.5), 2 * math.sin(0.5), -5.0], abs=2 * 0.5**5 / 120 * 1.1)


@pytest.mark.parametrize(("phase", "across"), [(40.0, 0.2), (-70.0, -0.3)])
def test_a_tidal_stream_is_strongest_by_its_phase_and_turns_to_the_left(phase: float, across: float) -> None:
    keys = {"period_h": 12.0, "speed_mps": 0.9, "towards_deg": 30.0}
    stream = TidalCurrentConfig(across_mps=across, phase_deg=phase, **keys).build(None)
    ahead, left = np.array([math.cos(math.pi / 6), -0.5, 0]), np.array([0.5, math.cos(math.pi / 6), 0])
    for quarter, expected in ((0, 0.9 * ahead), (1, across * left), (2, -0.9 * ahead)):
        t = 43200.0 * (phase / 360 + quarter / 4)
        found = numbers(stream.velocity(point(3.0, 4.0, -5.0), jit.Float64(t)))
        assert found == pytest.approx(expected, abs=1e-9)


@pytest.mark.parametrize(("west", "covered"), [((-40.0, -10.0), True), ((10.0, 40.0), False)])
def test_a_grid_in_metres_counts_columns_eastwards(west: tuple[float, float], covered: bool) -> None:
    one = np.zeros(1)
    data = GriddedData(np.zeros((1, 1, 1, 1, 1)), one, one, one, one, True, 0.0, (0.0, 100.0, 0.0, 50.0))
    corners = np.array([[10.0, west[0], -20.0], [90.0, west[1], 0.0]])
    lacking = _lacking(data, SimpleNamespace(corners=corners, duration_s=10.0), "a.nc")
    assert (lacking == "") == covered
    assert covered or "longitude" in lacking


@pytest.mark.parametrize(("count", "around"), [(160, 6.0), (48, 2.7)])  # by trees, and one by one
def test_pairs_are_those_that_a_search_of_all_finds(count: int, around: float) -> None:
    rng = np.random.default_rng(3)
    place, copy = rng.uniform(-around, around, (count, 3)), rng.integers(0, 2, count)
    reach = 0.05 * 60.0 ** rng.random(count)  # from 5 cm to 3 m
    i, j = np.triu_indices(count, 1)
    near = (np.linalg.norm(place[i] - place[j], axis=1) < reach[i] + reach[j]) & (copy[i] == copy[j])
    expected = np.stack([i[near], j[near]], axis=1)
    assert len(expected) > 60
    assert np.array_equal(close_pairs(place, reach, copy), expected)


def test_a_sphere_is_near_a_box_by_the_boxs_own_axes() -> None:
    """Distances of points from 200 turned boxes, found by turning the points with SciPy."""
    rng = np.random.default_rng(5)
    turn = Rotation.from_euler("ZYX", rng.uniform(-1.5, 1.5, (200, 3)))
    low, high = -rng.uniform(0.2, 3.0, (200, 3)), rng.uniform(0.2, 3.0, (200, 3))
    apart = rng.uniform(-4, 4, (200, 3))
    local = turn.inv().apply(apart)
    gap = np.linalg.norm(np.maximum(np.maximum(low - local, local - high), 0), axis=1)
    attitude = np.concatenate([np.tile([1.0, 0, 0, 0], (200, 1)), np.roll(turn.as_quat(), 1, axis=1)])
    both = [np.concatenate(v) for v in ((apart, 0 * apart), (low, low), (high, high))]
    bodies = BoundedBodies(both[0], attitude, np.full(400, 0.6), both[1], both[2], np.zeros(400, np.int64))
    sphere, box = np.arange(200), np.arange(200, 400)
    assert 20 < (gap < 0.7).sum() < 180
    assert np.array_equal(_near_box(bodies, sphere, box, 0.1), gap < 0.7)


@pytest.mark.parametrize("clockwise", [True, False])
def test_a_circle_is_followed_bow_ahead_to_the_side_that_was_asked(clockwise: bool) -> None:
    keys = {"centre_m": (5.0, -3.0, -2.0), "radius_m": 8.0, "speed_mps": 0.7}
    path = CirclePath(clockwise=clockwise, **keys)
    quarter = 0.5 * math.pi * 8.0 / 0.7
    assert path.pose(0.0).position == pytest.approx([13.0, -3.0, -2.0])  # north of the centre
    assert path.pose(quarter).position == pytest.approx([5.0, -11.0 if clockwise else 5.0, -2.0])  # then east, or west
    for t in (1.3, 17.0):
        pose, ahead, behind = path.pose(t), path.pose(t + 1e-4), path.pose(t - 1e-4)
        assert pose.velocity == pytest.approx((ahead.position - behind.position) / 2e-4, abs=1e-6)
        w, x, y, z = pose.attitude
        bow = [w * w + x * x - y * y - z * z, 2 * (x * y + w * z), 2 * (x * z - w * y)]
        assert np.array(bow) * 0.7 == pytest.approx(pose.velocity, abs=1e-9)
        assert pose.angular_velocity == pytest.approx([0, 0, (-1 if clockwise else 1) * 0.7 / 8.0])


def test_a_map_of_heights_never_says_far_of_what_is_near() -> None:
    """Points up to their margin above a floor at -20 m may be near; those above it by more than that are not."""
    corners = np.array([[-40.0, -40, -20], [40, -40, -20], [40, 40, -20], [-40, 40, -20]])
    floor = Geometry(corners, np.array([[0, 1, 2], [0, 2, 3]], dtype=np.uint32), 0, 1, 1)
    clearance = Clearance([floor])
    height = np.array([0.5, 2.5, 2.9, 3.5, 9.0])
    places = np.stack([np.linspace(-20, 20, 5), np.linspace(15, -15, 5), -20 + height], axis=1)
    assert np.array_equal(clearance.near(places, np.full(5, 3.0)), height <= 3.0)
    assert np.array_equal(clearance.near(places, np.array([1.0, 2.0, 40.0, 4.0, 5.0])), [1, 0, 1, 1, 0])


@pytest.mark.parametrize(("z", "words"), [(-12.0, "lies inside"), (-9.5, "is nearer"), (-8.0, None)])
def test_what_lies_in_the_ground_is_told_from_what_is_near_it(z: float, words: str | None) -> None:
    world = SimpleNamespace(height=lambda x, y: -10.0)
    found = _below_ground(world, np.array([3.0, -4.0, z]), 1.0)
    assert found is None if words is None else words in found


def test_a_rigid_cylinder_side_on() -> None:
    """10 log10(a L^2/(2 lambda)), Urick 1983, Table 9.1: 10 cm by 1 m at 15 cm of wave length, -4.77 dB."""
    assert float(cylinder(jit.Float(0.1), jit.Float(1.0), jit.Float(0.15))[0]) == pytest.approx(-4.7712, abs=1e-3)


@pytest.fixture(scope="module")
def channel():
    agents = {"it": {"vehicle": "remus100", "start": {"position_m": [0, 0, -15]}}}
    sim = pl.Simulation.load({"world": {"type": "flat", "depth_m": 30.0}, "agents": agents})
    return pl.channel(sim, (0.0, 3.0, -12.0), (90.0, -7.0, -21.0), frequency_hz=9000.0)


def test_pressures_of_all_paths_add_by_their_phase(channel) -> None:
    a = channel.arrivals()
    assert len(a) >= 3
    total = sum(p * np.exp(-2j * np.pi * 9000.0 * tau) for p, tau in zip(a.amplitude, a.delay, strict=True))
    assert channel.transmission_loss(coherent=True) == pytest.approx(-20 * math.log10(abs(total)), abs=1e-9)


def test_noise_of_a_waveform_has_its_spectral_density(channel) -> None:
    """Mean square of complex samples is the level times the sample rate, within 3 standard errors of 20 000."""
    _, got = channel.transmit(np.zeros(20_000), 4000.0, noise_seed=3)
    expected = 10 ** (channel.noise_level_db() / 10) * 4000.0
    assert np.mean(np.abs(got) ** 2) == pytest.approx(expected, rel=3 / math.sqrt(20_000))
    assert np.std(got.real) == pytest.approx(np.std(got.imag), rel=0.03)


@pytest.mark.parametrize("upwards", [False, True])
def test_water_between_levels_is_interpolated_by_its_depth(upwards: bool) -> None:
    """5 + 2 z on uneven levels that differ from column to column is the same at any depth, and held beyond them."""
    z = np.array([-11.0, -7.0, -3.0, -1.0])[None, :, None, None] * np.array([1.0, 1.3])[None, None, None, :]
    z = z[:, ::-1] if upwards else z
    depth = np.array([0.2, 1.9, 2.3, 6.0, 9.0, 20.0])
    found = _at_depths(5.0 + 2.0 * z, z, depth)
    for column, scale in enumerate((1.0, 1.3)):
        expected = 5.0 + 2.0 * np.clip(-depth, -11.0 * scale, -1.0 * scale)
        assert found[0, :, 0, column] == pytest.approx(expected)


def test_levels_of_a_grid_are_those_of_its_deepest_middle_and_shallowest_column() -> None:
    z = -np.array([0.5, 2.0, 4.0])[None, :, None, None] * np.array([1.0, 2.0, 3.0, 5.0, 8.0])[None, None, None, :]
    expected = sorted({round(a * b, 3) for a in (0.5, 2.0, 4.0) for b in (1.0, 2.0, 3.0, 8.0)})
    assert _even_levels(z) == pytest.approx(expected)


@pytest.mark.filterwarnings("ignore:.*it hears nothing there")
@pytest.mark.parametrize("roll", [40.0, -25.0])
def test_a_modem_stands_where_its_arm_is_over_the_tide(roll: float) -> None:
    """z of the vehicle, the arm in the world, less the tide's level."""
    arm = [0.2, 0.5, 2.4]
    start = {"position_m": [1.0, -2.0, -1.1], "heading_deg": 30.0, "pitch_deg": 12.0, "roll_deg": roll}
    sim = pl.Simulation.load(
        {
            "world": {"type": "flat", "depth_m": 12.0},
            "ocean": {"tide": {"period_h": 12.0, "amplitude_m": 0.4, "phase_deg": 50.0}},
            "agents": {
                "it": {"vehicle": "bluerov2", "start": start, "sensors": {"m": {"type": "modem", "position_m": arm}}}
            },
        }
    )
    sim.reset()
    pose = sim.state["it"]
    turned = Rotation.from_quat(np.roll(pose.attitude[0], -1)).apply(arm)[2]
    expected = float(pose.position[0, 2]) + turned - 0.4 * math.cos(math.radians(50.0))
    assert expected > 0.2
    with pytest.raises(CommandError, match=f"it.m is {expected:.2g} m above the water"):
        sim.send("it", "m", b"?")

"""Signs, factors and axes of what instruments make of their echoes and noises: closed forms, inputs of both signs."""

from __future__ import annotations

import math
from types import SimpleNamespace

import numpy as np
import pytest
from sonar_scenes import DT_NS, at, context, plane, still_water

from pelagos import jit
from pelagos.math.geodesy import GeoOrigin
from pelagos.math.rotation import conjugate, from_vector, product, to_vector
from pelagos.navigation.error_state import SIZE, InertialNoise, Lanes, SlowNoise
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.report.swarm import Swarm
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.navigation.gps import Gps, GpsConfig
from pelagos.sensors.navigation.imu import Imu, ImuConfig
from pelagos.sensors.sensor import SensorContext
from pelagos.sensors.sonar.adcp import Adcp, AdcpConfig
from pelagos.sensors.sonar.altimeter import Altimeter, AltimeterConfig, first_echo
from pelagos.sensors.sonar.dvl import Dvl, DvlConfig
from pelagos.sensors.sonar.multibeam import Multibeam, MultibeamConfig

DEEP = -200.0  # keeps the sea surface out of the picture


def test_white_noise_of_gps_is_half_as_large_again_upwards() -> None:
    world = SimpleNamespace(origin=GeoOrigin(45.0, 13.0))
    where = SensorContext("a.x", 1, DT_NS, None, world, build_ocean(OceanConfig(), world), np.zeros(1, np.uint32))
    gps = Gps(GpsConfig(horizontal_std_m=0.0, vertical_std_m=0.0, noise_density=0.4, rate_hz=4.0), where)
    read = gps.sense(lanes([7], dt_ns=DT_NS, environments=range(4000), position=(3.0, -4.0, 2.0)))
    error = read.extras["position"] - read.extras["position_truth"]
    assert error.std(axis=0) == pytest.approx([0.8, 0.8, 1.2], rel=4 / math.sqrt(2 * 4000))


def test_biases_of_an_imu_walk_each_by_its_own_density() -> None:
    """k sqrt(t) after t, of 400 units; accelerometers first."""
    zero = ("_density", "_instability", "_random_walk", "_std", "_resolution")
    keys = {name: 0.0 for name in ImuConfig.model_fields if name.endswith(zero)}
    config = ImuConfig(**keys | {"accelerometer_random_walk": 0.02, "gyroscope_random_walk": 0.005})
    unit = Imu(config, SensorContext("a.imu", 4, DT_NS, None, SimpleNamespace(origin=None), None, np.zeros(1)))
    bias = unit.sense(lanes([18_000], dt_ns=DT_NS, environments=range(400))).extras["bias"]
    seconds = 18_000 * DT_NS * 1e-9
    expected = math.sqrt(seconds) * np.array([0.02] * 3 + [0.005] * 3)
    assert bias.std(axis=0) == pytest.approx(expected, rel=4 / math.sqrt(800))


@pytest.mark.parametrize("ground", [(0.3, -0.5, 0.0), (-0.6, 0.2, 0.1)])
def test_a_dvl_measures_against_ground_that_moves(ground: tuple[float, float, float]) -> None:
    """Over a deck 12 m below that moves by itself: the difference of velocities, and the height above it."""
    where = context([plane(-300.0)])
    where.scene.set_moving([(plane(0.0), 0)])
    where.scene.move(np.array([[0, 0, DEEP - 12]]), np.array([[1.0, 0, 0, 0]]), np.array([ground]), np.zeros((1, 3)))
    exact = {"noise_mps": 0.0, "noise_relative": 0.0, "range_noise_relative": 0.0}
    reading = Dvl(DvlConfig(**exact), where).sense(at(0, 0, DEEP, velocity=(1.0, 0.4, -0.2)))
    assert reading.data[0] == pytest.approx(np.array([1.0, 0.4, -0.2]) - ground, abs=1e-5)
    assert reading.extras["altitude"][0] == pytest.approx(12.0, rel=1e-3)


def test_errors_of_an_altimeter_add_by_their_squares() -> None:
    """10 cm, and 2 % of 15 m: 31.6 cm."""
    unit = Altimeter(AltimeterConfig(noise_m=0.1, noise_relative=0.02), context([plane(DEEP - 15)]))
    reading = unit.sense(lanes(range(800), dt_ns=DT_NS, position=(0, 0, DEEP)))
    error = np.asarray(reading.data - reading.truth).ravel()
    assert error.std() == pytest.approx(math.sqrt(0.1**2 + 0.3**2), rel=4 / math.sqrt(1600))


def test_the_first_echo_is_the_nearest_of_those_that_are_strong() -> None:
    """Of three rays: within 13 dB of the strongest; one too near, one too weak; a lane without any has none."""
    distance = jit.Float([9.0, 7.0, 8.0, 0.1, 6.0, 5.0, 3.0, 4.0, 5.0])
    energy = jit.Float([1.0, 0.5, 0.7, 9.0, 1.0, 0.01, 0.0, 0.0, 0.0])
    found = np.array(first_echo(distance, energy, 3, 0.3))
    np.testing.assert_allclose(found, [7.0, 6.0, np.nan], rtol=1e-6)


@pytest.mark.parametrize(("keys", "along"), [({}, 0.01), ({"noise_cell_exponent": 1.0}, 0.005)])
def test_longer_cells_of_an_adcp_are_surer(keys: dict[str, float], along: float) -> None:
    """By the root of their length: 4 m, half the deviation of 1 m; or by their length, a quarter."""
    unit = Adcp(AdcpConfig(noise_mps=0.02, cells=3, cell_m=4.0, **keys), context([plane(DEEP - 50)]))
    error = unit.sense(lanes(range(1500), dt_ns=DT_NS, position=(0, 0, DEEP))).data
    expected = along / (math.sqrt(2) * math.sin(math.radians(20)))
    assert error[..., 0].std(axis=0) == pytest.approx(np.full(3, expected), rel=4 / math.sqrt(3000))


def test_soundings_in_slower_water_than_assumed_lie_too_deep() -> None:
    config = MultibeamConfig(beams=3, swath_deg=60.0, sound_speed_mps=1530.0, range_max_m=60.0)
    reading = Multibeam(config, context([plane(-20.0)], ocean=still_water(1450.0))).sense(at(0, 0, 0))
    assert reading.data[0][1] == pytest.approx(20.0 * 1530 / 1450, abs=0.15)
    assert reading.truth[0][1] == pytest.approx(20.0, abs=0.01)


def predicted(start: Lanes, h: float) -> Lanes:
    made = Lanes(**{k: v.copy() for k, v in vars(start).items()})
    slow = SlowNoise((2.0,) * 7, (40.0,) * 7)
    force, rate = np.array([[0.4, -1.1, 9.2]]), np.array([[0.3, -0.2, 0.5]])
    made.predict(force, rate, h, InertialNoise(0, 0, 0, 0, 0, 0, 0, 0), slow)
    return made


@pytest.mark.parametrize("column", range(15))
def test_errors_of_a_prediction_spread_as_differences_do(column: int) -> None:
    """One error alone, in the state and in the covariance: F by central differences, to h^2 times 10 m/s^2."""
    rng, h, by = np.random.default_rng(5), 0.01, 1e-4
    start = Lanes.at(np.zeros((1, 3)), rng.normal(size=(1, 3)), from_vector(rng.normal(size=(1, 3))), np.zeros(SIZE))

    def moved(sign: float) -> Lanes:
        error = np.zeros((1, 15))
        error[0, column] = sign * by
        made = Lanes(**{k: v.copy() for k, v in vars(start).items()})
        made.position, made.velocity = made.position + error[:, 0:3], made.velocity + error[:, 3:6]
        made.attitude = product(made.attitude, from_vector(error[:, 6:9]))
        made.gyroscope, made.accelerometer = made.gyroscope + error[:, 9:12], made.accelerometer + error[:, 12:15]
        return predicted(made, h)

    up, down = moved(1.0), moved(-1.0)
    turned = to_vector(product(conjugate(down.attitude), up.attitude))
    names = ("position", "velocity"), ("gyroscope", "accelerometer")
    before, after = ([getattr(up, n) - getattr(down, n) for n in group] for group in names)
    differences = np.concatenate([*before, turned, *after], axis=1)[0] / (2 * by)
    start.covariance[:, column, column] = 1.0
    spread = predicted(start, h).covariance[0]
    assert spread[:15, column] / spread[column, column] ** 0.5 == pytest.approx(differences, abs=h * h * 10)


def test_slow_errors_keep_their_spread() -> None:
    """A Gauss-Markov error of its own standard deviation has it ever after; one that is known forgets."""
    std = np.zeros(SIZE)
    std[15:18] = 2.0
    after = predicted(Lanes.at(np.zeros((1, 3)), np.zeros((1, 3)), np.array([[1.0, 0, 0, 0]]), std), 15.0)
    slow = np.diagonal(after.covariance[0])[15:]
    assert slow[:3] == pytest.approx(4.0, rel=1e-9)
    assert slow[3:] == pytest.approx(4.0 * (1 - math.exp(-2 * 15.0 / 40.0)), rel=1e-9)


def test_neighbours_of_a_group_on_two_lines() -> None:
    """Half of 120 members at x = 0 exactly, the rest at 50 m: trees of equal coordinates end."""
    np.array(jit.Float64([1.0, 2.0]) * 3.0)  # from the first kernel on, numbers below 1e-308 count as 0
    place = np.stack([np.repeat([0.0, 50.0], 60), np.tile(np.arange(60) * 0.1, 2), np.zeros(120)], axis=1)
    distance, _ = Swarm("all", [], np.zeros(1), place[None], None).nearest
    assert distance == pytest.approx(0.1)

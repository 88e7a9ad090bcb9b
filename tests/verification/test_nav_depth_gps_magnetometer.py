"""Depth, GPS and magnetometer against TEOS-10, the ellipsoid and a known field."""

from types import SimpleNamespace

import gsw
import numpy as np
import pytest

from pelagos.math.geodesy import GeoOrigin
from pelagos.math.so3 import from_euler
from pelagos.ocean.config import OceanConfig, build_ocean
from pelagos.sensors.example_motion import lanes
from pelagos.sensors.navigation.depth import Depth, DepthConfig
from pelagos.sensors.navigation.gps import Gps, GpsConfig
from pelagos.sensors.navigation.magnetometer import Magnetometer, MagnetometerConfig
from pelagos.sensors.schedule import period_ticks
from pelagos.sensors.sensor import SensorContext

DT = 5_000_000
QUIET_DEPTH = {"noise_density": 0, "bias_std_m": 0, "drift_m": 0, "resolution_m": 0}
QUIET_GPS = {"horizontal_std_m": 0, "vertical_std_m": 0, "noise_density": 0}


def context(latitude: float = 45.0, longitude: float = 13.0, **ocean) -> SensorContext:
    world = SimpleNamespace(origin=GeoOrigin(latitude, longitude))
    sea = build_ocean(OceanConfig.model_validate(ocean), world)
    return SensorContext("auv0.x", 1, DT, None, world, sea, np.zeros(1, np.uint32))


def at(z, **more):
    position = np.stack([np.zeros(len(z)), np.zeros(len(z)), np.asarray(z, dtype=float)], -1)
    return lanes(range(len(z)), dt_ns=DT, position=position, **more)


def test_depth_of_the_water_column_is_the_depth() -> None:
    z = np.array([0.0, -0.013, -3.3, -57.123, -250.0, -4000.2])
    column = {"temperature_c": {"depth_m": [0, 40, 900], "value": [22, 10, 4]}, "salinity": 38.0}
    read = Depth(DepthConfig(**QUIET_DEPTH), context(**column)).sense(at(z))
    assert read.data == pytest.approx(-z, abs=1e-9)
    assert read.truth == pytest.approx(-z, abs=1e-9)


def test_pressure_in_the_standard_ocean_is_that_of_teos10() -> None:
    """Cast 1 of the TEOS-10 check values: 176 dbar lie at 174.9251074 m, 909 at 901.8572643 (latitude 11 deg).

    Pressure here is the integral of density over depth in water of 35.16504 g/kg at 0 degC conservative temperature,
    whose practical salinity is 35. The trapezoid over 0.5 m and in-situ for conservative temperature cost less than
    1e-5.
    """
    depth = np.array([174.9251074, 901.8572643])
    dbar = np.array([176.0, 909.0])
    t = gsw.t_from_CT(35.16504, 0.0, np.linspace(0, 1000, 11))
    profile = {"depth_m": list(np.linspace(0, 1000, 11)), "value": [float(x) for x in t]}
    ocean = context(11.0, -150.0, temperature_c=profile, salinity=35.0)
    read = Depth(DepthConfig(**QUIET_DEPTH, conversion="teos10"), ocean).sense(at(-depth))
    assert (read.extras["pressure_pa"] - 101_325) / 1e4 == pytest.approx(dbar, rel=3e-5)
    assert read.data == pytest.approx(depth, rel=3e-5)


def test_instrument_made_for_the_standard_ocean_is_wrong_in_fresh_water() -> None:
    """At 20 degC fresh water weighs 998.2 kg/m^3, the standard ocean 1028.1 at the surface: 2.9 % less depth."""
    lake = context(temperature_c=20.0, salinity=0.0)
    read = Depth(DepthConfig(**QUIET_DEPTH, conversion="teos10"), lake).sense(at([-50.0]))
    assert read.data[0] == pytest.approx(50 * 998.2 / 1028.2, rel=5e-4)


def test_pressure_is_pascal_not_decibar_and_zero_depth_in_air() -> None:
    read = Depth(DepthConfig(**QUIET_DEPTH), context()).sense(at([2.0, -10.0]))
    assert read.data == pytest.approx([0, 10], abs=1e-9)
    assert read.extras["pressure_pa"] == pytest.approx([101_325, 101_325 + 10 * 1026.6 * 9.806], rel=1e-4)


def test_depth_noise_is_a_density() -> None:
    only = {**QUIET_DEPTH, "noise_density": 0.01}
    for rate in (10, 100):
        z = np.full(2000 * rate, -20.0)
        motion = lanes(range(len(z)), dt_ns=1_000_000_000 // rate, position=(0, 0, -20))
        data = Depth(DepthConfig(**only, rate_hz=rate), context()).sense(motion).data
        assert data.reshape(2000, rate).mean(axis=1).std() == pytest.approx(0.01, rel=0.065)


def test_depth_follows_waves() -> None:
    wave = {"type": "regular", "height_m": 2.0, "period_s": 8.0}
    read = Depth(DepthConfig(**QUIET_DEPTH), context(waves=[wave])).sense(at([0.5, -0.5]))
    k = (2 * np.pi / 8) ** 2 / 9.81  # a crest of 1 m stands over the origin at t = 0; below z = 0 it decays with e^{kz}
    assert read.data == pytest.approx([0.5, 0.5 + np.exp(-0.5 * k)], abs=1e-3)


def test_gps_only_above_the_surface() -> None:
    ground = context(waves=[{"type": "regular", "height_m": 2.0, "period_s": 8.0}])
    z = [-5.0, 0.9, 1.01, 1.03, 3.0]
    read = Gps(GpsConfig(**QUIET_GPS), ground).sense(at(z))
    assert read.valid.tolist() == [False, False, False, True, True]
    assert np.isnan(read.data[:3]).all()
    assert np.isfinite(read.data[3:]).all()


def test_gps_on_an_antenna_mast() -> None:
    """The antenna goes where the hull's attitude takes it, R = Rz Ry Rx: a mast of (0.4, -0.3, 1.5)."""
    roll, pitch, yaw = 0.3, -0.2, 0.7
    (cr, sr), (cp, sp), (cy, sy) = ((np.cos(a), np.sin(a)) for a in (roll, pitch, yaw))
    turn = np.array([[cy, -sy, 0], [sy, cy, 0], [0, 0, 1]]) @ np.array([[cp, 0, sp], [0, 1, 0], [-sp, 0, cp]])
    turn = turn @ np.array([[1, 0, 0], [0, cr, -sr], [0, sr, cr]])
    tip = turn @ [0.4, -0.3, 1.5]
    sensor = Gps(GpsConfig(**QUIET_GPS, position_m=(0.4, -0.3, 1.5)), context())
    read = sensor.sense(at([-1.0, -tip[2] - 0.1], attitude=[float(c) for c in from_euler(roll, pitch, yaw)]))
    assert read.valid.tolist() == [True, False]
    assert read.extras["position"][0] == pytest.approx([*tip[:2], tip[2] - 1.0], abs=1e-9)
    assert read.data[0, 2] == pytest.approx(tip[2] - 1.0)


def test_gps_gives_degrees_of_the_ellipsoid() -> None:
    """One arc minute of latitude at 45 deg is 1852.2 m; of longitude 1314.2 m (radii of curvature of WGS 84)."""
    motion = lanes([0, 1, 2], dt_ns=DT, position=[(0, 0, 1), (1852.2, 0, 1), (0, -1314.2, 1)])
    read = Gps(GpsConfig(**QUIET_GPS), context()).sense(motion)
    assert read.data[0] == pytest.approx([45, 13, 1], abs=1e-9)
    assert read.data[1, :2] == pytest.approx([45 + 1 / 60, 13], abs=2e-6)
    assert read.data[2, :2] == pytest.approx([45, 13 + 1 / 60], abs=3e-6)
    assert read.extras["position"] == pytest.approx(read.extras["position_truth"])


def test_gps_error_is_slow_and_white() -> None:
    """Over 500 copies: variance slow^2 + density^2 rate within 4 sigma, and a correlation of e^{-t/T} after t."""
    motion = lanes([0, 6000], dt_ns=DT, environments=range(500), position=(0, 0, 2))
    read = Gps(GpsConfig(horizontal_std_m=2.0, noise_density=0.5, correlation_time_s=30.0), context()).sense(motion)
    error = (read.extras["position"] - read.extras["position_truth"]).reshape(2, 500, 3)
    assert error[0, :, 0].var() == pytest.approx(4.0 + 0.25 * 5, rel=4 * np.sqrt(2 / 500))
    covariance = np.mean(error[0, :, :2] * error[1, :, :2])
    assert covariance == pytest.approx(4.0 * np.exp(-1), abs=4 * 5.25 / np.sqrt(1000))


def quaternion_yaw(angle: float) -> tuple[float, float, float, float]:
    return (np.cos(angle / 2), 0.0, 0.0, np.sin(angle / 2))


def test_compass_heading_from_the_field() -> None:
    """Declination 10 deg east, level: heading h reads atan2(y, x) = h - 10 deg (y to port)."""
    quiet = {"noise_density": 0, "bias_std_t": 0, "resolution_t": 0}
    config = MagnetometerConfig(**quiet, intensity_t=5e-5, declination_deg=10, inclination_deg=60)
    sensor = Magnetometer(config, context())
    for heading in (0.0, 10.0, 90.0, 200.0):
        read = sensor.sense(lanes([0], dt_ns=DT, attitude=quaternion_yaw(-np.radians(heading)))).data[0]
        assert np.linalg.norm(read) == pytest.approx(5e-5, rel=1e-12)
        assert read[2] == pytest.approx(-5e-5 * np.sin(np.radians(60)))
        found = np.degrees(np.arctan2(read[1], read[0])) + 10
        assert (found - heading + 180) % 360 - 180 == pytest.approx(0, abs=1e-9)


def test_hard_and_soft_iron() -> None:
    quiet = {"noise_density": 0, "bias_std_t": 0, "resolution_t": 0}
    matrix = (1.1, 0.02, 0.0, 0.01, 0.9, 0.03, 0.0, -0.05, 1.0)
    config = MagnetometerConfig(
        **quiet,
        intensity_t=5e-5,
        declination_deg=0,
        inclination_deg=30,
        hard_iron_t=(1e-6, -2e-6, 3e-6),
        soft_iron=matrix,
    )
    read = Magnetometer(config, context()).sense(lanes([0], dt_ns=DT))
    expected = np.reshape(matrix, (3, 3)) @ read.truth[0] + [1e-6, -2e-6, 3e-6]
    assert read.data[0] == pytest.approx(expected, rel=1e-12)


def test_part_of_a_field_is_refused() -> None:
    with pytest.raises(ValueError, match="all of"):
        MagnetometerConfig(intensity_t=5e-5)


def test_periods() -> None:
    from pelagos.errors import ScenarioError

    assert period_ticks(200, DT) == 1
    assert period_ticks(10, DT) == 20
    assert period_ticks(1 / 3, DT) == 600
    assert period_ticks(30, round(1e9 / 30)) == 1  # a tick is a whole number of nanoseconds
    assert period_ticks(7.5, round(1e9 / 30)) == 4
    with pytest.raises(ScenarioError, match=r"does not divide.*200 Hz; nearest: 28\.5714 or 33\.3333") as error:
        period_ticks(30, DT, where="x.yaml:3: rate_hz")
    assert str(error.value).startswith("x.yaml:3")
    with pytest.raises(ScenarioError, match="faster than"):
        period_ticks(400, DT)

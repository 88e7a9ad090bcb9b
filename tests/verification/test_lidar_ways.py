"""What a LiDAR makes of the ways of its pulses: intensity by medium and surface, dropout, small fields."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from test_lidar_points import CLEAN, at, box, context, floor

from pelagos import jit
from pelagos.math.philox import uniform32
from pelagos.optics.water import REFRACTIVE_INDEX
from pelagos.sensors.lidar.lidar import Lidar, LidarConfig, echo_intensity, survives
from pelagos.sensors.lidar.scan.laser import scan_pattern
from pelagos.sensors.lidar.semantic_lidar import SemanticLidar, SemanticLidarConfig, points


@pytest.mark.parametrize("reflectance", [False, True])
def test_each_medium_takes_its_own_share(reflectance: bool) -> None:
    """e^-(0.03 air + 0.4 water), and of the surface its own row's albedo times the cosine."""
    air, water, cosine = np.array([3.0, 0.0, 8.0, 2.0]), np.array([0.0, 2.5, 1.5, 0.5]), np.array([1.0, 0.7, 0.2, 0.9])
    row, albedo = np.array([2, 0, 1, 2]), np.array([0.3, 0.6, 0.15])
    echo: Any = SimpleNamespace(
        in_air=jit.Float(air), in_water=jit.Float(water), incidence=jit.Float(cosine), material=jit.UInt32(row),
        valid=jit.Bool([True] * 4),
    )  # fmt: skip
    rates = jit.Float(0.03), jit.Float(0.4)
    found = np.array(echo_intensity(echo, jit.Float(albedo), rates, reflectance=reflectance))
    expected = np.exp(-0.03 * air - 0.4 * water) * (albedo[row] * cosine if reflectance else 1)
    assert found == pytest.approx(expected, rel=1e-5)


def test_a_point_stays_by_two_draws_of_its_own() -> None:
    """The first is over the general rate; the second under 1 - z (1 - I / limit), or the point is strong."""
    rng = np.random.default_rng(2)
    words = rng.integers(0, 2**32, (4, 5000), dtype=np.uint32)
    intensity = rng.uniform(0, 1, 5000).astype(np.float32)
    config = LidarConfig(dropoff_general_rate=0.3, dropoff_zero_intensity=0.8, dropoff_intensity_limit=0.6)
    drawn = tuple(jit.UInt32(w) for w in words)
    found = np.array(survives(jit.Float(intensity), drawn, config))
    first, second = (np.array(uniform32(w)) for w in drawn[:2])
    expected = (first >= 0.3) & ((intensity >= 0.6) | (second < 1 - 0.8 * (1 - intensity / np.float32(0.6))))
    assert (found == expected).mean() > 0.999
    assert 0.3 < found.mean() < 0.65


@pytest.mark.parametrize("water_points", [False, True])
def test_a_green_pulse_pays_for_air_and_water(water_points: bool) -> None:
    """5 m over the sea and 4 m of it, 60 degrees down; only where the ground is out of reach the sea itself answers."""
    keys: dict[str, Any] = {
        "through_water": True, "water_points": water_points, "channels": 2, "upper_fov_deg": -15, "lower_fov_deg": -60,
        "range_m": 24.0,
    }  # fmt: skip
    config = LidarConfig(**CLEAN | {"atmosphere_attenuation_rate": 0.05}, water_attenuation_rate=0.3, **keys)
    got = Lidar(config, context([floor(-4.0)])).sense(at(5.0))
    sine = math.sin(math.radians(60))
    deep = 4.0 / math.cos(math.asin(math.cos(math.radians(60)) / REFRACTIVE_INDEX))
    assert got.truth[0, 1, :, 3] == pytest.approx(math.exp(-0.05 * 5.0 / sine - 0.3 * deep), rel=2e-3)  # 1 mm off it
    assert np.isfinite(got.truth[0, 0]).all() == water_points
    if water_points:
        assert got.truth[0, 0, :, 3] == pytest.approx(math.exp(-0.05 * 5.0 / math.sin(math.radians(15))), rel=1e-4)
        assert np.linalg.norm(got.truth[0, 0, :, :3], axis=-1) == pytest.approx(5.0 / math.sin(math.radians(15)))


def test_a_field_of_less_than_a_turn_is_swept_again_and_again() -> None:
    """90 degrees from 45 to the left, 7 times a second: 40 samples a second have 15.75 degrees each, and those at the
    end of the field go on at its beginning."""
    config = SemanticLidarConfig(
        channels=1, rate_hz=40.0, rotation_hz=7.0, points_per_second=3600, horizontal_fov_deg=90.0, upper_fov_deg=0,
        lower_fov_deg=0,
    )  # fmt: skip
    assert (config.steps, config.swept_deg) == (90, pytest.approx(15.75))
    azimuth, elevation, age = scan_pattern(config)
    assert np.degrees(azimuth[0]) == pytest.approx(0.175 * np.arange(90))
    assert not elevation.any()
    assert age[0] == pytest.approx((1 - np.arange(90) / 90) * 0.025)
    lidar = SemanticLidar(config, context([box(12.0)]))
    for k in (0, 1, 4, 6, 12, 13):
        got = lidar.sense(at(50.0, t_s=0.025 * k))
        angle = np.degrees(np.arctan2(got.data[0, 0, :, 1], got.data[0, 0, :, 0]))
        turned = 15.75 * (k - 1) + 0.175 * np.arange(90)  # from the left edge, clockwise, field after field
        off = (45.0 - angle - turned + 45.0) % 90 - 45.0
        assert np.abs(off).max() < 2e-3
        assert np.abs(angle).max() < 45.0 + 1e-3
        assert np.degrees(got.extras["horizontal_angle_rad"][0]) == pytest.approx((15.75 * k) % 90, abs=1e-6)
    fast = SemanticLidarConfig(channels=1, rate_hz=5.0, rotation_hz=20.0, points_per_second=360)
    assert fast.swept_deg == 360.0


def test_a_solid_state_field_is_seen_at_once() -> None:
    """The middles of equal parts of 60 degrees, whatever the time; nothing turns, nothing is old."""
    config = SemanticLidarConfig(
        channels=2, points_per_second=120, rate_hz=10.0, horizontal_fov_deg=60.0, upper_fov_deg=20, lower_fov_deg=-10,
        pattern="solid_state",
    )  # fmt: skip
    lidar = SemanticLidar(config, context([box(12.0)]))
    for t in (0.0, 0.37):
        got = lidar.sense(at(50.0, t_s=t))
        xyz = got.data[0, ..., :3].astype(float)
        angle = np.degrees(np.arctan2(xyz[..., 1], xyz[..., 0]))
        assert angle == pytest.approx(np.tile([25.0, 15.0, 5.0, -5.0, -15.0, -25.0], (2, 1)), abs=1e-3)
        rise = np.degrees(np.arcsin(xyz[..., 2] / np.linalg.norm(xyz, axis=-1)))
        assert rise == pytest.approx(np.tile([[20.0], [-10.0]], (1, 6)), abs=1e-3)
        assert got.extras["horizontal_angle_rad"].tolist() == [0.0]
    assert not scan_pattern(config)[2].any()


def test_semantic_points_are_listed_with_what_is_theirs() -> None:
    """Each with its own cosine, object, tag and ring."""
    rng = np.random.default_rng(3)
    image = rng.uniform(-9, 9, (3, 7, 4)).astype(np.float32)
    image[[0, 0, 1, 2], [1, 5, 3, 0]] = np.nan
    instance, label = rng.integers(1, 90_000, (3, 7)).astype(np.uint32), rng.integers(1, 255, (3, 7)).astype(np.uint8)
    rows = points(image, instance, label)
    there = [(c, s) for c in range(3) for s in range(7) if np.isfinite(image[c, s, 0])]
    assert [tuple(r) for r in rows.tolist()] == [
        (*image[c, s].tolist(), int(instance[c, s]), int(label[c, s]), c) for c, s in there
    ]

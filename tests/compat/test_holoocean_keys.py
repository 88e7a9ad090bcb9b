"""Keys of HoloOcean's sensors as those of ours: each with a value of its own, unequal and away from 0."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pelagos.compat.holoocean.lidars import RaycastLidar


def test_a_lidar_keeps_what_the_other_drops() -> None:
    """Their drop-off at no intensity is the share that stays, in the engine's code; ours the share that is lost."""
    sensor = object.__new__(RaycastLidar)
    sensor.env, sensor.tick_every = SimpleNamespace(_ticks_per_sec=60, advice=None), 6
    sensor.config = {
        "Channels": 17, "Range": 81.0, "PointsPerSecond": 4000, "RotationFrequency": 7, "UpperFovLimit": 12.0,
        "LowerFovLimit": -23.0, "HorizontalFov": 210.0, "AtmospAttenRate": 0.05, "DropOffGenRate": 0.15,
        "DropOffIntensityLimit": 0.6, "DropOffAtZeroIntensity": 0.3, "NoiseStdDev": 0.02, "SaveWaterPoints": True,
    }  # fmt: skip
    assert sensor.native() == {
        "type": "lidar", "channels": 17, "range_m": 81.0, "points_per_second": 4000, "rotation_hz": 7.0,
        "upper_fov_deg": 12.0, "lower_fov_deg": -23.0, "horizontal_fov_deg": 210.0, "water_points": True,
        "atmosphere_attenuation_rate": 0.05, "water_attenuation_rate": 0.05, "dropoff_general_rate": 0.15,
        "dropoff_intensity_limit": 0.6, "dropoff_zero_intensity": pytest.approx(0.7), "noise_stddev_m": 0.02,
    }  # fmt: skip

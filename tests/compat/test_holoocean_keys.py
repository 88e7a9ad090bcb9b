"""Keys of HoloOcean's sensors as those of ours: each with a value of its own, unequal and away from 0."""

from __future__ import annotations

from types import SimpleNamespace

import pytest

from pelagos.compat.holoocean.cameras import CameraSensor
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


def test_all_keys_of_a_camera_are_told_on() -> None:
    """Centimetres, kilometres, percent and stops of HoloOcean's sheet in the units of ours."""
    sensor = object.__new__(CameraSensor)
    sensor.env, sensor.agent_name = SimpleNamespace(lamps_of=lambda agent: {}, advice=None), "auv0"
    sensor.config = {
        "CaptureWidth": 65, "CaptureHeight": 49, "FovAngle": 71.0, "FocalDistance": 250.0, "DepthBlurAmount": 0.03,
        "DepthBlurRadius": 3.0, "BladeCount": 7, "DepthOfFieldMinFstop": 2.2, "Aperture": 3.1, "FilmSlope": 0.8,
        "FilmToe": 0.5, "FilmShoulder": 0.3, "FilmBlackClip": 0.01, "FilmWhiteClip": 0.05, "ExposureMinBrightness": -1,
        "ExposureMaxBrightness": 5, "ExposureSpeedUp": 3.5, "ExposureSpeedDown": 1.5, "ExposureCompensation": 6,
        "MotionBlurIntensity": 0.6, "MotionBlurMaxDistortion": 0.07, "MotionBlurMinObjectScreenSize": 4,
        "LensFlareIntensity": 0.4, "BloomIntensity": 0.9, "WhiteTemp": 5200, "WhiteTint": -0.2,
        "ChromAberrIntensity": 2.0, "ChromAberrOffset": 0.1, "MaxViewDistanceOverride": 4000,
    }  # fmt: skip
    assert sensor.native() == pytest.approx({
        "type": "camera", "width_px": 65, "height_px": 49, "horizontal_fov_deg": 71.0, "focus_distance_m": 2.5,
        "depth_blur_distance_m": 30.0, "depth_blur_px": 3.0, "aperture_blades": 7, "aperture_widest": 2.2,
        "aperture": 3.1, "tone": "film", "film_slope": 0.8, "film_toe": 0.5, "film_shoulder": 0.3,
        "film_black_clip": 0.01, "film_white_clip": 0.05, "meter_min_cd_m2": 0.0625, "meter_max_cd_m2": 4.0,
        "exposure_speed_up_ev_per_s": 3.5, "exposure_speed_down_ev_per_s": 1.5, "compensation_ev": 2.0,
        "motion_blur": 0.6, "motion_blur_max": 0.07, "motion_blur_min_object": 0.04, "lens_flare": 0.4, "bloom": 0.9,
        "white_temperature_k": 5200, "white_tint": -0.2, "chromatic_aberration": 0.02,
        "chromatic_aberration_start": 0.1, "max_range_m": 40.0, "samples": 8,
    })  # fmt: skip

"""Keys of cameras and LiDARs that contradict one another are refused, those that change nothing are warned of."""

from __future__ import annotations

from typing import Any

import pytest

from pelagos.config.loader import load_scenario
from pelagos.errors import ScenarioError, ValidityWarning
from pelagos.sensors.camera.instance_camera import InstanceCameraConfig
from pelagos.sensors.camera.picture.camera_config import NEEDS, CameraConfig
from pelagos.sim.simulation import Simulation


def scenario(**sensor: Any) -> dict[str, Any]:
    start = {"position_m": [0, 0, -5]}
    rov = {"vehicle": "bluerov2", "start": start, "sensors": {"eye": {"type": "camera", **sensor}}}
    return {"world": {"type": "flat", "depth_m": 10}, "agents": {"rov": rov}}


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"horizontal_fov_deg": 180}, "of a pinhole is below 180, not 180; for more, 'lens: fisheye'"),
        ({"lens": "fisheye", "distortion": [0, 0, 0, 0, 0.1]}, "k1 to k4; the fifth value is 0, not 0.1"),
        ({"lens": "fisheye", "distortion": [-0.1, 0, 0, 0, 0], "horizontal_fov_deg": 220}, "is at most 209.2"),
        ({"port": {"type": "dome", "offset_m": [0.03, 0, 0.05]}}, "0.05831 m from the centre of a dome of 0.05 m"),
        ({"exposure": "manual", "shutter_s": 0.3, "rate_hz": 4}, "'shutter_s' of 0.3 s is longer than the 0.25 s"),
        ({"rolling_shutter_s": 0.3, "rate_hz": 4}, "'rolling_shutter_s' of 0.3 s is longer than the 0.25 s"),
        ({"iso": 1600, "iso_max": 800}, "'iso' of 1600, .* is above 'iso_max', 800"),
        ({"meter_min_cd_m2": 2, "meter_max_cd_m2": 1}, "'meter_min_cd_m2', 2, is above 'meter_max_cd_m2', 1"),
        ({"aperture": 2, "aperture_widest": 2.8}, "'aperture' of 2 is wider than 'aperture_widest', f/2.8"),
        ({"lamps": [{"color": [1, -1, 0]}]}, r"lamps.0.color.1: must be at least 0, not -1"),
        (
            {"type": "lidar", "upper_fov_deg": -20, "lower_fov_deg": 5},
            "'upper_fov_deg', -20, is below 'lower_fov_deg', 5",
        ),
        ({"type": "lidar", "points_per_second": 100}, "32 channels at 10 Hz need 320"),
    ],
)
def test_refused(keys: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=r"agents\.rov\.sensors\.eye.*" + message):
        load_scenario(scenario(**keys))


@pytest.mark.parametrize(
    ("keys", "message"),
    [
        ({"gamma": 1.8}, "'gamma' changes nothing without 'tone: gamma'"),
        ({"tone": "film", "highlight_knee": 0.5}, "without 'tone: srgb or gamma'"),
        ({"film_toe": 0.3, "film_slope": 1}, "'film_slope', 'film_toe' changes nothing without 'tone: film'"),
        ({"exposure": "manual", "compensation_ev": 1}, "'compensation_ev' changes nothing without 'exposure: auto'"),
        ({"focus_distance_m": 2}, "'focus_distance_m' changes nothing without several 'samples'"),
        ({"motion_blur": 0.5}, "'motion_blur' changes nothing without several 'samples'"),
        (
            {"motion_blur_max": 0.3, "motion_blur_min_object": 0.1},
            "'motion_blur_max', 'motion_blur_min_object' changes",
        ),
        ({"samples": 4, "aperture_blades": 5}, "'aperture_blades' changes nothing without 'focus_distance_m'"),
        ({"samples": 4, "depth_blur_distance_m": 5}, "'depth_blur_distance_m' changes nothing without 'depth_blur_px'"),
        ({"sensor_width_mm": 36.0}, "'sensor_width_mm' changes nothing without 'focus_distance_m'"),
        ({"chromatic_aberration_start": 0.5}, "'chromatic_aberration_start' changes .* 'chromatic_aberration'"),
        ({"type": "depth_camera", "iso": 200}, "'iso' changes nothing without 'image: true'"),
        ({"type": "depth_camera", "disparity_noise_px": 0.3}, "_px' changes nothing without 'stereo_baseline_m'"),
    ],
)
def test_warned_of(keys: dict[str, Any], message: str) -> None:
    with pytest.warns(ValidityWarning, match=r"rov\.eye: .*" + message):
        Simulation.load(scenario(width_px=16, height_px=16, **keys))


@pytest.mark.parametrize("kind", ["lidar", "semantic_lidar"])
def test_a_lidar_that_does_not_turn_has_no_rotation(kind: str) -> None:
    with pytest.warns(ValidityWarning, match="'rotation_hz', 'motion_distortion' changes .* 'pattern: rotating'"):
        Simulation.load(scenario(type=kind, pattern="solid_state", rotation_hz=20.0, motion_distortion=True))


def test_every_key_that_is_named_is_one() -> None:
    for need in NEEDS:
        assert {need.key, *need.keys} <= set(CameraConfig.model_fields)


def test_a_lens_that_folds_leaves_pixels_blind_and_says_so() -> None:
    """It sees a disc of radius 0.7027 of a square of 2 x 1.1918: 73 % are left out."""
    keys = {"distortion": (-0.3, 0, 0, 0, 0), "horizontal_fov_deg": 100, "width_px": 32, "height_px": 32}
    InstanceCameraConfig(**keys)
    with pytest.warns(ValidityWarning, match=r"rov\.eye: 7[23]\.\d% of the picture see nothing"):
        Simulation.load(scenario(type="instance_camera", **keys))


def test_automatic_exposures_end_with_their_frames() -> None:
    """At night the longest time is taken: that of a frame, where `shutter_s` is longer."""
    night = {"ocean": {"sun": {"elevation_deg": -20}}}
    keys = {"rate_hz": 20, "shutter_s": 1.0, "width_px": 32, "height_px": 32}
    seen = Simulation.load(scenario(**keys) | night).reset()["rov"]["eye"]
    assert seen.extras["exposure_s"] == pytest.approx(1 / 20)

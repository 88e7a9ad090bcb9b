"""Readings of every sensor in a sea with a wall, a mover, wind, a current, layers and a neighbour, off all axes."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from test_every_sensor import NAMES
from test_every_sensor_key import LINKED, own, said, sea, ticks_of

import pelagos as pl
from known import SINGLE, check

SIZES: dict[str, dict[str, Any]] = {
    "multibeam": {"beams": 48, "range_max_m": 40.0},
    "imaging_sonar": {"beams": 48, "bins": 96, "range_max_m": 18.0},
}
PING = {
    "pulse": "cw", "pulse_s": 2e-4, "multipath": "surface_and_bottom", "multipath_order": 2, "refraction": True,
    "volume_scattering_db": -55.0, "volume_scatterers_per_m3": 20.0, "labels": True, "scale": "db", "ringing_db": 150.0,
    "adc_bits": 14, "adc_full_scale_db": 170.0, "sound_speed_mps": 1478.0, "wind_speed_mps": 9.0, "ph": 7.9,
    "surface_loss_db": 2.0, "bottom_loss_db": 9.0, "tvg_db": 22.0, "texture_db": 2.5, "roughness_seed": 5,
    "floor_db": -70.0, "range_min_m": 0.8, "sea_surface": "flat",
}  # fmt: skip
ARRAY = {"beamwidth_deg": 2.3, "vertical_beamwidth_deg": 27.0, "shading": "hamming", "side_lobe_beams": 5}
LENS = {
    "exposure": "manual", "shutter_s": 0.013, "iso": 640.0, "rolling_shutter_s": 0.02, "aperture": 4.0,
    "aperture_blades": 5, "focus_distance_m": 3.0, "depth_blur_px": 1.5, "vignette": 0.8, "bloom": 0.2,
     "lens_flare": 0.3,
    "chromatic_aberration": 0.03, "white_balance": "grey_world", "white_temperature_k": 5000.0, "white_tint": 0.2,
    "tone": "film", "distortion": [-0.2, 0.05, 0.01, -0.008, 0.003], "marine_snow_per_m3": 80.0,
}  # fmt: skip
OTHERWISE: dict[str, list[dict[str, Any]]] = {
    "imaging_sonar": [
        PING | ARRAY, {"elements": True, "channel_gain_db": 1.2, "channel_phase_deg": 9.0, "dead_elements": 0.1,
         "transmit_phase_deg": 20.0, "vehicle_noise": "none"},
        {"interference": {"rate_hz": 7.0, "azimuth_deg": 25.0, "distance_m": 14.0, "source_level_db": 200.0},
         "iq": True},
        {"painted_noise": {"onto": "level", "additive": 0.1, "multiplicative": 0.2, "range_m": 0.1}},
    ],
    "incidence_sonar": [{"cone": True, "beams": 1, "horizontal_aperture_deg": 50.0, "bins": 64, "range_max_m": 12.0}],
    "profiling_sonar": [PING | {"beamwidth_deg": 2.3}],
    "singlebeam": [PING | {"multipath_order": 1, "beamwidth_deg": 17.0, "orientation_deg": [3.0, 55.0, -40.0]},
                   {"iq": True}],
    "sidescan": [PING | {"depression_deg": 22.0, "vertical_floor_db": -22.0}],
    "synthetic_aperture_sonar": [{"depression_deg": 32.0, "beamwidth_deg": 11.0, "range_min_m": 3.0, "bins": 1600}],
    "mechanical_scanning_sonar": [PING | {"sector_deg": 90.0, "step_deg": 2.7, "beamwidth_deg": 3.3}],
    "multibeam": [
        {"spacing": "equidistant", "pulse": "cw", "pulse_s": 1e-4, "sectors": 3, "sector_spacing_hz": 9000.0,
         "stabilised": ["pitch", "roll"], "orientation_deg": [0.0, 0.0, 5.0], "attitudes": True, "labels": True,
          "volume_scattering_db": -60.0,
         "water_column_bins": 64, "refraction": True, "sound_speed_mps": 1478.0, "wind_speed_mps": 9.0},
        {"dual_swath_deg": 4.0, "iq": True, "beamwidth_across_deg": 2.1, "beamwidth_along_deg": 1.4},
    ],
    "dvl": [
        {"orientation_deg": [3.0, -4.0, 33.0], "beam_tilt_deg": 24.0, "water_layer_m": 2.0, "sound_speed_mps": 1478.0,
         "scale_error": 0.01, "noise_mps": 0.02},
        {"orientation_deg": [170.0, -4.0, 5.0]},
    ],
    "adcp": [{"cells": 7, "cell_m": 0.6, "beam_tilt_deg": 25.0, "sound_speed_mps": 1478.0, "orientation_deg": [0, 4,
     20]}],
    "imu": [{"misalignment_std": 0.02, "accelerometer_random_walk": 0.01, "gyroscope_random_walk": 0.001,
             "bias_correlation_time_s": 3.0, "accelerometer_scale_std": 0.02, "gyroscope_scale_std": 0.02}],
    "camera": [
        LENS, {"lens": "fisheye", "horizontal_fov_deg": 150.0, "mosaic": "grbg", "bits": 12},
        {"renderer": "reference", "samples": 4, "tone": "linear"},
    ],
    "depth_camera": [{"stereo_baseline_m": 0.12, "lens": "fisheye", "horizontal_fov_deg": 130.0}],
    "event_camera": [{"threshold": 0.02, "threshold_mismatch": 0.1, "background_hz": 5.0}],
    "lidar": [
        {"orientation_deg": [3.0, -4.0, 5.0], "position_m": [0.3, 0.1, 5.4], "lower_fov_deg": -80.0,
         "water_points": True,
         "noise_stddev_m": 0.05, "motion_distortion": True, "reflectance": True},
        {"through_water": True, "pattern": "solid_state", "horizontal_fov_deg": 80.0, "water_attenuation_rate": 0.3},
    ],
    "range_finder": [{"range_max_m": 30.0, "azimuth_deg": [0.0, 35.0, -50.0], "elevation_deg": [10.0, -20.0, 35.0]}],
    "hydrophone": [{"elements_m": [[0.0, 0.0, 0.0], [0.3, -0.2, 0.1]], "shipping": 0.9, "self_noise_db": 40.0}],
}  # fmt: skip
LOOSE = ("collision", ("singlebeam", 1), ("singlebeam", 2))
"""Stiff: forces, and phases of echoes that overlap, follow what little single precision finds otherwise."""
SHALLOW = ("turbidity", "oxygen", "fluorometer", "tracer", "ctd", "sound_velocity")
LONG = ("profiling_sonar", "sidescan", "mechanical_scanning_sonar")  # to compile; imaging_sonar has what they have
CASES = [
    pytest.param(name, k, marks=pytest.mark.slow) if k and name in LONG else (name, k)
    for name in NAMES
    for k in range(1 + len(OTHERWISE.get(name, [])))
]


LONG_IN_WAVES = (*LONG, "synthetic_aperture_sonar", "incidence_sonar")  # to compile
MOVING = [
    pytest.param(name, k, marks=pytest.mark.slow)
    if name in LONG_IN_WAVES or (k and name == "imaging_sonar") or (k == 2 and name == "multibeam")
    else (name, k)
    for name in NAMES
    if name not in LINKED
    for k in range(1 + len(OTHERWISE.get(name, [])))
]
WEATHER = {
    "waves": {"type": "regular", "height_m": 0.7, "period_s": 3.1, "towards_deg": 115.0, "phase_deg": 40.0},
    "weather": {"rain_mm_per_h": 14.0},
}
FLOWING = ("adcp", "dvl", "current_meter", "multibeam", "imu")
"""Sensors that tell where the water moves how."""
EDDIES = [
    {"type": "shear", "speed_mps": 0.3, "towards_deg": 200.0, "per_m": 0.05},
    {"type": "vortex", "center_m": [3.0, -4.0], "radius_m": 5.0, "speed_mps": 0.4, "drift_mps": 0.3,
     "drift_towards_deg": 80.0},
]  # fmt: skip


ALIKE = ("multibeam", "camera", "event_camera")
"""Sensors, long to compile, that both vehicles have at the same place: kernels of the one serve the other."""


def waters(name: str, setting: int) -> dict[str, Any]:
    """The sea of a case."""
    keys = SIZES.get(name, {})
    scenario = sea(name, keys | (OTHERWISE[name][setting - 1] if setting else {}))
    if name in ALIKE:
        scenario["agents"]["auv1"]["sensors"]["its"] = own(name, keys)
    return scenario


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")
@pytest.mark.parametrize(("name", "setting"), MOVING)
def test_readings_in_motion(name: str, setting: int) -> None:
    """Thrown about in waves and rain: every lever, lag and wind that a vehicle at rest in calm water does not show."""
    scenario = waters(name, setting)
    scenario["ocean"] |= WEATHER
    scenario["ocean"]["currents"] += EDDIES if name in FLOWING else []
    sim = pl.Simulation.load(scenario)
    sim.reset()
    depth = -0.2 if name in ("gps", "thermal_camera") else 0.2 if name in SHALLOW else 2.6
    sim.set_state(
        "auv0", position=[0.7, -0.9, -depth], attitude=[0.91, 0.15, -0.12, -0.35], velocity=[1.3, -0.4, 0.25],
        angular_velocity=[0.6, -0.5, 0.8],
    )  # fmt: skip
    found = []
    for _ in range(4 if setting else 8):
        found += sim.step().get("auv0", {}).values()
    assert found, name
    check("moving", f"{name} {setting}" if setting else name, parts_of(found))


def parts_of(found: list[Any]) -> dict[str, Any]:
    """Data, truth and whatever else readings have, end to end."""
    numbers: dict[str, list[Any]] = {}
    for r in found:
        for part, values in {"data": r.data, "truth": r.truth, "valid": r.valid, **r.extras}.items():
            if values is not None and np.asarray(values).dtype != object:
                numbers.setdefault(part, []).append(np.ravel(np.asarray(values)))
    numbers["t_ns"] = [np.array([r.t_ns for r in found]) * 1e-9]
    return {part: np.concatenate(v) for part, v in numbers.items()}


@pytest.mark.filterwarnings("ignore::pelagos.errors.ValidityWarning")
@pytest.mark.parametrize(("name", "setting"), CASES)
def test_readings(name: str, setting: int) -> None:
    """As a sensor is without further keys, and in other settings."""
    sim = pl.Simulation.load(waters(name, setting))
    obs, found = sim.reset(), []
    for tick in range(ticks_of(name)):
        found += [r for agent in obs.values() for r in agent.values()]
        if name in LINKED and name != "ais":
            said(sim, tick)
        obs = sim.step()
    assert found, name
    share = 1e-2 if name in LOOSE or (name, setting) in LOOSE else SINGLE
    check("sensors", f"{name} {setting}" if setting else name, parts_of(found), share)

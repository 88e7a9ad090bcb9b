"""Configurations in which `test_every_sensor_key` tries the keys of each sensor, and what they are never heard in.

A key counts as heard if it makes a difference in any of a sensor's settings; so each key, and each part of a table that
is absent by default (a port, a lamp, another sonar), has to stand in one of them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

Settings = tuple[dict[str, Any], ...]

MAST = {"position_m": [0.3, 0.1, 5.4], "lower_fov_deg": -80.0}  # over the water, which it sees
DRIFTS: Settings = ({"drift_std": 0.5, "drift_time_s": 40.0, "resolution": 0.0}, {})
MODEMS: Settings = (
    {
        "acknowledge": True, "noise_db": 130.5, "detection_db": 3.0, "packet_max_bytes": 6, "queue": 2,
        "depth_max_m": 3.0, "beacon_s": 0.84, "beacon_bytes": 5,
    },  # hardly over the noise
    {"acknowledge": True, "noise_db": 140.0, "timeout_s": 0.4, "retries": 2},  # hears no acknowledgements
    {"mac": "maca"},
    {"mac": "tdma", "slots": 2, "slot_s": 0.61},
    {"modulation": "chirp", "chirp_order": 16, "noise_db": 131.5},
)  # fmt: skip
FLAT_PORT: dict[str, Any] = {"port": {"type": "flat", "distance_m": 0.03, "thickness_m": 0.15}}
WIDE: dict[str, Any] = {**FLAT_PORT, "horizontal_fov_deg": 120.0}
DOME_PORT: dict[str, Any] = {
    "port": {"type": "dome", "radius_m": 0.6, "thickness_m": 0.02, "offset_m": [0.1, -0.06, 0.04]}
}
LIGHTS: dict[str, Any] = {
    "lamps": [{
        "position_m": [0.2, 0.3, 0.1], "orientation_deg": [2.0, 3.0, -6.0], "flux_lm": 60000.0, "beam_angle_deg": 70.0,
        "color": [1.0, 0.8, 0.5],
    }],
    "lasers": [{
        "position_m": [0.2, -0.3, 0.2], "orientation_deg": [12.0, 2.0, 25.0], "flux_lm": 3000.0, "fan_deg": 40.0,
        "aperture_mm": 40.0, "divergence_mrad": 40.0, "color": [0.1, 1.0, 0.2],
    }],
}  # fmt: skip
MANUAL: dict[str, Any] = {"bits": 16, "exposure": "manual"}
LAGS: dict[str, Any] = {"exposure_speed_up_ev_per_s": 0.002, "exposure_speed_down_ev_per_s": 0.003}
DISTURBED: dict[str, Any] = {
    "interference": {
        "rate_hz": 3.0, "azimuth_deg": 11.0, "elevation_deg": -4.0, "distance_m": 20.0, "source_level_db": 190.0,
        "pulse_s": 1e-3,
    },
    "painted_noise": {
        "additive": 0.1, "additive_reference_db": -20.0, "multiplicative": 0.1, "range_m": 0.3,
        "azimuth_streaks": "dark",
    },
}  # fmt: skip
FAINTLY: dict[str, Any] = {"interference": {**DISTURBED["interference"], "source_level_db": 165.0}, "scale": "db"}
"""What neither the converter of `BUSY` cuts off nor the scale."""
BUSY: dict[str, Any] = {
    "multipath": "surface_and_bottom", "ringing_db": 150.0, "adc_bits": 12, "adc_full_scale_db": 150.0,
    "volume_scattering_db": -50.0, "volume_scatterers_per_m3": 20.0,
}  # fmt: skip
"""Bounces, ringing, a converter and few scatterers in the water."""
FAULTY: dict[str, Any] = {
    "vehicle_noise": "none", "elements": True, "channel_gain_db": 1.0, "channel_phase_deg": 8.0, "dead_elements": 0.1,
}  # fmt: skip
"""Errors of a receive array's channels, which no noise of vehicles may be beside."""
PLAIN_TONE: dict[str, Any] = {"bandwidth_hz": 2000.0, "pulse_s": 5e-4, "sound_speed_mps": 1470.0}
"""A chirp as short as a tone burst, which it may become, and a sound speed that others may take the place of."""
NARROW: dict[str, Any] = {"bins": 128, "source_level_db": 150.0}
SETTINGS: Mapping[str, Settings] = {
    "depth": ({"drift_m": 0.5, "drift_time_s": 40.0, "resolution_m": 0.0}, {}),
    **dict.fromkeys(("fluorometer", "oxygen", "turbidity", "current_meter", "sound_velocity", "tracer"), DRIFTS),
    "modem": MODEMS,
    "usbl": (
        {"noise_db": 120.5},  # hardly over the noise
        {
            "acknowledge": True, "noise_db": 118.0, "detection_db": -0.6, "packet_max_bytes": 6, "queue": 2,
            "beacon_s": 0.84, "beacon_bytes": 5,
        },
        {"acknowledge": True, "noise_db": 140.0, "timeout_s": 0.4, "retries": 2},
        {"mac": "tdma", "slots": 2, "slot_s": 0.47, "interrogate_s": 50.0},
        {"mac": "maca", "interrogate_s": 2.0},
    ),
    "lbl": ({}, {"noise_db": 118.0}),
    "range_bearing": ({}, {"noise_db": 85.4}),
    "altimeter": ({}, {"water_column_bins": 64, "self_noise_db": 0.0}),
    "adcp": (
        {"cells": 5, "cell_m": 0.7, "sound_speed_mps": 1480.0},
        {
            "cells": 8, "cell_m": 0.7, "water_column_bins": 64, "iq": True, "volume_scattering_db": -60.0,
            "bandwidth_hz": 1e4, "pulse_s": 1e-4,
        },  # down to the bottom, by a pulse that may be a burst
    ),
    "singlebeam": (
        {},
        {
            "orientation_deg": [3.0, -75.0, -40.0],
            "beamwidth_deg": 50.0,
            "multipath": "surface_and_bottom",
            "self_noise_db": 0.0,
            "bins": 128,
            "ringing_db": 170.0,
            "adc_bits": 16,
            "adc_full_scale_db": 200.0,
        },
    ),
    "imaging_sonar": (
        {"rays_per_beam": 24},
        {"rays_per_beam": 24, **BUSY, **PLAIN_TONE, **FAINTLY},
        {
            "rays_per_beam": 24, **FAULTY, "transmit_gain_db": 1.0, "transmit_phase_deg": 8.0,
            "transmit_dead_elements": 0.1,
        },
        {"rays_per_beam": 24, "orientation_deg": [3.0, 76.0, 5.0], "painted_noise": DISTURBED["painted_noise"]},
    ),
    "profiling_sonar": (
        {"beams": 32, "bins": 64, "rays_per_beam": 24, "vertical_beamwidth_deg": 12.0},
        {"beams": 32, "bins": 64, "rays_per_beam": 24, **BUSY, **PLAIN_TONE, **FAINTLY},
        {"beams": 32, "bins": 64, "rays_per_beam": 24, **FAULTY},
        {
            "beams": 32, "bins": 64, "rays_per_beam": 24, "orientation_deg": [3.0, 86.0, 5.0],
            "painted_noise": DISTURBED["painted_noise"],
        },
    ),
    "sidescan": (
        {"bins": 128, "rays_per_side": 128, "orientation_deg": [3.0, -4.0, -46.0], "beamwidth_deg": 15.0},
        {
            "bins": 128, "rays_per_side": 128, "beamwidth_deg": 15.0, **BUSY, **DISTURBED, **PLAIN_TONE,
            "interference": {**DISTURBED["interference"], "azimuth_deg": 82.0},
        },  # heard abeam
    ),
    "mechanical_scanning_sonar": (
        {"bins": 128, "rays": 64, "orientation_deg": [3.0, -4.0, 44.0], "sector_deg": 9.0},
        {
            "bins": 128, "rays": 64, "orientation_deg": [3.0, -4.0, 44.0], "sector_deg": 32.0, **BUSY, **PLAIN_TONE,
            **FAINTLY,
        },
        {
            "bins": 128, "rays": 64, "orientation_deg": [3.0, 76.0, 44.0], "sector_deg": 9.0,
            "painted_noise": DISTURBED["painted_noise"],
        },  # squarely onto the bottom
    ),
    "synthetic_aperture_sonar": (
        {"bins": 128, "rays": 1024, "range_min_m": 6.0, "range_max_m": 9.2, "orientation_deg": [3.0, -4.0, -88.0]},
        {
            "bins": 208, "rays": 1024, "range_min_m": 6.0, "range_max_m": 11.2, "orientation_deg": [3.0, -4.0, -88.0],
            "depression_deg": 5.0, "pulse_s": 1 / 30e3, "sound_speed_mps": 1480.0, **BUSY, "ringing_db_per_ms": 2.0,
            "interference": {
                "rate_hz": 10.0, "azimuth_deg": 84.0, "distance_m": 15.0, "source_level_db": 165.0, "pulse_s": 1e-3
            },
        },  # a pulse that may be a burst
    ),  # looks at the wall
    "incidence_sonar": (
        {"beams": 16, "bins": 32, "additive": 0.1},
        {"beams": 1, "bins": 32, "cone": True, "horizontal_aperture_deg": 30.0},
    ),
    "lidar": ({}, MAST, {**MAST, "water_points": True, "atmosphere_attenuation_rate": 0.2}),
    "semantic_lidar": ({}, MAST),
    "dvl": ({}, {"orientation_deg": [170.0, -4.0, 5.0]}),
    "semantic_camera": (WIDE,),
    "instance_camera": (WIDE,),
    "normal_camera": (DOME_PORT,),
    "optical_flow_camera": (DOME_PORT,),
    "thermal_camera": (FLAT_PORT,),
    "depth_camera": ({}, {"stereo_baseline_m": 0.1}),
    "camera": (
        {**MANUAL, "shutter_s": 0.001},
        {**MANUAL, "ripple": 0.0, "lamps": LIGHTS["lamps"]},
        {
            **MANUAL, **FLAT_PORT, "shutter_s": 0.001, "tone": "film", "film_black_clip": 0.1, "film_white_clip": 0.1,
            "chromatic_aberration": 0.02,
        },
        {
            **MANUAL, **DOME_PORT, "samples": 8, "shutter_s": 0.1, "iso": 2.0, "focus_distance_m": 1.5,
            "aperture_blades": 5, "aperture": 4.0, "aperture_widest": 3.0, "depth_blur_px": 40.0,
            "depth_blur_distance_m": 5.0, "motion_blur_max": 0.02, "motion_blur_min_object": 0.01, "tone": "gamma",
        },
        {"bits": 16, **LAGS, "orientation_deg": [3.0, -4.0, -130.0]},  # astern it grows darker
        {"bits": 16, **LAGS},
        {"bits": 16, "shutter_s": 1e-4, "meter_min_cd_m2": 100.0, "meter_max_cd_m2": 1e6},  # short of light
        {"bits": 16, "ripple": 0.0, "lasers": LIGHTS["lasers"]},  # onto the mover
    ),
    "multibeam": ({}, {"source_level_db": 130.0}, {"water_column_bins": 64}),
    "event_camera": ({}, {"threshold": 0.002, "threshold_mismatch": 0.0, "refractory_s": 0.01}),
}  # fmt: skip
"""Configurations in which keys are tried; the defaults where a sensor is not named."""
SCALARS = ("depth", "gps", "ctd", "fluorometer", "oxygen", "sound_velocity", "tracer", "turbidity", "lbl", "ais")
RINGS = ("radio", "modem")
DEAF: dict[str, str] = {
    **{f"{name}.orientation_deg.{k}": "has no direction; its frame is told" for name in SCALARS for k in range(3)},
    **{f"{name}.orientation_deg.{k}": "sends all around; its frame is told" for name in RINGS for k in range(3)},
    "ais.address": "numbers it among radios, of which none sends to it; ships know it by its mmsi",
    "multibeam.refraction=true": "is what auto does in this layered water",
    "singlebeam.refraction=true": "is what auto does in this layered water",
    "sidescan.refraction=true": "is what auto does in this layered water",
    "mechanical_scanning_sonar.refraction=true": "is what auto does in this layered water",
    "imaging_sonar.refraction=true": "is what auto does in this layered water",
    "profiling_sonar.refraction=true": "is what auto does in this layered water",
    "imaging_sonar.vehicle_noise=all!": "is what it has by default, and is refused beside elements",
    "profiling_sonar.vehicle_noise=all!": "is what it has by default, and is refused beside elements",
    "modem.modulation=qpsk!": "is what it has by default, and warned of beside an order of chirps",
    "dvl.bed_grain_mm": "no grain moves in the current of 0.2 m/s",
    "camera.lamps.0.orientation_deg.0": "its cone is round about its axis",
    "optical_modem.orientation_deg.0": "its cone is round about its axis",
    "synthetic_aperture_sonar.iq!": "is refused: the complex signal is what it is for",
    "synthetic_aperture_sonar.refraction=true": "is what auto does in this layered water",
    "singlebeam.sea_surface=flat": "has no waves above it here",
    **{f"hydrophone.orientation_deg.{k}": "hears all around; its frame is told" for k in range(3)},
    **{f"magnetometer.position_m.{k}": "the Earth's field is the same all over a vehicle" for k in range(3)},
    **{f"collision.position_m.{k}": "feels the whole hull; its frame is told" for k in range(3)},
    **{f"collision.orientation_deg.{k}": "feels the whole hull; its frame is told" for k in range(3)},
}
"""Keys that no scene hears, and why."""
UNTRIED: Mapping[str, tuple[str, ...]] = {
    "ais": ("name",),
    "depth_camera": ("lamps", "lasers", "port"),
    "dvl": ("device",),
    "event_camera": ("lamps", "lasers", "port"),
    "modem": ("beacon_to", "device"),
    "multibeam": ("device", "stabilised"),
    "singlebeam": ("device", "interference", "painted_noise"),
    "synthetic_aperture_sonar": ("device", "painted_noise"),
    "tracer": ("tracer",),
    "usbl": ("beacon_to", "device"),
    **dict.fromkeys(("imaging_sonar", "mechanical_scanning_sonar", "profiling_sonar", "sidescan"), ("device",)),
}
"""Keys of which no other value is tried: names, and what other sensors have alike."""
UNTAKEN = (
    "ais", "altimeter", "collision", "ctd", "current_meter", "depth_camera", "dvl", "event_camera", "fluorometer",
    "hydrophone", "imu", "lbl", "lidar", "magnetometer", "multibeam", "optical_modem", "oxygen", "radio",
    "range_bearing", "range_finder", "singlebeam", "sound_velocity", "tracer", "turbidity",
)  # fmt: skip
"""Sensors with keys that all settings refuse, or warn of, which is not looked at yet; the list only shrinks."""

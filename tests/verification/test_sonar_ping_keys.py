"""From a sonar's keys to its ping: each key in its place, angles as directions, defaults where there is none."""

from __future__ import annotations

import math

import numpy as np
import pytest
from sonar_scenes import context, plane

from pelagos.acoustics.noise import ambient_level
from pelagos.config.radiated_noise import ShipNoise, ThrusterNoise
from pelagos.sensors.sonar.adcp import AdcpConfig
from pelagos.sensors.sonar.dvl import DvlConfig
from pelagos.sensors.sonar.imaging_sonar import ImagingSonarConfig
from pelagos.sensors.sonar.keys.echo_keys import echo_spec
from pelagos.sensors.sonar.keys.ping_keys import ping_spec
from pelagos.sensors.sonar.keys.radiated import noise_source
from pelagos.sensors.sonar.mechanical_scanning_sonar import MechanicalScanningSonarConfig
from pelagos.sensors.sonar.ping.ping_spec import Bounces, Display, noise_power
from pelagos.sensors.sonar.profiling_sonar import strongest
from pelagos.sensors.sonar.sidescan import first_return


def test_each_key_of_a_ping_is_in_its_place() -> None:
    config = ImagingSonarConfig(
        rate_hz=4, bins=300, range_min_m=0.7, range_max_m=33.0, pulse_s=0.8e-3, ringing_db=150.0,
        ringing_db_per_ms=22.0, adc_bits=14, adc_full_scale_db=171.0, wind_speed_mps=6.5, texture_db=1.1,
        roughness_seed=9, tvg_db=20.0, scale="db", floor_db=-60.0, dynamic_range_db=50.0,
        multipath="surface_and_bottom", multipath_order=2, surface_loss_db=1.5, bottom_loss_db=4.5,
        volume_scattering_db=-70.0, volume_scatterers_per_m3=12.0, sea_surface="flat", ph=7.9,
        position_m=(0.4, -0.2, 0.1),
        interference={"rate_hz": 9.0, "azimuth_deg": 35.0, "elevation_deg": -20.0, "distance_m": 44.0,
                      "source_level_db": 201.0, "pulse_s": 3e-3},
        painted_noise={"additive": 0.3, "additive_reference_db": -20.0, "multiplicative": 0.2, "range_m": 0.05,
                       "azimuth_streaks": "dark"},
    )  # fmt: skip
    made = ping_spec(config, context([plane()]))
    assert made.ringing == (150.0, 22.0)
    assert made.converter == (14, 171.0)
    assert made.bounces == Bounces(True, 2, 1.5, 4.5)
    assert made.mounting.position_m == (0.4, -0.2, 0.1)
    for name in ("rate_hz", "bins", "range_min_m", "range_max_m", "frequency_hz", "bandwidth_hz", "pulse_s", "pulse",
                 "source_level_db", "self_noise_db", "wind_speed_mps", "ph", "texture_db", "roughness_seed",
                 "refraction", "sea_surface", "volume_scattering_db", "doppler", "hears", "vehicle_noise", "iq",
                 "labels"):  # fmt: skip
        assert getattr(made, name) == getattr(config, name), name
    assert made.volume_scatterers == 12.0
    other = made.disturber
    assert other is not None
    a, e = math.radians(35.0), math.radians(-20.0)
    assert other.direction == pytest.approx((math.cos(e) * math.cos(a), math.cos(e) * math.sin(a), math.sin(e)))
    assert (other.rate_hz, other.distance_m, other.source_level_db, other.pulse_s) == (9.0, 44.0, 201.0, 3e-3)
    paint = made.display.painting
    assert paint is not None
    assert (made.display.tvg_db, made.display.floor_db, made.display.dynamic_range_db) == (20.0, -60.0, 50.0)
    assert (paint.additive, paint.additive_reference_db, paint.multiplicative, paint.range_m) == (0.3, -20.0, 0.2, 0.05)
    assert (paint.azimuth_streaks, paint.onto) == ("dark", "intensity")
    only = ping_spec(ImagingSonarConfig(multipath="surface"), context([plane()])).bounces
    assert only == Bounces(False, 1, None, 6.0)
    assert ping_spec(ImagingSonarConfig(), context([plane()])).bounces is None


def test_sizes_of_a_ping_follow_from_its_ranges_and_band() -> None:
    made = ping_spec(
        ImagingSonarConfig(bins=300, range_min_m=3.0, range_max_m=33.0, bandwidth_hz=25e3), context([plane()])
    )
    assert made.bin_width_m == pytest.approx(0.1)
    assert made.ranges[[0, -1]] == pytest.approx([3.05, 32.95])
    assert made.resolution_m == pytest.approx(0.03)
    assert made.equivalent_m == pytest.approx(0.045)
    assert made.longest_strip_m == pytest.approx(33.0 / 8)


@pytest.mark.parametrize(("pulse", "lost_db"), [("chirp", 10 * math.log10(1.5)), ("cw", 0.0)])
def test_noise_behind_filter_and_beams(pulse: str, lost_db: float) -> None:
    """Density over the band less B T, less what shading loses, less directivity, which is not below nothing."""
    keys = {"pulse": pulse, "pulse_s": 2e-3, "source_level_db": 197.0, "self_noise_db": 44.0, "wind_speed_mps": 8.0}
    config = ImagingSonarConfig(frequency_hz=90e3, **keys, **({"bandwidth_hz": 6e3} if pulse == "chirp" else {}))
    made = ping_spec(config, context([plane()]))
    band = config.bandwidth_hz
    density = 10 * math.log10(10 ** (float(ambient_level(90e3, 8.0)) / 10) + 10**4.4)
    base = density + 10 * math.log10(band) - 10 * math.log10(band * 2e-3) + lost_db - 197.0
    for width, height in ((0.02, 0.4), (4.0, 4.0)):
        index = max(10 * math.log10(4 * math.pi / (width * height)), 0.0)
        assert 10 * math.log10(noise_power(made, width, height)) == pytest.approx(base - index, abs=2e-3)


def test_echoes_begin_outside_of_the_face_and_ping_no_faster_than_they_come_home() -> None:
    """From 5 cm on; at whole parts of the sensor's rate: 90 m and 7 Hz need a half of it, at 1400 m/s."""
    around = context([plane()])
    config = DvlConfig(
        water_column_bins=77, rate_hz=7, roughness_seed=3, volume_scattering_db=-66.0, sound_speed_mps=1490.0
    )
    made = echo_spec(config, around, nearest=0.01, farthest=90.0)
    assert (made.range_min_m, made.range_max_m, made.bins, made.rate_hz) == (0.05, 90.0, 77, 7.0)
    assert echo_spec(config, around, nearest=0.4, farthest=150.0).rate_hz == pytest.approx(3.5)
    assert (made.doppler, made.display) == (False, Display(scale="db"))
    assert (made.roughness_seed, made.volume_scattering_db, made.sound_speed_mps) == (3, -66.0, 1490.0)
    assert echo_spec(config, around, nearest=1.0, farthest=9.0, bins=5).bins == 5
    for keys, bins in (
        ({}, 0),
        ({"iq": True}, 512),
        ({"labels": True}, 512),
        ({"iq": True, "water_column_bins": 9}, 9),
    ):
        assert AdcpConfig(**keys).echo_bins == bins


def test_vehicles_hum_and_reach_as_far_as_their_hulls() -> None:
    assert noise_source(ThrusterNoise(level_db=120.0, frequency_hz=2e4, speed_mps=2.0)).hull_m == 2.0
    assert noise_source(ShipNoise(ship_class="tug", length_m=3.0)).hull_m == 2.0
    hums = noise_source(ThrusterNoise(level_db=120.0, idle_db=100.0, frequency_hz=2e4, speed_mps=2.0)).level
    expected = 10 * math.log10(10 ** ((120 + 60 * math.log10(1.5)) / 10) + 1e10) - 20 * math.log10(3)
    assert hums(6e4, np.array([3.0]))[0] == pytest.approx(expected, abs=1e-6)


@pytest.mark.parametrize(("sector", "step", "expected"), [
    (360.0, 45.0, [180, 135, 90, 45, 0, -45, -90, -135, 180, 135]),
    (100.0, 30.0, [50, 20, -10, -40, -10, 20, 50, 20]),  # the last step would leave the sector
    (90.0, 45.0, [45, 0, -45, 0, 45, 0]),
    (30.9, 10.3, [15.45, 5.15, -5.15, -15.45, -5.15]),  # three steps, of which floats lack the last digit
    (360.0, 7.0, [180, 173, 166]),
])  # fmt: skip
def test_a_head_goes_round_or_to_and_fro(sector: float, step: float, expected: list[float]) -> None:
    config = MechanicalScanningSonarConfig(sector_deg=sector, step_deg=step)
    assert np.degrees(config.angles(np.arange(len(expected)))) == pytest.approx(expected)


def test_a_beams_strongest_sample_counts_over_its_middle() -> None:
    """Over the median by the margin; the range of the first of equals."""
    ranges = np.array([1.0, 2.0, 3.0, 4.0, 5.0], np.float32)
    levels = np.array([[[-40, -39, -20, -41, -38], [-40, -39, -26, -41, -38], [0, 0, 30, 30, 0]]], np.float32)
    found = strongest(levels, ranges, 15.0)
    assert found[0, [0, 2]] == pytest.approx([3.0, 3.0])
    assert np.isnan(found[0, 1])


def test_the_first_return_is_where_both_sides_mean_comes_near_to_the_loud_part() -> None:
    """A step at bin 60 of 200, on port alone half as loud: found within the five bins of the mean; noise has none."""
    ranges = (np.arange(200) * 0.1).astype(np.float32)
    power = np.full((4, 2, 200), 1e-6)
    power[0, :, 60:] = 1e-2
    power[1, 0, 60:] = 1e-2
    power[2, :, 60:] = 3e-6
    power[3, :, 20:60], power[3, :, 60:] = 1e-3, 3e-2  # 14.8 dB below the loud part is not near to it
    found = first_return(10 * np.log10(power), ranges)
    assert found[[0, 1, 3]] == pytest.approx([5.8, 5.8, 5.8], abs=0.11)
    assert np.isnan(found[2])

"""What follows from a multibeam's keys: where its rays go, what they weigh, what it hears of noise and sectors."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest
from sonar_scenes import StillWater, context, plane, still_water

from pelagos.acoustics.absorption import absorption
from pelagos.acoustics.noise import ambient_level
from pelagos.sensors.sonar.keys.multibeam_parts import behind_filter, column_spec, noise_power, sector_losses, swath_of
from pelagos.sensors.sonar.multibeam import MultibeamConfig, fan_rays, receiver


def length(width_deg: float) -> float:
    """Of a uniform line by its half-power width [wavelengths]."""
    return 0.8858929413789 / (2 * math.sin(math.radians(width_deg) / 2))


def test_beams_are_even_in_angle_or_over_the_bottom_from_port_to_starboard() -> None:
    even = MultibeamConfig(beams=7, swath_deg=130.0)
    assert np.degrees(even.angles) == pytest.approx(np.linspace(65.0, -65.0, 7))
    bottom = np.tan(MultibeamConfig(beams=7, swath_deg=130.0, spacing="equidistant").angles)
    assert bottom == pytest.approx(math.tan(math.radians(65.0)) * np.linspace(1, -1, 7))
    assert MultibeamConfig(beams=1, spacing="equidistant").angles.tolist() == [0.0]
    twice = MultibeamConfig(beams=3, dual_swath_deg=2.0)
    assert np.degrees(twice.angles) == pytest.approx([60.0, 0.0, -60.0, 60.0, 0.0, -60.0], abs=1e-9)
    assert (twice.swaths, twice.soundings) == (2, 6)


@pytest.mark.parametrize("dual", [None, 3.0])
def test_rays_of_a_beam_are_five_across_and_some_along_and_weigh_what_it_hears_there(dual: float | None) -> None:
    """At -0.8 to 0.8 half-power widths, across those of the steered beam; strata tile across; the fore swath first."""
    config = MultibeamConfig(
        beams=3, swath_deg=100.0, beamwidth_across_deg=1.5, beamwidth_along_deg=2.5, rays_along=5, dual_swath_deg=dual
    )
    rays = fan_rays(config)
    swaths = [0.0] if dual is None else [1.5, -1.5]
    k = 0
    for swath in swaths:
        for angle in (50.0, 0.0, -50.0):
            for across in (-0.8, -0.4, 0.0, 0.4, 0.8):
                for along in (-0.8, -0.4, 0.0, 0.4, 0.8):
                    wide = 1.5 / math.cos(math.radians(angle))
                    a, t = math.radians(angle + across * wide), math.radians(along * 2.5 + swath)
                    way = [math.sin(t), math.cos(t) * math.sin(a), -math.cos(t) * math.cos(a)]
                    assert rays["direction"][k] == pytest.approx(way, abs=1e-12)
                    assert rays["along"][k] == pytest.approx([0.0, math.cos(a), math.sin(a)], abs=1e-12)
                    step = 0.4 * math.radians(wide)
                    assert (rays["lower"][k], rays["upper"][k]) == pytest.approx((-step / 2, step / 2))
                    heard = np.sinc(length(1.5) * across * math.radians(1.5)) ** 2
                    sent = np.sinc(length(2.5) * math.sin(math.radians(along * 2.5))) ** 2
                    cell = step * math.radians(2.5) * 0.4 * math.cos(t)
                    assert rays["weight"][k] == pytest.approx(cell * heard * sent)
                    assert rays["beam"][k] == k // 25
                    k += 1
    assert len(rays["beam"]) == k


def test_a_single_ray_along_stands_for_the_whole_beam() -> None:
    rays = fan_rays(MultibeamConfig(beams=1, rays_along=1, beamwidth_along_deg=2.0))
    assert rays["weight"][2] == pytest.approx(0.4 * math.radians(1.0) * math.radians(2.0))
    assert rays["direction"][2] == pytest.approx([0.0, 0.0, -1.0], abs=1e-12)


def test_a_receiver_hears_each_ray_by_its_place_across() -> None:
    config = MultibeamConfig(beams=4, rays_along=3, beamwidth_across_deg=2.0, bandwidth_hz=25e3, frequency_hz=300e3,
                             range_max_m=90.0, roughness_seed=7, samples=32, dual_swath_deg=1.0)  # fmt: skip
    found = receiver(config)
    heard = np.sinc(length(2.0) * np.array([-0.8, -0.4, 0.0, 0.4, 0.8]) * math.radians(2.0)) ** 2
    assert found.receive == pytest.approx(np.repeat(heard, 3))
    assert (found.count, found.samples, found.seed) == (8, 32, 7)
    assert found.length == pytest.approx(length(2.0))
    assert found.finest == pytest.approx(2e-5)  # half of 1/B
    assert found.facet == pytest.approx(0.5 * length(2.0) * 1500 / 300e3)  # half the aperture
    assert found.longest == pytest.approx(18.0)


def test_noise_is_behind_the_filter_and_the_array() -> None:
    """Ambient and own density, over the band, less the filter's B T and the directivity of a beam of across by 60."""
    config = MultibeamConfig(beamwidth_across_deg=1.5, self_noise_db=38.0, source_level_db=207.0, frequency_hz=120e3,
                             bandwidth_hz=8e3, pulse_s=3e-3)  # fmt: skip
    density = 10 * math.log10(10 ** (float(ambient_level(120e3, 7.0, rain_mm_per_h=4.0)) / 10) + 10**3.8)
    index = 10 * math.log10(4 * math.pi / (math.radians(1.5) * math.radians(60.0)))
    expected = density + 10 * math.log10(8e3) - 10 * math.log10(24.0) - index - 207.0
    assert 10 * math.log10(noise_power(config, 7.0, 4.0)) == pytest.approx(expected, abs=1e-3)
    level = 41.0 + 10 * math.log10(8e3) - 10 * math.log10(24.0) - 13.0 - 207.0
    assert 10 * math.log10(behind_filter(config, 41.0, 13.0)) == pytest.approx(level, abs=1e-3)


@dataclass
class WarmBelow(StillWater):
    """Warmer and fresher away from the origin and the surface; a struct."""

    def temperature(self, position: Any, t: Any) -> Any:
        return 12.0 - 0.5 * position[2] + 0.1 * position[0]

    def salinity(self, position: Any, t: Any) -> Any:
        return 33.0 + 0.3 * position[2]


def test_each_sector_loses_by_its_frequency_in_the_water_at_the_origin() -> None:
    """Four sectors 20 kHz apart about 110 kHz: 80 to 140 kHz, from port to starboard."""
    around = context([plane(-50.0)], ocean=WarmBelow(still_water().speed))
    config = MultibeamConfig(sectors=4, sector_spacing_hz=20e3, frequency_hz=110e3, ph=7.8)
    loss = [float(absorption(f, 12.0, 33.0, 0.0, 7.8)) for f in (80e3, 100e3, 120e3, 140e3, 110e3)]
    assert sector_losses(config, around) == pytest.approx(np.array(loss[:4]) / loss[4], rel=1e-6)
    assert sector_losses(MultibeamConfig(sectors=4, stabilised=("yaw",)), around).tolist() == [1.0] * 4


def test_a_swath_and_a_water_column_are_the_sounders() -> None:
    config = MultibeamConfig(beams=5, doppler=False, stabilised=("roll",), sound_speed_mps=1510.0, frequency_hz=200e3,
                             bandwidth_hz=20e3, pulse_s=2e-3, rays_along=5)  # fmt: skip
    swath = swath_of(config)
    assert (swath.beams, swath.rays, swath.moves, swath.held, swath.assumed_speed) == (5, 25, False, ("roll",), 1510.0)
    assert swath.coupling_s == pytest.approx(200e3 * 2e-3 / 20e3)
    assert not swath.plain
    assert not swath_of(MultibeamConfig(beams=5)).plain
    assert swath_of(MultibeamConfig(beams=5, doppler=False)).plain
    assert swath_of(MultibeamConfig(pulse="cw", pulse_s=1e-3)).coupling_s == 0.0
    around = context([plane(-50.0)])
    keys = {"water_column_bins": 64, "range_max_m": 80.0, "refraction": False, "vehicle_noise": "others"}
    near, far = (column_spec(MultibeamConfig(range_min_m=r, **keys), around) for r in (0.02, 3.0))
    assert (near.range_min_m, far.range_min_m) == (0.1, 3.0)
    assert (far.bins, far.range_max_m, far.refraction, far.vehicle_noise, far.heard) == (
        64,
        80.0,
        False,
        "others",
        False,
    )
    assert (far.doppler, far.display.scale, far.rate_hz) == (False, "db", 5.0)

"""Errors of a transmitter's elements: the fan's pattern is that of the array as it is, in every echo.

Own formulas: one way the faulty array sends |sum over n f_n exp(2 pi i y_n s)/N|^2 in the direction whose sine is s,
N elements at most half a wavelength apart; the receiver, and the transmitter without errors, have sinc(L s)^2.
"""

from __future__ import annotations

import math

import numpy as np
import pytest
from sonar_scenes import at, context, plane, sphere

from pelagos.acoustics.element_array import ElementLine, channel_factors, element_line, line_amplitude
from pelagos.errors import ValidityWarning
from pelagos.sensors.sonar.imaging_sonar import ImagingSonar, ImagingSonarConfig
from pelagos.world.material import MATERIALS

WIDTH_DEG = 9.0
LENGTH = 0.8858929413789 / (2 * math.sin(math.radians(WIDTH_DEG) / 2))  # [wavelengths]
KEYS = {
    "beams": 32, "bins": 300, "range_max_m": 30.0, "horizontal_aperture_deg": 40.0, "orientation_deg": (0, 0, 0),
    "vertical_beamwidth_deg": WIDTH_DEG, "iq": True, "scale": "linear", "source_level_db": 270.0,
    "rays_per_beam": 160, "texture_db": 0.0,
}  # fmt: skip
ERRORS = {"transmit_gain_db": 2.0, "transmit_phase_deg": 25.0, "transmit_dead_elements": 0.15, "channel_seed": 7}


def sent(sine: np.ndarray) -> np.ndarray:
    """Power that the faulty transmitter of `ERRORS` sends over that of the ideal one on its axis."""
    count = math.ceil(2 * LENGTH)
    y = ((np.arange(count) + 0.5) / count - 0.5) * LENGTH
    f = channel_factors(count, gain_db=2.0, phase_rad=math.radians(25.0), dead=0.15, seed=(7, 1))
    return np.abs(np.exp(2j * np.pi * np.multiply.outer(sine, y)) @ f / count) ** 2


def sonar(things, **options) -> ImagingSonar:
    return ImagingSonar(ImagingSonarConfig(**(KEYS | options)), context(things, materials=(MATERIALS["steel"],)))


@pytest.mark.parametrize("elevation_deg", [0.0, 2.7, -3.4, 5.1])
def test_a_sphere_echoes_by_the_pattern_as_it_is(elevation_deg):
    """Exact but for the half wavelength between elements: the ideal line is continuous, (pi d s)^2/6 of its level."""
    e = math.radians(elevation_deg)
    things = [plane(-1000.0), sphere((12.0 * math.cos(e), 0.8, 12.0 * math.sin(e)), 0.15)]
    loud = [np.abs(s.sense(at(0, 0, 0)).extras["iq"][0]).max() ** 2 for s in (sonar(things, **ERRORS), sonar(things))]
    sine = math.sin(e) * 12.0 / math.hypot(12.0, 0.8)
    expected = sent(np.array([sine]))[0] / np.sinc(LENGTH * sine) ** 2
    assert loud[0] / loud[1] == pytest.approx(expected, rel=0.02)
    assert abs(expected - 1.0) > 0.1


def test_a_bottom_is_lit_by_the_pattern_as_it_is():
    """Each range of a flat bottom 1.4 m below has an elevation of its own, to a stratum: 160 over 40 degrees, within
    which the pattern changes by less than 2 %."""
    energy = []
    for options in (ERRORS, {}):
        image = sonar([plane(-1.4)], **options).sense(at(0, 0, 0)).truth[0].astype(float)
        energy.append(image[8:-8].mean(axis=0))
    ranges = sonar([plane(-1.4)]).tables["range"].astype(float)
    far = (ranges > 11.0) & (ranges < 28.0)  # 7 to 3 degrees down
    sine = -1.4 / ranges[far]
    expected = sent(sine) / np.sinc(LENGTH * sine) ** 2
    measured = energy[0][far] / energy[1][far]
    assert measured / expected == pytest.approx(1.0, abs=0.02)
    assert np.ptp(10 * np.log10(expected)) > 1.0  # the errors do tilt the fan


def test_a_pattern_of_errors_has_hsiao_s_floor_and_loss():
    """Means of 4 000 arrays: m^2 of the power on axis, v/N beside the lobes, m and v by the moments of a log-normal
    gain and a normal phase; the standard error of either is below 2 %."""
    line, gain, phase = element_line(6.0, "uniform"), 1.5 * math.log(10) / 20, math.radians(11.0)
    mean, variance = math.exp(gain**2 / 2 - phase**2 / 2), math.exp(2 * gain**2) - math.exp(gain**2 - phase**2)
    null, found = 1.0 / 6.0, []
    for seed in range(4000):
        f = channel_factors(line.count, gain_db=1.5, phase_rad=phase, dead=0.0, seed=(seed, 1))
        made = line_amplitude(ElementLine(line.places, line.weights, f), np.array([0.0, null]))
        found.append(np.abs(made) ** 2)
    on_axis, beside = np.mean(found, axis=0)
    assert on_axis == pytest.approx(mean**2 + variance / line.count, rel=0.03)
    assert beside == pytest.approx(variance / line.count, rel=0.06)


def test_a_transmitter_without_errors_is_the_line_that_it_was():
    plain = sonar([plane(-2.0)]).sense(at(0.1, 0.2, 0.0)).data
    told = "'channel_seed' changes nothing without one of 'channel_gain_db', .*'transmit_dead_elements'"
    with pytest.warns(ValidityWarning, match=told):
        seeded = sonar([plane(-2.0)], channel_seed=7)
    assert np.array_equal(plain, seeded.sense(at(0.1, 0.2, 0.0)).data)

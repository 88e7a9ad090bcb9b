"""Beam patterns and pulses against closed forms."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.beam_pattern import (
    SHADING_WIDTH,
    elements,
    equivalent_width,
    line,
    line_length,
    line_np,
    shaded_length,
    steering_matrix,
    weighted_line_np,
)
from pelagos.acoustics.pulse import point_spread, processing_gain_db, range_resolution


def first_side_lobe_db(pattern, sine):
    """Highest level beyond the first minimum."""
    level = np.abs(pattern)
    dip = np.flatnonzero((level[1:-1] < level[:-2]) & (level[1:-1] <= level[2:]))[0] + 1
    return 20 * math.log10(level[dip:].max())


def half_power_width(pattern, sine):
    level = np.abs(pattern)
    k = np.flatnonzero(level < math.sqrt(0.5))[0]
    f = (level[k - 1] - math.sqrt(0.5)) / (level[k - 1] - level[k])
    return 2 * (sine[k - 1] + f * (sine[k] - sine[k - 1]))


def test_uniform_line_has_its_width_and_side_lobe():
    u = np.linspace(0, 4, 40001)
    pattern = np.array(line(jit.Float64(u), 1.0))
    assert half_power_width(pattern, u) == pytest.approx(0.8859, abs=1e-4)
    assert first_side_lobe_db(pattern, u) == pytest.approx(-13.26, abs=0.005)
    assert first_side_lobe_db(pattern**2, u) == pytest.approx(-26.52, abs=0.01)
    assert half_power_width(pattern**2, u) == pytest.approx(0.6378, abs=1e-4)


@pytest.mark.parametrize(
    ("count", "width", "lobe"),
    [(16, 6.359, -13.147), (32, 3.174, -13.233), (64, 1.5864, -13.254), (256, 0.3965, -13.261)],
)
def test_half_wave_elements(count, width, lobe):
    sine = np.linspace(0, 8 / count, 40001)
    pattern = np.array(elements(jit.Float64(sine), count))
    found = 2 * math.degrees(math.asin(half_power_width(pattern, sine) / 2))
    assert found == pytest.approx(width, rel=5e-4)
    assert first_side_lobe_db(pattern, sine) == pytest.approx(lobe, abs=0.01)


@pytest.mark.parametrize(
    ("shading", "lobe"), [("uniform", -13.26), ("light", -21.21), ("hann", -31.47), ("hamming", -42.68)]
)
def test_shaded_lines(shading, lobe):
    u = np.linspace(0, 12, 120001)
    pattern = weighted_line_np(u, 1.0, shading)
    assert first_side_lobe_db(pattern, u) == pytest.approx(lobe, abs=0.05)
    assert half_power_width(pattern, u) / 0.8858929 == pytest.approx(SHADING_WIDTH[shading], rel=2e-4)


@pytest.mark.parametrize("width_deg", [0.5, 1.0, 20.0])
def test_line_length_gives_the_width_back(width_deg):
    half = math.sin(math.radians(width_deg) / 2)
    assert line_np(np.array(half), line_length(math.radians(width_deg))) ** 2 == pytest.approx(0.5, abs=1e-6)


@pytest.mark.parametrize("shading", ["uniform", "light", "hamming", "hann"])
@pytest.mark.parametrize("azimuth", [0.0, -0.6, 0.9])
def test_equivalent_width_is_the_integral_of_the_power_pattern(shading, azimuth):
    # the pattern's tails fall as the square of the sine at least: what lies beyond 200 lobes is less than 1/(100 pi^2)
    length = shaded_length(math.radians(1.2), shading)
    sine, step = np.linspace(-200.0 / length, 200.0 / length, 400_001, retstep=True)
    power = weighted_line_np(sine, length, shading) ** 2
    width = power.sum() * step / math.cos(azimuth)  # of the angle, by its sine
    assert equivalent_width(np.array([azimuth]), math.radians(1.2), shading)[0] == pytest.approx(width, rel=2e-3)


def test_steering_keeps_the_power_of_independent_scatterers():
    azimuths = np.linspace(1.1, -1.1, 128)
    for shading in ("uniform", "hamming"):
        m = steering_matrix(azimuths, 0.017, shading, 12)
        assert (m**2).sum(axis=1) == pytest.approx(np.ones(128), rel=1e-5)
        assert np.argmax(m[64]) == 12


def test_range_resolution_of_30_khz_is_two_and_a_half_centimetres():
    assert range_resolution(1500.0, 30e3) == pytest.approx(0.025)
    assert processing_gain_db(30e3, 1e-3) == pytest.approx(14.771, abs=1e-3)


def test_point_spread_is_one_bin_where_the_pulse_is_short_and_has_the_pulses_width_where_it_is_long():
    assert point_spread(0.1, 0.01) == pytest.approx([1.0])
    spread = point_spread(0.01, 0.1)
    x = (np.arange(len(spread)) - len(spread) // 2) * 0.01
    level = spread / spread.max()
    assert (level[np.abs(x) < 0.07] > math.sqrt(0.5)).all()  # a Hann-shaded chirp is 1.44 resolutions wide
    assert (level[np.abs(x) > 0.075] < math.sqrt(0.5)).all()
    assert (spread**2).sum() == pytest.approx(1.0, rel=1e-5)

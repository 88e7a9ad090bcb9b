"""Where acoustics meets the sonars: closed forms away from the special cases, each sign and factor on its own."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics import noise
from pelagos.acoustics.doppler import janus_beams, velocity_from_beams
from pelagos.acoustics.pulse import range_coupling
from pelagos.acoustics.reverberation import volume_intensity
from pelagos.acoustics.sea_surface import bubble_loss_db, surface_backscatter, surface_facets
from pelagos.acoustics.specular import round_side


@pytest.mark.parametrize("lost", [None, 0, 2])
def test_a_velocity_comes_back_from_unequal_beams_of_four_or_of_three(lost):
    # beams of unequal tilt and azimuth: no term of the normal equations is zero
    beams = np.concatenate([janus_beams(math.radians(20.0), (0.3,)), janus_beams(0.6, (1.7, -2.1, -0.7))])
    tilt = math.radians(20.0)
    assert beams[0] == pytest.approx([math.sin(tilt) * math.cos(0.3), math.sin(tilt) * math.sin(0.3), -math.cos(tilt)])
    velocity = np.array([1.3, -0.7, 0.4])
    speeds = [jit.Float64(float(b @ velocity)) for b in beams]
    valid = [jit.Bool(i != lost) for i in range(4)]
    found, solved = velocity_from_beams(speeds, valid, beams)
    assert bool(solved[0])
    assert [found[i][0] for i in range(3)] == pytest.approx(velocity, abs=1e-9)  # double precision, condition below 100
    assert not velocity_from_beams(speeds, [jit.Bool(i < 2) for i in range(4)], beams)[1][0]


def test_the_echo_of_a_cell_of_water_spreads_by_the_square_and_is_absorbed_both_ways():
    # sv psi dr / r^2 10^(-2 a r/10): two-way spreading r^-4 over an area that grows with r^2
    near, far = (float(volume_intensity(jit.Float(3e-4), jit.Float(r), jit.Float(0.07), 0.02)[0]) for r in (20.0, 55.0))
    assert near == pytest.approx(3e-4 * 0.02 / 20.0**2 * 10 ** (-2 * 0.07 * 20.0 / 10), rel=1e-5)
    assert far / near == pytest.approx((20 / 55) ** 2 * 10 ** (-2 * 0.07 * 35 / 10), rel=1e-5)


@pytest.mark.parametrize("wind", [7.5, 12.0])
def test_bubbles_take_from_the_echo_of_facets_straight_above(wind):
    # near the vertical the facets' share is 1 - 1e-6; the bubbles' own echo is 30 dB below them and the rest left out
    angle, khz100 = jit.Float(math.radians(89.0)), 100e3
    sine = jit.Float(math.sin(math.radians(89.0)))
    loss = float(bubble_loss_db(sine, khz100, wind)[0])
    assert loss > 0.3
    expected = float(surface_facets(sine, wind)[0]) * 10 ** (-loss / 10)
    assert float(surface_backscatter(angle, khz100, wind)[0]) == pytest.approx(expected, rel=0.02)


@pytest.mark.parametrize(("radius", "height"), [(5.0, 5.0), (2.0, 11.0)])
def test_a_curved_side_sends_back_less_than_a_flat_one_by_its_curvature(radius, height):
    # geometrical optics: intensity a/(a + r) of that of a flat side, whose radius here is a million metres
    def amplitude(a: float) -> float:
        return float(round_side(*(jit.Float(v) for v in (a, 0.4, 0.1, a + height, 0.02)))[0][0])

    # in single precision a + height - a keeps 0.06 m at a = 1e6: 0.5 % of the range, 1 % of the level
    assert amplitude(radius) / amplitude(1e5) == pytest.approx(math.sqrt(radius / (radius + height)), rel=5e-3)


def test_an_upward_chirp_shows_a_closing_target_too_near_or_far_by_f_t_over_b():
    assert range_coupling(450e3, 30e3, 0.004, "chirp") == pytest.approx(450e3 * 0.004 / 30e3)
    assert range_coupling(450e3, 30e3, 0.004, "cw") == 0.0


@pytest.mark.parametrize(
    ("frequency", "rate", "level"),
    [
        (5e3, 1.0, 42.4), (2e3, 10.0, 57.8), (5e3, 40.0, 42.4 + 15.4 * 1.602060),  # Ma, Nystuen and Lien 2005
        (20e3, 10.0, 57.8 - 6.0206), (100e3, 3.0, 42.4 + 15.4 * 0.477121 - 20.0),  # beyond 10 kHz by its square
    ],
)  # fmt: skip
def test_rain_at_its_rates_and_frequencies(frequency: float, rate: float, level: float) -> None:
    assert noise.rain_level(frequency, rate) == pytest.approx(level, abs=1e-3)
    assert noise.rain_level(frequency, 0.05) == -math.inf
    quiet, loud = (float(noise.ambient_level(frequency, 3.0, 0.2, rain_mm_per_h=r)) for r in (0, rate))
    assert 10 ** (loud / 10) - 10 ** (quiet / 10) == pytest.approx(10 ** (level / 10), rel=1e-5)

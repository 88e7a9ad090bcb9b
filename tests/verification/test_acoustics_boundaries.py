"""Reflection and scattering at the sea bed and at targets against published tables."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos import jit
from pelagos.acoustics.reflection import bottom_loss_db, fluid_reflection
from pelagos.acoustics.seabed import Bottom, backscatter
from pelagos.acoustics.target_strength import corner, cylinder, facets, lambert, plate, sphere
from pelagos.errors import ValidityWarning

ROUGH_ROCK = Bottom(2.5, 2.5, 0.01374, 0.002, 0.20693)
ROCK = Bottom(2.5, 2.5, 0.01374, 0.002, 0.01862)
COBBLE = Bottom(2.5, 1.8, 0.01374, 0.002, 0.0156)
SANDY_GRAVEL = Bottom(2.492, 1.3370, 0.01705, 0.002, 0.012937)
COARSE_SAND = Bottom(2.231, 1.2503, 0.01638, 0.002, 0.006957)
MEDIUM_SAND = Bottom(1.845, 1.1782, 0.01624, 0.002, 0.004446)
VERY_FINE_SAND = Bottom(1.268, 1.0568, 0.01875, 0.002, 0.001544)
SILT = Bottom(1.149, 0.9873, 0.00386, 0.001, 0.000518)
THIN_SILT = Bottom(1.149, 0.9873, 0.00386, 0.0003, 0.000518)

GRAZING = (1, 2, 3, 5, 7, 10, 20, 40, 60, 70, 80, 85, 88, 89, 90)
# APL-UW TR 9407 (1994), Section IV, Table 3 [dB]
TABLE = [
    (ROUGH_ROCK, 30, (-23.0, -19.4, -17.4, -14.8, -13.3, -11.3, -7.9, -5.4, -4.9, -5.0, -5.4, -5.3, -5.4, -5.4, -5.4)),
    (ROCK, 30, (-44.0, -37.3, -33.3, -28.4, -25.2, -21.7, -15.4, -10.0, -9.1, -8.3, -7.3, -6.8, -6.6, -6.6, -6.6)),
    (COBBLE, 30, (-48.5, -41.7, -37.6, -32.6, -29.2, -25.7, -19.3, -14.9, -13.1, -11.5, -9.2, -8.2, -7.9, -7.9, -7.8)),
    (SANDY_GRAVEL, 30, (-50.3, -44.2, -40.3, -35.1, -31.7, -28.1, -22.1, -18.9, -16.5, -13.7, -9.9, -8.4, -8.0, -7.9,
                        -7.8)),
    (COARSE_SAND, 30, (-47.1, -43.8, -41.5, -37.9, -34.9, -31.5, -25.1, -21.4, -18.8, -15.3, -8.9, -5.6, -4.6, -4.4,
                       -4.4)),
    (MEDIUM_SAND, 10, (-61.5, -56.8, -53.2, -47.6, -43.4, -38.8, -30.9, -24.4, -22.6, -20.4, -13.2, -5.0, 1.2, 2.3,
                       2.6)),
    (MEDIUM_SAND, 30, (-51.4, -48.1, -45.8, -42.1, -39.0, -35.4, -28.3, -23.5, -21.2, -17.7, -10.8, -5.5, -3.4, -3.1,
                       -3.1)),
    (MEDIUM_SAND, 100, (-50.0, -44.9, -41.5, -36.6, -33.3, -29.8, -24.2, -21.7, -19.5, -16.4, -12.2, -10.4, -9.8, -9.7,
                        -9.7)),
    (VERY_FINE_SAND, 30, (-59.7, -54.7, -50.8, -44.6, -40.1, -35.2, -27.1, -24.9, -23.7, -23.1, -20.2, -13.1, -5.9,
                          -4.3, -3.8)),
    (VERY_FINE_SAND, 100, (-51.4, -47.9, -45.4, -41.3, -37.9, -34.0, -27.0, -24.8, -23.5, -22.3, -18.0, -12.9, -10.3,
                           -10.0, -10.0)),
    (SILT, 30, (-58.2, -51.1, -46.6, -41.3, -38.3, -35.7, -31.8, -28.8, -27.4, -27.0, -26.3, -23.9, -13.1, -6.8, -3.6)),
    (THIN_SILT, 30, (-63.4, -56.3, -51.8, -46.5, -43.5, -40.9, -37.0, -34.0, -32.6, -32.1, -30.5, -25.8, -13.3, -6.8,
                     -3.6)),
]  # fmt: skip


@pytest.mark.parametrize(("bottom", "kilohertz", "expected"), TABLE)
def test_backscatter_reproduces_the_reports_table(bottom, kilohertz, expected):
    section = backscatter(jit.Float64(np.radians(GRAZING)), kilohertz * 1e3, bottom)
    # the report rounds its parameters and its levels; its own uncertainty is 3 dB
    assert np.abs(10 * np.log10(np.array(section)) - np.array(expected)).max() < 0.6


def test_backscatter_of_a_number_is_that_of_an_array():
    one = backscatter(0.5, 3e4, SILT)
    assert np.array(backscatter(jit.Float64([0.5]), 3e4, SILT)) == pytest.approx([one], rel=1e-9)


def test_backscatter_warns_outside_of_the_model():
    with pytest.warns(ValidityWarning, match="TR 9407"):
        backscatter(0.5, 4e5, SILT)


@pytest.mark.parametrize(
    ("bottom", "grazing_deg", "loss"),
    [(ROCK, 90, 2.80), (SANDY_GRAVEL, 90, 5.38), (Bottom(1.195, 1.0179, 0.02158, 0.002, 0.000781), 90, 20.17),
     (MEDIUM_SAND, 5, 0.2093), (MEDIUM_SAND, 10, 0.3686), (MEDIUM_SAND, 20, 0.5641), (MEDIUM_SAND, 30, 1.1531),
     (MEDIUM_SAND, 45, 6.5479), (MEDIUM_SAND, 90, 8.6391), (ROCK, 30, 0.029), (ROCK, 60, 0.058), (SILT, 90, 24.03)],
)  # fmt: skip
def test_forward_loss_of_sediments(bottom, grazing_deg, loss):
    sine = math.sin(math.radians(grazing_deg))
    r = fluid_reflection(sine, bottom.density_ratio, bottom.sound_speed_ratio, bottom.loss)
    assert float(bottom_loss_db(r)) == pytest.approx(loss, abs=0.02)


def test_reflection_of_a_lossless_fluid_at_normal_incidence():
    real, imaginary = fluid_reflection(1.0, 1200 / 1023, 1600 / 1540, 0.0)
    assert (real, imaginary) == pytest.approx((0.09858, 0.0), abs=1e-5)


def test_reflection_of_a_lossy_fluid():
    real, imaginary = fluid_reflection(math.cos(0.5), 1200 / 1023, 1600 / 1540, 0.2)
    assert (real, abs(imaginary)) == pytest.approx((0.08545, 0.12776), abs=1e-5)


def test_lambert_law_with_mackenzies_constant():
    levels = [10 * math.log10(lambert(math.sin(math.radians(g)), -27.0)) for g in (90, 60, 45, 30, 10)]
    assert levels == pytest.approx([-27.00, -28.25, -30.01, -33.02, -42.21], abs=0.005)


def test_a_perfect_lambert_surface_returns_what_it_receives():
    """The integral of mu sin(in) sin(out) over the upper hemisphere is pi mu sin(in), at most the power sin(in)."""
    out = np.linspace(0, np.pi / 2, 20001)
    integral = trapezoid(np.sin(out) * 2 * np.pi * np.cos(out), out) / np.pi
    assert integral == pytest.approx(1.0, rel=1e-6)


@pytest.mark.parametrize("slope", [0.05, 0.12, 0.2])
def test_facets_at_normal_incidence_return_no_more_than_they_receive(slope):
    """Backscatter at angle i comes from facets tilted by i; all of them together have the probability 1.

    The integral of 4 sigma cos^4 over tan is that of the Gaussian density of slopes, so that it is |R|^2 exactly.
    """
    tilt = np.linspace(1e-6, 1.2, 20001)
    section = np.array(facets(jit.Float64(np.cos(tilt)), 1.0, slope))
    tan = np.tan(tilt)
    total = trapezoid(4 * section * np.cos(tilt) ** 4 * 2 * np.pi * tan, tan)
    assert total == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize(("radius", "level"), [(0.1, -26.02), (0.25, -18.06), (0.5, -12.04), (1.0, -6.02)])
def test_rigid_sphere(radius, level):
    assert float(sphere(radius)) == pytest.approx(level, abs=0.005)


def test_targets_scale_with_size_and_wavelength():
    assert float(plate(2.0, 0.01) - plate(1.0, 0.01)) == pytest.approx(6.0206, abs=1e-3)
    # Knott, Table 6.1: 4 pi a^4/(3 lambda^2) = 339.29 m^2 for 0.3 m at 1 cm; over 4 pi, in decibels
    assert float(corner(0.3, 0.01)) == pytest.approx(10 * math.log10(339.292 / (4 * math.pi)), abs=1e-3)
    assert float(corner(2.0, 0.01) - corner(1.0, 0.01)) == pytest.approx(12.0412, abs=1e-3)
    assert float(cylinder(0.3, 2.0, 0.01) - cylinder(0.3, 1.0, 0.01)) == pytest.approx(6.0206, abs=1e-3)

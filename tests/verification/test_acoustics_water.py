"""Sound in water against published values (sources in the functions' docstrings)."""

from __future__ import annotations

import math
import warnings

import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.absorption import absorption, francois_garrison, thorp
from pelagos.acoustics.noise import ambient_level, directivity_index
from pelagos.acoustics.sound_speed import chen_millero, del_grosso, mackenzie
from pelagos.acoustics.spreading import doppler_two_way, time_varied_gain, transmission_loss, two_way_intensity
from pelagos.errors import ValidityWarning

KILO = 1e3


@pytest.mark.parametrize(
    ("f", "t", "s", "d", "total"),
    [
        (10, 15, 35, 0, 0.86285), (50, 27, 35, 0, 10.72536), (100, 27, 35, 0, 35.66176), (100, 14, 38.5, 0, 39.86901),
        (100, 14, 38.5, 2000, 29.83564), (100, 14, 38.5, 6000, 16.19384), (1, 10, 35, 0, 0.07026),
        (30, 10, 35, 0, 6.89068), (300, 10, 35, 0, 73.16207), (450, 10, 35, 50, 109.22098),
        (900, 10, 35, 50, 298.65161), (1200, 10, 35, 10, 495.19483),
    ],
)  # fmt: skip
def test_francois_garrison_gives_the_published_absorption(f, t, s, d, total):
    parts = francois_garrison(f * KILO, float(t), float(s), float(d))
    assert sum(parts) == pytest.approx(total, abs=6e-6)  # digits as printed


def test_francois_garrison_parts_add_up_by_origin():
    assert francois_garrison(50e3, 27.0, 35.0, 0.0) == pytest.approx((0.23675, 10.03888, 0.44973), abs=6e-6)


def test_absorption_is_the_same_on_arrays_and_numbers():
    t = np.array([0.0, 12.0, 27.0])
    lanes = np.array(absorption(jit.Float64(400e3), jit.Float64(t), jit.Float64(35.0), jit.Float64(20.0)))
    assert lanes == pytest.approx([absorption(400e3, float(x), 35.0, 20.0) for x in t], rel=1e-12)


@pytest.mark.parametrize("frequency", [100.0, 3e6])
def test_absorption_warns_outside_of_the_fit(frequency):
    with pytest.warns(ValidityWarning, match="Francois"):
        absorption(frequency, 10.0, 35.0, 0.0)


def test_absorption_is_silent_inside_of_the_fit():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        absorption(750e3, 10.0, 35.0, 0.0)


@pytest.mark.parametrize(("f", "expected"), [(1, 0.06900), (10, 1.18703), (20, 4.13384), (50, 17.46712)])
def test_thorp(f, expected):
    assert thorp(f * KILO) == pytest.approx(expected, abs=6e-6)


def test_mackenzie():
    assert mackenzie(27.0, 35.0, 10.0) == pytest.approx(1539.0866, abs=1e-4)
    assert mackenzie(25.0, 35.0, 1000.0) == pytest.approx(1550.744, abs=5e-4)


@pytest.mark.parametrize(("t", "salinity", "depth"), [(4.0, 39.0, 0.0), (22.0, 31.0, 500.0), (12.0, 37.5, 1800.0)])
def test_mackenzie_agrees_with_del_grosso_away_from_salinity_35(t, salinity, depth):
    # Mackenzie gives his fit to Del Grosso's data a standard error of 0.07 m/s; three of these, 0.05 for pressure
    kg_per_cm2 = 0.101971621 * (1.00525 * depth + 2.3e-6 * depth**2)  # Leroy and Parthiot 1998 at 40 deg, to 1 dbar
    assert mackenzie(t, salinity, depth) == pytest.approx(del_grosso(t, salinity, kg_per_cm2), abs=0.26)


def test_chen_millero_in_its_90s_temperatures():
    given = [(0.0, 35.0), (10.0, 35.0), (25.0, 35.0), (25.0, 0.0)]
    expected = [1449.1388, 1489.8321, 1534.4108, 1496.7045]
    assert [chen_millero(t, s, 0.0) for t, s in given] == pytest.approx(expected, abs=1e-4)


def test_del_grosso():
    dbar = 0.101971621
    given = [(10.0, 35.0, 0.0), (10.0, 35.0, 5000 * dbar), (2.0, 34.7, 4000 * dbar)]
    expected = [1489.7805, 1572.9862, 1524.2881]
    assert [del_grosso(*g) for g in given] == pytest.approx(expected, abs=2e-4)


@pytest.mark.parametrize(
    ("f", "levels"),
    [(0.1, (67.22, 67.79, 69.55)), (1, (45.37, 60.95, 67.88)), (10, (29.35, 46.09, 53.04)), (30, (21.27, 37.02, 43.95)),
     (100, (25.13, 28.94, 34.20))],
)  # fmt: skip
def test_wenz_noise_by_wind(f, levels):
    assert [float(ambient_level(f * KILO, w)) for w in (0.0, 5.0, 10.0)] == pytest.approx(levels, abs=0.005)


def test_directivity_of_a_full_sphere_is_nothing():
    assert directivity_index(2 * math.pi, 2.0) == pytest.approx(0.0, abs=1e-12)


def test_one_way_loss_of_a_kilometre_at_30_khz():
    a = absorption(30e3, 10.0, 35.0, 0.0)
    assert transmission_loss(1000.0, a) == pytest.approx(66.891, abs=1e-3)


def test_gain_undoes_spreading_and_absorption():
    r = np.array([1.0, 7.0, 60.0])
    level = np.array(two_way_intensity(jit.Float64(r), 0.25) * time_varied_gain(jit.Float64(r), 0.25, spreading=40.0))
    assert level == pytest.approx(np.ones(3), rel=1e-12)


def test_doppler_of_an_active_echo():
    assert doppler_two_way(50e3, 10.0, 1538.92) == pytest.approx(50654.06, abs=0.01)

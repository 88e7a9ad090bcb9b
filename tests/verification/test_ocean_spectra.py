"""Spectra, spreading and dispersion against tables and closed forms.

The tables were computed by integrating the published formulas; sources beside each.
"""

import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos.math.dispersion import wavenumber
from pelagos.ocean.spectrum import (
    cos2s,
    jonswap,
    ochi_hubble,
    pierson_moskowitz,
    pierson_moskowitz_peak,
    tma,
)
from pelagos.ocean.wave_system import JonswapWavesConfig, TmaWavesConfig

F = np.linspace(0.02, 20.0, 400_000)  # for Tp = 10 s: to 200 fp, where 2e-9 of the energy is left


def moment(density: np.ndarray, order: float) -> float:
    return float(trapezoid(density * F**order, F))


@pytest.mark.parametrize(
    ("period", "depth", "k", "speed", "group"),
    [
        (10, None, 0.0402430, 15.6131, 7.8066),
        (10, 50, 0.0415285, 15.1298, 8.5529),
        (10, 20, 0.0518257, 12.1237, 9.2745),
        (10, 5, 0.0928360, 6.7680, 6.3268),
        (6, 10, 0.1298012, 8.0677, 5.6044),
    ],
)
def test_dispersion(period, depth, k, speed, group) -> None:
    """omega^2 = g k tanh(k h), g = 9.81; group speed by differentiation."""
    omega = np.array([2 * np.pi / period])
    found = wavenumber(omega, depth)[0]
    assert found == pytest.approx(k, abs=6e-8)
    assert omega[0] / found == pytest.approx(speed, abs=6e-5)
    d = 1e-6
    slope = 2 * d * omega[0] / (wavenumber(omega * (1 + d), depth)[0] - wavenumber(omega * (1 - d), depth)[0])
    assert slope == pytest.approx(group, abs=1e-4)


def test_dispersion_over_all_depths() -> None:
    omega, depth = np.geomspace(0.01, 30, 400), np.geomspace(0.01, 1e4, 20)
    for h in depth:
        k = wavenumber(omega, float(h))
        assert 9.81 * k * np.tanh(k * h) == pytest.approx(omega**2, rel=1e-12)


@pytest.mark.parametrize(
    ("gamma", "tz", "t1", "tm10", "peak"),
    [
        (1.0, 0.71042, 0.77177, 0.85722, 0.56998),
        (1.5, 0.73048, 0.79123, 0.87234, 0.75797),
        (3.3, 0.77744, 0.83433, 0.90330, 1.23345),
        (7.0, 0.82853, 0.87748, 0.93123, 1.79307),
    ],
)
def test_jonswap_moments(gamma, tz, t1, tm10, peak) -> None:
    """Hs 2 m, Tp 10 s: periods over Tp, and the value at the peak in m^2 s per radian."""
    s = jonswap(F, 2.0, 10.0, gamma)
    m0 = moment(s, 0)
    assert 4 * np.sqrt(m0) == pytest.approx(2.0, rel=1e-5)
    assert np.sqrt(m0 / moment(s, 2)) / 10 == pytest.approx(tz, rel=1e-4)
    assert m0 / moment(s, 1) / 10 == pytest.approx(t1, rel=1e-4)
    assert moment(s, -1) / m0 / 10 == pytest.approx(tm10, rel=1e-4)
    assert jonswap(np.array([0.1]), 2.0, 10.0, gamma)[0] / (2 * np.pi) == pytest.approx(peak, rel=1e-4)


@pytest.mark.parametrize(
    ("wind", "height", "period"), [(5, 0.5332, 3.651), (10, 2.1330, 7.302), (15, 4.7992, 10.953), (20, 8.5319, 14.604)]
)
def test_pierson_moskowitz(wind, height, period) -> None:
    s = pierson_moskowitz(F, wind)
    assert 4 * np.sqrt(moment(s, 0)) == pytest.approx(height, rel=1e-4)
    assert pierson_moskowitz_peak(wind) == pytest.approx(period, abs=5e-4)
    assert 1 / F[np.argmax(s)] == pytest.approx(period, rel=1e-3)


@pytest.mark.parametrize(
    ("wind", "values"),
    [(5, (1.500196e-3, 4.117343e-2, 2.641258e-2)), (10, (1.300081, 0.1215258, 0.04588103)),
     (15, (1.866973, 0.1287702, 0.04725667))],
)  # fmt: skip
def test_pierson_moskowitz_over_wavenumber(wind, values) -> None:
    """S(k) = S(f) df/dk at three wave numbers (numbers of srmainwaring/asv_wave_sim's regression tests)."""
    k = np.array([0.12566371, 0.31415927, 0.43982297])
    omega = np.sqrt(9.81 * k)
    found = pierson_moskowitz(omega / (2 * np.pi), wind) * 9.81 / (2 * omega) / (2 * np.pi)
    assert found == pytest.approx(values, rel=2e-3)  # that code has g = 9.8


def test_pierson_moskowitz_is_jonswap_of_gamma_one() -> None:
    s = pierson_moskowitz(F, 10.0)
    same = jonswap(F, 4 * np.sqrt(moment(s, 0)), pierson_moskowitz_peak(10.0), 1.0)
    np.testing.assert_allclose(same, s, rtol=1e-4, atol=1e-9)


def test_tma_tends_to_jonswap_in_deep_water_and_keeps_its_height() -> None:
    deep = tma(F, 2.0, 10.0, 3.3, 2000.0)
    np.testing.assert_allclose(deep, jonswap(F, 2.0, 10.0, 3.3), rtol=1e-4, atol=1e-9)
    shallow = tma(F, 2.0, 10.0, 3.3, 10.0)
    assert 4 * np.sqrt(moment(shallow, 0)) == pytest.approx(2.0, rel=1e-4)
    assert moment(shallow, 1) / moment(shallow, 0) > moment(deep, 1) / moment(deep, 0)  # low frequencies lose most


def test_ochi_hubble() -> None:
    """lambda 1 is Pierson and Moskowitz's shape; the height and the peak are kept for any."""
    np.testing.assert_allclose(ochi_hubble(F, 2.0, 10.0, 1.0), jonswap(F, 2.0, 10.0, 1.0), rtol=1e-4, atol=1e-9)
    for sharpness in (0.8, 3.0, 8.0):
        s = ochi_hubble(F, 2.0, 10.0, sharpness)
        assert 4 * np.sqrt(moment(s, 0)) == pytest.approx(2.0, rel=1e-3)
        assert F[np.argmax(s)] == pytest.approx(0.1, rel=1e-3)


def test_spreading() -> None:
    angles = np.array([0, 0.31415927, 0.62831853, np.pi / 2])
    assert cos2s(angles, 10) == pytest.approx([0.9032781, 0.7050502, 0.3310915, 8.821075e-4], rel=1e-6)
    grid = np.linspace(-np.pi, np.pi, 2001)
    for s in (0.7, 1, 10, 75):
        assert trapezoid(cos2s(grid, s), grid) == pytest.approx(1, rel=1e-5)


def test_seas_without_energy_or_depth_are_none() -> None:
    rng = np.random.default_rng(2)
    sea = JonswapWavesConfig(significant_height_m=1.5, peak_period_s=8)
    energy = 0.5 * (sea.components(rng, None).amplitude ** 2).sum()
    assert 4 * np.sqrt(energy) == pytest.approx(1.5, rel=2e-3)  # the band leaves 0.1 % out
    with pytest.raises(ValueError, match=r"the spectrum has no energy between 0\.0625 and 0\.75 Hz"):
        JonswapWavesConfig(significant_height_m=1e-170, peak_period_s=8).components(rng, None)
    shallow = TmaWavesConfig(significant_height_m=1.5, peak_period_s=8)
    assert (shallow.density(np.array([0.1, 0.2]), 9.0) > 0).all()
    with pytest.raises(ValueError, match="waves of type tma need the ocean's waves_depth_m"):
        shallow.density(np.array([0.1, 0.2]), None)

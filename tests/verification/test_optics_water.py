"""Water optics against tables, closed forms and conservation."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos import jit
from pelagos.errors import LookupFailed
from pelagos.optics.interface import critical_angle, fresnel, reflect, refract
from pelagos.optics.lamp import Beam, lamp_backscatter
from pelagos.optics.light_source import light_at, loss_of
from pelagos.optics.phase import henyey_greenstein, henyey_greenstein_backward, water_molecules
from pelagos.optics.sunlight import daylight
from pelagos.optics.transport import (
    fitted_rate,
    near_transmission,
    path_length,
    sharp_transmission,
)
from pelagos.optics.water import (
    JERLOV_TYPES,
    REFRACTIVE_INDEX,
    WaterArrays,
    WaterOptics,
    channel_means,
    channel_weights,
    kirk,
    spectra,
    table_sun,
    water_optics,
)

OCEANIC = ("I", "IA", "IB", "II", "III")
COASTAL = ("1C", "3C", "5C", "7C", "9C")


def numbers(array: Any) -> Any:
    return np.array(array, dtype=float).squeeze()


def test_downward_attenuation_is_the_table():
    """N. G. Jerlov 1976 and Austin and Petzold 1984, at wavelengths that the tables hold."""
    for name, nm, kd in [
        ("I", 475, 0.0184),
        ("II", 550, 0.0863),
        ("1C", 600, 0.3057),
        ("3C", 500, 0.22),
        ("9C", 450, 1.6),
    ]:
        s = spectra(name)
        assert s.downwelling[list(s.nm).index(nm)] == pytest.approx(kd, rel=1e-12)


@pytest.mark.parametrize("name", JERLOV_TYPES)
def test_absorption_scattering_and_attenuation_agree(name: str):
    """They give back Kd, except where pure water alone absorbs more than the old tables allow (red)."""
    s = spectra(name)
    kd = kirk(s.absorption, s.water_scattering, s.particle_scattering, sun=table_sun(name))
    free = s.particle_scattering > 1e-9
    assert kd[free] == pytest.approx(s.downwelling[free], rel=1e-9)
    assert kd == pytest.approx(s.downwelling, rel=0.1)  # Smith and Baker's water, 1981, against Pope and Fry's, 1997
    assert (s.absorption > 0.0044).all()  # nothing is clearer than pure water at its clearest
    assert (s.particle_scattering >= 0).all()


# C. A. Williamson and R. C. Hollins, Appl. Opt. 61:9951 (2022), doi 10.1364/AO.470464: means of 6 to 79 campaigns
MEASURED_NM = (488, 510, 555)
MEASURED_A = {
    "IB": (0.0282, 0.0493, 0.0705), "II": (0.0466, 0.0612, 0.0770), "III": (0.0818, 0.0853, 0.0907),
    "1C": (0.1098, 0.1052, 0.0991), "3C": (0.1523, 0.1391, 0.1183), "5C": (0.2126, 0.1893, 0.1567),
}  # fmt: skip
MEASURED_B = {
    "IB": (0.137, 0.127, 0.120), "II": (0.197, 0.187, 0.184), "III": (0.324, 0.308, 0.306),
    "1C": (0.446, 0.437, 0.447), "3C": (0.642, 0.668, 0.675), "5C": (1.238, 1.268, 1.267),
}  # fmt: skip


@pytest.mark.parametrize("name", MEASURED_B)
def test_scattering_is_the_measured_one(name: str):
    """8 %: the smooth curve that the authors draw through their points misses them by as much."""
    s = spectra(name)
    assert np.interp(MEASURED_NM, s.nm, s.scattering) == pytest.approx(np.array(MEASURED_B[name]), rel=0.08)


def test_absorption_is_near_the_measured_one():
    """It follows from Kd and scattering here, and from instruments there, which spread by 10 to 30 % between campaigns:
    within 20 % in the mean over wavelengths, and 5 % in that over types."""
    ratios = [
        np.mean(np.interp(MEASURED_NM, spectra(name).nm, spectra(name).absorption) / measured)
        for name, measured in MEASURED_A.items()
    ]
    assert ratios == pytest.approx(np.ones(6), abs=0.2)
    assert np.mean(ratios) == pytest.approx(1, abs=0.05)


def test_the_most_turbid_coast_keeps_the_published_green_values():
    """Solonenko and Mobley 2015, band around 550 nm."""
    for name, b in [("7C", 2.350), ("9C", 3.120)]:
        s = spectra(name)
        assert s.scattering[list(s.nm).index(550)] == pytest.approx(b, rel=0.01)


def test_channel_weights_are_a_mean():
    w = channel_weights()
    assert w.sum(axis=1) == pytest.approx([1, 1, 1])
    assert channel_means(np.full(61, 0.3)) == pytest.approx((0.3, 0.3, 0.3))


@pytest.mark.parametrize("name", OCEANIC)
def test_red_is_lost_first_in_the_ocean(name: str):
    r, g, b = water_optics(name).downwelling
    assert r > g > b


@pytest.mark.parametrize("name", ["3C", "5C", "7C", "9C"])
def test_blue_is_lost_before_green_at_the_coast(name: str):
    _, g, b = water_optics(name).downwelling
    assert b > g


def test_blue_is_lost_first_of_all_in_9c():
    r, g, b = water_optics("9C").downwelling
    assert b > g > r


def test_more_particles_scatter_more_and_darken():
    clear, murky = water_optics("1C"), water_optics("1C", turbidity=4.0)
    assert murky.particle_scattering == pytest.approx(tuple(4 * b for b in clear.particle_scattering))
    assert murky.absorption == clear.absorption
    assert all(m > c for m, c in zip(murky.downwelling, clear.downwelling, strict=True))


def test_unknown_type_names_the_nearest():
    with pytest.raises(LookupFailed, match="3C"):
        water_optics("3c")


def some_water() -> WaterOptics:
    return WaterOptics("test", (0.3, 0.1, 0.05), (0.001, 0.002, 0.003), (0.2, 0.3, 0.4), (0.35, 0.15, 0.1))


def test_two_distances_give_back_the_attenuation():
    """In linear light ln(I1 / I2) / (z2 - z1) is the rate, for both transmissions."""
    water = some_water()
    a, b = (np.array(v) for v in (water.absorption, water.scattering))
    z = jit.Float([2.0, 7.0])
    for rule, rate in [
        (sharp_transmission, a + 0.8 * b),
        (near_transmission, a + 0.5 * b),
    ]:
        t = numbers(rule(water.arrays(), z))
        assert np.log(t[:, 0] / t[:, 1]) / 5 == pytest.approx(rate, rel=1e-5)


def test_no_distance_gives_the_surface_and_all_distance_the_veil():
    water = some_water().arrays()
    assert numbers(sharp_transmission(water, jit.Float(0))) == pytest.approx([1, 1, 1])
    assert numbers(path_length(water.attenuation, jit.Float(0))) == pytest.approx([0, 0, 0])
    far = numbers(path_length(water.attenuation, jit.Float(1e4)))
    assert far == pytest.approx(1 / np.array(numbers(water.attenuation)), rel=1e-5)
    assert numbers(sharp_transmission(water, jit.Float(1e4))) == pytest.approx([0, 0, 0])


def test_path_length_is_the_integral_along_the_ray():
    """Against the trapezoid rule, falling and rising; 4000 steps leave (k h)^2 / 12 < 1e-6."""
    s = np.linspace(0, 12, 4001)
    rate = np.array([-0.4, -1e-5, 0.0, 1e-5, 0.02, 0.7])
    expected = trapezoid(np.exp(-np.outer(rate, s)), s, axis=1)
    assert numbers(path_length(jit.Float(rate), jit.Float(12.0))) == pytest.approx(expected, rel=1e-4)


def test_fitted_rate_gives_the_whole_back():
    """Newton's method to rounding, from rates that rise to rates that leave a thousandth."""
    rate = np.array([-0.15, -0.01, 0.0, 0.003, 0.1, 1.0, 20.0])
    whole = path_length(jit.Float(rate), jit.Float(12.0)) * 3.0
    found = numbers(fitted_rate(whole, jit.Float(3.0), jit.Float(12.0)))
    assert found == pytest.approx(rate, rel=2e-3, abs=2e-5)


@pytest.mark.parametrize("g", [0.0, 0.5, 0.924])
def test_phase_functions_integrate_to_one(g: float):
    mu = np.linspace(-1, 1, 400_001)
    p = numbers(henyey_greenstein(jit.Float64(mu), g))
    assert 2 * math.pi * trapezoid(p, mu) == pytest.approx(1, abs=1e-6)
    assert 2 * math.pi * trapezoid(p * mu, mu) == pytest.approx(g, abs=1e-6)
    if g:
        back = 2 * math.pi * trapezoid(p[mu <= 0], mu[mu <= 0])
        assert back == pytest.approx(henyey_greenstein_backward(g), abs=1e-6)


def test_backward_share_of_henyey_greenstein():
    assert henyey_greenstein_backward(0.924) == pytest.approx(0.0170, abs=5e-5)


def test_molecules_scatter_half_backward():
    mu = np.linspace(-1, 1, 20_001)
    p = numbers(water_molecules(jit.Float64(mu)))
    assert 2 * math.pi * trapezoid(p, mu) == pytest.approx(1, abs=1e-6)
    assert 2 * math.pi * trapezoid(p[mu <= 0], mu[mu <= 0]) == pytest.approx(0.5, abs=1e-4)


def test_reflectance_of_the_surface():
    """n = 1.34: 0.0211 at normal incidence; total reflection from below past 48.27 degrees."""
    assert float(fresnel(jit.Float64(1.0), REFRACTIVE_INDEX)[0]) == pytest.approx(0.0211, abs=5e-5)
    assert math.degrees(critical_angle()) == pytest.approx(48.27, abs=0.01)
    for degrees, total in [(48.2, False), (48.3, True)]:
        r = float(fresnel(jit.Float64(math.cos(math.radians(degrees))), 1 / REFRACTIVE_INDEX)[0])
        assert (r == 1) is total


def test_snell_both_ways():
    for degrees in (5.0, 30.0, 48.0):
        angle = math.radians(degrees)
        down = jit.Array3f64(math.sin(angle), 0, -math.cos(angle))
        up = jit.Array3f64(0, 0, 1)
        inside = refract(down, up, 1 / REFRACTIVE_INDEX)
        assert float(inside.x[0]) == pytest.approx(math.sin(angle) / REFRACTIVE_INDEX, abs=1e-12)
        back = refract(-inside, -up, REFRACTIVE_INDEX)
        assert numbers(back) == pytest.approx(-numbers(down), abs=1e-12)
        assert numbers(reflect(down, up)) == pytest.approx([math.sin(angle), 0, math.cos(angle)], abs=1e-12)


def lamp(offset: float) -> Beam:
    return Beam(jit.Array3f(0, offset, 0), jit.Array3f(1, 0, 0), jit.Array3f(100), jit.Float(0.8), jit.Float(0.5))


def test_lamp_falls_with_the_square_and_the_water():
    water = some_water()
    keep = np.array(water.absorption) + np.array(water.backscatter)
    light = lamp(0.0)
    loss = loss_of(light, water.arrays())
    near, far = (numbers(light_at(light, loss, jit.Array3f(r, 0, 0), jit.Float(0.01))[0]) for r in (2.0, 5.0))
    assert near == pytest.approx(100 * np.exp(-keep * 2) / 4, rel=1e-5)
    assert far == pytest.approx(100 * np.exp(-keep * 5) / 25, rel=1e-5)


def test_lamp_beside_the_camera_lights_more_fog_than_one_aside():
    water = some_water().arrays()
    got = [float(lamp_backscatter(lamp(y), water, jit.Array3f(1, 0, 0), jit.Float(6.0)).y[0]) for y in (0.1, 0.3, 1.0)]
    assert got[0] > got[1] > got[2] > 0


def test_backscatter_is_the_integral_of_single_scattering():
    """Against 200 000 trapezoids: six steps of equal angle stay within 5 % for a lamp 0.5 m aside."""
    water, y, reach = some_water(), 0.5, 6.0
    s = np.linspace(0, reach, 200_001)
    r = np.hypot(s, y)
    turn = -s / r  # cosine between the line of sight and the way back to the lamp
    t = np.clip((s / r - 0.5) / 0.3, 0, 1)
    cone = t * t * (3 - 2 * t)
    g = 0.924
    phase = (1 - g * g) / (4 * math.pi) / (1 + g * g - 2 * g * turn) ** 1.5
    expected = []
    for a, bw, bp, bb in zip(
        water.absorption, water.water_scattering, water.particle_scattering, water.backscatter, strict=True
    ):
        f = 100 * cone * np.exp(-(a + bb) * (r + s)) * (bw / (4 * math.pi) + bp * phase) / r**2
        expected.append(trapezoid(f, s))
    got = numbers(lamp_backscatter(lamp(y), water.arrays(), jit.Array3f(1, 0, 0), jit.Float(reach)))
    assert got == pytest.approx(np.array(expected), rel=0.05)


def test_sun_is_whiter_and_brighter_high_up():
    low, high = daylight(math.radians(8)), daylight(math.radians(60))
    assert low.sun[0] / low.sun[2] > 2 * high.sun[0] / high.sun[2]
    assert 0.9e5 < np.mean(high.sun) < 1.1e5  # [lx], clear air
    assert 1e4 < np.mean(high.sky) < 2.5e4
    assert daylight(math.radians(-10)).sun == (0, 0, 0)
    overcast = daylight(math.radians(45), cloud=1.0)
    clear = daylight(math.radians(45))
    assert overcast.sun == pytest.approx((0, 0, 0), abs=1e-9)
    total = np.array(clear.sun) * math.sin(math.radians(45)) + np.array(clear.sky)
    assert overcast.sky == pytest.approx(0.3 * total, rel=1e-9)


def test_arrays_hold_the_numbers():
    water = water_optics("3C")
    arrays = water.arrays()
    assert isinstance(arrays, WaterArrays)
    assert numbers(arrays.attenuation) == pytest.approx(water.attenuation, rel=1e-6)
    assert numbers(arrays.backscatter) == pytest.approx(water.backscatter, rel=1e-6)
    dr.eval(arrays)

"""Bilge keels after Ikeda: moments of pressure by quadrature along the section, and other programs' figures."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pelagos.hydro.bilge_keel import Bilge, keel_force_damping, keel_pressure_damping, moment_before, moment_behind

BILGES = [Bilge(1.4, 10.0, 0.95, 2.0, 1.0), Bilge(1.1, 8.0, 0.9, 3.0, -2.0), Bilge(0.8, 8.0, 0.9, 3.0, -1.3)]
ROUNDED = 4e-4  # the published coefficients 0.414, 0.0651, 0.382, 0.0106, 0.215 and 1.414 have three digits


def contour(bilge: Bilge) -> tuple[np.ndarray, np.ndarray, float]:
    """Way along the section from the waterline [m], lever of a unit pressure there about the axis [m], bilge's middle.

    Upright side, quarter of a circle, flat bottom to the middle.
    """
    d, r, half, n = bilge.draught, bilge.radius, bilge.ratio * bilge.draught, 20001
    side, turn, bottom = np.linspace(0, d - r, n), np.linspace(0, np.pi / 2, n), np.linspace(0, half - r, n)
    y = np.concatenate([np.full(n, half), half - r + r * np.cos(turn), half - r - bottom])
    z = np.concatenate([side, d - r + r * np.sin(turn), np.full(n, d)])
    out = np.concatenate([np.ones(n), np.cos(turn), np.zeros(n)])
    down = np.concatenate([np.zeros(n), np.sin(turn), np.ones(n)])
    way = np.concatenate([side, d - r + r * turn, d - r + r * np.pi / 2 + bottom])
    return way, out * (z - bilge.depth_of_axis) - down * y, d - r + r * np.pi / 4


@pytest.mark.parametrize("bilge", BILGES)
def test_moment_of_the_pressure_before_the_keels(bilge: Bilge) -> None:
    """From 1 at the bilge's middle to 0 at the waterline at one bilge, to 0 at the keel at the other."""
    way, lever, middle = contour(bilge)
    up = np.where(way <= middle, way / middle, 0.0)
    along = np.where(way > middle, (way[-1] - way) / (way[-1] - middle), 0.0)
    expected = np.trapezoid((up - along) * lever, way) / bilge.draught**2
    assert moment_before(bilge) == pytest.approx(expected, rel=ROUNDED)


@pytest.mark.parametrize("of_radius", [0.3, 0.78, 1.6])
@pytest.mark.parametrize("bilge", BILGES)
def test_moment_of_the_wakes(bilge: Bilge, of_radius: float) -> None:
    """A unit pressure along the wake's length, up the side at one bilge and along the bottom at the other.

    Its ends lie between points of the contour, 1/20000 of a part: 3e-4 of the shortest wake.
    """
    way, lever, middle = contour(bilge)
    wake = of_radius * bilge.radius
    side, bottom = (way > middle - wake) & (way < middle), (way > middle) & (way < middle + wake)
    expected = np.trapezoid((side * 1.0 - bottom * 1.0) * lever, way) / bilge.draught**2
    assert moment_behind(bilge, wake) == pytest.approx(expected, rel=2 * ROUNDED)


def test_a_barge_and_a_ship_of_another_program() -> None:
    """Normal force and pressure, per length, by a public program after Chakrabarti's equations 46 to 60.

    Its figures: a barge of 49 m x 5.2 m whose axis is 13 m above the water, wake longer than the bilge; and a ship of
    30 m x 12 m, axis 1.5 m below, wake within the bilge. Density 1.025 t/m^3; 10 digits.
    """
    barge = Bilge(49 / 2 / 5.198, 5.198, 0.99, 2.4360402657672093, 5.198 - 18.21)
    ship = Bilge(30 / 2 / 12, 12.0, 0.96, 5.792279778942272, 1.5)
    for bilge, keel, force, pressure in (
        (barge, (0.45, 0.06, 2 * np.pi / 13.9, 1.025), 1265.4516556953367, 4910.035808612291),
        (ship, (0.3, 0.05, 0.5, 1.025), 135.01775319423888, 196.41960112795647),
    ):
        assert keel_force_damping(bilge, *keel) == pytest.approx(force, rel=1e-9)
        assert keel_pressure_damping(bilge, *keel) == pytest.approx(pressure, rel=2e-4)  # it has sqrt(2), not 1.414


def test_a_car_carrier_of_a_third_program() -> None:
    """The normal force on a ship's keels, 350 903 N s, that the tests of rolldecay-estimators (MIT) hold to 0.1 %."""
    bilge = Bilge(32.26 / 19, 9.5, 0.93, 5.0, 9.5 - 14.9)
    found = keel_force_damping(bilge, 0.4, np.radians(10), 2 * np.pi / 27.6, 1025.0)
    assert found == pytest.approx(3.509033728796537e5, rel=1e-3)


def test_keels_count_for_what_their_breadth_says() -> None:
    """The force: 22.5 b^2 f r^2 / pi of small rolls plus 2.4 b f^2 r^3 a, times 8/(3 pi) rho w."""
    bilge = BILGES[1]
    r, f = bilge.distance, bilge.flow_factor
    for b, a in ((0.2, 0.02), (0.5, 0.3)):
        expected = 8 / (3 * np.pi) * 1025 * 0.6 * (22.5 * b**2 * f * r**2 / np.pi + 2.4 * b * f**2 * r**3 * a)
        assert keel_force_damping(bilge, b, a, 0.6, 1025.0) == pytest.approx(expected, rel=1e-12)
    sharp = replace(bilge, fullness=0.999)
    assert sharp.flow_factor == pytest.approx(1 + 0.3 * np.exp(-0.16), rel=1e-12)

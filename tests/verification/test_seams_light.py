"""Signs, factors and axes of light, lenses and optical links: closed forms, inputs of both signs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.integrate import quad

from pelagos import jit
from pelagos.optics.caustics import TILE, Ripple, _slopes
from pelagos.optics.exposure import GREY, SATURATION, metered
from pelagos.optics.film import balance_gains
from pelagos.optics.interface import fresnel, reflect, surface_normal
from pelagos.optics.lens import Intrinsics, kannala_brandt, project
from pelagos.optics.optical_link import noise_current, received_power, sunlight_power
from pelagos.optics.radiative_transfer import mirror
from pelagos.optics.rain import drops_per_m3
from pelagos.optics.water import CHANNELS_NM, REFRACTIVE_INDEX


def numbers(values) -> np.ndarray:
    return np.array([np.array(v)[0] for v in values])


@pytest.mark.parametrize(("stops", "mean"), [(1.5, 80.0), (-2.0, 300.0)])
def test_compensation_lets_in_more_light_by_powers_of_two(stops: float, mean: float) -> None:
    keys = {"aperture": 4.0, "longest": 1e3, "shortest": 1e-9, "iso": (100.0, 100.0)}
    time, iso = metered(jit.Float(mean), compensation=stops, **keys)
    expected = SATURATION * 16 * GREY * 2.0**stops / (mean * 100)
    assert (numbers([time])[0], numbers([iso])[0]) == pytest.approx((expected, 100.0), rel=1e-5)


def test_fresnels_reflectance_at_three_angles() -> None:
    """Straight on, at Brewster's angle, where only the part across the plane is left, and past the critical one."""
    n = 1.34
    straight = ((n - 1) / (n + 1)) ** 2
    brewster = 0.5 * ((n * n - 1) / (n * n + 1)) ** 2
    cosines = [1.0, 1 / math.hypot(1, n), 1.0, 1 / math.hypot(1, 1 / n), 0.5]
    found = np.array(fresnel(jit.Float(cosines), jit.Float([n, n, 1 / n, 1 / n, 1 / n])))
    assert found == pytest.approx([straight, brewster, straight, brewster, 1.0], rel=1e-4)


def test_the_mirror_from_below_at_brewsters_angle() -> None:
    n = REFRACTIVE_INDEX
    expected = [((n - 1) / (n + 1)) ** 2, 0.5 * ((n * n - 1) / (n * n + 1)) ** 2, 1.0]
    assert mirror(np.array([1.0, n / math.hypot(1, n), 0.5])) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("slope", [(0.3, -0.2), (-0.5, 0.1)])
def test_a_tilted_mirror_turns_what_is_along_its_normal(slope: tuple[float, float]) -> None:
    normal = numbers(surface_normal(jit.Array2f(*slope)))
    assert normal @ [1, 0, slope[0]] == pytest.approx(0, abs=1e-6)
    assert normal @ [0, 1, slope[1]] == pytest.approx(0, abs=1e-6)
    assert normal[2] > 0
    way = np.array([0.6, -0.3, 0.74])
    back = numbers(reflect(jit.Array3f(*way.tolist()), jit.Array3f(*normal.tolist())))
    assert back @ normal == pytest.approx(-way @ normal, abs=1e-6)
    assert back - (back @ normal) * normal == pytest.approx(way - (way @ normal) * normal, abs=1e-6)


@pytest.mark.parametrize("point", [(4.0, 1.0, -2.0), (5.0, -1.5, 0.5)])
def test_what_lies_to_the_left_is_in_the_left_half(point: tuple[float, float, float]) -> None:
    """u = cx - fx y/x, v = cy - fy z/x of a pinhole; tangential distortion tells both axes apart."""
    camera = Intrinsics(fx=300.0, fy=310.0, cx=160.0, cy=118.0, width=320, height=240)
    x, y = -point[1] / point[0], -point[2] / point[0]
    assert project(np.array(point), camera) == pytest.approx([160 + 300 * x, 118 + 310 * y], rel=1e-9)
    k1, k2, p1, p2 = 0.1, -0.02, 0.01, -0.03
    r2 = x * x + y * y
    radial = 1 + k1 * r2 + k2 * r2 * r2
    u = x * radial + 2 * p1 * x * y + p2 * (r2 + 2 * x * x)  # Brown 1966, as OpenCV writes it
    v = y * radial + p1 * (r2 + 2 * y * y) + 2 * p2 * x * y
    found = project(np.array(point), camera, (k1, k2, p1, p2, 0.0))
    assert found == pytest.approx([160 + 300 * u, 118 + 310 * v], rel=1e-9)


def test_a_fisheyes_polynomial() -> None:
    theta = np.array([0.3, 0.9, -1.2])
    k = (0.05, -0.02, 0.013, -0.004)
    expected = np.polyval([k[3], 0, k[2], 0, k[1], 0, k[0], 0, 1, 0], theta)
    assert kannala_brandt(theta, k) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("order", [1.0, 4.8])
def test_all_the_power_of_a_lamp_arrives_on_a_sphere_around_it(order: float) -> None:
    """Integral over the half sphere of what a small detector that faces the lamp gets, without water; and with it."""

    def got(angle: float, attenuation: float = 0.0) -> float:
        return received_power(3.0, 2.0, attenuation, 1e-4, order=order, cos_lamp=math.cos(angle), cos_receiver=1.0)

    total = quad(lambda a: got(a) / 1e-4 * 2 * math.pi * 4.0 * math.sin(a), 0, math.pi / 2)[0]
    assert total == pytest.approx(3.0, rel=1e-6)
    assert got(0.4, 0.25) == pytest.approx(got(0.4) * math.exp(-0.5), rel=1e-12)
    assert got(2.0) == 0.0


def test_shot_and_thermal_noise_of_a_photodiode() -> None:
    """2 q I B: 1 mA over 1 MHz are 17.9 nA; 4 k T B/R: 50 ohm at 290 K over 1 MHz are 17.9 nA."""
    assert noise_current(5e-4, 3e-4, 2e-4, 1e6, 1e12) == pytest.approx(17.901e-9, rel=1e-4)
    assert noise_current(0.0, 0.0, 0.0, 1e6, 50.0) == pytest.approx(17.897e-9, rel=1e-4)


@pytest.mark.parametrize("half", [0.3, 1.1])
def test_daylight_in_a_cone_is_the_integral_of_its_radiance(half: float) -> None:
    radiance = 40.0 * 0.02 / math.pi
    expected = quad(lambda a: radiance * math.cos(a) * 2 * math.pi * math.sin(a) * 5e-4, 0, half)[0]
    assert sunlight_power(40.0, 5e-4, half, 0.02) == pytest.approx(expected, rel=1e-9)


@pytest.mark.parametrize("rate", [1.0, 25.0])
def test_raindrops_of_marshall_and_palmer(rate: float) -> None:
    """J. S. Marshall, W. McK. Palmer, J. Meteor. 5:165 (1948): 8000 exp(-4.1 R^-0.21 D) per m^3 and mm."""
    expected = quad(lambda d: 8000 * math.exp(-4.1 * rate**-0.21 * d), 1.0, 50.0, limit=200)[0]
    assert float(np.array(drops_per_m3(jit.Float(rate)))[0]) == pytest.approx(expected, rel=1e-3)


def test_ripples_return_after_their_period() -> None:
    """omega^2 = g k + (surface tension over density) k^3: a wave of 8 cm is back after 0.2168 s, not 0.2264 s."""
    k = 2 * math.pi / TILE * math.hypot(96, 28)
    period = 2 * math.pi / math.sqrt(9.81 * k + 7.3e-5 * k**3)
    sea = Ripple(i=(96,), j=(28,), height=(0.002,), phase=(0.4,))
    (x0, y0), (x1, y1), (x2, _) = (
        _slopes(sea, sea.height, jit.Float64([t]), 1) for t in (0.0, 3 * period, 3.5 * period)
    )
    size = float(np.abs(np.array(x0)).max())
    assert size > 0
    for before, after in ((x0, x1), (y0, y1)):
        assert np.array(after) == pytest.approx(np.array(before), abs=2e-3 * size)
    assert np.array(x2) == pytest.approx(-np.array(x0), abs=2e-3 * size)


@pytest.mark.parametrize("kelvin", [3200.0, 9000.0])
def test_white_balance_undoes_a_black_bodys_colour(kelvin: float) -> None:
    """Gains of light of T and of 6500 K are as their radiances, by Planck's law with c2 = 1.4388e-2 m K."""

    def planck(nm: float, t: float) -> float:
        return nm**-5 / math.expm1(1.4388e-2 / (nm * 1e-9 * t))

    gains = [planck(nm, 6500.0) / planck(nm, kelvin) for nm, _ in CHANNELS_NM.values()]
    assert balance_gains(kelvin, 0.0) == pytest.approx([g / gains[1] for g in gains], rel=2e-3)
    red, green, blue = balance_gains(kelvin, 0.7)  # magenta: less green
    assert (red / green, blue / green) == pytest.approx([2**0.7 * g / gains[1] for g in (gains[0], gains[2])], rel=2e-3)

"""The clear sky against daylight recommendations, the CIE's standard sky, and what is measured in twilight."""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.clear_sky import COLUMNS, ROWS, clear_sky
from pelagos.optics.sunlight import daylight, sky_radiance

SOLAR_LX = 133_800.0
LUMINOUS = np.array([0.2126, 0.7152, 0.0722])  # of red, green, blue (ITU-R BT.709)


def lux(values: np.ndarray) -> float:
    return SOLAR_LX * float(values @ LUMINOUS)


@pytest.mark.parametrize("degrees", [20, 30, 45, 60])
def test_beam_and_sky_of_clear_days(degrees: float) -> None:
    """IES, Recommended Practice for the Calculation of Daylight Availability, J. IES 13:381 (1984), clear sky: beam
    127.5 klx exp(-0.21 m), sky 0.8 + 15.5 sqrt(sin h) klx on level ground.

    Means over many days; on one, it says, the sky can be twice or half as bright. Ours has the haze of clear sea air:
    within 10 % of the beam, and the sky by up to 30 % brighter.
    """
    h = math.radians(degrees)
    mass = 1 / (math.sin(h) + 0.50572 * (degrees + 6.07995) ** -1.6364)
    sky = clear_sky(h)
    assert lux(sky.beam) == pytest.approx(127.5e3 * math.exp(-0.21 * mass), rel=0.1)
    assert 1.0 < lux(sky.irradiance) / (800 + 15.5e3 * math.sqrt(math.sin(h))) < 1.3


@pytest.mark.parametrize("degrees", [20, 40, 60])
def test_luminance_is_spread_as_in_the_standard_clear_sky(degrees: float) -> None:
    """CIE S 011/E:2003, type 12 (low turbidity): a = -1, b = -0.32, c = 10, d = -3, e = 0.45.

    It is one of fifteen kinds of sky; those next to it in turbidity (types 11 and 13) differ by as much. From 10 deg
    up and more than 30 deg from the sun, where haze matters least: within a third.
    """
    a, b, c, d, e = -1.0, -0.32, 10.0, -3.0, 0.45
    sun = math.radians(degrees)

    def relative(up: np.ndarray, chi: np.ndarray) -> np.ndarray:
        return (1 + a * np.exp(b / up)) * (1 + c * (np.exp(d * chi) - math.exp(d * math.pi / 2)) + e * np.cos(chi) ** 2)

    up, side = (np.arange(ROWS) / (ROWS - 1)) ** 2, np.linspace(0, math.pi, COLUMNS)
    rows = up > math.sin(math.radians(10))
    cosine = np.sqrt(1 - up**2)[:, None] * np.cos(side) * math.cos(sun) + up[:, None] * math.sin(sun)
    chi = np.arccos(np.clip(cosine, -1, 1))
    ours = clear_sky(sun).radiance @ LUMINOUS
    standard = relative(np.maximum(up, 1e-6)[:, None], chi)
    ratio = (ours / ours[-1, 0]) / (standard / standard[-1, 0])
    far = rows[:, None] & (chi > math.radians(30))
    assert far.sum() > 200
    assert ratio[far].min() > 0.75
    assert ratio[far].max() < 1.34


def test_twilight() -> None:
    """AMS Glossary of Meteorology, civil twilight: 585 to 410 lx when the sun sets, 3.5 to 2 lx when it is 6 deg down.

    Light that was scattered several times is taken as even all round, which makes the end too bright: by a factor 2.5.
    """
    sunset, dusk = (lux(clear_sky(math.radians(h)).irradiance) for h in (-50 / 60, -6.0))
    assert 400 < sunset < 650
    assert 2 < dusk < 2.5 * 3.5
    assert lux(clear_sky(math.radians(-9)).irradiance) < 0.1 * dusk


def test_the_sky_is_blue_overhead_and_red_where_the_sun_sets() -> None:
    noon, evening = clear_sky(math.radians(45)).radiance, clear_sky(math.radians(1)).radiance
    assert noon[-1, 0, 2] > 1.7 * noon[-1, 0, 0]  # molecules alone, scattering once: (605 / 465)^4 = 2.9
    towards_sun = evening[4, 0]  # one degree up
    assert towards_sun[0] > 1.5 * towards_sun[1]
    assert towards_sun[1] > 1.5 * towards_sun[2]
    assert evening[-1, 0, 2] > 1.2 * evening[-1, 0, 0]  # ozone keeps the zenith blue (E. O. Hulburt 1953)


@pytest.mark.parametrize("cloud", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("degrees", [4, 45])
def test_all_radiance_of_the_sky_makes_its_irradiance(degrees: float, cloud: float) -> None:
    """Integral over the upper half of what cameras see, by 200 x 360 midpoints: 1 % for the table's linear steps."""
    light = daylight(math.radians(degrees), 1.0, cloud=cloud)
    square, side = np.meshgrid((np.arange(200) + 0.5) / 200, np.radians(np.arange(360)), indexing="ij")
    up, level = np.sqrt(square).ravel(), np.sqrt(1 - square).ravel()
    d = jit.Array3f(level * np.cos(side.ravel()), level * np.sin(side.ravel()), up)
    mean = np.array(sky_radiance(light.arrays(), d, glare=0.0)).mean(axis=1) * math.pi
    assert mean == pytest.approx(np.array(light.sky), rel=0.01)
    assert dr.width(d) == 72_000

"""Daylight in the water: discrete ordinates against conservation, eigenvalues, tables and themselves."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from scipy.integrate import trapezoid

from pelagos import jit
from pelagos.optics.light_field import beam_at, diffuse_irradiance, diffuse_radiance, light_field, window_radiance
from pelagos.optics.light_tables import CRITICAL_COSINE, entering
from pelagos.optics.radiative_transfer import MODES, Above, Field, WaterChannel, gauss, media, solve
from pelagos.optics.sunlight import Daylight, daylight
from pelagos.optics.water import (
    JERLOV_TYPES,
    MEAN_COSINE,
    channel_means,
    spectra,
    table_sun,
    water_optics,
)


def sun_alone(medium: WaterChannel, depths: Any, towards_sun: float = 1.0) -> Field:
    """Under a black sky, with a beam of 1 lx."""
    u, weight = gauss(CRITICAL_COSINE, 1, 16)
    return solve(medium, Above(towards_sun, 1.0, u, weight, np.zeros(16)), depths)


def beam(field: Field) -> Any:
    """Irradiance across what no water has scattered [lx]."""
    return np.exp(-field.medium.attenuation * field.depths / field.above.towards_sun)


def moment(field: Field, power: int) -> Any:
    """Integral of L u^power over all directions, beam included: scalar irradiance, net irradiance."""
    scattered = 2 * math.pi * field.radiance[:, :, 0] @ (field.weight * field.u**power)
    return scattered * np.exp(-field.medium.decay * field.depths) + beam(field) * field.above.towards_sun**power


def downward(field: Field) -> Any:
    """Irradiance on a level surface from above [lx]."""
    scattered = 2 * math.pi * field.radiance[:, :, 0] @ (field.weight * np.maximum(field.u, 0))
    return scattered * np.exp(-field.medium.decay * field.depths) + beam(field) * field.above.towards_sun


@pytest.mark.parametrize("towards_sun", [1.0, 0.8])
@pytest.mark.parametrize(
    "medium", [WaterChannel(0.1, 0.002, 0.4), WaterChannel(0.02, 0.004, 0.01), WaterChannel(0.05, 0.0, 1.0)]
)
def test_what_is_lost_of_net_irradiance_is_absorbed(medium: WaterChannel, towards_sun: float):
    """Gershun's law, d(E_d - E_u)/dz = -a E_0 (1939), between each two depths.

    The source is taken as linear between depths, which leaves (c h)^2 / 12 = 4e-4 of it at steps of c h = 0.07 in the
    most turbid; 1e-3 with what orders of scattering beyond 1e-5 add.
    """
    depths = np.arange(0, 4, 0.02) / medium.decay
    field = sun_alone(medium, depths, towards_sun)
    net, scalar = moment(field, 1), moment(field, 0)
    assert net[0] - net[-1] == pytest.approx(medium.absorption * trapezoid(scalar, depths), rel=1e-3)


@pytest.mark.parametrize("ratio", [2.0, 4.0, pytest.param(8.0, marks=pytest.mark.slow)])
def test_deep_light_falls_at_the_rate_of_the_slowest_mode(ratio: float):
    """Asymptotic attenuation: the greatest eigenvalue 1 / k of the moments' three-term recurrence,

    (2 l + 1)(1 - w g^l) psi_l = k ((l + 1) psi_{l+1} + l psi_{l-1}), lengths in 1 / c (C. D. Mobley, Light and Water,
    1994, Section 9.6), 200 moments of the whole phase function. Delta-M keeps the first 16; 0.5 % covers the rest, and
    that the slowest mode still mixes with the next at twenty optical lengths.
    """
    medium = WaterChannel(1.0, 0.0, ratio)
    c = 1 + ratio
    order = np.arange(200)
    h = (2 * order + 1) * (1 - ratio / c * MEAN_COSINE**order)
    off = (order[:-1] + 1) / np.sqrt(h[:-1] * h[1:])
    k = c / np.linalg.eigvalsh(np.diag(off, 1) + np.diag(off, -1)).max()
    depths = np.linspace(0, 20 / medium.decay, 400)
    light = np.log(moment(sun_alone(medium, depths), 0))
    found = -(light[-1] - light[-40]) / (depths[-1] - depths[-40])
    assert found == pytest.approx(k, rel=0.005)


MOST_OVER = {
    "I": 0.02, "IA": 0.02, "IB": 0.08, "II": 0.065, "III": 0.06,
    "1C": 0.045, "3C": 0.05, "5C": 0.055, "7C": 0.06, "9C": 0.06,
}  # fmt: skip


@pytest.mark.parametrize("name", JERLOV_TYPES)
def test_irradiance_against_depth_is_the_table(name: str):
    """E of the solution under the sun that the tables are of, against exp(-Kd z) down to where a tenth is left.

    Kd is the mean over that depth, so that both ends meet: `kirk` fits the solution within 0.3 % of K, over ln 10 = 2.3
    optical lengths 0.7 % of E. Between them light has fallen more slowly, as it goes straight down at first: by
    `MOST_OVER` at most, in water that scatters a few times as much as it absorbs. Kd as it is found from a measured
    profile, the slope of ln E by least squares (R. C. Smith and K. S. Baker, 1984), is the table's within 2 %.
    """
    water, sun = water_optics(name), table_sun(name)
    for kd, medium in zip(channel_means(spectra(name).downwelling), media(water), strict=True):
        depths = np.linspace(0, math.log(10) / kd, 120)
        down = downward(sun_alone(medium, depths, sun))
        assert down[-1] / down[0] == pytest.approx(0.1, rel=0.007)
        assert down / down[0] == pytest.approx(np.exp(-kd * depths), rel=MOST_OVER[name])
        assert -np.polyfit(depths, np.log(down), 1)[0] == pytest.approx(kd, rel=0.02)


@pytest.mark.parametrize("name", JERLOV_TYPES)
def test_light_from_the_zenith_falls_to_a_tenth_as_kirk_says(name: str):
    """Within 0.3 % of K, 0.7 % of E."""
    water = water_optics(name)
    for kd, medium in zip(water.downwelling, media(water), strict=True):
        down = downward(sun_alone(medium, np.linspace(0, math.log(10) / kd, 120)))
        assert down[-1] / down[0] == pytest.approx(0.1, rel=0.007)


def test_turning_off_scattering_leaves_the_beam():
    depths = np.linspace(0, 20, 30)
    field = sun_alone(WaterChannel(0.1, 1e-9, 0.0), depths, 0.9)
    assert downward(field) == pytest.approx(0.9 * np.exp(-0.1 * depths / 0.9), rel=1e-6)


def test_what_goes_down_at_the_surface_is_what_comes_up_mirrored() -> None:
    """Fresnel's reflectance of the surface from below, of all light that was scattered, once or often, in each
    direction of the solution; a direction's own interpolation converges to 1e-3.
    """
    field = sun_alone(WaterChannel(0.06, 0.01, 0.3), np.linspace(0, 60, 240), 0.8)
    up = field.u < 0
    u = -field.u[up]
    sine = 1.34 * np.sqrt(1 - u**2)  # in air
    air = np.sqrt(np.maximum(1 - sine**2, 0.0))
    s, p = (1.34 * u - air) / (1.34 * u + air), (u - 1.34 * air) / (u + 1.34 * air)
    share = np.where(sine >= 1, 1.0, 0.5 * (s**2 + p**2))
    expected = share[:, None] * field.radiance[0, up]
    assert field.at(u)[0] == pytest.approx(expected, abs=1e-3 * np.abs(expected).max())


SUN = daylight(math.radians(45), 1.0)


@pytest.mark.parametrize("name", ["I", "II", "1C", "9C"])
def test_tables_hold_all_light_at_any_depth(name: str):
    """Beam and diffuse light of the tables on level ground, against the solution itself with its sky.

    The fourth-order series of max(n . d, 0) is off by 2 % at the zenith; tables between depths by another.
    """
    water = water_optics(name)
    depths = np.array([0.0, 1.0, 5.0])
    field = light_field(water, SUN)
    up = jit.Array3f(0, 0, 1)
    z = jit.Float(depths)
    got = np.array(beam_at(field, z) * field.below.z + diffuse_irradiance(field, z, up))
    for c, (medium, above) in enumerate(zip(media(water), entering(SUN), strict=True)):
        fine = np.unique(np.concatenate([depths, np.geomspace(0.01, 60, 80)]))
        solved = solve(medium, above, fine)
        sky = np.exp(-medium.attenuation * fine[:, None] / above.window_u)
        sky = 2 * math.pi * sky @ (above.window * above.window_weight * above.window_u)
        scattered = 2 * math.pi * solved.radiance[:, :, 0] @ (solved.weight * np.maximum(solved.u, 0))
        straight = above.sun * above.towards_sun * np.exp(-medium.attenuation * fine / above.towards_sun)
        whole = straight + sky + scattered * np.exp(-medium.decay * fine)
        assert got[c] == pytest.approx(np.interp(depths, fine, whole), rel=0.04)


def test_the_window_is_as_wide_as_snell_says():
    """arcsin(1 / 1.34) = 48.27 deg from the zenith, the edge to a hundredth of a degree."""
    field, light = light_field(water_optics("I"), SUN), SUN.arrays()
    angle = np.radians([0.0, 30.0, 48.26, 48.28, 60.0])
    direction = jit.Array3f(jit.Float(np.sin(angle)), 0, jit.Float(np.cos(angle)))
    seen = np.array(window_radiance(field, light, jit.Float(2.0), direction))
    assert (seen[:, :2] > 0).all()
    assert (seen[:, 2] >= 0).all()
    assert (seen[:, 3:] == 0).all()


def test_light_from_below_is_a_few_hundredths():
    """Irradiance reflectance R = E_u / E_d = 0.33 b_b / (a + b_b) in clear water (H. R. Gordon et al. 1975): to 30 %,
    which sky light, and Henyey and Greenstein's backscatter of 0.0170 in place of 0.0183, account for."""
    water = water_optics("IB")
    field = light_field(water, SUN)
    up, z = jit.Array3f(0, 0, 1), jit.Float(0.0)
    down = np.array(beam_at(field, z) * field.below.z + diffuse_irradiance(field, z, up)).ravel()
    back = np.array(diffuse_irradiance(field, z, -up)).ravel()
    a, bb = np.array(water.absorption), np.array(water.backscatter)
    ratio = (back / down) / (0.33 * bb / (a + bb))
    assert ratio[1:] == pytest.approx([1, 1], abs=0.3)


def test_night_is_dark_and_finite():
    night = Daylight((1.0, 0.0, -0.2), (0.0, 0.0, 0.0), (1e-3, 1e-3, 1e-3))
    field = light_field(water_optics("1C"), night)
    seen = np.array(diffuse_radiance(field, jit.Float(3.0), jit.Array3f(0.6, 0, 0.8)))
    assert np.isfinite(seen).all()
    assert (seen >= 0).all()
    assert seen.max() < 1e-3


def test_modes_are_those_of_the_phase_function():
    """As many azimuth modes as moments: the light of a low sun, far off its plane, is not negative by more than 1 % of
    the brightest."""
    field = sun_alone(WaterChannel(0.1, 0.002, 0.3), np.linspace(0, 20, 40), 0.75)
    sides = np.cos(np.arange(MODES)[:, None] * np.linspace(0, math.pi, 9))
    radiance = field.radiance @ sides
    assert radiance.min() > -0.01 * radiance.max()

"""Rays past stations and fields of beams, in water of one speed: straight lines between surface and bottom."""

from __future__ import annotations

import math

import numpy as np

from pelagos.acoustics.section import Section
from pelagos.acoustics.transmission_loss import field, ray_depths, ray_paths

DEPTHS = (40.0, 75.0, 60.0)
SECTIONS = [
    Section(np.array([0.0, d]), np.full(2, 1500.0), np.zeros(1), np.array([d]), density_ratio=1e9) for d in DEPTHS
]
STATIONS = 7


def folded(start: float, angle: float, x: np.ndarray, depth: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Depth, and bounces at surface and bottom, of a straight line that is folded between both."""
    line = start + math.tan(angle) * x
    crossed = np.floor(line / depth).astype(int)  # sheets: odd ones are upside down
    z = np.where(crossed % 2 == 0, line - crossed * depth, (crossed + 1) * depth - line)
    count = np.abs(crossed)
    first_at_bottom = angle > 0
    bottom = (count + 1) // 2 if first_at_bottom else count // 2
    return z, count - bottom, bottom


def test_rays_pass_stations_at_equal_parts_of_their_reach_with_their_bounces() -> None:
    """A fan of five in 60 m, bounces up to each station."""
    angles, reach = np.array([-0.5, -0.11, 0.03, 0.2, 0.62]), 700.0
    found = ray_paths(SECTIONS[2], 23.0, angles, reach, stations=STATIONS)
    x = reach / STATIONS * np.arange(1, STATIONS + 1)
    np.testing.assert_allclose(found.x, x)
    np.testing.assert_array_equal(found.angle, angles)
    for k, angle in enumerate(angles):
        z, surface, bottom = folded(23.0, angle, x, 60.0)
        np.testing.assert_allclose(found.depth[k], z, atol=1e-6)
        assert found.surface[k].tolist() == surface.tolist()
        assert found.bottom[k].tolist() == bottom.tolist()
    assert (found.surface != found.bottom).any()


def test_rays_of_several_sections_have_their_own_water_reach_and_depth() -> None:
    """Four rays in three sections, in another order."""
    path, source = np.array([2, 0, 1, 0]), np.array([23.0, 5.0, 61.0, 31.0])
    angle, reach = np.array([0.31, -0.2, 0.14, 0.4]), np.array([350.0, 210.0, 980.0, 140.0])
    found = ray_depths(SECTIONS, path, source, angle, reach, stations=STATIONS)
    assert found.shape == (4, STATIONS)
    for k in range(4):
        x = reach[k] / STATIONS * np.arange(1, STATIONS + 1)
        np.testing.assert_allclose(found[k], folded(source[k], angle[k], x, DEPTHS[path[k]])[0], atol=1e-6)


def test_beams_in_open_lossy_water_are_a_spherical_wave() -> None:
    """exp(-i k R)/R less absorption, on and off the axis: levels within 0.05 dB.

    Coherent ones within 0.13 dB and 0.13 rad, near by: beams are pi wavelengths wide, and straight across. Surface and
    bottom are far away.
    """
    widest = 0.7
    section = Section(np.array([0.0, 4000.0]), np.full(2, 1480.0), absorption=0.01, frequency=2e3)
    depths = 2000.0 + np.array([-190.0, -70.0, 0.0, 25.0, 140.0])
    made = field(section, 2000.0, reach=600.0, columns=3, depths=depths, widest=widest, beams=900)
    away = np.hypot(made.x[:, None], depths - 2000.0)
    loss = 20 * np.log10(away) + 0.01 * away
    inside = np.abs(depths - 2000.0) < 0.8 * math.tan(widest) * made.x[:, None]
    assert inside.sum() >= 12
    np.testing.assert_allclose(made.incoherent_loss_db[inside], loss[inside], atol=0.05)
    np.testing.assert_allclose(made.loss_db[inside], loss[inside], atol=0.13)
    turned = np.angle(made.pressure * np.exp(2j * np.pi * 2e3 / 1480.0 * away))
    np.testing.assert_allclose(turned[inside], 0.0, atol=0.13)

"""What rays lose on their way, by straight images in water of one speed: absorption, bubbles, and the bottom's pieces.

Sources: as of `layered_rays`; APL-UW TR 9407 (1994), Sections II (bubbles) and IV (bottoms).
"""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from pelagos.acoustics.eigenrays import Arrivals, eigenrays
from pelagos.acoustics.section import Section

BOUNCES = 4
LEVELS, ABSORPTION = np.array([0.0, 25.0, 60.0]), np.array([2e-3, 2e-2, 6e-3])
SPEED, SURFACE = np.full(3, 1490.0), np.zeros(1)
PATCHES = {"density_ratio": [1.9, 1.2, 2.4], "sound_speed_ratio": [1.12, 0.97, 1.3], "loss": [0.02, 0.005, 0.04]}
SECTIONS = [
    Section(LEVELS, SPEED, np.array([0.0, 190.0, 430.0]), np.full(3, 60.0), absorption=ABSORPTION, frequency=30e3,
            wind_speed=12.0, begins=SURFACE, **PATCHES),
    Section(np.array([5.0, 90.0]), np.full((2, 2), 1525.0), np.array([0.0, 310.0]), np.full(2, 75.0), frequency=14e3,
            absorption=np.array([[1e-3, 1e-3], [9e-3, 9e-3]]), wind_speed=4.0, begins=np.array([0.0, 260.0]),
            density_ratio=[1.6, 2.0], sound_speed_ratio=[1.05, 1.2], loss=0.03),
    Section(LEVELS, SPEED, np.zeros(1), np.array([60.0]), absorption=3 * ABSORPTION, frequency=20e3, begins=SURFACE,
            density_ratio=1.4, sound_speed_ratio=1.1),
]  # fmt: skip
SOURCE, RECEIVER, REACH = np.array([12.0, 61.0, 44.0]), np.array([37.0, 20.0, 8.0]), np.array([640.0, 700.0, 350.0])


def lost(section: Section, z: list[float], reach: float) -> float:
    """Absorption [dB] along straight legs between depths `z`, evenly in x: of columns, or of levels."""
    rise = sum(abs(b - a) for a, b in pairwise(z))
    way = math.hypot(rise, reach)
    table = np.atleast_2d(section.absorption)
    if len(table) > 1:
        share = section.begins[1] / reach
        return float(way * (share * table[0, 0] + (1 - share) * table[1, 0]))
    fine = np.linspace(0.0, 60.0, 60_001)
    below = np.interp(fine, section.depth, table[0])
    column = np.concatenate([[0.0], np.cumsum(0.5 * (below[1:] + below[:-1]) * np.diff(fine))])
    return float(sum(abs(np.diff(np.interp([a, b], fine, column))[0]) for a, b in pairwise(z)) * way / rise)


def reflection(section: Section, x: float, sine: float) -> complex:
    """Of the piece behind the last node before x; exp(+i omega t)."""
    k = int(np.searchsorted(section.bottom_x, x, side="right")) - 1
    rho, nu, delta = (
        np.broadcast_to(v, section.bottom_x.shape)[k]
        for v in (section.density_ratio, section.sound_speed_ratio, section.loss)
    )
    inside = np.sqrt(((1 + 1j * delta) / nu) ** 2 - (1 - sine**2) + 0j)
    return complex(np.conj((rho * sine - inside) / (rho * sine + inside)))


def bubbles(section: Section, sine: float) -> float:
    """Of one bounce [dB]."""
    u = section.wind_speed
    if u == 0.0:
        return 0.0
    loss = 1.26e-3 * max(u, 6.0) ** 1.57 * (section.frequency / 1e3) ** 0.85 * math.exp(1.2 * min(u - 6.0, 0.0))
    return min(loss / sine, 15.0)


def images(k: int) -> list[tuple[float, float, float, int, int, complex]]:
    """Length, departure, arrival, bounces at surface and bottom, amplitude of every path, shortest first."""
    section, bottom, reach = SECTIONS[k], float(SECTIONS[k].bottom_depth[0]), float(REACH[k])
    found = []
    for down in (True, False):
        for count in range(BOUNCES + 1):
            walls = [bottom if (n % 2 == 0) == down else 0.0 for n in range(count)]
            z = [float(SOURCE[k]), *walls, float(RECEIVER[k])]
            if count == 0 and (z[1] > z[0]) != down:
                continue
            legs = np.abs(np.diff(z))
            rise = float(legs.sum())
            sine, at = rise / math.hypot(rise, reach), np.cumsum(legs) * reach / rise
            amplitude = 10.0 ** (-lost(section, z, reach) / 20.0) / math.hypot(rise, reach) + 0j
            for wall, x in zip(walls, at, strict=False):
                amplitude *= reflection(section, x, sine) if wall else -(10.0 ** (-bubbles(section, sine) / 20.0))
            ends = math.asin(sine) if down else -math.asin(sine), math.copysign(math.asin(sine), z[-1] - z[-2])
            found.append((math.hypot(rise, reach), *ends, walls.count(0.0), count - walls.count(0.0), amplitude))
    return sorted(found)


@pytest.fixture(scope="module")
def arrivals() -> Arrivals:
    return eigenrays(SECTIONS, SOURCE, RECEIVER, REACH, rays=256, bounces=BOUNCES)


@pytest.mark.parametrize("k", range(3))
def test_images_lose_what_water_bubbles_and_each_piece_of_the_bottom_take(arrivals: Arrivals, k: int) -> None:
    """Three sections at once, of other numbers of nodes, levels and columns, two with the same profile."""
    expected, found = images(k), arrivals.of(k)
    assert len(found) == len(expected) == 2 * BOUNCES + 1
    length, departure, arrival, surface, bottom, amplitude = (np.array(v) for v in zip(*expected, strict=True))
    speed = float(np.ravel(SECTIONS[k].speed)[0])
    np.testing.assert_allclose(found.length, length, rtol=1e-8)
    np.testing.assert_allclose(found.delay, length / speed, rtol=1e-8)
    np.testing.assert_allclose(found.departure, departure, atol=1e-7)
    np.testing.assert_allclose(found.arrival, arrival, atol=1e-7)
    assert found.surface.tolist() == surface.tolist()
    assert found.bottom.tolist() == bottom.tolist()
    assert not found.caustics.any()
    np.testing.assert_allclose(found.surface_sine, np.where(surface > 0, np.abs(np.sin(arrival)), 0.0), atol=1e-7)
    np.testing.assert_allclose(found.amplitude, amplitude, rtol=3e-5)
    assert np.abs(np.angle(amplitude)).max() > 0.3
    np.testing.assert_allclose(found.loss_db, -20 * np.log10(np.abs(amplitude)), atol=3e-4)
    assert k or max(bubbles(SECTIONS[0], s) for s in np.abs(np.sin(departure))) == 15.0


def test_ends_stand_over_their_own_ground() -> None:
    """Up and down a slope, of which one end lies deeper than the ground at the other; and from the ground itself."""
    x, depth = np.array([0.0, 300.0, 640.0]), np.array([100.0, 75.0, 50.0])
    water = {"depth": np.array([0.0, 120.0]), "speed": np.full((2, 2), 1500.0), "begins": np.array([0.0, 260.0])}
    sections = [Section(bottom_x=x, bottom_depth=d, **water) for d in (depth, depth[::-1].copy(), depth)]
    ends = np.array([[94.0, 30.0], [30.0, 94.0], [100.0, 20.0]])
    found = eigenrays(sections, ends[:, 0], ends[:, 1], np.full(3, 640.0), rays=256, bounces=0)
    rise = np.diff(ends, axis=1)[:, 0]
    assert found.path.tolist() == [0, 1, 2]
    np.testing.assert_allclose(found.length, np.hypot(640.0, rise), rtol=1e-8)
    np.testing.assert_allclose(found.departure, np.arctan2(rise, 640.0), atol=1e-7)

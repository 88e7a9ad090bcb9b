"""The clearance map: many positions at once give what each gives alone."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos.raycast.geometry import Geometry
from pelagos.world.clearance import Clearance


def scattered(seed: int) -> Clearance:
    """300 triangles of a few metres at random places and heights."""
    random = np.random.default_rng(seed)
    first = random.uniform([-60, -40, -30], [80, 90, -5], (300, 3))
    corners = np.stack([first, *(first + random.uniform(-3, 3, (2, 300, 3)))], axis=1).reshape(-1, 3)
    return Clearance([Geometry(corners, np.arange(900, dtype=np.uint32).reshape(-1, 3), 0, 1, 1)])


def by_hand(of: Clearance, x: float, y: float, z: float, margin: float) -> bool:
    """Ask every cell whether it lies in the square of the margin."""
    for (i, j), top in np.ndenumerate(of.top):
        low, high = of.x0 + i * of.cell, of.y0 + j * of.cell
        across = low <= x + margin and low + of.cell > x - margin
        along = high <= y + margin and high + of.cell > y - margin
        if across and along and top >= z - margin:
            return True
    return False


def test_many_positions_look_at_the_cells_that_each_reaches():
    clearance, random = scattered(3), np.random.default_rng(4)
    places, margins = random.uniform([-90, -70, -40], [110, 120, 0], (400, 3)), random.uniform(0.1, 30, 400)
    together = clearance.near(places, margins)
    assert together.tolist() == [by_hand(clearance, *p, m) for p, m in zip(places.tolist(), margins, strict=True)]
    assert together.tolist() == [bool(clearance.near(p[None], m)[0]) for p, m in zip(places, margins, strict=True)]
    assert 0.2 < together.mean() < 0.8


@pytest.mark.parametrize("broken", [math.nan, math.inf])
def test_what_is_not_finite_counts_as_near_and_harms_no_other(broken):
    clearance = scattered(3)
    places = np.array([[500.0, -300.0, 0.0], [broken, 2.0, -3.0], [1.0, 2.0, -60.0]])
    assert clearance.near(places, np.array([2.0, 3.0, 4.0])).tolist() == [False, True, True]
    assert clearance.near(places[[0, 2]], np.array([1e9, 4.0])).tolist() == [True, True]

"""Sections of hulls for strip theory: where a mesh meets the water."""

from __future__ import annotations

import numpy as np
import pytest
import trimesh

from pelagos.errors import InputError
from pelagos.vehicles.shape.stations import mesh_stations

KEEL, DECK, HALF_KEEL, HALF_DECK, LENGTH, ASIDE = 0.7, -0.5, 0.4, 1.0, 6.0, 0.3  # FRD: the deck is up


def prism() -> trimesh.Trimesh:
    """A hull of one section, a trapezoid, that lies a bit to starboard."""
    corners = [
        [x, ASIDE + side * half, z]
        for x in (-LENGTH / 2, LENGTH / 2)
        for z, half in ((KEEL, HALF_KEEL), (DECK, HALF_DECK))
        for side in (-1, 1)
    ]
    return trimesh.convex.convex_hull(np.array(corners))


def test_sections_end_in_the_waterline() -> None:
    """The sides are straight: half the beam at the water is between those of keel and deck, as the heights are."""
    hull = prism()
    found = mesh_stations(np.array(hull.vertices), np.array(hull.faces), 5)
    half = HALF_KEEL + (HALF_DECK - HALF_KEEL) * KEEL / (KEEL - DECK)
    assert [s.position for s in found] == pytest.approx([-2.4, -1.2, 0.0, 1.2, 2.4])
    for station in found:
        assert station.side == pytest.approx(ASIDE)
        assert station.points[0] == pytest.approx([-half, 0.0])
        assert station.points[-1] == pytest.approx([half, 0.0])
        assert station.points[:, 1].min() == pytest.approx(-KEEL, abs=0.01)  # points at even distances round corners


def test_stations_reach_as_far_as_the_water() -> None:
    """Stem and stern are raked: not as far as the deck, and beyond the keel, in the same proportion as the heights."""
    keel, deck = (-2.0, 1.5), (-2.6, 3.5)
    corners = [
        [x, side * half, z]
        for ends, z, half in ((keel, KEEL, HALF_KEEL), (deck, DECK, HALF_DECK))
        for x in ends for side in (-1, 1)
    ]  # fmt: skip
    hull = trimesh.convex.convex_hull(np.array(corners))
    found = mesh_stations(np.array(hull.vertices), np.array(hull.faces), 8)
    stern, stem = (a + (b - a) * KEEL / (KEEL - DECK) for a, b in zip(keel, deck, strict=True))
    length = (stem - stern) / 8
    assert [s.position for s in found] == pytest.approx(stern + length * (np.arange(8) + 0.5))
    assert {round(s.width, 9) for s in found} == {round(length, 9)}


def test_a_hull_beside_the_water_has_no_section() -> None:
    hull = prism()
    with pytest.raises(InputError, match="does not float at z = 0"):
        mesh_stations(np.add(hull.vertices, [0.0, 0.0, 2.0]), np.array(hull.faces), 5)

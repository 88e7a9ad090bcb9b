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


def test_a_hull_beside_the_water_has_no_section() -> None:
    hull = prism()
    with pytest.raises(InputError, match="does not float at z = 0"):
        mesh_stations(np.add(hull.vertices, [0.0, 0.0, 2.0]), np.array(hull.faces), 5)

"""Restoring and rest of a box that floats, against the formulas of a wall-sided hull."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.vehicles.hull_at_rest import mesh_stiffness, to_waterline, unbalanced, unbalanced_rest
from pelagos.vehicles.shape.pontoon import PontoonConfig, pontoon_mesh

LENGTH, BEAM, DRAUGHT, AHEAD = 6.0, 2.0, 0.5, 0.7
VOLUME = LENGTH * BEAM * DRAUGHT
RHO, G = 1025.0, 9.81
HULL = PontoonConfig(length_m=LENGTH, beam_m=BEAM, freeboard_m=0.8, position_x_m=AHEAD)


def body(weight: float = RHO * G * VOLUME, center: tuple[float, float, float] = (AHEAD, 0.0, 0.1)) -> Any:
    return SimpleNamespace(density=RHO, gravity=G, weight=weight, center_of_gravity=np.array(center))


def test_a_wall_sided_hull_rights_itself_by_its_waterplane() -> None:
    """G33 = rho g A, G35 = -rho g A x_f, G44 and G55 = rho g (I - V z_B) + W z_G, z down."""
    area, down = LENGTH * BEAM, DRAUGHT / 2
    expected = np.zeros((6, 6))
    expected[2, 2] = RHO * G * area
    expected[2, 4] = expected[4, 2] = -RHO * G * area * AHEAD
    rest = -RHO * G * VOLUME * (down - 0.1)
    expected[3, 3] = RHO * G * LENGTH * BEAM**3 / 12 + rest
    expected[4, 4] = RHO * G * (BEAM * LENGTH**3 / 12 + area * AHEAD**2) + rest
    found = mesh_stiffness(*pontoon_mesh(HULL, DRAUGHT), body())
    moments = np.ix_([2, 3, 4], [2, 3, 4])
    assert found[moments] == pytest.approx(expected[moments], rel=1e-3, abs=1e-3 * RHO * G)
    assert found[:, [0, 1, 5]] == pytest.approx(np.zeros((6, 3)))


def test_what_weight_and_water_leave_unbalanced() -> None:
    """A weight that is 90 N too small, ahead of the hull's middle and to starboard: it lifts, and tilts by its arms."""
    heavy = body(RHO * G * VOLUME - 90.0, (1.1, 0.2, -0.3))
    arm = np.array([AHEAD, 0.0, DRAUGHT / 2])
    expected = [
        0.0,
        0.0,
        -90.0,
        *(np.cross(arm, [0, 0, -RHO * G * VOLUME]) + np.cross([1.1, 0.2, -0.3], [0, 0, heavy.weight])),
    ]
    afloat: Any = SimpleNamespace(hulls=(HULL,))
    assert unbalanced(afloat, DRAUGHT, heavy) == pytest.approx(expected, rel=1e-9, abs=1e-6)
    assert unbalanced_rest(heavy, VOLUME, arm) == pytest.approx(expected, rel=1e-9, abs=1e-6)
    halves = tuple(
        PontoonConfig(length_m=LENGTH / 2, beam_m=BEAM, freeboard_m=0.8, position_x_m=AHEAD + s * LENGTH / 4)
        for s in (1, -1)
    )
    two: Any = SimpleNamespace(hulls=halves)
    assert unbalanced(two, DRAUGHT, heavy) == pytest.approx(expected, rel=1e-9, abs=1e-6)


def test_a_hull_up_to_the_water_has_no_deck() -> None:
    vertices, _ = to_waterline(HULL, DRAUGHT)
    assert (vertices[:, 2].min(), vertices[:, 2].max()) == (0.0, DRAUGHT)

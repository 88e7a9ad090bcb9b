"""Sections as tables on the device, and seen from their other end, by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from pelagos.acoustics.layered_water import LEVELS
from pelagos.acoustics.section import Section, mirrored, on_device, thinned

SHALLOW = Section(
    np.array([4.0, 9.0, 31.0]), np.array([1502.0, 1497.5, 1511.0]), np.array([0.0, 80.0, 210.0]),
    np.array([33.0, 47.0, 41.0]), absorption=np.array([0.001, 0.003, 0.002]), density_ratio=[1.2, 1.5, 1.9],
    sound_speed_ratio=[0.98, 1.05, 1.1], loss=[0.01, 0.02, 0.03], frequency=26e3, wind_speed=11.0,
)  # fmt: skip
FINE = np.linspace(0.0, 240.0, 161)
KINKED = 1490.0 + np.stack([0.016 * FINE, 0.016 * FINE + 9.0 * np.exp(-(((FINE - 70.0) / 9.0) ** 2))])
DEEP = Section(FINE, KINKED, np.array([0.0, 500.0]), np.array([60.0, 900.0]), absorption=1e-4 * (KINKED - 1400.0),
               begins=np.array([0.0, 300.0]), frequency=26e3)  # fmt: skip


def test_sections_are_rows_of_tables_with_as_many_nodes_levels_and_columns() -> None:
    """Of profiles with more levels than there is room for those that tell the water of all columns within 2 mm/s; what
    only fills the tables lies below each bottom, and behind each path."""
    deeper = replace(SHALLOW, bottom_depth=SHALLOW.bottom_depth + 700.0, wind_speed=7.0)  # of the same profile
    water, floor = on_device([SHALLOW, DEEP, deeper])
    assert np.array(water.columns).tolist() == [2, 2, 2]
    assert np.array(floor.nodes).tolist() == [3, 3, 3]
    depth = np.array(water.depth).reshape(3, LEVELS)
    speed, absorption = (np.array(v).reshape(3, 2, LEVELS) for v in (water.speed, water.absorption))
    assert (np.diff(depth, axis=1) > 0).all()
    assert depth[:, 0].tolist() == [0.0, 0.0, 0.0]
    for k, (section, levels) in enumerate(((SHALLOW, 4), (DEEP, LEVELS - 4), (deeper, 4))):
        filling = depth[k][depth[k] > section.depth[-1]]
        assert len(filling) >= LEVELS - levels
        assert filling.min() > section.bottom_depth.max()
        z = np.linspace(0.0, 300.0, 701)
        for column in range(2):
            known = np.atleast_2d(section.speed)[min(column, len(section.begins) - 1)]
            made = np.interp(z, depth[k], speed[k, column])
            np.testing.assert_allclose(made, np.interp(z, section.depth, known), atol=2.1e-3)
    np.testing.assert_allclose(absorption[1], 1e-4 * (speed[1] - 1400.0), rtol=1e-12)
    np.testing.assert_allclose(absorption[0, 0, :4], [0.001, 0.001, 0.003, 0.002])
    begins = np.array(water.begins).reshape(3, 2)
    assert begins[1].tolist() == [0.0, 300.0]
    assert begins[:, 0].tolist() == [0.0, 0.0, 0.0]
    assert begins[[0, 2], 1].min() > 1e8
    bounces = [1.26e-3 * wind**1.57 * 26.0**0.85 for wind in (11.0, 0.0, 7.0)]
    assert np.array(water.bubble_loss) == pytest.approx(bounces, rel=1e-5)
    x, bottom = (np.array(v).reshape(3, 3) for v in (floor.x, floor.depth))
    assert x[0].tolist() == SHALLOW.bottom_x.tolist()
    assert x[1, :2].tolist() == [0.0, 500.0]
    assert x[1, 2] > 1e8
    assert bottom.tolist() == [[33.0, 47.0, 41.0], [60.0, 900.0, 900.0], [733.0, 747.0, 741.0]]
    materials = (floor.density_ratio, floor.sound_speed_ratio, floor.loss)
    for values, given in zip(materials, ([1.2, 1.5, 1.9], [0.98, 1.05, 1.1], [0.01, 0.02, 0.03]), strict=True):
        np.testing.assert_allclose(np.array(values).reshape(3, 3)[[0, 2]], [given, given])


def test_a_profile_is_thinned_where_it_is_straight() -> None:
    """Ends and kinks are kept, in their order, the worst first where there is room for few."""
    z = np.arange(0.0, 101.0, 10.0)
    bent = np.interp(z, [0, 30, 70, 100], [1500.0, 1490.0, 1496.0, 1480.0])
    assert thinned(z, bent, levels=9).tolist() == [0, 3, 7, 10]
    assert thinned(z, bent, levels=3).tolist() == [0, 7, 10]
    assert thinned(z, bent, levels=2).tolist() == [0, 10]
    assert thinned(z, bent, levels=9, error=20.0).tolist() == [0, 10]
    dip = np.full(11, 1500.0)
    dip[5] = 1485.0
    assert thinned(z, np.stack([bent, dip]), levels=12).tolist() == [0, 3, 4, 5, 6, 7, 10]


def test_a_column_begins_where_it_says() -> None:
    assert DEEP.speed_at([70.0, 70.0, 70.0], [299.999, 300.0, 1e6]) == pytest.approx(
        [1490.0 + 1.12, 1490 + 10.12, 1490 + 10.12], abs=0.07
    )


def test_a_section_seen_from_its_other_end_has_all_its_materials_and_columns_there() -> None:
    """Cut at 400 m, between the last nodes; a piece's material is that of its node on the side of the source."""
    section = Section(
        SHALLOW.depth, np.stack([SHALLOW.speed + k for k in range(3)]), np.array([0.0, 90.0, 250.0, 700.0]),
        np.array([40.0, 55.0, 38.0, 83.0]), absorption=np.stack([0.001 * (k + SHALLOW.depth) for k in range(3)]),
        density_ratio=[1.1, 1.2, 1.3, 1.4], sound_speed_ratio=[0.9, 1.0, 1.05, 1.2], loss=[0.1, 0.2, 0.3, 0.4],
        begins=np.array([0.0, 120.0, 330.0]),
    )  # fmt: skip
    seen = mirrored(section, 400.0)
    assert seen.bottom_x.tolist() == [0.0, 150.0, 310.0, 400.0]
    assert seen.bottom_depth.tolist() == pytest.approx([53.0, 38.0, 55.0, 40.0])
    assert seen.begins.tolist() == [0.0, 70.0, 280.0]
    for name, values in (("density_ratio", [1.3, 1.2, 1.1]), ("sound_speed_ratio", [1.05, 1.0, 0.9]),
                         ("loss", [0.3, 0.2, 0.1])):  # fmt: skip
        assert np.asarray(getattr(seen, name))[:3].tolist() == values
    np.testing.assert_array_equal(seen.speed, section.speed[::-1])
    np.testing.assert_array_equal(seen.absorption, np.asarray(section.absorption)[::-1])
    assert np.array_equal(mirrored(replace(section, absorption=0.004), 400.0).absorption, 0.004)
    near = mirrored(section, 200.0)
    assert (near.begins.tolist(), near.bottom_x.tolist()) == ([0.0, 80.0], [0.0, 110.0, 200.0])
    np.testing.assert_array_equal(near.speed, section.speed[1::-1])
    assert math.isclose(float(near.bottom_at(0.0)), 55.0 - 17.0 * 110 / 160)

"""Sections of the sea as the tables that rays are traced in: levels, columns, nodes, and both ends exchanged."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from pelagos.acoustics.layered_water import LEVELS
from pelagos.acoustics.sea_surface import bubble_loss_db
from pelagos.acoustics.section import Section, Sections, mirrored, on_device, thinned

BOTTOM_X, BOTTOM = np.array([0.0, 300.0, 900.0, 1500.0]), np.array([60.0, 90.0, 70.0, 120.0])
STREAM = Section(
    np.array([5.0, 20.0, 80.0]),
    np.array([[1500.0, 1490.0, 1510.0], [1480.0, 1470.0, 1505.0], [1520.0, 1515.0, 1530.0]]),
    BOTTOM_X, BOTTOM, absorption=np.array([[0.01, 0.02, 0.03], [0.02, 0.03, 0.04], [0.03, 0.05, 0.06]]),
    density_ratio=np.array([1.5, 1.8, 2.0, 2.4]), sound_speed_ratio=1.1, loss=np.array([0.1, 0.2, 0.3, 0.4]),
    frequency=30e3, wind_speed=9.0, begins=np.array([0.0, 400.0, 1000.0]),
)  # fmt: skip
CALM = Section(np.array([0.0, 50.0]), np.array([1500.0, 1450.0]), absorption=0.007)


def test_tables_hold_each_section_in_its_row() -> None:
    """Levels from the surface on, where the uppermost speed goes on; below, levels that only fill; columns and nodes
    that a row does not have begin behind every path."""
    water, floor = on_device([CALM, STREAM])
    depth = np.array(water.depth).reshape(2, LEVELS)
    speed, loss = (np.array(v).reshape(2, 3, LEVELS) for v in (water.speed, water.absorption))
    assert depth[1, :4].tolist() == [0.0, 5.0, 20.0, 80.0]
    assert (np.diff(depth, axis=1) > 0).all()
    assert depth[0, 2] > 1e5
    assert depth[1, 4] > 120.0
    for column in range(3):
        assert speed[1, column, :5].tolist() == [*STREAM.speed[column][[0, 0, 1, 2]], STREAM.speed[column][2]]
        assert loss[1, column, 1:5] == pytest.approx([*np.asarray(STREAM.absorption)[column], 0.01 * (3, 4, 6)[column]])
        assert speed[0, column, :3].tolist() == [1500.0, 1450.0, 1450.0]
        assert loss[0, column] == pytest.approx(0.007)
    begins = np.array(water.begins).reshape(2, 3)
    assert begins[1].tolist() == [0.0, 400.0, 1000.0]
    assert begins[0, 0] == 0.0
    assert (begins[0, 1:] > 1e6).all()
    assert np.array(water.columns).tolist() == [3, 3]
    assert np.array(water.bubble_loss) == pytest.approx([0.0, float(bubble_loss_db(1.0, 30e3, 9.0))])
    assert np.array(floor.nodes).tolist() == [4, 4]
    x, bottom, density, ratio, lost = (
        np.array(v).reshape(2, 4)
        for v in (floor.x, floor.depth, floor.density_ratio, floor.sound_speed_ratio, floor.loss)
    )
    assert x[1].tolist() == BOTTOM_X.tolist()
    assert bottom[1].tolist() == BOTTOM.tolist()
    assert density[1].tolist() == [1.5, 1.8, 2.0, 2.4]
    assert ratio[1].tolist() == [1.1] * 4
    assert lost[1].tolist() == [0.1, 0.2, 0.3, 0.4]
    assert (x[0, 1:] > 1e6).all()
    assert (np.diff(x[0]) > 0).all()
    assert bottom[0].tolist() == [1e5] * 4


def test_sections_that_share_their_water_have_each_its_own_bottom() -> None:
    """The lowest filling level lies below the bottom of each; tables of `Sections` are made once."""
    flat = Section(CALM.depth, CALM.speed, np.zeros(1), np.array([40.0]))
    deep = replace(flat, bottom_depth=np.array([3000.0]))
    both = Sections([flat, deep])
    water, _ = on_device(both)
    depth = np.array(water.depth).reshape(2, LEVELS)
    assert depth[0, 2] == pytest.approx(150.0)
    assert depth[1, 2] == pytest.approx(3100.0)
    assert on_device(both) is on_device(both)


def test_a_shorter_section_goes_on_as_behind_its_last_node_and_column() -> None:
    short = Section(
        CALM.depth, CALM.speed, np.array([0.0, 70.0]), np.array([40.0, 55.0]), density_ratio=np.array([1.2, 1.9])
    )
    _, floor = on_device([short, STREAM])
    assert np.array(floor.depth)[:4].tolist() == [40.0, 55.0, 55.0, 55.0]
    assert np.array(floor.density_ratio)[:4].tolist() == [1.2, 1.9, 1.9, 1.9]
    assert (np.diff(np.array(floor.x)[:4]) > 0).all()
    two = Section(CALM.depth, np.array([[1500.0, 1450.0], [1520.0, 1490.0]]), begins=np.array([0.0, 250.0]))
    water, _ = on_device([two, STREAM])
    assert np.array(water.speed).reshape(2, 3, LEVELS)[0, :, 0].tolist() == [1500.0, 1520.0, 1520.0]


def test_many_levels_are_thinned_to_those_that_tell_the_profile() -> None:
    """Levels on a line say nothing; of two columns' bends both are kept, first the larger."""
    depth = np.linspace(0.0, 200.0, 201)
    bent = [np.interp(depth, [0, 70, 200], c) for c in ([1500.0, 1480.0, 1490.0], [1510.0, 1510.0, 1510.0])]
    bent[1] += np.interp(depth, [0, 130, 200], [0.0, 5.0, 0.0])
    assert thinned(depth, np.array(bent), levels=20).tolist() == [0, 70, 130, 200]
    assert thinned(depth, np.array(bent), levels=3).tolist() == [0, 70, 200]
    assert thinned(depth, bent[0] * 0 + 1500.0, levels=20).tolist() == [0, 200]
    assert thinned(depth, 1500.0 + 1e-3 * np.sin(depth), levels=20).tolist() == [0, 200]
    curved = 1500.0 + 1e-3 * (depth - 90.0) ** 2
    water, _ = on_device([Section(depth, curved, np.zeros(1), np.array([150.0]))])
    table, speed = np.array(water.depth), np.array(water.speed)
    assert np.interp(depth, table, speed) == pytest.approx(curved, abs=0.02)  # chords of 60 levels: 1e-3 (200/59)^2/4


def test_speed_and_bottom_at_a_place_are_its_columns_and_pieces() -> None:
    assert float(STREAM.speed_at(12.5, 399.0)) == pytest.approx(1495.0)
    assert float(STREAM.speed_at(12.5, 401.0)) == pytest.approx(1475.0)
    assert STREAM.speed_at([2.0, 200.0], [1200.0, 0.0]) == pytest.approx([1520.0, 1510.0])
    assert CALM.speed_at([25.0, 90.0], [0.0, 1e4]) == pytest.approx([1475.0, 1450.0])
    assert STREAM.bottom_at([150.0, 600.0, 5000.0]) == pytest.approx([75.0, 80.0, 120.0])


def test_a_section_seen_from_its_other_end_has_the_same_water_and_bottom_at_each_place() -> None:
    reach = 1300.0
    back = mirrored(STREAM, reach)
    place = np.array([10.0, 250.0, 390.0, 410.0, 890.0, 950.0, 1010.0, 1190.0, 1280.0])
    for depth in (3.0, 12.0, 60.0):
        assert back.speed_at(depth, reach - place) == pytest.approx(STREAM.speed_at(depth, place))
    assert back.bottom_at(reach - place) == pytest.approx(STREAM.bottom_at(place))

    def behind(section: Section, name: str, x: np.ndarray) -> np.ndarray:
        """Of the piece that begins at the node before."""
        rows = np.broadcast_to(np.asarray(getattr(section, name), float), section.bottom_x.shape)
        return np.asarray(rows[np.searchsorted(section.bottom_x, x, side="right") - 1])

    for name in ("density_ratio", "loss", "sound_speed_ratio"):
        assert behind(back, name, reach - place) == pytest.approx(behind(STREAM, name, place))
    column = lambda s, x: np.asarray(s.absorption)[np.searchsorted(s.begins, x, side="right") - 1]
    assert column(back, reach - place) == pytest.approx(column(STREAM, place))
    assert (back.frequency, back.wind_speed) == (30e3, 9.0)

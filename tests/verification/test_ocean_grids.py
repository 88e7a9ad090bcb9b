"""Parts of reading gridded seas by themselves: windows, longitudes, gaps, edges and levels, by hand."""

from __future__ import annotations

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.math.interpolate import bilinear, triangulated
from pelagos.ocean.curvilinear import _even_levels, _inside, _span
from pelagos.ocean.netcdf import _window, around
from pelagos.ocean.netcdf_variable import cell_of, in_our_units, without_gaps


@pytest.mark.parametrize(
    ("window", "first", "rows"),
    [(None, 0, (0, 12)), ((3.2, 5.8, 9.0, 9.1), 0, (2, 8)), ((0.0, 1.0, 4.5, 20.0), 2, (3, 12)),
     ((-9.0, 0.5, 0.0, 0.0), 0, (0, 3)), ((6.3, 6.6, 0.0, 0.0), 0, (4, 9)), ((6.6, 6.7, 0.0, 0.0), 0, (5, 10))],
)  # fmt: skip
def test_a_window_is_covered_with_two_more_entries_on_each_side(window: Any, first: int, rows: tuple[int, int]) -> None:
    """Of 0 to 11; between two entries the nearer one is its middle."""
    found = _window(np.arange(12.0), window, first)
    assert (found.start, found.stop) == rows


def test_longitudes_are_counted_about_the_place() -> None:
    """As they are where all are near; shifted where they still increase; cut on the far side, and one read once."""
    near, order = around(np.array([-20.0, 10.0, 159.0]), 20.0)
    assert (near.tolist(), order) == ([-20.0, 10.0, 159.0], None)
    near, order = around(np.array([352.0, 356.0, 364.0]), 3.0)
    assert (near.tolist(), order) == ([-8.0, -4.0, 4.0], None)
    near, order = around(np.array([364.0, 356.0, 352.0]), 3.0)
    assert (near.tolist(), order) == ([4.0, -4.0, -8.0], None)
    near, order = around(np.array([-170.0, -150.0]), 175.0)
    assert (near.tolist(), order) == ([190.0, 210.0], None)
    near, order = around(np.arange(0.0, 361.0, 90.0), 10.0)
    assert order is not None
    assert (near.tolist(), order.tolist()) == ([-90.0, 0.0, 90.0, 180.0], [3, 0, 1, 2])


def test_gaps_are_filled_from_the_nearest_of_the_level_else_from_above() -> None:
    """Cells twice as high as wide: two columns away is as near as one row, three columns are farther."""
    nan = np.nan
    values = np.array([[[[nan, nan, nan], [1.0, nan, 7.0]], [[nan] * 3, [nan] * 3]],
                       [[[4.0, 5.0, nan], [nan, nan, 9.0]], [[nan, 3.0, nan], [nan] * 3]]])  # fmt: skip
    filled = without_gaps(values, np.isnan(values), zero=False, cell=(1.5, 1.0))
    assert filled[0, 0, :, [0, 2]].tolist() == [[1.0, 1.0], [7.0, 7.0]]
    assert filled[0, 0, 1, 1] in (1.0, 7.0)
    np.testing.assert_array_equal(filled[0, 1], filled[0, 0])
    assert filled[1, 0].tolist() == [[4.0, 5.0, 5.0], [4.0, 9.0, 9.0]]
    assert filled[1, 1].tolist() == [[3.0] * 3] * 2
    still = without_gaps(values, np.isnan(values), zero=True, cell=(1.5, 1.0))
    np.testing.assert_array_equal(still, np.nan_to_num(values))
    dry = np.stack([np.full((1, 2, 2), nan), np.arange(4.0).reshape(1, 2, 2)])[None, :, 0]
    found = without_gaps(dry, np.isnan(dry), zero=False, cell=(1.0, 1.0))
    assert found[0, 0].tolist() == [[1.5, 1.5], [1.5, 1.5]]  # nothing above the first level: the mean of all


def test_cells_are_as_wide_as_meridians_are_apart() -> None:
    row, column = np.array([58.0, 60.0, 62.0, 70.0]), np.array([3.0, 6.0, 9.5])
    assert cell_of(row[:3], column, metric=False) == pytest.approx((2.0, 3.25 * 0.5))
    assert cell_of(row, column, metric=True) == (2.0, 3.25)
    assert cell_of(row[:1], column, metric=True) == (1.0, 3.25)


@pytest.mark.parametrize(
    ("label", "units", "factor"),
    [("east", "cm s-1", 0.01), ("up", "m.s-1", 1.0), ("salinity", "kg kg-1", 1e3), ("salinity", "g kg^-1", 1.0),
     ("chlorophyll", "kg m-3", 1e6), ("chlorophyll", "g m**-3", 1e3), ("chlorophyll", "\u00b5g/l", 1.0),
     ("oxygen", "mmol m-3", 1 / 1.025), ("oxygen", "mol m-3", 1e3 / 1.025), ("oxygen", "mg/l", 1e3 / 31.9988 / 1.025),
     ("oxygen", "ml l-1", 1e3 / 22.3916 / 1.025), ("oxygen", "\u03bcmol kg-1", 1.0), ("dye", "furlongs", 1.0)],
)  # fmt: skip
def test_values_come_in_our_units(label: str, units: str, factor: float) -> None:
    variable: Any = SimpleNamespace(attrs={"units": units}, encoding={}, name="v")
    found = in_our_units(np.array([2.0, -0.5]), label, variable, Path("sea.nc"))
    assert found == pytest.approx(np.array([2.0, -0.5]) * factor, rel=1e-5)


def test_temperatures_come_in_celsius() -> None:
    for units, expected in (("K", 6.85), ("degC", 280.0)):
        variable: Any = SimpleNamespace(attrs={"units": units}, encoding={}, name="v")
        assert in_our_units(np.array([280.0]), "temperature", variable, Path("sea.nc")) == pytest.approx(expected)


def test_edges_with_most_points_outside_are_cut_off_first() -> None:
    """A corner of two rows and one column, and a last column: the second plane lacks another row."""
    first, second = np.ones((6, 8, 3)), np.ones((6, 8, 3))
    first[:, -1], second[0, :5] = np.nan, np.nan
    assert _inside([first]) == (0, 6, 0, 7)
    assert _inside([first, second]) == (1, 6, 0, 7)
    left = np.ones((6, 8, 3))
    left[2:, :2] = np.nan
    assert _inside([left]) == (0, 6, 2, 8)
    below = np.ones((6, 8, 3))
    below[4:, 1:] = np.nan
    assert _inside([below]) == (0, 4, 0, 8)


@pytest.mark.parametrize(("near", "rows"), [
    ([0, 0, 1, 1, 0, 0], (1, 5)), ([1, 0, 0, 0, 1, 0], (0, 6)), ([0] * 6, (0, 6)), ([0, 0, 0, 0, 0, 1], (4, 7)),
])  # fmt: skip
def test_what_is_near_is_taken_with_one_more_on_each_side(near: list[int], rows: tuple[int, int]) -> None:
    found = _span(np.array(near, bool))
    assert (found.start, found.stop) == rows


def test_levels_are_those_of_a_deep_a_middle_and_a_shallow_column() -> None:
    """Of five columns 10 to 50 m deep: the shallowest, the second, the middle and the deepest; none above the water."""
    depths = np.array([30.0, 10.0, 50.0, 20.0, 40.0])
    z = -np.array([-0.01, 0.5, 1.0])[:, None] * depths
    found = _even_levels(z.reshape(1, 3, 1, 5))
    assert found.tolist() == [0.0, 5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 50.0]
    assert _even_levels(np.zeros((1, 3, 1, 2))).tolist() == [0.0, 1.0]


@pytest.mark.parametrize("rule", [bilinear, triangulated])
def test_grids_hold_up_to_their_last_nodes_and_no_farther(rule: Any) -> None:
    """Three rows and five columns of a plane: exact everywhere on it, to the last corner; not a number beyond."""
    grid = 2.0 * np.arange(3)[:, None] - 0.7 * np.arange(5) + 1.0
    i, j = np.array([0.0, 2.0, 2.0, 1.3, 0.0, 2.0]), np.array([0.0, 4.0, 0.0, 3.9, 4.0, 1.6])
    np.testing.assert_allclose(rule(grid, i, j), 2.0 * i - 0.7 * j + 1.0)
    rough = np.random.default_rng(4).normal(size=(3, 5))
    np.testing.assert_allclose(
        rule(rough, np.array([0.0, 2.0, 1.0]), np.array([3.0, 4.0, 2.0])), rough[[0, 2, 1], [3, 4, 2]]
    )
    beyond = rule(grid, np.array([-1e-6, 2.000001, 1.0, 1.0]), np.array([1.0, 1.0, -1e-6, 4.000001]))
    assert np.isnan(beyond).all()

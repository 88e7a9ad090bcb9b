"""Lanes of pictures: tiles of squares, blocks of both sizes, and places between them, against plain loops and SciPy.

Two unlike pictures whose sides are no multiples of a tile or of each other.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import convolve, map_coordinates, uniform_filter

from pelagos import jit
from pelagos.sensors.camera.picture import ambient_light, exposure_lag, light_shafts, pixel_blocks, pixel_order
from pelagos.sensors.camera.picture.pixel_order import Tiling, pixels

WIDTH, HEIGHT, IMAGES = 53, 37, 2
TILING = Tiling(WIDTH, HEIGHT)
ROWS, COLUMNS = 3, 4  # of tiles
PLACES = [  # (row, column) of each lane of a picture
    (16 * ty + 4 * sy + y, 16 * tx + 4 * sx + x)
    for ty in range(ROWS) for tx in range(COLUMNS) for sy in range(4) for sx in range(4) for y in range(4)
    for x in range(4)
]  # fmt: skip
PICTURE = np.random.default_rng(8).uniform(-1.0, 3.0, (IMAGES, HEIGHT, WIDTH))


def in_lanes(pictures: NDArray[np.float64]) -> Any:
    """`Float` by lane; a number that nobody should look at outside of the pictures."""
    return jit.Float([p[r, c] if r < HEIGHT and c < WIDTH else 1e6 for p in pictures for r, c in PLACES])


def near(values: Any, row: Any, column: Any) -> NDArray[np.float64]:
    """Bilinear, repeating the edge."""
    return np.asarray(map_coordinates(values, [np.ravel(row), np.ravel(column)], order=1, mode="nearest"))


def test_lanes_go_square_by_square_and_tile_by_tile() -> None:
    where = pixels(TILING, IMAGES)
    rows, columns = np.array(PLACES).T
    assert (TILING.across, TILING.down, TILING.tiles, TILING.lanes) == (COLUMNS, ROWS, 12, 12 * 256)
    assert np.array(where.row).tolist() == rows.tolist() * IMAGES
    assert np.array(where.column).tolist() == columns.tolist() * IMAGES
    assert np.array(where.image).tolist() == np.repeat([0, 1], TILING.lanes).tolist()
    assert np.array(where.ray).tolist() == list(range(TILING.lanes)) * IMAGES
    active = (rows < HEIGHT) & (columns < WIDTH)
    assert np.array(where.active).tolist() == active.tolist() * IMAGES
    back = pixel_order.lane_at(TILING, where.image, where.column, where.row)
    assert np.array(back).tolist() == list(range(IMAGES * TILING.lanes))
    edged = PICTURE[0][np.minimum(rows, HEIGHT - 1), np.minimum(columns, WIDTH - 1)]
    np.testing.assert_allclose(TILING.arrange(PICTURE[0]), edged, rtol=1e-6)
    again = pixel_order.image_rows(in_lanes(PICTURE), TILING, where, IMAGES)
    np.testing.assert_allclose(np.array(again).reshape(PICTURE.shape), PICTURE, rtol=1e-6)


def test_means_of_tiles_and_pictures_leave_idle_lanes_out() -> None:
    where = pixels(TILING, IMAGES)
    light = [jit.Array3f(*(k * in_lanes(PICTURE) for k in ks)) for ks in ((1.0, -2.0, 0.5), (3.0, 0.0, 0.25))]
    tiles = [[p[r : r + 16, c : c + 16] for r in (0, 16, 32) for c in (0, 16, 32, 48)] for p in PICTURE]
    means = np.array([[t.mean() for t in row] for row in tiles])
    for found, ks in zip(pixel_order.tile_means(light, where.active), ((1, -2, 0.5), (3, 0, 0.25)), strict=True):
        np.testing.assert_allclose(np.array(found), np.outer(ks, means.ravel()), rtol=1e-4, atol=1e-5)
    sizes = [t.size for row in tiles for t in row]
    assert np.array(pixel_order.tile_sizes(TILING, IMAGES)).tolist() == sizes
    found = np.array(pixel_order.image_means(in_lanes(PICTURE), where.active, TILING))
    np.testing.assert_allclose(found, PICTURE.mean(axis=(1, 2)), rtol=1e-5)


def test_tiles_under_a_tent_and_between() -> None:
    values = np.random.default_rng(3).uniform(0.5, 4.0, (3, IMAGES, ROWS, COLUMNS))
    coarse = jit.Array3f(values.reshape(3, -1).astype(np.float32))
    tent = np.outer([1, 2, 1], [1, 2, 1]) / 16
    smooth = np.array([[convolve(v, tent, mode="nearest") for v in part] for part in values])
    np.testing.assert_allclose(
        np.array(pixel_order.smooth_tiles(coarse, TILING, IMAGES)), smooth.reshape(3, -1), rtol=1e-5
    )
    where = pixels(TILING, IMAGES)
    found = np.array(pixel_order.between_tiles(coarse, TILING, where)).reshape(3, IMAGES, -1)
    row, column = (np.array(PLACES).T + 0.5) / 16 - 0.5
    for part in range(3):
        for image in range(IMAGES):
            np.testing.assert_allclose(found[part, image], near(values[part, image], row, column), rtol=1e-4)
    row, column = np.array([3.4, -9.0, 36.0, 80.0, 17.2]), np.array([20.7, 31.0, -4.0, 99.0, 51.9])
    image = np.array([0, 1, 1, 0, 1], dtype=np.uint32)
    lanes = [jit.UInt32(image), jit.Float(column), jit.Float(row)]
    found = np.array(pixel_order.pixel_values_at(in_lanes(PICTURE), TILING, *lanes))
    expected = [near(PICTURE[i], r, c)[0] for i, r, c in zip(image, row, column, strict=True)]
    np.testing.assert_allclose(found, expected, rtol=1e-4, atol=1e-5)
    packed = jit.Float(np.moveaxis(np.concatenate([values, values[:1]]), 0, -1).ravel())
    four = np.array(pixel_order.tiles_at(packed, TILING, *lanes, jit.Array4f))
    for part in range(4):
        at = zip(image, (row + 0.5) / 16 - 0.5, (column + 0.5) / 16 - 0.5, strict=True)
        np.testing.assert_allclose(four[part], [near(values[part % 3, i], r, c)[0] for i, r, c in at], rtol=1e-4)


def test_squares_of_four_by_four() -> None:
    """14 across and 10 down; each asks its second pixel, or the picture's last."""
    assert pixel_blocks.size(TILING) == (14, 10)
    for lanes in (1, 4):
        where, x, y = pixel_blocks.square_pixels(TILING, IMAGES, lanes=lanes)
        image, row, column, _ = np.mgrid[0:IMAGES, 0:10, 0:14, 0:lanes].reshape(4, -1)
        assert np.array_equal(np.array(where.image), image)
        assert np.array_equal(np.array([x, y]), [column, row])
        assert np.array_equal(np.array(where.column), np.minimum(4 * column + 1, WIDTH - 1))
        assert np.array_equal(np.array(where.row), np.minimum(4 * row + 1, HEIGHT - 1))
        seen = [PLACES[k] for k in np.array(where.ray)]
        assert np.array_equal(np.transpose(seen), [np.array(where.row), np.array(where.column)])
        assert np.array(where.active).all()
    places = np.array(pixel_blocks.stratum(*(jit.UInt32(v.ravel()) for v in np.mgrid[5:8, 2:5])))
    assert sorted(places) == pytest.approx((np.arange(9) + 0.5) / 9)
    assert places.tolist() != sorted(places)  # neighbours ask far apart


def test_values_of_squares_are_smoothed_and_asked_for_between() -> None:
    values = np.random.default_rng(4).uniform(-2.0, 2.0, (4, IMAGES, 10, 14))
    squares = jit.Array4f(values.reshape(4, -1).astype(np.float32))
    smooth = light_shafts.mean_3x3(squares, TILING)
    expected = np.array([[uniform_filter(v, 3, mode="nearest") for v in part] for part in values])
    np.testing.assert_allclose(np.array(smooth).reshape(-1, 4).T, expected.reshape(4, -1), rtol=0, atol=1e-5)
    found = np.array(light_shafts.shafts_at(smooth, TILING, pixels(TILING, IMAGES))).reshape(4, IMAGES, -1)
    row, column = (np.array(PLACES).T - 1) / 4
    for part in range(4):
        for image in range(IMAGES):
            np.testing.assert_allclose(found[part, image], near(expected[part, image], row, column), rtol=0, atol=1e-5)


def test_one_ray_a_tile_meters_for_it() -> None:
    where = exposure_lag._tiles(TILING, IMAGES)
    row, column = np.array(where.row), np.array(where.column)
    assert np.array(where.image).tolist() == [0] * 12 + [1] * 12
    assert (row // 16 * COLUMNS + column // 16).tolist() == list(range(12)) * IMAGES
    assert [PLACES[k] for k in np.array(where.ray)] == list(zip(row, column, strict=True))
    assert np.array_equal(np.array(where.active), (row < HEIGHT) & (column < WIDTH))
    assert np.abs(np.array([row % 16, column % 16]) - 7.5).max() <= 0.5  # the middle: a last row of tiles has few rows


def test_probes_of_blocks_of_32_lie_in_them() -> None:
    """No two of a block in a row or column, at the picture's edge the edge's; the middles likewise."""
    blocks = np.arange(4)
    for number in (14, 12):
        where = ambient_light._probes(TILING, IMAGES, number)
        assert np.array(where.image).tolist() == np.repeat([0, 1], 4 * number).tolist()
        column, row = (np.array(v).reshape(IMAGES, 4, number) for v in (where.column, where.row))
        assert [PLACES[k] for k in np.array(where.ray)] == list(zip(row.ravel(), column.ravel(), strict=True))
        assert np.array_equal(column, np.minimum(column, WIDTH - 1))
        inside = np.minimum(np.arange(number) * 32 // number, WIDTH - 33)
        assert np.array_equal(column[0], [np.arange(number) * 32 // number, 32 + inside] * 2)
        assert len(set(row[0, 0])) == number
        assert np.array_equal(row[:, 2:], np.minimum(row[:, :2] + 32, HEIGHT - 1))
    middle = ambient_light._middles(TILING, IMAGES)
    assert np.array(middle.column).tolist() == [15, 47, 15, 47] * IMAGES
    assert np.array(middle.row).tolist() == [15, 15, HEIGHT - 1, HEIGHT - 1] * IMAGES
    assert np.array(middle.image).tolist() == np.repeat([0, 1], len(blocks)).tolist()

"""Rays of several images and the sea over each of them: where they come through it, and which side a port is on."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.sensors.camera.picture.camera_rays import Frame, Lens, local_directions, starts_wet
from pelagos.sensors.camera.picture.pixel_order import Tiling, pixels
from pelagos.sensors.camera.picture.sea_crossing import level_over, sea_crossing, uneven_sea

LANES = np.array([0, 1, 2, 0, 1, 2, 1, 0, 2, 2])
PLACES = np.array([[10.0, -4.0, -2.0], [-30.0, 7.0, 0.4], [2.0, 55.0, -1.0]])
TIMES, COPIES = np.array([1.0, 4.0, 2.5]), np.array([1, 0, 2])
AWAY = np.array([  # up and down, steep and flat
    [0.6, 0.0, 0.8], [0.0, 0.8, -0.6], [0.36, 0.48, 0.8], [0.8, 0.0, -0.6], [0.6, 0.0, 0.8], [0.48, 0.64, 0.6],
    [-0.64, 0.48, -0.6], [0.28, 0.0, 0.96], [0.0, 0.6, -0.8], [0.0, -0.28, 0.96],
])  # fmt: skip
START = PLACES[LANES] + np.array([0.1, -0.2, 0.05])


def ocean(*, tilt: float, waves: bool) -> Any:
    """A plane that leans along x and rises with time, over each copy at a height of its own."""

    def elevation(x: Any, y: Any, t: Any, copy: Any) -> Any:
        return tilt * x + 0.5 * tilt * y + 0.2 * t + 0.3 * jit.Float64(copy)

    return SimpleNamespace(elevation=elevation, waves=object() if waves else None, tide=None if waves else object())


@pytest.mark.parametrize("waves", [False, True])
def test_rays_cross_the_sea_over_their_own_image(waves: bool) -> None:
    """A plane's crossing is (h - z) / (d_z - h_x d_x - h_y d_y), of rays that come through it from their side."""
    tilt = 0.04 if waves else 0.0
    rays: Any = SimpleNamespace(
        origin=jit.Array3f64(np.ascontiguousarray(START.T)), direction=jit.Array3f(AWAY.T.astype(np.float32))
    )
    position = jit.Array3f64(np.ascontiguousarray(PLACES.T))
    t_ns, copy = jit.UInt64((TIMES * 1e9).astype(np.uint64)), jit.UInt32(COPIES.astype(np.uint32))
    sea = uneven_sea(ocean(tilt=tilt, waves=waves))
    assert sea is not None
    found = sea_crossing(rays, jit.UInt32(LANES.astype(np.uint32)), sea, position, t_ns, copy)
    base = 0.2 * TIMES[LANES] + 0.3 * COPIES[LANES]
    over = START[:, 2] - (tilt * START[:, 0] + 0.5 * tilt * START[:, 1] + base)
    closing = -(AWAY[:, 2] - tilt * AWAY[:, 0] - 0.5 * tilt * AWAY[:, 1])
    way = over / closing
    comes = (way > 0) & ((over < 0) == (AWAY[:, 2] > 0))
    assert np.array_equal(np.array(found.under), over < 0)
    assert 2 < comes.sum() < 10
    assert np.array(found.way)[comes] == pytest.approx(way[comes], abs=2e-3)
    assert (np.array(found.way)[~comes] >= 1e4).all()
    level = np.array(level_over(sea, position, t_ns, copy))
    expected = tilt * PLACES[:, 0] + 0.5 * tilt * PLACES[:, 1] + 0.2 * TIMES + 0.3 * COPIES
    assert level == pytest.approx(expected, rel=1e-5)


def test_a_level_sea_is_that_of_height_none() -> None:
    flat: Any = SimpleNamespace(waves=None, tide=None)
    assert uneven_sea(flat) is None
    rays: Any = SimpleNamespace(
        origin=jit.Array3f64(np.ascontiguousarray(START.T)), direction=jit.Array3f(AWAY.T.astype(np.float32))
    )
    found = sea_crossing(rays, jit.UInt32(LANES.astype(np.uint32)), None, None, None, None)  # type: ignore[arg-type]
    under = START[:, 2] < 0
    assert np.array_equal(np.array(found.under), under)
    expected = np.where(under == (AWAY[:, 2] > 0), -START[:, 2] / AWAY[:, 2], np.inf)
    assert np.array(found.way) == pytest.approx(expected, rel=1e-5)


def test_a_port_refracts_in_those_images_whose_sea_is_over_it() -> None:
    """The same height is under water in one image and above it in the next; so are two starts of one image."""
    tiling = Tiling(20, 16)
    where = pixels(tiling, 2)
    lanes = dr.width(where.ray)
    wet, dry = np.random.default_rng(3).normal(size=(2, 3, tiling.lanes)).astype(np.float32)
    lens = Lens(None, jit.Array3f(wet), jit.Array3f(dry), dr.full(jit.Bool, True, tiling.lanes))
    height = np.where(np.arange(lanes) % 3 == 0, 0.4, -0.1)
    origin = jit.Array3f64(0.0, 0.0, jit.Float64(height))
    image, ray = np.array(where.image), np.array(where.ray)
    for level, over in (([0.2, -0.3], np.array([0.2, -0.3])[image]), (None, 0.0)):
        given = None if level is None else jit.Float(level)
        under = height < over
        assert np.array_equal(np.array(starts_wet(where, origin, given)), under)
        found = np.array(local_directions(lens, where, origin, given))
        assert np.array_equal(found, np.where(under, wet[:, ray], dry[:, ray]))
    bare = local_directions(Lens(None, lens.direction, None, lens.serves), where, origin, None)
    assert np.array_equal(np.array(bare), wet[:, ray])


def test_each_pixel_of_each_image_has_a_counter_of_its_own() -> None:
    tiling = Tiling(20, 33)
    motion: Any = SimpleNamespace(environment=jit.UInt32([7, 3, 7]), tick=jit.UInt32([11, 12, 13]))
    where = pixels(tiling, 3)
    frame: Any = Frame(None, motion, None, None, tiling)  # type: ignore[arg-type]
    index, environment, tick = (np.array(v) for v in frame.counter(where))
    active, image = np.array(where.active), np.array(where.image)
    assert sorted(zip(image[active], index[active], strict=True)) == [(i, k) for i in range(3) for k in range(660)]
    assert np.array_equal(index, np.array(where.row) * 20 + np.array(where.column))
    assert np.array_equal(environment, np.array([7, 3, 7])[image])
    assert np.array_equal(tick, np.array([11, 12, 13])[image])
    assert frame.images == 3

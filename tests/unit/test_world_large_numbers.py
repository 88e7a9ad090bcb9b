"""Large worlds beside what is asked of every node: noise, clearance, tiles and the sources of heights."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from pelagos.errors import WorldError
from pelagos.world.large.clearance import GroundClearance
from pelagos.world.large.field import _beneath
from pelagos.world.large.ground import Inset, LargeGround
from pelagos.world.large.noise import _RMS, Fractal, gradient_noise
from pelagos.world.large.quadtree import CELLS, coarser_sides, leaves, reaches, top_level
from pelagos.world.large.source import FileSource, FractalSource


class Wavy:
    """Heights by a formula that is unlike along x and y."""

    def __init__(self, deep: float) -> None:
        self.deep = deep

    def heights(self, x: Any, y: Any) -> Any:
        return self.deep + 3 * np.sin(x / 7.0) + 2 * np.cos(y / 11.0) + 0.05 * x - 0.02 * y


def ground(*insets: Inset, cells: tuple[int, int] = (100, 60), spacing: float = 4.0) -> LargeGround:
    return LargeGround(-120.0, 40.0, cells, spacing, Wavy(-30.0), insets, (0, 1), 1, 1, 10_000)


HIGH = Inset((0.0, 80.0), (80.0, 160.0), -2, Wavy(-12.0), False, 8.0)


# noise


def test_octaves_have_the_spectrum_and_the_height_that_is_asked_for() -> None:
    relief = Fractal(seed=3, rms_m=2.5, longest_m=80.0, shortest_m=9.0, slope=3.4)
    octaves = np.array(relief.octaves)
    assert octaves[:, 0].tolist() == [80.0, 40.0, 20.0, 10.0]
    np.testing.assert_allclose(octaves[1:, 1] / octaves[:-1, 1], 0.5 ** (1.4 / 2), rtol=1e-12)
    assert math.sqrt(sum((_RMS * octaves[:, 1]) ** 2)) == pytest.approx(2.5)
    turns = np.arctan2(octaves[:, 3], octaves[:, 2])
    golden = math.pi * (3 - math.sqrt(5))
    assert np.remainder(np.diff(turns), 2 * np.pi) == pytest.approx(golden, abs=1e-5)
    rng = np.random.default_rng(2)
    x, y = rng.uniform(-5e4, 5e4, (2, 30_000))
    height = relief.heights(x, y)
    assert height.std() == pytest.approx(2.5, rel=0.03)
    assert abs(height.mean()) < 0.06
    few = relief.heights(x[9000:9006].reshape(2, 3), y[9000:9006].reshape(2, 3))
    assert few.ravel().tolist() == height[9000:9006].tolist()
    assert len(Fractal(1, 1.0, 64.0, 8.0, 3.0).octaves) == 4
    assert len(Fractal(1, 1.0, 8.0, 64.0, 3.0).octaves) == 1


def test_an_octave_is_the_noise_at_its_own_scale_turn_and_seed() -> None:
    relief = Fractal(seed=7, rms_m=1.0, longest_m=30.0, shortest_m=10.0, slope=3.0)
    x, y = np.random.default_rng(4).uniform(-300, 300, (2, 50))
    total = np.zeros(50)
    for k, (wavelength, amplitude, cosine, sine) in enumerate(relief.octaves):
        u, v = np.array([[cosine, -sine], [sine, cosine]]) @ [x, y] / wavelength
        total += amplitude * gradient_noise(u, v, 7 * 1013 + k)
    np.testing.assert_allclose(relief.heights(x, y), total, rtol=1e-12, atol=1e-14)


def test_noise_is_zero_on_nodes_and_smooth_across_them() -> None:
    """Its slope on a node is that node's gradient; second differences have no step where cells meet."""
    i, j = np.meshgrid(np.arange(-6.0, 7.0), np.arange(-3.0, 4.0), indexing="ij")
    assert not gradient_noise(i, j, 5).any()
    rng, h = np.random.default_rng(3), 1e-4
    along = rng.uniform(-5, 5, 40)
    for node in (-2.0, 0.0, 3.0):
        for turn in (False, True):
            f = lambda d: gradient_noise(*((along, node + d) if turn else (node + d, along)), 5)  # noqa: B023
            f = (lambda g: lambda d: g(np.full(40, d)))(f)
            left, right = f(-2 * h) - 2 * f(-h) + f(0.0), f(2 * h) - 2 * f(h) + f(0.0)
            np.testing.assert_allclose(left / h**2, right / h**2, atol=0.05)
    u, v = rng.uniform(-50, 50, (2, 4000))
    one, other, aside = gradient_noise(u, v, 5), gradient_noise(u, v, 6), gradient_noise(u + 2, v, 5)
    for a, b in ((one, other), (one, aside), (one, gradient_noise(v, u, 5))):
        assert abs(np.corrcoef(a, b)[0, 1]) < 0.1
    assert one.std() == pytest.approx(_RMS, rel=0.05)
    corner = gradient_noise(np.array([1e-6, 0.0, 1 - 1e-6]), np.array([0.0, 1e-6, 0.0]), 5) / 1e-6
    assert (abs(corner) <= 1).all()
    assert len(set(corner.round(6))) == 3


# clearance


def test_no_ground_is_overlooked_and_none_is_seen_from_afar() -> None:
    """Of every node within the margin's square one by one; blocks of eight cells about it are seen with them."""
    made, rng = ground(HIGH), np.random.default_rng(6)
    clearance = GroundClearance(made)
    places = rng.uniform([-160, 10, -45], [320, 320, 0], (120, 3))
    margins = rng.uniform(0.2, 25, 120)
    found = clearance.near(places, margins)
    i, j = np.meshgrid(np.arange(401), np.arange(241), indexing="ij")
    x, y, z = -120.0 + i, 40.0 + j, made.nodes(-2, i, j)
    for (px, py, pz), margin, seen in zip(places, margins, found, strict=True):
        close = (abs(x - px) <= margin) & (abs(y - py) <= margin) & (z >= pz - margin)
        wide = (abs(x - px) <= margin + 36) & (abs(y - py) <= margin + 36) & (z >= pz - margin)
        assert seen or not close.any()
        assert not seen or wide.any()
    assert 0.2 < found.mean() < 0.8
    assert clearance.near(places, 3.0).tolist() == [bool(clearance.near(p[None], 3.0)[0]) for p in places]


def test_the_ground_of_an_inset_counts_in_all_of_its_detail() -> None:
    """A spike on a node that the coarse grid does not have; a sphere beside the inset does not see it."""
    spike = SimpleNamespace(heights=lambda x, y: np.where((x == 32.0) & (y == 104.0), -5.0, -60.0))
    clearance = GroundClearance(ground(Inset((0.0, 80.0), (80.0, 160.0), -2, spike, False, 1e-6)))  # type: ignore[arg-type]
    for place, margin, seen in (
        ((33.0, 103.0, -4.0), 2.0, True),
        ((60.0, 103.0, -4.0), 2.0, False),
        ((33.0, 130.0, -4.0), 2.0, False),
        ((31.5, 103.5, -32.0), 0.3, True),  # on its flank, in the block whose last corner it is
    ):
        assert clearance.near(np.array([place]), margin).tolist() == [seen], place


def test_a_sphere_outside_of_the_world_is_near_nothing_and_a_wide_one_near_everything() -> None:
    clearance = GroundClearance(ground())
    edges = np.array([[-124.0, 100.0, -99.0], [284.0, 100.0, -99.0], [0.0, 36.0, -99.0], [0.0, 284.0, -99.0]])
    assert clearance.near(edges, 3.9).tolist() == [False] * 4
    assert clearance.near(edges, 4.1).tolist() == [True] * 4
    wide = GroundClearance(ground(cells=(6000, 40)))
    assert wide.near(np.array([[9000.0, 100.0, 2900.0]]), np.array([1000.0])).tolist() == [False]
    assert wide.near(np.array([[9000.0, 100.0, 9000.0]]), np.array([2000.0])).tolist() == [True]
    long = GroundClearance(ground(cells=(40, 6000)))
    assert long.near(np.array([[0.0, 9000.0, 2700.0]]), np.array([1000.0])).tolist() == [False]
    assert long.near(np.array([[0.0, 9000.0, 9000.0]]), np.array([2000.0])).tolist() == [True]
    slope = np.array([[0.0, 100.0, -33.0], [0.0, 5000.0, -33.0]])  # 2 m deeper every 100 m
    assert long.near(slope, 1.0).tolist() == [True, False]


@pytest.mark.parametrize("broken", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_counts_as_near(broken: float) -> None:
    places = np.array([[broken, 100.0, 9.0], [0.0, broken, 9.0], [0.0, 100.0, broken], [0.0, 100.0, 9.0]])
    clearance = GroundClearance(ground())
    assert clearance.near(places, 1.0).tolist() == [True, True, True, False]
    assert clearance.near(places[3:], np.array([broken])).tolist() == [True]


# tiles


def test_tiles_cover_the_world_once_finest_about_the_places() -> None:
    """Of every finest tile's middle: one tile holds it; tiles that touch differ by one level at most."""
    made = ground(HIGH, cells=(256, 160))
    places, reach = np.array([[300.0, 500.0], [40.0, 120.0]]), reaches(made, 1.5)
    tiles = leaves(made, places, reach)
    assert (top_level(made), made.finest) == (4, -2)
    edges = CELLS * 4.0 * 2.0**tiles.level
    low_x, low_y = made.x0 + tiles.i * edges, made.y0 + tiles.j * edges
    step = CELLS * 1.0
    level = np.full((64, 40), 99)
    for i in range(64):
        for j in range(40):
            x, y = made.x0 + (i + 0.5) * step, made.y0 + (j + 0.5) * step
            (at,) = np.flatnonzero((low_x < x) & (x < low_x + edges) & (low_y < y) & (y < low_y + edges))
            level[i, j] = tiles.level[at]
    for beside in (np.abs(np.diff(level, axis=0)), np.abs(np.diff(level, axis=1))):
        assert beside.max() == 1
    order = list(zip(tiles.level.tolist(), tiles.i.tolist(), tiles.j.tolist(), strict=True))
    assert order == sorted(order)
    found = [level[int((px - made.x0) // step), int((py - made.y0) // step)] for px, py in places]
    assert found == [0, -2]  # the second lies in the inset
    assert (low_x < made.x1).all()
    assert (low_y < made.y1).all()

    def split(x: float, y: float, edge: float, level: int) -> bool:
        """Whether a tile is: a place is near, and in the ground's own grid it holds or borders on an inset."""
        if level not in reach:
            return False
        away = min(max(abs(x + edge / 2 - px), abs(y + edge / 2 - py)) - edge / 2 for px, py in places)
        beside = max(0.0 - (x + edge), x - 80.0, 80.0 - (y + edge), y - 160.0) < edge
        return away < reach[level] * edge and (level > 0 or beside)

    for x, y, edge, own, i, j in zip(low_x, low_y, edges, tiles.level, tiles.i, tiles.j, strict=True):
        assert not split(x, y, edge, own)
        if own < 4:
            assert split(x - edge * (i % 2), y - edge * (j % 2), 2 * edge, own + 1)
    bits = coarser_sides(tiles)
    for at, (x, y, edge, own) in enumerate(zip(low_x, low_y, edges, tiles.level, strict=True)):
        for bit, (dx, dy) in enumerate(((-0.5, 0.5), (edge + 0.5, 0.5), (0.5, -0.5), (0.5, edge + 0.5))):
            there = (low_x <= x + dx) & (x + dx < low_x + edges) & (low_y <= y + dy) & (y + dy < low_y + edges)
            assert bool(bits[at] >> bit & 1) == bool((tiles.level[there] > own).any())


def test_reach_is_the_detail_of_the_finest_and_halves_from_level_to_level() -> None:
    plain, with_inset = reaches(ground(cells=(4096, 100)), 9.0), reaches(ground(HIGH, cells=(4096, 100)), 9.0)
    assert plain == {1: 9.0, 2: 5.0, 3: 3.0, 4: 3.0, 5: 3.0, 6: 3.0, 7: 3.0, 8: 3.0}
    assert with_inset == {-1: 9.0, 0: 5.0} | plain
    assert set(reaches(ground(cells=(4096, 100)), 2.0).values()) == {2.0}


# sources


def test_relief_lies_on_a_slope_of_both_axes() -> None:
    relief = Fractal(1, 0.5, 20.0, 5.0, 3.0)
    x, y = np.random.default_rng(5).uniform(-90, 90, (2, 2, 4))
    found = FractalSource(relief, -40.0, (0.03, -0.07)).heights(x, y)
    np.testing.assert_allclose(found - relief.heights(x, y), -40 + 0.03 * x - 0.07 * y, rtol=1e-12)


def test_a_file_answers_at_nodes_and_beyond_its_edge_with_the_edge(tmp_path: Path) -> None:
    z = np.random.default_rng(1).normal(size=(5, 7)).astype(np.float32)
    np.save(tmp_path / "z.npy", z)
    source = FileSource(tmp_path / "z.npy", x0=-10.0, y0=3.0, spacing=2.5)
    i, j = np.array([[0, 4, 2], [-3, 6, 1]]), np.array([[6, 0, 3], [1, 9, -2]])
    found = source.heights(-10 + 2.5 * i + 0.4, 3 + 2.5 * j - 0.4)
    np.testing.assert_array_equal(found, z[np.clip(i, 0, 4), np.clip(j, 0, 6)])
    z[1, 5] = np.nan
    np.save(tmp_path / "z.npy", z)
    with pytest.raises(WorldError, match=r"the value at node \(1, 5\) is not finite"):
        source.heights(np.array([-10.0, -7.5]), np.array([3.0, 15.5]))


def test_the_ground_beneath_a_field_is_that_of_its_finest_nodes() -> None:
    made = ground(HIGH)
    for low, high, step in (((-100.0, 50.0), (-60.0, 90.0), 4.0), ((-30.5, 90.0), (10.5, 100.0), 1.0),
                            ((10.0, 200.0), (60.0, 240.0), 4.0)):  # fmt: skip
        field = _beneath(made, np.array(low), np.array(high))
        assert field.spacing == step
        assert low[0] - step < field.x0 <= low[0]
        assert low[1] - step < field.y0 <= low[1]
        x, y = np.meshgrid(field.x, field.y, indexing="ij")
        assert high[0] <= field.x[-1] < high[0] + 2 * step
        assert high[1] <= field.y[-1] < high[1] + 2 * step
        np.testing.assert_allclose(field.z, made.height(x, y) if step == 4.0 else made.surface(x, y), rtol=1e-12)


def test_between_nodes_the_ground_is_bilinear_or_two_triangles() -> None:
    """By the weights of a cell's four corners; its diagonal goes from the lower corner to the upper one."""
    made = ground(HIGH)
    for low, step in ((np.array([-84.0, 52.0]), 4.0), (np.array([33.0, 121.0]), 1.0)):
        corners = {(i, j): float(made.height(*(low + step * np.array([i, j])))) for i in (0, 1) for j in (0, 1)}
        assert len({round(z, 3) for z in corners.values()}) == 4
        for p, q in ((0.2, 0.7), (0.85, 0.35)):
            x, y = low + step * np.array([p, q])
            weights = {(i, j): (p if i else 1 - p) * (q if j else 1 - q) for i, j in corners}
            assert made.height(x, y) == pytest.approx(sum(w * corners[at] for at, w in weights.items()), rel=1e-12)
            third = (1, 0) if p > q else (0, 1)
            weights = {(0, 0): 1 - max(p, q), third: abs(p - q), (1, 1): min(p, q)}
            assert made.surface(x, y) == pytest.approx(sum(w * corners[at] for at, w in weights.items()), rel=1e-12)

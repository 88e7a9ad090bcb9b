"""Where things of a generated world may stand, how many, and what they take of the ground."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Annotated, Any

import numpy as np
import pytest
from pydantic import TypeAdapter, ValidationError

from pelagos.math.geodesy import GeoOrigin
from pelagos.world.by_hand import ThingConfig, add, footprint
from pelagos.world.generate.draw import Drawn, bounded
from pelagos.world.generate.grade import GradeConfig, graded
from pelagos.world.generate.kinds.natural import NATURAL
from pelagos.world.generate.objects import ObjectConfig, Placer, _ground_at, _Suits
from pelagos.world.generate.route import add_cable, add_pipeline
from pelagos.world.generate.scatter import Places, covering
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField


@pytest.mark.parametrize("size", [0.5, 3.0])
def test_a_thing_stands_where_water_is_as_deep_as_its_size_asks(size: float) -> None:
    kind = next(k for k in NATURAL.values() if k.needs_depth > 0)
    least = kind.needs_depth * size
    for share in (0.9, 1.1):
        ground = HeightField(-10.0, -10.0, 2.0, np.full((11, 11), -share * least))
        suits = _Suits(ground, ObjectConfig(kind=next(n for n, k in NATURAL.items() if k is kind), count=1), kind, size)
        assert suits(1.0, -2.0) == (share > 1)


def slope(a: float, b: float, depth: float = 20.0) -> HeightField:
    x, y = -10 + 2.0 * np.arange(11), -14 + 2.0 * np.arange(15)
    return HeightField(-10.0, -14.0, 2.0, a * x[:, None] + b * y - depth)


def test_the_slope_of_the_ground_is_that_over_a_cell_to_each_side_and_at_the_rim_of_the_next_place() -> None:
    ground = slope(0.3, -0.2)
    for x, y, at in ((1.7, -3.2, (1.7, -3.2)), (-9.9, 3.1, (-8.0, 3.1)), (4.3, 13.9, (4.3, 12.0)),
                     (9.5, -14.0, (8.0, -12.0))):  # fmt: skip
        z, found = _ground_at(ground, np.array([x, y]))
        assert z == pytest.approx(0.3 * at[0] - 0.2 * at[1] - 20)
        assert found == pytest.approx((0.3, -0.2))


@pytest.mark.parametrize(("asked", "kinds", "steep", "suits"), [
    (None, 30.0, 0.57, True), (None, 30.0, 0.58, False), (40.0, 30.0, 0.83, True), (40.0, 30.0, 0.85, False),
    (10.0, 30.0, 0.17, True), (10.0, 30.0, 0.18, False),
])  # fmt: skip
def test_a_scenarios_word_on_slopes_goes_before_the_kinds(asked, kinds, steep, suits) -> None:
    """Of the steepest way down: tan(30 deg) = 0.577, tan(40 deg) = 0.839, tan(10 deg) = 0.176."""
    kind: Any = SimpleNamespace(max_slope_deg=kinds, needs_depth=0.0)
    config = ObjectConfig(kind="boulder", max_slope_deg=asked)
    for turn in (0.4, 2.1, -1.3):
        made = _Suits(slope(steep * np.cos(turn), steep * np.sin(turn), 30.0), config, kind, 1.0)
        assert made(0.0, 0.0) == suits


def test_depths_that_are_asked_for_are_met_at_both_ends() -> None:
    kind: Any = SimpleNamespace(max_slope_deg=60.0, needs_depth=4.0)
    config = ObjectConfig(kind="boulder", depth_m=(6.0, 19.0))
    suits = lambda depth, size=1.0: _Suits(slope(0, 0, depth), config, kind, size)(1.0, 1.0)
    assert [suits(d) for d in (5.9, 6.1, 18.9, 19.1)] == [False, True, True, False]
    assert [suits(d, 2.0) for d in (7.9, 8.1)] == [False, True]  # the kind asks for more
    land: Any = SimpleNamespace(max_slope_deg=60.0, needs_depth=0.0)
    assert _Suits(slope(0, 0, -3.0), ObjectConfig(kind="boulder"), land, 1.0)(0.0, 0.0)


def test_numbers_of_things_are_asked_for_drawn_or_those_of_their_places() -> None:
    placer = Placer(Site(), Places((-50.0, 70.0), (10.0, 90.0)), slope(0, 0))
    rng: Any = SimpleNamespace(poisson=lambda mean: mean, uniform=lambda a, b: (a + 3 * b) / 4)
    wanted = lambda **keys: placer._wanted(ObjectConfig(kind="boulder", **keys), rng)
    assert wanted() == 1
    assert wanted(at_m=[[0, 20], [5, 30], [9, 40]]) == 3
    assert wanted(count=7, density_per_ha=50, at_m=[[0, 20]]) == 7
    assert wanted(density_per_ha=50) == 48  # of 120 m by 80 m
    assert wanted(density_per_ha=[10, 50]) == int(40 * 0.96)


@pytest.mark.parametrize("size", [(8.0, 5.0), (3.0, 90.0), (0.4, 300.0), (50.0, 50.0)])
def test_a_rectangle_is_covered_by_discs_that_do_not_reach_far_beyond_it(size: tuple[float, float]) -> None:
    low = np.array([-3.0, 7.0])
    high = low + size
    discs = covering(low, high)
    places = np.random.default_rng(1).uniform(low, high, (3000, 2))
    corners = np.array([[x, y] for x in (low[0], high[0]) for y in (low[1], high[1])])
    for some in (places, corners):
        away = np.linalg.norm(some[:, None] - discs[:, :2], axis=2) - discs[:, 2]
        assert away.min(axis=1).max() < 1e-9
    reach = np.maximum(low - (discs[:, :2] - discs[:, 2:]), discs[:, :2] + discs[:, 2:] - high).max()
    assert reach < max(0.2 * min(size), 1.6 * max(size) / 64)
    assert max(len(np.unique(discs[:, k].round(9))) for k in (0, 1)) <= 64


def test_a_row_of_things_takes_the_ground_that_it_stands_on() -> None:
    """Every corner of the three lies on a disc; a disc ends near the thing that it is for."""
    origin = GeoOrigin(43.0, 9.0)
    lat, lon = (float(v) for v in origin.to_latlon(30.0, -18.0))
    thing = ThingConfig(at_deg=(lat, lon), at_m=(0, 0, -4), size_m=(6, 2, 3), orientation_deg=(10, -15, 35), repeat=3,
                        step_m=(9, -14, 2))  # fmt: skip
    site = Site()
    add(site, thing, origin)
    discs = footprint(thing, origin)
    for geometry, at in zip(site.geometries, ((30, -18), (39, -32), (48, -46)), strict=True):
        corners = geometry.vertices[:, :2]
        assert (corners.min(axis=0) + corners.max(axis=0)) / 2 == pytest.approx(at, abs=1e-3)
        away = np.linalg.norm(corners[:, None] - discs[:, :2], axis=2) - discs[:, 2]
        assert away.min(axis=1).max() < 1e-6
    boxes = np.stack([(g.vertices[:, :2].min(axis=0), g.vertices[:, :2].max(axis=0)) for g in site.geometries])
    out = np.maximum(boxes[:, 0] - discs[:, None, :2], discs[:, None, :2] - boxes[:, 1]).max(axis=2).min(axis=1)
    assert out.max() <= 1e-6


def test_a_free_place_touches_nothing_and_lies_in_the_extent() -> None:
    """By comparison with every disc that is taken; about a heap as the heap's own spread says."""
    rng = np.random.default_rng(6)
    places = Places((-60.0, 40.0), (-20.0, 90.0))
    for x, y, r in zip(rng.uniform(-60, 40, 40), rng.uniform(-20, 90, 40), rng.uniform(0.2, 14, 40), strict=True):
        places.take(x, y, r)
    taken = np.array(places.taken)
    for x, y, r in zip(rng.uniform(-90, 70, 300), rng.uniform(-50, 120, 300), rng.uniform(0.1, 9, 300), strict=True):
        free = (np.hypot(taken[:, 0] - x, taken[:, 1] - y) > taken[:, 2] + r).all()
        assert places.free(x, y, r) == free
    touching = Places((-9.0, 9.0), (-9.0, 9.0))
    touching.take(0.0, 0.0, 2.0)
    assert [touching.free(x, 0.0, 1.0) for x in (2.9, 3.0, 3.1)] == [False, False, True]
    wide = Places((-500.0, 500.0), (-300.0, 300.0))
    found = np.array([wide.find(rng, 0.01, around=(np.array([100.0, -50.0]), 20.0)) for _ in range(400)])
    assert found.mean(axis=0) == pytest.approx([100, -50], abs=4)
    assert found.std(axis=0) == pytest.approx([20, 20], rel=0.15)
    assert wide.find(rng, 0.01, accept=lambda x, y: False) is None
    some = np.array([wide.find(rng, 30.0, accept=lambda x, y: x > y) for _ in range(20)])
    assert (some[:, 0] > some[:, 1]).all()
    assert (np.abs(some) <= [470, 270]).all()
    assert Places((-5.0, 5.0), (-50.0, 50.0)).find(rng, 5.1) is None
    assert len(wide.taken) == 420
    for corner in ((-485.0, -285.0), (-485.0, 285.0), (485.0, -285.0), (485.0, 285.0)):
        heap = np.array([wide.find(rng, 5.0, around=(np.array(corner), 20.0)) for _ in range(4)])
        assert (np.abs(heap) <= [495, 295]).all()
        assert (np.abs(heap - corner) < 100).all()


def test_ground_is_graded_in_rectangles_and_discs_and_returns_beyond_them() -> None:
    """Within, the relief about its own mean is left by its share; halfway through the rim half of either is left."""
    ground = slope(0.5, -0.25)
    x, y = ground.x[:, None], ground.y[None, :]
    box = GradeConfig(at_m=(2.0, -4.0), size_m=(8.0, 4.0), depth_m=11.0, relief=0.4, blend_m=4.0)
    found = graded(ground, [box]).z
    inside = (np.abs(x - 2) <= 4) & (np.abs(y + 4) <= 2)
    wanted = -11 + 0.4 * (ground.z - ground.z[inside].mean())
    np.testing.assert_allclose(found[inside], wanted[inside])
    away = np.hypot(np.maximum(np.abs(x - 2) - 4, 0), np.maximum(np.abs(y + 4) - 2, 0))
    np.testing.assert_array_equal(found[away >= 4], ground.z[away >= 4])
    half = np.isclose(away, 2)
    assert half.sum() > 5
    np.testing.assert_allclose(found[half], (wanted[half] + ground.z[half]) / 2)
    disc = GradeConfig(at_m=(2.0, -4.0), radius_m=4.0, depth_m=-3.0, relief=0.0, blend_m=2.0)
    found = graded(ground, [box, disc]).z
    r = np.hypot(x - 2, y + 4)
    np.testing.assert_allclose(found[r <= 4], 3.0)
    np.testing.assert_array_equal(found[r >= 6], graded(ground, [box]).z[r >= 6])


def test_a_cable_lies_half_sunk_on_the_bed() -> None:
    site, ground = Site(), slope(0.0, 0.0, 9.0)
    path = np.column_stack([np.linspace(-6, 7, 14), np.full(14, 3.0)])
    add_cable(site, path, ground, 0.4)
    add_cable(site, path, ground, 0.4, label=150)
    first, second = site.geometries
    assert (first.name, first.label, second.label) == ("cable", 74, 150)
    low, high = first.extent
    assert (low[2], high[2]) == pytest.approx((-9 + 0.04 - 0.2, -9 + 0.04 + 0.2), abs=0.011)  # ten sides
    assert (low[0], high[0]) == pytest.approx((-6, 7), abs=0.01)
    assert (low[1] + high[1]) / 2 == pytest.approx(3, abs=0.01)
    assert site.materials[int(first.material)].name == "black"


def test_a_pipeline_hangs_over_a_scour_that_it_has_dug() -> None:
    """Proud of a flat bed by no more than its height, sunk by less than 0.7 of it, and free of the ground in its span;
    in the first nine tenths of its way."""
    x = -60 + 0.5 * np.arange(241)
    ground = HeightField(-60.0, -10.0, 0.5, np.full((241, 41), -12.0))
    site = Site()
    path = np.column_stack([np.linspace(-55, 55, 111), np.zeros(111)])
    add_pipeline(site, path, ground, 0.8, np.random.default_rng(5))
    pipe, props = site.geometries
    assert (pipe.name, pipe.label, props.name) == ("pipeline", 14, "pipe supports")
    assert site.materials[int(pipe.material)].name == "concrete"
    low, high = pipe.extent
    assert -12.65 < low[2] < high[2] < -11.0
    dug = ground.z[:, 20] < -12.1
    assert 5 < x[dug].max() - x[dug].min() < 24
    assert x[dug].min() > -55 + 0.3 * 110 - 6
    assert x[dug].max() < -55 + 0.9 * 110 + 6
    for at in x[dug]:
        near = pipe.vertices[np.abs(pipe.vertices[:, 0] - at) < 0.6]
        assert near[:, 2].min() > float(ground.height(at, 0.0)) - 0.05
    assert (np.abs(ground.z[:, [0, -1]] + 12) < 1e-3).all()
    assert x[dug].min() < props.extent.mean(axis=0)[0] < x[dug].max()


@pytest.mark.parametrize(("limits", "value", "says"), [
    ({"above": 0}, 0.0, "greater than 0, not 0"), ({"above": 0}, 0.1, ""), ({"above": 0}, [0, 3], ""),
    ({"above": 0}, [-1, 3], "greater than 0, but this gives -1 .. 3"), ({"least": 0}, 0, ""),
    ({"least": 0}, [-0.5, 2], "at least 0, but this gives -0.5 .. 2"), ({"least": 0, "most": 8}, 8, ""),
    ({"least": 0, "most": 8}, 8.1, "at most 8, not 8.1"), ({"most": 8}, {"normal": [5, 1.4]}, ""),
    ({"most": 8}, {"normal": [5, 1.6]}, "at most 8, but this gives 1.8 .. 8.2"),
    ({"least": 2}, {"choice": [3, 2, 9]}, ""), ({"least": 2}, {"choice": [3, 1.5, 9]}, "gives 1.5 .. 9"),
])  # fmt: skip
def test_numbers_that_are_drawn_stay_within_what_is_allowed(limits, value, says) -> None:
    check = TypeAdapter(Annotated[Drawn, bounded(**limits)])
    if says:
        with pytest.raises(ValidationError, match=says):
            check.validate_python(value)
    else:
        check.validate_python(value)

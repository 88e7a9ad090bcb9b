"""Grounds, columns and obstacles along ways through the water, with casts and water of formulas."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

import pelagos.sensors.comms.link.water_paths as parts
from pelagos.acoustics.eigenrays import Arrivals
from pelagos.acoustics.section import Section
from pelagos.sensors.comms.link.water_paths import NODES, WaterPaths

LEVEL = 1.3
SOURCE = np.array([[0.0, 10.0, -4.0], [50.0, -20.0, -12.0], [-30.0, 5.0, -7.0]])
RECEIVER = np.array([[300.0, -110.0, -9.0], [-10.0, 60.0, -6.0], [90.0, 165.0, -15.0]])
COPY = np.array([1, 0, 1])


def ground(x: Any, y: Any, copy: Any) -> Any:
    """Height of a hill that stands out of the ways, another in each copy; none north of 240 m."""
    z = -20.0 - 0.02 * x + 0.03 * y + (14.0 + 5.0 * copy) * np.exp(-(((x - 40.0) / 25.0) ** 2))
    return np.where(x > 240.0, -np.inf, z)


def paths(**keys: Any) -> Any:
    made = object.__new__(WaterPaths)
    vars(made).update(keys)
    return made


def test_grounds_along_ways_are_met_from_above_where_a_hill_stands_over_them() -> None:
    """Depths below the sea's level, at equal parts of each way; behind the world's edge as at it."""
    asked: list[int] = []

    def ask(origin: Any, direction: Any, reach: Any, copy: Any, own: Any, *, ground: bool = False) -> Any:
        assert ground
        assert (direction == [0.0, 0.0, -1.0]).all()
        asked.append(len(origin))
        z = globals()["ground"](origin[:, 0], origin[:, 1], copy)
        t = np.where((z <= origin[:, 2]) & (origin[:, 2] - z < reach), origin[:, 2] - z, np.inf)
        return {"t": t, "material": np.where(np.isfinite(t), 3 + (origin[:, 0] > 60.0), 0)}

    x, depth, material = paths(_ask=ask)._bottoms(SOURCE, RECEIVER, LEVEL, COPY)
    assert asked[0] == 3 * NODES
    assert 0 < asked[1] < 2 * NODES
    share = np.linspace(0.0, 1.0, NODES)
    for k in range(3):
        way = RECEIVER[k] - SOURCE[k]
        np.testing.assert_allclose(x[k], share * math.hypot(way[0], way[1]), atol=1e-9)
        places = SOURCE[k] + share[:, None] * way
        there = ground(places[:, 0], places[:, 1], COPY[k])
        inside = np.isfinite(there)
        last = np.flatnonzero(inside)[-1]
        expected = np.where(inside, LEVEL - there, LEVEL - there[last])
        np.testing.assert_allclose(depth[k], np.maximum(expected, 0.05), atol=1e-9)
        assert material[k].tolist() == np.where(inside, 3 + (places[:, 0] > 60.0), 4).tolist()
    assert (~np.isfinite(ground(RECEIVER[:, 0], RECEIVER[:, 1], COPY))).tolist() == [True, False, False]


def test_level_ground_is_level_to_the_last_digit_and_nothing_is_deep() -> None:
    """Casts that scatter by micrometres; a way over no ground at all; one of no length."""
    rng = np.random.default_rng(1)

    def ask(origin: Any, *_: Any, **__: Any) -> Any:
        t = origin[:, 2] + 40.0 + 8e-6 * rng.uniform(-1, 1, len(origin))
        return {"t": np.where(origin[:, 0] < -500.0, np.inf, t), "material": np.full(len(origin), 2)}

    source = np.array([[1.0, 2.0, -5.0], [-900.0, 0.0, -5.0]])
    receiver = np.array([[1.0, 2.0, -25.0], [-930.0, 40.0, -5.0]])
    x, depth, _ = paths(_ask=ask)._bottoms(source, receiver, 0.0, np.zeros(2, int))
    assert np.ptp(depth[0]) == 0.0
    assert depth[0, 0] == pytest.approx(40.0, abs=5e-6)
    assert (depth[1] > 10_000.0).all()
    assert x[:, -1] == pytest.approx([1e-3, 50.0])


@pytest.mark.parametrize("change", [0.0, 5e-5, 0.03])
def test_columns_have_the_water_of_their_middle(change: float) -> None:
    """Speeds that change along the way; as one column, of their mean, where they differ by less than 2 cm/s."""
    asked: list[Any] = []

    def water(places: Any, depth: Any, t: float) -> Any:
        asked.append((places, depth, t))
        along = change * (places[:, :1] - SOURCE[0, 0])
        speed = 1500.0 + along * np.exp(-depth / 15.0) - 9.0 * np.exp(-depth / 20.0)
        return speed, 1e-3 * speed

    depth, speed, absorption, begins = paths(_column=None, _asked=water)._levels(SOURCE[0], RECEIVER[0], 7.0, 55.0)
    ((places, levels, t),) = asked
    assert t == 7.0
    assert (levels[0], levels[-1]) == (0.0, pytest.approx(55.0))
    np.testing.assert_allclose(places[[0, -1]], [SOURCE[0], RECEIVER[0]])
    way = math.hypot(300.0, 120.0)
    count = 1 if change * 300.0 < 0.02 else 25
    assert speed.shape == absorption.shape == (count, len(depth))
    surface = 1491.0 + (change * 150.0 if count == 1 else change * np.linspace(0.0, 300.0, 25))
    np.testing.assert_allclose(speed[:, 0], surface)
    assert begins[0] == 0.0
    assert len(begins) == count
    if count > 1:
        np.testing.assert_allclose(begins[1:], way * (np.arange(24) + 0.5) / 24)
        np.testing.assert_allclose(absorption, 1e-3 * speed)
    z = np.linspace(0, 55.0, 200)
    expected = (surface - 1491.0 if count == 1 else 0.0) * np.exp(-z / 15.0) - 9.0 * np.exp(-z / 20.0)
    np.testing.assert_allclose(np.interp(z, depth, speed[0]) - 1500.0, expected, atol=0.03)


def test_the_columns_own_table_ends_below_each_bottom() -> None:
    """Down to the first level that lies below it; the same array for the same cut."""
    depth = np.array([0.0, 10.0, 25.0, 60.0, 200.0])
    made = paths(_column=(depth, 1500.0 + depth, 1e-3 + 1e-5 * depth), _cuts={})
    for bottom, last in ((24.0, 25.0), (25.0, 25.0), (61.0, 200.0), (900.0, 200.0)):
        levels, speed, absorption, begins = made._levels(SOURCE[0], RECEIVER[0], 0.0, bottom)
        assert levels[-1] == last
        np.testing.assert_array_equal(speed, 1500.0 + levels)
        np.testing.assert_array_equal(absorption, 1e-3 + 1e-5 * levels)
        assert begins.tolist() == [0.0]
        assert made._levels(SOURCE[1], RECEIVER[1], 9.0, bottom)[0] is levels


class Found(SimpleNamespace):
    """Rays of pairs."""

    def __len__(self) -> int:
        return len(self.path)


def test_what_stands_in_the_way_of_a_ray_is_asked_leg_by_leg(monkeypatch: pytest.MonkeyPatch) -> None:
    """Four rays of three pairs, straight; one meets a hull in its eighth leg, one only ground. The last leg ends 1.5 m
    before the receiver; a ray that never came, as deep as its source; none goes into the ground."""
    path = np.array([0, 2, 2, 1])
    way = (RECEIVER - SOURCE)[:, :2]
    distance = np.hypot(*way.T)
    heading = np.arctan2(way[:, 1], way[:, 0])
    zs, zr = LEVEL - SOURCE[:, 2], LEVEL - RECEIVER[:, 2]
    legs = 24
    share = np.arange(1, legs + 1) / legs
    asked: dict[str, Any] = {}

    def depths(sections: Any, rows: Any, source: Any, angle: Any, reach: Any, *, stations: int) -> Any:
        assert (rows.tolist(), stations) == (path.tolist(), legs)
        np.testing.assert_allclose(source, zs[path])
        np.testing.assert_allclose(reach, distance[path])
        assert angle.tolist() == [0.1, 0.2, 0.3, 0.4]
        made = zs[path][:, None] + share * (zr - zs)[path][:, None]
        made[2] = np.nan
        return made

    def ask(origin: Any, direction: Any, reach: Any, copy: Any, own: Any) -> Any:
        asked.update(origin=origin, direction=direction, reach=reach, copy=copy, own=own)
        t, label = np.full(len(origin), np.inf), np.zeros(len(origin), int)
        t[[1 * legs + 7, 3 * legs + 5]] = 1.0
        label[[1 * legs + 7, 3 * legs + 5]] = 11, 6
        return {"t": t, "label": label}

    monkeypatch.setattr(parts, "ray_depths", depths)
    floors = [Section(np.zeros(1), np.full(1, 1500.0), np.zeros(1), np.array([d])) for d in (60.0, 9.0, 70.0)]
    found = Found(path=path, departure=np.array([0.1, 0.2, 0.3, 0.4]))
    own = np.array([70, 71, 72], np.uint32)
    blocked = paths(_ask=ask)._blocked(found, floors, SOURCE, zs, distance, LEVEL, heading[path], COPY, own)
    assert blocked.tolist() == [False, True, False, False]
    assert asked["copy"].tolist() == np.repeat(COPY[path], legs).tolist()
    assert asked["own"].tolist() == np.repeat(own[path], legs).tolist()
    origin, direction, reach = (asked[n].reshape(4, legs, -1) for n in ("origin", "direction", "reach"))
    for row, k in ((0, 0), (1, 2)):
        line = SOURCE[k] + np.linspace(0.0, 1.0, legs + 1)[:, None] * (RECEIVER[k] - SOURCE[k])
        np.testing.assert_allclose(origin[row], line[:-1], atol=1e-9)
        along = RECEIVER[k] - SOURCE[k]
        length = float(np.linalg.norm(along))
        np.testing.assert_allclose(direction[row], np.tile(along / length, (legs, 1)), atol=1e-9)
        np.testing.assert_allclose(reach[row, :-1, 0], length / legs)
        assert reach[row, -1, 0] == pytest.approx(length / legs - 1.5)
    np.testing.assert_allclose(origin[2, :, 2], SOURCE[2, 2])
    assert origin[3, :, 2].min() == pytest.approx(LEVEL - 9.0 + 0.05)
    assert (
        paths(_ask=ask)._blocked(Found(path=path[:0]), floors, SOURCE, zs, distance, LEVEL, heading, COPY, own).size
        == 0
    )


def arrivals(path: list[int]) -> Arrivals:
    """Made-up ones of three pairs."""
    k, n = np.arange(len(path), dtype=float), np.zeros(len(path), np.int64)
    return Arrivals(np.array(path), 0.1 + k, 1.0 + 1j * k, 0.2 - 0.1 * k, 0.05 * k - 0.3, n, n, n, 10.0 + k, 0 * k)


def test_arrivals_come_from_where_their_ends_lie_and_none_in_the_air(monkeypatch: pytest.MonkeyPatch) -> None:
    """Directions by the heading of each pair and the ray's angles, positive down; what stands in the way is looked for
    only in pairs that are at risk; the speed of sound at both ends."""
    source, receiver = SOURCE.copy(), RECEIVER.copy()
    receiver[0, 2], receiver[1, 2] = LEVEL + 0.01, LEVEL - 0.01  # the first pair's is dry
    floors = [
        Section(np.array([0.0, 100.0]), np.array([[1500.0 + k, 1510.0 + k], [1540.0 + k, 1550.0 + k]]),
                begins=np.array([0.0, 20.0]))
        for k in range(3)
    ]  # fmt: skip
    asked: dict[str, Any] = {}

    def rays(sections: Any, zs: Any, zr: Any, distance: Any, **options: int) -> Arrivals:
        assert options == {"rays": 77, "bounces": 5}
        asked.update(zs=zs, zr=zr, distance=distance)
        return arrivals([0, 1, 1, 2, 2])

    def at_risk(source: Any, receiver: Any, distance: Any, copy: Any, own: Any) -> Any:
        assert (copy.tolist(), own.tolist()) == (COPY.tolist(), [7, 8, 9])
        return np.array([True, False, True])

    def blocked(
        found: Any, sections: Any, source: Any, zs: Any, distance: Any, level: Any, heading: Any, *_: Any
    ) -> Any:
        assert (found.path.tolist(), found.delay.tolist(), level) == ([2, 2], [3.1, 4.1], LEVEL)
        way = RECEIVER[2] - SOURCE[2]
        np.testing.assert_allclose(heading, math.atan2(way[1], way[0]))
        return np.array([False, True])

    monkeypatch.setattr(parts, "eigenrays", rays)
    made = paths(_rays=77, _bounces=5, level=lambda t: LEVEL if t == 4.0 else math.nan, sections=lambda *_: floors,
                 _in_the_way=at_risk, _blocked=blocked)  # fmt: skip
    found = made.trace(source, receiver, 4.0, COPY, np.array([7, 8, 9], np.uint32))
    np.testing.assert_allclose(asked["zs"], LEVEL - source[:, 2])
    np.testing.assert_allclose(asked["zr"], LEVEL - receiver[:, 2])
    np.testing.assert_allclose(asked["distance"], np.hypot(*(receiver - source)[:, :2].T))
    assert found.arrivals.path.tolist() == [1, 1, 2, 2]
    assert found.blocked.tolist() == [False, False, False, True]
    for k, row in enumerate(found.arrivals.path):
        level = (receiver - source)[row, :2]
        for vectors, angle in (
            (found.departure, found.arrivals.departure[k]),
            (found.arrival, found.arrivals.arrival[k]),
        ):
            expected = [*(level / np.linalg.norm(level) * math.cos(angle)), -math.sin(angle)]
            np.testing.assert_allclose(vectors[k], expected, atol=1e-12)
    z, r = LEVEL - source[:, 2], LEVEL - receiver[:, 2]
    k = np.arange(3)
    np.testing.assert_allclose(found.speed, np.stack([1500.0 + k + 0.1 * z, 1540.0 + k + 0.1 * np.maximum(r, 0.0)], 1))


def test_ways_are_at_risk_by_structures_and_by_hulls_between() -> None:
    """All of them where there is a structure or hulls of no known size; else those with a hull between, the own one and
    those near the ends left out: 1.5 m, or a leg of a shorter way."""
    distance = np.array([90.0, 12.0, 400.0])
    asked: list[Any] = []

    def between(source: Any, receiver: Any, copy: Any, *, own: Any, spared: Any) -> Any:
        asked.append((copy.tolist(), own.tolist(), spared.tolist()))
        return np.array([True, False, True])

    def risk(*, only_ground: bool, moving: Any, spheres: Any, own: Any = None) -> list[bool]:
        scene = SimpleNamespace(moving=moving, spheres=spheres)
        made = paths(_scene=scene, _only_ground=only_ground)
        return list(made._in_the_way(SOURCE, RECEIVER, distance, COPY, own).tolist())

    hulls = SimpleNamespace(between=between)
    assert risk(only_ground=False, moving=None, spheres=None) == [True] * 3
    assert risk(only_ground=True, moving=None, spheres=None) == [False] * 3
    assert risk(only_ground=True, moving=1, spheres=None) == [True] * 3
    assert risk(only_ground=False, moving=1, spheres=hulls) == [True] * 3
    assert risk(only_ground=True, moving=1, spheres=hulls) == [True, False, True]
    assert risk(only_ground=True, moving=1, spheres=hulls, own=np.array([4, 5, 6], np.uint32)) == [True, False, True]
    nobody = int(parts.NO_BODY)
    assert asked == [(COPY.tolist(), rows, [1.5, 0.5, 1.5]) for rows in ([nobody] * 3, [4, 5, 6])]


def test_a_section_has_the_ground_of_its_own_way() -> None:
    """Straight ones by their ends, a bent one and one of two materials by all nodes; levels to its deepest place."""
    x = np.outer([100.0, 70.0, 90.0, 60.0], np.linspace(0.0, 1.0, NODES))
    bottom = np.stack([20.0 + 0.1 * x[0], 30.0 + 5.0 * np.sin(x[1] / 9.0), 44.0 - 0.2 * x[2], 9.0 + 0.3 * x[3]])
    material = np.full((4, NODES), 1)
    material[2, 20:], material[3] = 0, 0
    asked: list[Any] = []

    def levels(source: Any, receiver: Any, t: float, deepest: float) -> Any:
        asked.append((source.tolist(), receiver.tolist(), t, deepest))
        k = float(len(asked))
        return np.array([0.0, deepest]), np.array([1500.0, 1500.0 + k]), np.array([k, k]), np.array([0.0])

    kinds = [SimpleNamespace(density_ratio=1.2 + k, sound_speed_ratio=1.1 + k, loss=0.1 + k) for k in range(2)]
    made = paths(level=lambda t: LEVEL * t, _bottoms=lambda a, b, level, copy: (x + 0 * level, bottom, material),
                 _levels=levels, _palette=kinds, frequency=19e3, _wind=6.5)  # fmt: skip
    source, receiver = SOURCE[[0, 1, 2, 1]], RECEIVER[[0, 1, 2, 0]]
    found = made.sections(source, receiver, 2.0, COPY[[0, 1, 2, 0]])
    assert [len(s.bottom_x) for s in found] == [2, NODES, NODES, 2]
    for k, s in enumerate(found):
        assert asked[k] == (source[k].tolist(), receiver[k].tolist(), 2.0, bottom[k].max())
        nodes = [0, -1] if k in (0, 3) else slice(None)
        np.testing.assert_array_equal(s.bottom_x, x[k][nodes])
        np.testing.assert_array_equal(s.bottom_depth, bottom[k][nodes])
        np.testing.assert_allclose(s.density_ratio, 1.2 + material[k][nodes])
        np.testing.assert_allclose(s.sound_speed_ratio, 1.1 + material[k][nodes])
        np.testing.assert_allclose(s.loss, 0.1 + material[k][nodes])
        assert (s.frequency, s.wind_speed, s.speed[1], s.absorption[0]) == (19e3, 6.5, 1501.0 + k, 1.0 + k)


def test_water_below_places_is_asked_from_the_seas_level_down() -> None:
    """Speed by place, height and time; absorption by temperature, salinity and depth, in this order."""
    ocean = SimpleNamespace(
        sound_speed=lambda at, t: 1500.0 + 0.01 * at.x - 0.02 * at.y + 0.1 * at.z + t,
        temperature=lambda at, t: 9.0 + 0.02 * at.z + 0.0 * t, salinity=lambda at, t: 33.0 + 0.001 * at.x,
    )  # fmt: skip

    def absorbed(temperature: Any, salinity: Any, depth: Any) -> Any:
        return temperature + 100.0 * salinity + 1e4 * depth

    depth = np.array([0.0, 4.0, 30.0])
    speed, absorption = paths(_ocean=ocean, level=lambda t: LEVEL, _absorption=absorbed)._asked(SOURCE[:2], depth, 3.0)
    x, y, z = SOURCE[:2, :1], SOURCE[:2, 1:2], LEVEL - depth
    np.testing.assert_allclose(speed, 1503.0 + 0.01 * x - 0.02 * y + 0.1 * z)
    np.testing.assert_allclose(absorption, 9.0 + 0.02 * z + 100.0 * (33.0 + 0.001 * x) + 1e4 * depth)

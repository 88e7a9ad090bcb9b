"""Viewpoints and pictures of a world: what is worth a look, how heights are stretched, what is marked and named."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from pelagos.raycast.geometry import Geometry
from pelagos.world import shapes, sheet, viewpoint
from pelagos.world.build import build_world, world_config
from pelagos.world.preview import _mark_small, _name_labels, statistics
from pelagos.world.viewpoint import (
    Viewpoint,
    _close,
    _covers,
    _crowded,
    _encloses,
    _exaggeration,
    _Object,
    _objects,
    _richest,
)


def thing(x: float, y: float, size: Any = (1.0, 1.0, 1.0), name: str = "it") -> _Object:
    return _Object(name, np.array([x, y, -5.0]), np.array(size, dtype=float))


@pytest.mark.parametrize(("reach", "relief", "factor"), [
    (20_000, 30, 20), (20_000, 100, 5), (20_000, 199, 2), (20_000, 201, 1), (4999, 9, 1), (5001, 9, 20),
    (20_000, 0, 1), (9000, 0.5, 500),
])  # fmt: skip
def test_heights_are_stretched_by_a_round_factor_where_the_ground_is_wide_and_flat(reach, relief, factor):
    """What makes of the relief four per cent of the width, or the next less of 1, 2, 5, 10, ...; outliers do not
    count."""
    z = np.linspace(-40.0, -40.0 + relief / 0.98, 1001)
    world = SimpleNamespace(terrain=SimpleNamespace(z=np.concatenate([z, [-900.0, 300.0]])))
    assert _exaggeration(world, reach) == factor
    assert _exaggeration(SimpleNamespace(terrain=None), reach) == 1


def test_parts_of_one_thing_are_one_and_the_ground_is_none():
    boxes = [((2, 1, 1), (0, 0, 0), 1, 7), ((1, 1, 3), (4, -2, 1), 1, 7), ((1, 2, 1), (9, 9, 0), 3, 8),
             ((50, 50, 1), (0, 0, -9), 4, 9)]  # fmt: skip
    made = []
    for size, at, label, instance in boxes:
        mesh = shapes.box(size).moved(at)
        made.append(Geometry(mesh.vertices, mesh.faces, 0, label, instance, None, f"thing {instance}"))
    found = _objects([*made, Geometry(np.zeros((0, 3)), np.zeros((0, 3), np.uint32), 0, 1, 11)])
    assert [o.name for o in found] == ["thing 7", "thing 8"]
    assert found[0].middle.tolist() == [1.75, -1.0, 1.0]
    assert found[0].size.tolist() == [5.5, 3.0, 3.0]
    assert found[1].size.tolist() == [1, 2, 1]


def test_the_fullest_part_that_is_not_in_view_yet_is_where_things_crowd():
    """Cells of 240 m / 24 = 10 m; nearer than 20 m to what is seen already does not count, nor does a thing alone."""
    here = [thing(3 + k, 4, name=f"a{k}") for k in range(4)]
    there = [thing(62, -57), thing(64, -55), thing(69, -53)]
    alone = [thing(-95, 12)]
    find = lambda *seen: _crowded([*here, *there, *alone], 240.0, np.array([*seen, 0.0]))
    assert find(100, 100)[:2].tolist() in ([4, 4], [5, 4])  # of four in a row one in the middle
    assert find(20, 9)[:2].tolist() == [64, -55]  # the nearest to their mean
    assert find(26, 4)[:2].tolist() in ([4, 4], [5, 4])
    assert _crowded(here[:3], 240.0, np.zeros(3)) is None
    assert _crowded([*here, *alone], 240.0, np.array([4.5, 4.0, 0.0])) is None


def test_the_richest_part_has_the_most_and_the_largest_about_it():
    small = [thing(-40 + 2 * k, 30) for k in range(5)]
    large = [thing(50, -20, (9, 9, 3)), thing(56, -20, (9, 8, 3))]
    far = Viewpoint("x", np.array([0.0, 0, 90]), np.zeros(3))
    found = _richest([*small, *large], 12.0, far)
    weight = np.minimum([np.sqrt(171), np.sqrt(154)], 12.0)
    assert found[:2] == pytest.approx([np.average([50, 56], weights=weight), -20])
    close_by = Viewpoint("x", np.array([50.0, -20, 15]), np.array([50.0, -20, -1]))
    assert _richest([*small, *large], 12.0, close_by) is None  # in view, and from afar
    nearer = Viewpoint("x", np.array([50.0, -20, 9]), np.array([50.0, -20, -1]))
    assert _richest([*small, *large], 12.0, nearer) is not None
    assert _richest(large, 12.0, far) is None


def test_floors_rims_and_lines_are_not_looked_at():
    low, high = np.array([-100.0, -60.0, -20.0]), np.array([100.0, 60.0, 5.0])
    inside = lambda o: _encloses(o, low, high)
    assert inside(thing(0, 0, (110, 61, 1)))
    assert not inside(thing(0, 0, (110, 59, 1)))
    assert not inside(thing(0, 0, (99, 70, 1)))
    assert inside(thing(0, 58, (185, 2, 9)))  # a wall along the rim
    assert not inside(thing(0, 40, (185, 2, 9)))
    assert not inside(thing(0, 58, (175, 2, 9)))
    assert inside(thing(-98, 3, (2, 110, 9)))
    assert inside(thing(3, 3, name="cable"))


def test_roofs_lie_high_and_cover_most_of_a_world():
    low, high = np.array([-10.0, -8.0, 0.0]), np.array([10.0, 8.0, 4.0])

    def covers(size, z, label=33):
        mesh = shapes.box(size).moved((0, 0, z))
        return _covers(Geometry(mesh.vertices, mesh.faces, 0, label, 1), low, high)

    assert covers((13, 10, 0.2), 3.0)
    assert not covers((11.5, 12, 0.2), 3.0)
    assert not covers((14, 9.5, 0.2), 3.0)
    assert not covers((13, 10, 0.2), 2.0)
    assert not covers((13, 10, 0.2), 3.0, label=4)


def test_the_eye_of_a_closer_look_is_clear_of_the_ground(monkeypatch):
    """From 215 degrees, 1.5 radii off and 0.45 of that up; higher where the ground rises; from the next side where the
    first is hidden."""
    target, radius = np.array([3.0, -4.0, -9.0]), 10.0
    level = {"ground": np.nan}
    world: Any = SimpleNamespace(height=lambda x, y: np.asarray(level["ground"]))
    tried = []
    monkeypatch.setattr(viewpoint, "_seen", lambda world, eye, target, share: tried.append(eye) or len(tried) > 1)
    found = _close(world, "it", target, radius)
    sides = [np.array([np.cos(a), np.sin(a)]) for a in np.radians([215.0, 145.0])]
    for eye, side in zip(tried, sides, strict=True):
        assert eye == pytest.approx([*(target[:2] + 15 * side), -9 + 6.75])
    assert (found.name, found.eye.tolist(), found.target.tolist()) == ("it", tried[1].tolist(), target.tolist())
    level["ground"] = -1.0
    assert _close(world, "it", target, radius).eye[2] == pytest.approx(-1.0 + 3.0)
    level["ground"] = -30.0
    assert _close(world, "it", target, radius).eye[2] == pytest.approx(-2.25)


class Axes:
    """Keeps what is drawn on it."""

    def __init__(self) -> None:
        self.marks: list[tuple[float, float]] = []
        self.legends: list[Any] = []

    def plot(self, x: float, y: float, *_: Any, **__: Any) -> None:
        self.marks.append((x, y))

    def legend(self, *, handles: Any, **_: Any) -> None:
        self.legends.append(handles)


def test_things_too_small_for_a_map_are_marked_once_for_each_place():
    def box(x, y, size, label=68, faces=12):
        extent = np.array([[x - size / 2, y - size / 2, -5.0], [x + size / 2, y + size / 2, 0.0]])
        return SimpleNamespace(label=label, faces=np.zeros(faces), extent=extent)

    made = [box(100, -70, 5), box(108, -77, 5), box(100, -70, 5, label=69), box(900, 40, 59), box(1500, 40, 61),
            box(2100, 40, 5, label=4), box(2100, 900, 5, faces=0)]  # fmt: skip
    world: Any = SimpleNamespace(geometries=made)
    axes = Axes()
    _mark_small(axes, world, 20.0)
    assert axes.marks == [(-70, 100), (-70, 100), (40, 900)]  # west to the left, north up
    _mark_small(axes, world, 14.9)
    assert len(axes.marks) == 3


def test_a_map_names_the_labels_of_the_largest_area_first():
    world: Any = SimpleNamespace(labels={17: "rock", 22: "pier", 68: "chain", 70: "mine"})
    axes = Axes()
    _name_labels(axes, world, np.array([22] * 5 + [17] * 9 + [150] * 2, dtype=np.uint32), {17, 22, 150, 70, 68})
    (handles,) = axes.legends
    assert [h.get_label() for h in handles] == ["rock", "pier", "150", "chain", "mine"]
    _name_labels(axes, world, np.zeros(0, dtype=np.uint32), set(range(100, 130)))
    assert [h.get_label() for h in axes.legends[1]] == [str(n) for n in range(100, 112)]
    _name_labels(axes, world, np.zeros(0, dtype=np.uint32), set())
    assert len(axes.legends) == 2


def test_statistics_count_things_and_number_labels():
    things = [{"shape": "box", "at_m": [3.0 * k, 0, -5], "label": what, "name": what}
              for k, what in enumerate(("pier", "mine", "pier", "pier"))]  # fmt: skip
    world = build_world(world_config({"type": "flat", "depth_m": 12.0, "size_m": [60, 30], "things": things,
                                      "latitude_deg": 43.5, "longitude_deg": -7.25}))  # fmt: skip
    found = statistics(world)
    assert list(found["objects"].items()) == [("pier", 3), ("seabed", 1), ("mine", 1)]
    assert found["labels"] == {"landscape": 4, "pier": 22, "mine": 70}
    assert found["extent_m"] == pytest.approx([60, 30, 7.5])
    assert found["ground_z_m"] == [-12, -12, -12]
    assert (found["latitude_deg"], found["longitude_deg"]) == (43.5, -7.25)
    assert found["materials"] == ["sand", "concrete"]


@pytest.mark.parametrize("count", [0, 1, 2, 3, 6])
def test_a_sheets_two_sides_are_as_even_as_they_can_be(count, tmp_path, monkeypatch):
    """A map of 8.4 x 6.3 inches and 3.6 of text at the left, views of 4.9 wherever the taller side grows least."""
    from PIL import Image

    Image.new("RGB", (40, 30), (9, 90, 200)).save(tmp_path / "map.png")
    views = []
    for k in range(count):
        Image.new("RGB", (20, 12), (20 * k, 0, 0)).save(tmp_path / f"{k}.png")
        views.append((f"view {k}", tmp_path / f"{k}.png"))
    drawn = []
    monkeypatch.setattr(Figure, "savefig", lambda self, path, **_: (drawn.append(self), path.write_bytes(b"x")))
    sheet.draw_sheet(tmp_path / "s.png", title="t", map_png=tmp_path / "map.png", views=views, lines=["a", "b"])
    left, right = drawn[0].subfigs
    titles = [[a.get_title(loc="left") for a in side.axes] for side in (left, right)]
    aside = len(titles[1])
    assert titles[1] == [f"view {k}" for k in range(aside)]
    assert titles[0] == ["", "", *(f"view {k}" for k in range(aside, count))]
    taller = [max(8.4 * 30 / 40 + 3.6 + 4.9 * (count - a), 4.9 * a) for a in range(count + 1)]
    assert max(9.9 + 4.9 * (count - aside), 4.9 * aside) == pytest.approx(min(taller))
    assert drawn[0].get_size_inches() == pytest.approx([16, min(taller)])
    assert left.axes[1].texts[0].get_text() == "a\nb"

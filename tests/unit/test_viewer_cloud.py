"""Clouds of points and tracks of the scene: what is sent, in which colours, and what goes when it is too much."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

from pelagos.drawing.colours import painted
from pelagos.viewer import cloud as module
from pelagos.viewer import track as tracks
from pelagos.viewer.cloud import Cloud
from pelagos.viewer.track import Track


class Node:
    def __init__(self, arrays: dict[str, Any]) -> None:
        self.arrays, self.visible, self.gone = arrays, True, False

    def show(self, *, visible: bool) -> None:
        self.visible = visible

    def update(self, **arrays: Any) -> None:
        self.arrays |= arrays

    def remove(self) -> None:
        self.gone = True


class Stand:
    """A stage that keeps the newest node of each name, and how often something was sent."""

    def __init__(self) -> None:
        self.nodes: dict[str, Node] = {}
        self.sent = 0

    def add(self, kind: str, name: str, **arrays: Any) -> Node:
        self.sent += 1
        self.nodes[name] = Node({"kind": kind, **arrays})
        return self.nodes[name]

    @property
    def left(self) -> list[str]:
        return [name.removeprefix("/points/auv0/mbes/") for name, node in self.nodes.items() if not node.gone]


def made(monkeypatch: pytest.MonkeyPatch, **limits: Any) -> tuple[Any, Cloud]:
    for name, value in limits.items():
        monkeypatch.setattr(module, name, value)
    stand: Any = Stand()
    return stand, Cloud(stand, "auv0.mbes")


def points(count: int, z: tuple[float, float]) -> np.ndarray[Any, Any]:
    rng = np.random.default_rng(count)
    xyz = np.column_stack([rng.uniform(-20, 30, (count, 2)), rng.uniform(*z, count)])
    xyz[[0, -1], 2] = z
    return xyz


def test_very_many_points_are_thinned_with_their_colours(monkeypatch: pytest.MonkeyPatch) -> None:
    stand, cloud = made(monkeypatch, _PIECE=10_000)
    many = points(9000, (-9.0, -3.0))
    colours = np.random.default_rng(2).integers(0, 255, (9000, 3)).astype(np.uint8)
    cloud.add(many, colours)
    cloud.flush(looked_on=False)
    assert stand.sent == 0
    cloud.flush()
    sent = stand.nodes["/points/auv0/mbes/1"].arrays
    assert sent["kind"] == "points"
    np.testing.assert_allclose(sent["points"], many[::2], rtol=1e-6)
    np.testing.assert_array_equal(sent["colours"], colours[::2])
    monkeypatch.setattr(module, "_EVERY_S", -1.0)
    cloud.flush()  # nothing new
    assert stand.sent == 1
    few = points(100, (-5.0, -4.0))
    cloud.add(few, colours[:100])
    cloud.flush()
    assert stand.left == ["1"]
    np.testing.assert_allclose(stand.nodes["/points/auv0/mbes/1"].arrays["points"][-100:], few, rtol=1e-6)


def test_a_piece_that_is_full_stays_and_the_oldest_goes(monkeypatch: pytest.MonkeyPatch) -> None:
    stand, cloud = made(monkeypatch, _PIECE=50, _MOST=2)
    for k in range(4):
        cloud.add(points(30, (-9.0 - k, -3.0)), None)
        cloud.add(points(20, (-9.0 - k, -3.0)), None)  # as many as make a piece
        assert len(stand.nodes[f"/points/auv0/mbes/{k + 1}"].arrays["points"]) == 50
    assert stand.left == ["3", "4"]
    cloud.add(points(10, (-9.0, -3.0)), None)
    cloud.flush()
    assert stand.left == ["3", "4", "5"]
    assert len(stand.nodes["/points/auv0/mbes/5"].arrays["points"]) == 10
    cloud.clear()
    assert stand.left == []
    cloud.flush()  # nothing is left to send
    assert stand.left == []


def test_colours_by_depth_keep_their_meaning_and_their_span_only_grows(monkeypatch: pytest.MonkeyPatch) -> None:
    """At first at least 2 m to either side of the middle; then down and up as far as points go; anew after a jump."""
    stand, cloud = made(monkeypatch, _PIECE=5)
    spans = [((-5.0, -4.0), (-6.5, -2.5)), ((-12.0, -3.0), (-12.0, -2.5)), ((-6.0, -1.0), (-12.0, -1.0))]
    for k, (z, span) in enumerate(spans, start=1):
        cloud.add(points(6, z), None)
        found = stand.nodes[f"/points/auv0/mbes/{k}"].arrays
        np.testing.assert_array_equal(found["colours"], painted(found["points"][:, 2], *span))
    cloud.clear()
    cloud.add(points(6, (-40.0, -20.0)), None)
    found = stand.nodes["/points/auv0/mbes/4"].arrays
    np.testing.assert_array_equal(found["colours"], painted(found["points"][:, 2], -40.0, -20.0))


def test_points_that_are_hidden_stay_so_and_so_do_those_to_come(monkeypatch: pytest.MonkeyPatch) -> None:
    stand, cloud = made(monkeypatch, _PIECE=40, _EVERY_S=-1.0)
    cloud.add(points(45, (-9.0, -3.0)), None)
    cloud.add(points(10, (-9.0, -3.0)), None)
    cloud.flush()
    cloud.visible = False
    assert not cloud.visible
    assert [stand.nodes[f"/points/auv0/mbes/{k}"].visible for k in (1, 2)] == [False, False]
    cloud.add(points(35, (-9.0, -3.0)), None)
    cloud.add(points(3, (-9.0, -3.0)), None)
    cloud.flush()
    assert [stand.nodes[f"/points/auv0/mbes/{k}"].visible for k in (2, 3)] == [False, False]
    cloud.visible = True
    assert all(node.visible for node in stand.nodes.values())


def test_a_track_goes_on_from_where_its_last_piece_ended(monkeypatch: pytest.MonkeyPatch) -> None:
    """Places nearer than 0.1 m along every axis are left out; pieces of 4 places, the newest two of them and one that
    grows."""
    monkeypatch.setattr(tracks, "_PIECE", 4)
    monkeypatch.setattr(tracks, "_MOST", 2)
    stand: Any = Stand()
    track = Track(stand, "/tracks/a", (1, 2, 3))
    way = np.cumsum(np.random.default_rng(4).uniform(0.2, 0.5, (12, 3)) * [1, -1, 0.1], axis=0)
    for place in way:
        track.add(place)
        track.add(place + np.array([0.09, -0.09, 0.09]))
    ends = [(0, 3), (3, 6), (6, 9), (9, 11)]
    assert [stand.nodes[f"/tracks/a/{k}"].gone for k in range(1, 5)] == [True, False, False, False]
    for k, (first, last) in enumerate(ends, start=1):
        sent = stand.nodes[f"/tracks/a/{k}"].arrays
        np.testing.assert_allclose(sent["points"][:, 0], way[first:last], rtol=1e-6)
        np.testing.assert_allclose(sent["points"][:, 1], way[first + 1 : last + 1], rtol=1e-6)
        assert (sent["kind"], sent["colour"]) == ("lines", (1, 2, 3))
    track.clear()
    assert all(node.gone for node in stand.nodes.values())
    track.add(way[0])
    assert len(stand.nodes) == 4  # one place is no line
    track.add(way[1])
    assert len(stand.nodes["/tracks/a/5"].arrays["points"]) == 1

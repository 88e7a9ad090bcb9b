"""The view's map: what comes near is in the colours and the light of the whole, and lies where it says."""

from __future__ import annotations

import io
import json
from typing import Any

import numpy as np
import pytest
from PIL import Image

from pelagos.drawing.relief import depth_norm, relief, shaded, tone_of
from pelagos.math.geodesy import GeoOrigin
from pelagos.viewer.chart import Chart
from pelagos.viewer.hub import Hub
from pelagos.world.shapes import box
from pelagos.world.site import Site
from pelagos.world.terrain import HeightField
from pelagos.world.world import World

HILL = np.array([-14.0, 9.0])
CRATE = np.array([21.0, -17.5])


@pytest.fixture(scope="module")
def world() -> World:
    """100 m by 120 m, a hill of 4 m on 12 m of water, and a crate of 3 m by 5 m."""
    x, y = np.meshgrid(np.arange(-50.0, 51.0), np.arange(-60.0, 61.0), indexing="ij")
    z = -12.0 + 4.0 * np.exp(-((x - HILL[0]) ** 2 + (y - HILL[1]) ** 2) / (2 * 8.0**2))
    site = Site()
    site.ground(HeightField(-50.0, -60.0, 1.0, z), "sand")
    site.add(box((3.0, 5.0, 2.0)).moved((*CRATE, -11.0)), "steel", label="debris", name="crate")
    return site.world(name="hill", description="", origin=GeoOrigin(43.1, 5.9))


@pytest.fixture(scope="module")
def chart(world: World) -> Chart:
    return Chart(world)


class _Sent(Hub):
    """Keeps what would go to browsers."""

    def publish(self, key: str, header: Any, blob: bytes = b"", *, keep: bool = True) -> None:
        json.dumps(header, allow_nan=False)
        assert not keep
        self.header, self.blob = dict(header), blob


def pixels(png: bytes) -> np.ndarray[Any, Any]:
    return np.asarray(Image.open(io.BytesIO(png)), dtype=float)


def at(picture: np.ndarray[Any, Any], bounds: Any, x: float, y: float) -> np.ndarray[Any, Any]:
    """The colour at a place, of the nearest pixel; the page lays pictures so."""
    x0, y0, x1, y1 = bounds
    h, w = picture.shape[:2]
    return picture[min(int((x1 - x) / (x1 - x0) * h), h - 1), min(int((y1 - y) / (y1 - y0) * w), w - 1)]


def test_a_part_has_the_colours_of_the_whole_and_lies_where_it_says(chart: Chart) -> None:
    """Over smooth ground, at most 3 of 255: a pixel of the whole is 0.23 m, its light that of a slope of two pixels."""
    sent, low, high = _Sent(), chart.bounds[0], chart.bounds[1]
    chart.ask({"bounds": [-31.0, -12.5, 7.0, 23.0]})
    found = chart.survey()
    assert found is not None
    chart.publish(sent, found)
    part, whole = pixels(sent.blob), pixels(chart.whole)
    assert sent.header["bounds"] == pytest.approx([-31.0, -12.5, 7.0, 23.0], abs=0.1)
    for x, y in np.random.default_rng(4).uniform([-29, -11], [5, 21], (60, 2)):
        assert at(part, sent.header["bounds"], x, y) == pytest.approx(at(whole, (*low, *high), x, y), abs=3.0)
    assert np.ptp(part.reshape(-1, 3), axis=0).min() > 40  # the hill is seen
    assert part.shape[0] > 4 * (7.0 + 31.0) / (high[1] - low[1]) * whole.shape[1] / 2  # and from nearer


def test_edges_of_structures_are_sharp_from_near(chart: Chart) -> None:
    """The crate of 3 m by 5 m, to a pixel of 19 mm on each side."""
    chart.ask({"bounds": [CRATE[0] - 4, CRATE[1] - 5, CRATE[0] + 4, CRATE[1] + 5]})
    found = chart.survey()
    assert found is not None
    step = float(found.east[1] - found.east[0])
    assert step < 0.02
    rows, columns = np.flatnonzero(found.structure.any(axis=1)), np.flatnonzero(found.structure.any(axis=0))
    north, west = found.north[rows], -found.east[columns]
    assert [north.min(), north.max()] == pytest.approx([CRATE[0] - 1.5, CRATE[0] + 1.5], abs=1.01 * step)
    assert [west.min(), west.max()] == pytest.approx([CRATE[1] - 2.5, CRATE[1] + 2.5], abs=1.01 * step)


def test_the_light_is_from_the_north_west(world: World) -> None:
    low, high = world.bounds[:, :2]
    ground = relief(world, low, high)
    light = shaded(ground, tone_of(ground, depth_norm(ground.height))).sum(axis=-1)

    def bright(x: float, y: float) -> float:
        return float(light[np.abs(ground.north - x).argmin(), np.abs(ground.east + y).argmin()])

    north_west, south_east, north_east = (HILL + 6.0 * np.array(way) for way in ((1, 1), (-1, -1), (1, -1)))
    assert bright(*north_west) > 1.2 * bright(*north_east) > 1.2 * 1.2 * bright(*south_east)


@pytest.mark.parametrize(
    "bounds",
    [None, "all", [1, 2, 3], [1, 2, 3, float("nan")], [5, 5, 5, 5], [9, 9, 1, 1], [400, 400, 500, 500], [0, 0, 0.2, 9],
     [0, "a", 9, 9]],
)  # fmt: skip
def test_nonsense_is_not_drawn(chart: Chart, bounds: Any) -> None:
    chart.ask({"bounds": bounds})
    assert chart.survey() is None


def test_browsers_that_ask_without_end_wait_in_a_short_line(chart: Chart) -> None:
    for i in range(50):
        chart.ask({"bounds": [i - 40.0, -3.0, i - 30.0, 5.0]})
    found = [chart.survey() for _ in range(5)]
    assert [f is None for f in found] == [False] * 4 + [True]
    assert found[0] is not None
    assert found[0].north[0] == pytest.approx(6.0)  # the newest


def test_a_world_without_ground_has_a_map_all_the_same() -> None:
    chart = Chart(World([], ()))
    chart.ask({"bounds": [-5, -6, 7, 8]})
    assert chart.survey() is None
    assert chart.legend == {}
    assert len(np.unique(pixels(chart.whole).reshape(-1, 3), axis=0)) == 1

"""Signs, factors and axes where numbers become pictures: fans of sonars, tracks of manoeuvres, flakes of snow."""

from __future__ import annotations

import math

import numpy as np
import pytest
from matplotlib.figure import Figure

from pelagos import jit
from pelagos.manoeuvres import turning_measures, zigzag_measures
from pelagos.manoeuvres.measures import Measure
from pelagos.manoeuvres.picture import _bollard, _overshoots, _track, _turn_marks
from pelagos.manoeuvres.trial import Track, Trial
from pelagos.messages.fan import FanPreview, copper
from pelagos.optics.snow import flakes


@pytest.mark.parametrize("azimuth", [np.linspace(0.7, -0.3, 6), np.linspace(-0.9, 0.1, 9)])
def test_a_fan_shows_each_cell_where_it_lies(azimuth: np.ndarray) -> None:
    """Bilinear weights keep what is linear in angle and range: 20 + 60 k/(beams - 1) + 70 j/(bins - 1), to the half of
    a level that a byte is off before it is weighed and the half after."""
    first, last, bins, height = 3.0, 18.0, 15, 60
    polar = 20 + 60 * np.linspace(0, 1, len(azimuth))[:, None] + 70 * np.linspace(0, 1, bins)[None, :]
    shown = FanPreview(azimuth, first, last, bins, height=height)(np.round(polar).astype(np.uint8))
    level = shown[..., 0] / 1.35  # red is 1.35 of the level, until it is full
    pixel = last / height
    ahead = (height - np.arange(height) - 0.5)[:, None] * pixel  # the sonar is below the middle of the lowest row
    left = (0.5 * shown.shape[1] - np.arange(shown.shape[1]) - 0.5)[None, :] * pixel
    angle, r = np.arctan2(left, ahead), np.hypot(left, ahead)
    depth = (last - first) / bins
    expected = (
        20
        + 60 * (angle - azimuth[0]) / (azimuth[-1] - azimuth[0])
        + 70 * (r - first - 0.5 * depth) / (last - first - depth)
    )
    within = (angle > azimuth.min()) & (angle < azimuth.max()) & (r > first + 0.5 * depth) & (r < last - 0.5 * depth)
    assert within.sum() > 500
    assert level[within] == pytest.approx(expected[within], abs=0.5 + 0.5 + 0.5 / 1.35)
    beam = abs(azimuth[1] - azimuth[0])
    outside = (angle < azimuth.min() - 0.51 * beam) | (angle > azimuth.max() + 0.51 * beam) | (r < first) | (r > last)
    assert not shown[outside].any()


def test_copper_grows_from_black_through_copper_to_pale() -> None:
    """Red 1.35 x, green 0.78 x + 0.22 x^4, blue 0.42 x + 0.45 x^5, in parts of 255, at x = 51/255 and 1."""
    assert copper()[[0, 51, 255]].tolist() == [[0, 0, 0], [69, 40, 21], [255, 255, 222]]


def test_a_track_begins_where_the_helm_is_laid() -> None:
    """In lengths, along the course at that moment and to its starboard; each outline's bow points where the ship heads,
    its beam is the ship's."""
    time = np.linspace(0.0, 30.0, 31)
    position = np.stack([40.0 + 5.0 * time, -70.0 + 3.0 * time, 0 * time], axis=1)
    attitude = np.stack([0 * time, 0 * time, 0.02 * time - 0.7], axis=1)
    still = np.zeros((31, 3))
    track = Track(time, position, attitude, still, still, np.zeros((31, 1)))
    axes = Figure().subplots()
    _track(axes, Trial("zigzag", "10/10", "ship", 25.0, 4.0, track, [], np.array([12.0])))
    course = 0.02 * 12.0 - 0.7
    north, east = 5.0 * (time - 12.0) / 25.0, 3.0 * (time - 12.0) / 25.0
    starboard = -north * math.sin(course) + east * math.cos(course)
    expected = np.stack([starboard, north * math.cos(course) + east * math.sin(course)], axis=1)
    assert axes.lines[0].get_xydata() == pytest.approx(expected)
    for patch, k in zip(axes.patches, np.linspace(0, 30, 9).astype(int), strict=True):
        stern, port, starboard, bow = (patch.get_xy()[j] for j in (0, 1, 3, 2))
        heading = attitude[k, 2] - course
        assert bow - expected[k] == pytest.approx([0.5 * math.sin(heading), 0.5 * math.cos(heading)])
        aside = np.array([math.cos(heading), -math.sin(heading)])  # to starboard
        assert [(v - expected[k]) @ aside for v in (stern, port, starboard)] == pytest.approx([-0.08, -0.08, 0.08])


@pytest.mark.parametrize("side", [1, -1])
def test_dimensions_of_a_turning_circle_end_at_its_points(side: int) -> None:
    """An ellipse, 30 m ahead by 24 m: its dots lie on the track at 90 and 180 deg of heading, to the turn's side."""
    time = np.linspace(0.0, 80.0, 8001)
    turned = np.maximum(time - 10.0, 0.0) * 0.1
    ahead = np.where(time < 10, 3.0 * (time - 10.0), 30.0 * np.sin(turned))
    aside = side * 24.0 * (1 - np.cos(turned))
    still = np.zeros((8001, 3))
    attitude = np.stack([0 * time, 0 * time, side * turned], axis=1)
    track = Track(time, np.stack([ahead, aside, 0 * time], axis=1), attitude, still, still, np.zeros((8001, 1)))
    found = turning_measures(time, ahead, aside, np.degrees(side * turned), ordered_s=10.0, length_m=12.0)
    axes = Figure().subplots()
    _turn_marks(axes, Trial("turning", "35 deg", "ship", 12.0, 2.0, track, found, np.array([10.0])))
    dots = [line.get_xydata()[0] for line in axes.lines if line.get_marker() == "o"]
    assert dots == [pytest.approx([2.0 * side, 2.5], abs=1e-5), pytest.approx([4.0 * side, 0.0], abs=1e-3)]


def test_overshoots_are_drawn_from_the_angle_to_the_peak() -> None:
    """10 deg of a heading 1 + 14 sin: arrows of 5 deg up and of 3 deg down."""
    time = np.linspace(0.0, 100.0, 10001)
    heading = np.radians(1 + 14 * np.sin(0.1 * time))
    first, second = (np.arcsin(9 / 14)) / 0.1, (np.pi + np.arcsin(11 / 14)) / 0.1
    third = first + 20 * np.pi
    still = np.zeros((10001, 3))
    track = Track(time, still, np.stack([0 * time, 0 * time, heading], axis=1), still, still, still[:, :1])
    found = zigzag_measures(time, np.degrees(heading), np.array([first, second, third]), rudder_deg=10, angle_deg=10,
                            length_m=12.0, speed_m_s=3.0, run_lengths=1.0)  # fmt: skip
    axes = Figure().subplots()
    switched = np.array([0.0, first, second, third])
    _overshoots(axes, Trial("zigzag", "10/10", "ship", 12.0, 2.0, track, found, switched))
    arrows = [(a.xyann[1], a.xy[1]) for a in axes.texts if not a.get_text()]
    assert arrows == [pytest.approx((10.0, 15.0), abs=1e-3), pytest.approx((-10.0, -13.0), abs=1e-3)]
    assert [a.get_text().split("\n")[0] for a in axes.texts if a.get_text()] == ["5.0°", "3.0°"]


@pytest.mark.parametrize(("pull", "unit", "drawn"), [(9900.0, "N", 9900.0), (1e4, "kN", 10.0)])
def test_pulls_of_ten_kilonewtons_and_more_are_drawn_in_kilonewtons(pull: float, unit: str, drawn: float) -> None:
    said = [Measure("screw, ahead", 2.0, "N"), Measure("screw, astern", -pull, "N"), Measure("lost", 7.0, "%")]
    figure, none = Figure(), np.zeros((0, 3))
    track = Track(np.zeros(0), none, none, none, none, none)
    _bollard(figure, Trial("bollard", "still water", "ship", 12.0, 0.0, track, said, np.zeros(0)))
    pulls, lost = figure.axes
    assert pulls.get_xlabel() == f"pull [{unit}], positive ahead"
    assert [bar.get_width() for bar in pulls.patches] == [2.0 * drawn / pull, -drawn]
    assert [bar.get_width() for bar in lost.patches] == [7.0]


def test_flakes_smaller_than_a_pixel_send_the_same_light_through_any() -> None:
    """A flake of radius s before pixels of width p > 2 s covers (2 s/p)^2 of one: coarser pixels, as much in all. Of
    some 300 flakes a tenth is the chance's; where pixels overlap, some more is lost."""
    rng = np.random.default_rng(5)
    n = 400_000
    away = rng.normal(size=(3, n))
    away /= np.linalg.norm(away, axis=0)
    place = jit.Array3f(13.7, -4.1, -6.3)
    rays = jit.Array3f(away.astype(np.float32))
    mean = []
    for angle in (0.01, 0.02):
        cover, where = flakes(place, rays, jit.Float(50.0), 60.0, angle)
        cover, where = np.array(cover), np.array(where)
        widest = 2 * 0.0012 / (where[cover > 0] * angle)
        assert (cover[cover > 0] <= np.minimum(1.0, widest**2) * 1.001).all()
        mean.append(cover.mean())
    assert mean[0] > 1e-4
    assert mean[1] == pytest.approx(mean[0], rel=0.2)

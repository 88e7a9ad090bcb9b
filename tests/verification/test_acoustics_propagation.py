"""Paths in layered water and between boundaries against closed forms and published arrivals."""

from __future__ import annotations

import math

import numpy as np
import pytest

from pelagos import jit
from pelagos.acoustics.image_sources import paths
from pelagos.acoustics.refraction import arc_radius, bend, trace_layers


def munk(depth):
    z = 2 * (depth - 1300) / 1300
    return 1500 * (1 + 0.00737 * (z - 1 + np.exp(-z)))


def test_linear_gradient_is_a_circle():
    """c = 1500 at the source, 0.05 1/s: a ray launched 10 deg down is back at its depth after 10 579.619 m."""
    ray = trace_layers([0, 2000], [1450, 1550], source_depth=1000, angle=math.radians(10), distance=10579.619)
    assert ray.depth == pytest.approx(1000.0, abs=1e-3)
    assert ray.time == pytest.approx(7.017033, abs=1e-6)
    assert ray.angle == pytest.approx(-math.radians(10), abs=1e-6)
    turn = trace_layers([0, 2000], [1450, 1550], source_depth=1000, angle=math.radians(10), distance=10579.619 / 2)
    assert turn.depth - 1000 == pytest.approx(462.798, abs=1e-3)


def test_layers_do_not_change_the_circle():
    depth = np.linspace(0, 2000, 41)
    one = trace_layers([0, 2000], [1450, 1550], source_depth=1010, angle=0.1, distance=7000.0)
    many = trace_layers(depth.tolist(), (1450 + 0.05 * depth).tolist(), source_depth=1010, angle=0.1, distance=7000.0)
    assert (many.depth, many.time, many.length) == pytest.approx((one.depth, one.time, one.length), rel=1e-9)


@pytest.mark.parametrize(("degrees", "radius"), [(0, 88235.29), (5, 88572.34), (10, 89596.47)])
def test_radius_of_the_arc(degrees, radius):
    assert arc_radius(1500.0, 0.017, math.radians(degrees)) == pytest.approx(radius, abs=0.005)


@pytest.mark.parametrize(
    ("degrees", "cycle", "seconds"),
    [(5, 50185.52, 33.45288), (10, 56696.66, 37.74834), (13, 62670.48, 41.64608)],
)
def test_munk_profile_cycles(degrees, cycle, seconds):
    depth = np.linspace(0, 5000, 5001)
    ray = trace_layers(
        depth.tolist(), munk(depth).tolist(), source_depth=1000, angle=math.radians(degrees), distance=cycle
    )
    assert ray.depth == pytest.approx(1000.0, abs=0.5)  # cycle ranges are given to 1 cm at angles around 0.1
    assert ray.time == pytest.approx(seconds, abs=1e-4)


def test_straight_water_keeps_rays_straight():
    ray = trace_layers([0, 100], [1500, 1500], source_depth=50, angle=0.2, distance=100)
    assert ray.depth == pytest.approx(50 + 100 * math.tan(0.2))
    assert ray.time == pytest.approx(100 / math.cos(0.2) / 1500)


def test_bend_turns_by_the_curvature():
    """After 100 m of level path in c' = -0.5 1/s (slower upwards) the ray has turned up by 100 0.5/1500."""
    d = bend(jit.Array3f(1, 0, 0), jit.Float(-0.5 / 1500), jit.Float(100.0))
    assert np.array(d).ravel() == pytest.approx([math.cos(1 / 30), 0, math.sin(1 / 30)], abs=1e-6)


def test_pekeris_arrivals():
    """org-arl/UnderwaterAcoustics.jl: depth 20 m, source 5 m, receiver 10 m deep at 100 m; 1538.9236 m/s."""
    expected = [
        (0, 0, 100.124922, 65.061659, 2.8624), (1, 0, 101.118742, 65.707448, 8.5308),
        (0, 1, 103.077641, 66.980350, 14.0362), (1, 1, 105.948101, 68.845589, 19.2900),
        (1, 1, 109.658561, 71.256664, 24.2277), (2, 1, 114.127122, 74.160357, 28.8108),
        (1, 2, 119.268604, 77.501317, 33.0239),
    ]  # fmt: skip
    for path, (surface, bottom, length, time, angle) in zip(paths(20, 5, 10, 100, count=7), expected, strict=True):
        assert (path.surface, path.bottom) == (surface, bottom)
        assert path.length == pytest.approx(length, abs=1e-6)
        assert path.length / 1538.9236 * 1e3 == pytest.approx(time, abs=1e-5)
        assert math.degrees(path.angle) == pytest.approx(angle, abs=1e-4)


def test_paths_are_reciprocal():
    there, back = paths(30, 4, 21, 250, count=9), paths(30, 21, 4, 250, count=9)
    assert [p.length for p in there] == pytest.approx([p.length for p in back], rel=1e-12)
    assert [(p.surface, p.bottom) for p in there] == [(p.surface, p.bottom) for p in back]

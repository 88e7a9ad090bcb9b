"""Maps of the sea surface around cameras, of several lanes that are elsewhere at other times, against NumPy."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.ndimage import map_coordinates

from pelagos import jit
from pelagos.optics.caustics import CELLS, PLANES, TILE, Waves, focusing, slope, unseen_slope
from pelagos.optics.swell import elevation_at, swell_around, swell_slope, whiteness_at

Values = NDArray[np.float64]
PLACES = np.array([[31.3, -12.9], [-207.6, 88.2], [5.1, 3.4]])
TIMES = np.array([3.0, 7.5, -2.0])
COPIES = np.array([2, 0, 1])
LANES = np.array([1, 0, 2, 1, 1, 2, 0, 0, 2, 1])
SHIFTS = np.array([  # of the places that are asked for, from the camera of their lane [m]
    [3.2, -7.9], [-14.1, 21.7], [0.4, 23.1], [-60.3, 44.0], [91.0, -20.0], [95.4, 95.1], [-333.0, 150.0],
    [-370.0, 12.0], [55.0, -379.0], [460.0, 20.0],
])  # fmt: skip


def sea(x: Any, y: Any, t: Any, copy: Any, lib: Any = np) -> Any:
    return 1.3 * lib.sin(0.11 * x - 0.05 * y + 0.4 * t + copy) + 0.004 * x + 0.7 * copy


def foam(x: Any, y: Any, t: Any, copy: Any, lib: Any = np) -> Any:
    return 0.5 + 0.4 * lib.sin(0.21 * x + 0.13 * y - t) + 0.05 * copy


def on_device(field: Any) -> Any:
    import drjit as dr

    return lambda x, y, t, copy: field(x, y, t, jit.Float64(copy), dr)


class Grids:
    """Three grids of 33 x 33 about a camera, 1.5, 6 and 24 m apart, their corners at whole steps."""

    def __init__(self, field: Any, lane: int) -> None:
        self.steps = (1.5, 6.0, 24.0)
        self.corners = [np.round((PLACES[lane] - 16 * s) / s) * s for s in self.steps]
        self.values = []
        for s, corner in zip(self.steps, self.corners, strict=True):
            x, y = (c + s * np.arange(33) for c in corner)
            self.values.append(field(x[:, None], y[None, :], TIMES[lane], COPIES[lane]))

    def at(self, values: list[Values], place: Values, beyond: float) -> float:
        """Passing over into the next in a grid's outer fifth, the last into `beyond`."""
        for k in (0, 1, 2):
            u = (place - self.corners[k]) / self.steps[k]
            far = np.abs(u - 16).max() / 16
            if far < 1 or k == 2:
                v = (place - self.corners[min(k + 1, 2)]) / self.steps[min(k + 1, 2)]
                here = map_coordinates(values[k], u[:, None], order=1, mode="nearest")[0]
                then = beyond if k == 2 else map_coordinates(values[k + 1], v[:, None], order=1, mode="nearest")[0]
                out = min(max((far - 0.8) / 0.2, 0.0), 1.0)
                return float((1 - out) * here + out * then)
        raise AssertionError


def test_swell_is_that_of_each_cameras_own_place_time_and_copy() -> None:
    place = jit.Array3f64(PLACES[:, 0], PLACES[:, 1], np.array([2.0, -1.0, 4.0]))
    made = swell_around(
        on_device(sea), place, jit.Float64(TIMES), 3, on_device(foam), jit.UInt32(COPIES.astype(np.uint32))
    )
    heights = [Grids(sea, k) for k in range(3)]
    whites = [Grids(foam, k) for k in range(3)]
    everything = [np.concatenate([v.ravel() for v in g.values]) for g in heights]
    for name, expected in (
        ("level", [sea(*PLACES[k], TIMES[k], COPIES[k]) for k in range(3)]), ("mean", [v.mean() for v in everything]),
        ("lowest", [v.min() for v in everything]), ("highest", [v.max() for v in everything]),
        ("corner_x", [g.corners[0][0] for g in heights]), ("corner_y", [g.corners[0][1] for g in heights]),
    ):  # fmt: skip
        assert np.array(getattr(made, name)) == pytest.approx(np.array(expected), rel=1e-5, abs=1e-5), name
    asked = PLACES[LANES] + SHIFTS
    lane = jit.UInt32(LANES.astype(np.uint32))
    local = asked - [heights[k].corners[0] for k in LANES]
    found = np.array(elevation_at(made, *(jit.Float(c) for c in local.T), lane))
    expected = [heights[k].at(heights[k].values, p, everything[k].mean()) for k, p in zip(LANES, asked, strict=True)]
    assert found == pytest.approx(expected, abs=2e-4)
    world = [jit.Float(c) for c in asked.T]
    white = [whites[k].at(whites[k].values, p, 0.0) for k, p in zip(LANES, asked, strict=True)]
    assert np.array(whiteness_at(made, *world, lane)) == pytest.approx(white, abs=2e-4)
    slopes = [[np.gradient(v, s) for v, s in zip(g.values, g.steps, strict=True)] for g in heights]
    tilt = [
        [heights[k].at([both[axis] for both in slopes[k]], p, 0.0) for k, p in zip(LANES, asked, strict=True)]
        for axis in (0, 1)
    ]
    assert np.array(swell_slope(made, *world, lane)) == pytest.approx(np.array(tilt), abs=1e-4)


def random_waves() -> tuple[Waves, list[Values], Values]:
    rng = np.random.default_rng(12)
    slopes = [rng.normal(0, 0.1, (2, CELLS, CELLS)) for _ in range(2)]
    focus = rng.uniform(0.2, 2.0, (2, len(PLANES), CELLS, CELLS))
    x, y, maps = (jit.Float(v.ravel().astype(np.float32)) for v in (*slopes, focus))
    rough = (jit.Float(v) for v in (0.013, 0.004, 0.009))
    return Waves(x, y, maps, None, jit.UInt32([1, 0, 1]), *rough), slopes, focus


def periodic(table: Values, x: Values, y: Values) -> Values:
    at = [np.ravel(v) * CELLS / TILE for v in (x, y)]
    return np.asarray(map_coordinates(table, at, order=1, mode="grid-wrap"))


def test_focused_light_is_asked_for_along_the_suns_rays_between_two_maps() -> None:
    """By the logarithm of depth between the planes' maps of the lane's own moment; none at the surface itself."""
    waves, _, focus = random_waves()
    rng = np.random.default_rng(13)
    x, y = rng.uniform(-30, 30, (2, 60))
    depth = np.concatenate([[0.0, -1.0, 0.4, 30.0], rng.uniform(0.1, 14.0, 56)])
    lane = np.arange(60) % 3
    sun = np.array([0.3, -0.4, math.sqrt(0.75)])
    arrays = [jit.Float(v) for v in (x, y, depth)]
    found = np.array(focusing(waves, *arrays, jit.Array3f(sun.tolist()), jit.UInt32(lane.astype(np.uint32))))
    marks = np.log(PLANES)
    for k in range(60):
        qx, qy = (np.array([p + depth[k] * s / sun[2]]) for p, s in ((x[k], sun[0]), (y[k], sun[1])))
        own = [periodic(plane, qx, qy)[0] for plane in focus[(1, 0, 1)[lane[k]]]]
        step = (math.log(max(depth[k], 1e-3)) - marks[0]) / (marks[1] - marks[0])
        value = float(np.interp(step, np.arange(len(PLANES)), own))
        shallow = min(max(depth[k] / PLANES[0], 0.0), 1.0)
        assert found[k] == pytest.approx(1 + (value - 1) * shallow, abs=4e-3), k


def test_slopes_average_out_in_far_pixels_and_are_rough_instead() -> None:
    """1 / (1 + (0.05 d)^2) of a ripple's slope is left, and of its mean square what that leaves is unseen; the ocean's
    own waves are so seen up to twelve times as far."""
    waves, (sx, sy), _ = random_waves()
    x, y = np.random.default_rng(14).uniform(-20, 20, (2, 30))
    lane, away = np.arange(30) % 3, np.linspace(0, 200, 30)
    found = np.array(slope(waves, jit.Float(x), jit.Float(y), jit.UInt32(lane.astype(np.uint32)), jit.Float(away)))
    for k in range(30):
        moment = (1, 0, 1)[lane[k]]
        left = 1 / (1 + (0.05 * away[k]) ** 2)
        expected = [left * periodic(s[moment], x[k : k + 1], y[k : k + 1])[0] for s in (sx, sy)]
        assert found[:, k] == pytest.approx(expected, abs=1e-4)
    short, long = ((1 / (1 + (r * away) ** 2)) ** 2 for r in (0.05, 0.004))
    unseen = 0.013 + 0.004 * (1 - short) + 0.009 * (1 - long)
    assert np.array(unseen_slope(waves, jit.Float(away))) == pytest.approx(unseen, rel=1e-4)

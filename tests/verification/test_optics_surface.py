"""Caustics, textures, lenses and tone: conservation, projection, repeatability."""

from __future__ import annotations

import math
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.optics.caustics import CELLS, PLANES, TILE, focusing, ripple, waves_at
from pelagos.optics.exposure import encode_srgb, metered, saturation_luminance, shoulder
from pelagos.optics.interface import sun_below_surface
from pelagos.optics.lens import brown_conrady, intrinsics, pinhole_directions, project, undistort
from pelagos.optics.sunlight import daylight
from pelagos.optics.texture import _seams, _turned_noise, value_noise


def numbers(array: Any) -> Any:
    return np.array(array, dtype=float).squeeze()


def sea(t: float, slope: float = 0.004) -> Any:
    return waves_at(ripple(slope), jit.Float64(t), jit.Array3f(*daylight(0.9).towards_sun), 1)


def test_caustics_move_light_and_make_none():
    focus = numbers(sea(2.0).focus).reshape(len(PLANES), CELLS, CELLS)
    assert focus.mean(axis=(1, 2)) == pytest.approx(np.ones(len(PLANES)), abs=1e-6)
    assert focus.max() > 2.0
    assert (focus >= 0).all()


def test_caustics_vanish_without_waves_and_change_with_time():
    assert numbers(sea(0.0, slope=0.0).focus) == pytest.approx(1, abs=1e-6)
    assert not np.array_equal(numbers(sea(0.0).focus), numbers(sea(0.2).focus))


def test_ripple_has_the_slope_asked_for():
    assert ripple(0.004).mean_square_slope == pytest.approx(0.004, rel=1e-6)
    waves = sea(1.0)
    total = np.mean(numbers(waves.slope_x) ** 2 + numbers(waves.slope_y) ** 2)
    assert total == pytest.approx(0.004, rel=0.02)  # equal wave vectors interfere: a few in 28


def test_shallow_caustics_have_the_contrast_of_theory():
    """At small depth E = 1 + D (1 - 1/n) lap(h) in geometric optics."""
    waves = waves_at(ripple(1e-3), jit.Float64(0.7), jit.Array3f(0, 0, 1), 1)
    depth = PLANES[0]
    r = ripple(1e-3)
    kx, ky = (2 * math.pi / TILE * np.array(v) for v in (r.i, r.j))
    seen = np.array(r.height) * (kx**2 + ky**2)
    for k in (kx, ky):  # what the tent over cells leaves of a wave
        seen = seen * np.cos(k * TILE / CELLS / 2) ** 2
    contrast = depth * (1 - 1 / 1.34) * math.sqrt(0.5 * np.sum(seen**2))
    focus = numbers(waves.focus).reshape(len(PLANES), CELLS, CELLS)[0]
    assert focus.std() == pytest.approx(contrast, rel=0.08)  # differences over a cell, and equal wave vectors interfere


def test_caustics_lie_along_the_refracted_sun():
    """The same light, met deeper, stands further from the sun by depth times the tangent."""
    waves = sea(1.0)
    towards = sun_below_surface(jit.Array3f(*daylight(0.9).towards_sun))
    x = jit.Float(np.linspace(0, 8, 200))
    lane = dr.zeros(jit.UInt32, 200)
    shift = PLANES[1] * float(towards.x[0] / towards.z[0])
    at_plane = numbers(focusing(waves, x - shift, jit.Float(0.0), jit.Float(PLANES[1]), towards, lane))
    table = numbers(waves.focus).reshape(len(PLANES), CELLS, CELLS)[1]
    column = np.interp(np.linspace(0, 8, 200) / TILE * CELLS, np.arange(CELLS + 1), np.r_[table[:, 0], table[0, 0]])
    assert at_plane == pytest.approx(column, abs=2e-3)


def test_noise_has_mean_zero_and_its_own_gradient():
    rng = np.random.default_rng(0)
    p = rng.uniform(-50, 50, (3, 20_000))
    value, _ = value_noise(jit.Array3f(p))
    assert abs(numbers(value).mean()) < 0.02
    assert np.abs(numbers(value)).max() <= 1
    h = 1e-2  # second order: h^2 / 6 times a third derivative of ~60
    for noise in (value_noise, _turned_noise):
        _, gradient = noise(jit.Array3f(p))
        for axis in range(3):
            step = h * np.eye(3)[:, axis : axis + 1]
            up, down = (noise(jit.Array3f(at))[0] for at in (p + step, p - step))
            slope = (numbers(up) - numbers(down)) / (2 * h)
            assert np.median(np.abs(slope - numbers(gradient)[axis])) < 2e-3


def test_seams_are_dark_lines_on_the_faces_that_their_planes_cut():
    """A mesh of 2.5 m has lines 19 mm to either side, fading over half of that; not on faces along the plane."""
    place = np.array([
        [2.5, 0.7, 1.1], [2.491, 0.7, 1.1], [2.519, 0.7, 1.1], [2.53, 0.7, 1.1], [1.2, -5.0, 0.6], [1.2, 0.7, 0.01],
        [2.5, 0.7, 1.1], [1.2, 0.7, 0.01],
    ])  # fmt: skip
    up, north = [0.0, 0.0, 1.0], [1.0, 0.0, 0.0]
    normal = np.array([up] * 6 + [north, north])
    half = 0.004 + 0.006 * 2.5
    expected = [min(max(1.5 - d / half, 0.0), 1.0) for d in (0.0, 0.009, 0.019, 0.03, 0.0, 1.0, 1.0, 0.01)]
    args = (jit.Array3f(place.T.astype(np.float32)), jit.Float(2.5), jit.Array3f(normal.T.astype(np.float32)))
    assert numbers(_seams(*args, jit.Float(0.0))) == pytest.approx(expected, abs=2e-3)
    wide = half + 0.5 * 0.2  # a pixel of 20 cm: lines as wide, and as much fainter
    fainter = 2 * half / wide
    blurred = [min(max(1.5 - d / wide, 0), 1) * fainter for d in (0, 0.009, 0.019, 0.03, 0, 1, 1, 0.01)]
    assert numbers(_seams(*args, jit.Float(0.2))) == pytest.approx(blurred, abs=2e-3)


def test_pixels_look_where_points_project():
    """Projection of points on the rays comes back to the pixel's centre."""
    camera = intrinsics(160, 120, math.radians(70))
    for distortion in ((0.0,) * 5, (-0.28, 0.09, 1e-3, -5e-4, -0.02), (0.12, 0.01, 0.0, 0.0, 0.0)):
        d = pinhole_directions(camera, distortion)
        assert np.linalg.norm(d, axis=-1) == pytest.approx(1)
        uv = project(d * np.linspace(1, 9, 160)[:, None], camera, distortion)
        v, u = np.mgrid[:120, :160]
        assert np.abs(uv[..., 0] - u).max() < 2.5e-4
        assert np.abs(uv[..., 1] - v).max() < 2.5e-4


def test_field_of_view_spans_the_outer_edges():
    camera = intrinsics(640, 480, math.radians(70))
    d = pinhole_directions(camera)
    edge = project(np.array([[1.0, math.tan(math.radians(35)), 0.0]]), camera)
    assert edge[0, 0] == pytest.approx(-0.5)  # the left edge of the leftmost pixel
    assert d[0, 0, 1] > 0  # left is left
    assert d[0, 0, 2] > 0  # and up is up


def test_distortion_inverts_and_says_where_it_cannot():
    x, y = np.meshgrid(np.linspace(-0.7, 0.7, 9), np.linspace(-0.5, 0.5, 9))
    k = (-0.3, 0.1, 2e-3, -1e-3, 0.0)
    xd, yd = brown_conrady(x, y, k)
    assert undistort(xd, yd, k)[0] == pytest.approx(x, abs=1e-9)
    assert np.isnan(undistort(np.array([2.5]), np.array([0.0]), (-0.4, 0.0, 0.0, 0.0, 0.0))[0]).all()


@pytest.mark.parametrize("k", [(-0.3, 0.1, 0.0, 0.0, 0.0), (-0.2, 0.03, 0.01, 0.01, 0.0), (1.0, 0.5, 1e-3, 0.0, 0.2)])
def test_distortion_inverts_in_wide_pictures(k: tuple[float, ...]):
    """One to one everywhere: each pixel of 120 degrees looks somewhere, and projects back to itself."""
    camera = intrinsics(160, 120, math.radians(120))
    d = pinhole_directions(camera, k)
    uv = project(d, camera, k)
    v, u = np.mgrid[:120, :160]
    assert np.abs(uv - np.stack([u, v], axis=-1)).max() < 1e-6


def test_distortion_has_no_inverse_beyond_its_fold():
    """r (1 - 0.3 r^2) is largest at r^2 = 1 / 0.9, where it is 0.7027; its second inverse beyond is not taken."""
    k = (-0.3, 0.0, 0.0, 0.0, 0.0)
    radius = np.array([0.70, 0.7025, 0.7029, 1.2])
    found = undistort(radius, np.zeros(4), k)[0]
    assert np.isfinite(found).tolist() == [True, True, False, False]
    assert found[:2].max() < math.sqrt(1 / 0.9)


def test_meter_uses_time_before_speed():
    mean = jit.Float([1e4, 10.0, 0.01])
    shutter, iso = metered(mean, aperture=2.8, longest=0.01, shortest=1e-5, iso=(100.0, 1600.0), compensation=0.0)
    assert numbers(iso)[0] == pytest.approx(100)
    assert numbers(shutter)[1:] == pytest.approx(0.01)
    assert numbers(iso)[2] == 1600
    full = numbers(saturation_luminance(2.8, shutter, iso))
    assert numbers(mean)[:2] / full[:2] == pytest.approx([0.18, 0.18], rel=1e-5)


def test_curve_is_srgb():
    """IEC 61966-2-1: 0.18 -> 0.4614, 0.001 -> 0.01292, 1 -> 1."""
    x = jit.Float64([0.001, 0.18, 1.0])
    assert numbers(encode_srgb(x)) == pytest.approx([0.01292, 0.46135, 1.0], abs=2e-5)
    assert numbers(shoulder(jit.Float64([0.5, 0.7, 2.0]), 1.0)) == pytest.approx([0.5, 0.7, 1.0])
    soft = numbers(shoulder(jit.Float64([0.5, 0.7, 0.7001, 50.0]), 0.7))
    assert soft[:2] == pytest.approx([0.5, 0.7])
    assert soft[2] == pytest.approx(0.7001, abs=1e-6)  # slope 1 at the knee
    assert 0.99 < soft[3] <= 1

"""Limits of blur, pixel by pixel, of two pictures whose cameras turn and go elsewhere, against NumPy."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
from scipy.ndimage import convolve
from scipy.spatial.transform import Rotation

from pelagos import jit
from pelagos.sensors.camera.picture import pixel_blur
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.pixel_order import Tiling, image_rows, pixels
from pelagos.sensors.sensor import Kinematics

WIDTH, HEIGHT = 92, 70
TILING = Tiling(WIDTH, HEIGHT)
WHERE = pixels(TILING, 2)
HULLS = Rotation.from_euler("ZYX", [[30.0, -15.0, 8.0], [-120.0, 20.0, 50.0]], degrees=True)
SPEED, SPIN = np.array([[1.2, -0.4, 0.3], [-0.5, 0.9, 0.2]]), np.array([[0.1, -0.3, 0.5], [0.4, 0.2, -0.6]])
RNG = np.random.default_rng(21)
LANES = len(np.array(WHERE.ray))
IMAGE, ACTIVE = np.array(WHERE.image), np.array(WHERE.active)
AWAY = RNG.normal(size=(LANES, 3))
AWAY /= np.linalg.norm(AWAY, axis=1, keepdims=True)
FAR = RNG.uniform(1.0, 9.0, LANES)
VALID = RNG.uniform(size=LANES) > 0.2
SHARE = np.array(WHERE.column) // 30 + 3 * (np.array(WHERE.row) // 40)
MOVES = VALID & (SHARE == 1)
VELOCITY = np.where(MOVES[:, None], RNG.normal(0, 1, (LANES, 3)), 0.0)
INSTANCE = 7 + SHARE + 4096 * (SHARE == 5)


def vectors(values: Any) -> Any:
    return jit.Array3f(np.ascontiguousarray(values.T, dtype=np.float32))


def hits() -> Any:
    return SimpleNamespace(
        valid=jit.Bool(VALID), t=jit.Float(np.where(VALID, FAR, np.inf)), velocity=vectors(VELOCITY),
        instance=jit.UInt32(INSTANCE.astype(np.uint32)),
    )  # fmt: skip


def frame(**keys: Any) -> Any:
    x, y, z, w = HULLS.as_quat().T
    zero, u = dr.zeros(jit.Float64, 2), dr.zeros(jit.UInt32, 2)
    motion = Kinematics(
        jit.Array3f64(zero, zero, zero), jit.Array4f64(*(jit.Float64(v) for v in (w, x, y, z))),
        jit.Array3f64(np.ascontiguousarray(SPEED.T)), jit.Array3f64(np.ascontiguousarray(SPIN.T)),
        jit.Array3f64(zero, zero, zero), jit.Array3f64(zero, zero, zero), jit.UInt64(u), u + 0, u + 0, u + 0,
    )  # fmt: skip
    config = CameraConfig(
        width_px=WIDTH, height_px=HEIGHT, samples=8, position_m=(0.4, -0.7, 0.2), orientation_deg=(10.0, -20.0, 35.0),
        **keys,
    )  # fmt: skip
    return SimpleNamespace(config=config, motion=motion, tiling=TILING, images=2)


def rays() -> Any:
    return SimpleNamespace(direction=vectors(AWAY))


def tiles(values: Any) -> Any:
    """Means over the active pixels of each tile, `(2, 5, 6)`, twice under a tent."""
    sums = np.where(ACTIVE, values, 0.0).reshape(2, 5, 6, 256).sum(axis=-1)
    means = sums / ACTIVE.reshape(2, 5, 6, 256).sum(axis=-1)
    tent = np.outer([1, 2, 1], [1, 2, 1]) / 16
    for _ in range(2):
        means = np.array([convolve(m, tent, mode="nearest") for m in means])
    return np.repeat(means.reshape(-1), 256)


def drift(values: Any, moves: Any) -> Any:
    weight = tiles(moves * 1.0)
    return np.stack([tiles(np.where(moves, v, 0.0)) / np.maximum(weight, 1e-9) for v in values.T], axis=-1)


def in_picture(values: Any) -> Any:
    return np.array(image_rows(jit.Float(values), TILING, WHERE, 2))


def speeds() -> Any:
    """Angle a second of each pixel's content across its ray, times the focal length."""
    config = frame().config
    velocity = HULLS.apply(SPEED + np.cross(SPIN, config.position_m))[IMAGE]
    spin = HULLS.apply(SPIN)[IMAGE]
    apparent = np.where(VALID[:, None], (VELOCITY - velocity) / FAR[:, None], 0.0) - np.cross(spin, AWAY)
    across = apparent - AWAY * (apparent * AWAY).sum(axis=1, keepdims=True)
    return np.linalg.norm(across, axis=1) * 0.5 * WIDTH / math.tan(math.radians(35))


def test_streaks_are_cut_where_they_are_longest() -> None:
    """As long as the faster of the pixel's own content and the bodies around makes them in the time that the shutter
    is open, `motion_blur` of it; no more than 3 % of the width."""
    exposure = np.array([0.04, 0.11])
    made = frame(motion_blur=0.6, motion_blur_max=0.03)
    found = pixel_blur.pixel_blur(hits(), rays(), WHERE, made, jit.Float(exposure))
    np.testing.assert_allclose(
        in_picture(np.array(found.drift.x)), in_picture(drift(VELOCITY, MOVES)[:, 0]), rtol=0, atol=1e-4
    )
    np.testing.assert_allclose(
        in_picture(np.array(found.drift.z)), in_picture(drift(VELOCITY, MOVES)[:, 2]), rtol=0, atol=1e-4
    )
    passing = drift(speeds()[:, None], MOVES)[:, 0]
    streak = np.maximum(speeds(), passing) * exposure[IMAGE] * 0.6
    expected = np.minimum(0.03 * WIDTH / streak, 1.0)
    np.testing.assert_allclose(in_picture(np.array(found.share)), in_picture(expected), rtol=2e-3)
    assert 0.02 < (expected[ACTIVE] < 1).mean() < 0.98
    assert not np.array(found.haze).any()
    whole = pixel_blur.pixel_blur(hits(), rays(), WHERE, frame(), jit.Float(exposure))
    assert np.array(whole.share).tolist() == [1.0] * LANES


def test_only_large_bodies_move_the_light_around() -> None:
    """Radius of the disc of as many moving pixels as show the same one in the same picture, over the width."""
    for limit, kept in ((0.0, True), (0.15, True), (0.25, False)):
        count = (MOVES & ACTIVE & (IMAGE == 0)).sum()
        assert (math.sqrt(count / math.pi) / WIDTH >= limit) == kept
        made = frame(motion_blur_min_object=limit)
        found = np.array(pixel_blur.pixel_blur(hits(), rays(), WHERE, made, jit.Float([0.1, 0.1])).drift)
        np.testing.assert_allclose(found.T, drift(VELOCITY, MOVES) if kept else 0 * VELOCITY, rtol=0, atol=1e-4)


def test_haze_grows_with_the_distance() -> None:
    """6 px of 1920, as a square of the disc's variance; half of that 3 m off, all where nothing is seen."""
    made = frame(depth_blur_px=6.0, depth_blur_distance_m=3.0, max_range_m=5000.0)
    found = np.array(pixel_blur.pixel_blur(hits(), rays(), WHERE, made, jit.Float([0.1, 0.1])).haze)
    far = np.where(VALID, 1 - 0.5 ** (FAR / 3.0), 1.0)
    np.testing.assert_allclose(found, far * 6.0 * WIDTH / 1920 * math.sqrt(3) / 2, rtol=1e-4)

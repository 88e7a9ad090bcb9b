"""Pictures of any size: the glow is sized by angle, white balance follows the sensor, lanes share the waves' maps."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import drjit as dr
import numpy as np
import pytest
from test_camera_picture import context, looking_down

from pelagos import jit
from pelagos.errors import ValidityWarning
from pelagos.optics.caustics import focusing, ripple, waves_at
from pelagos.sensors.camera.camera import Camera
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.glow import FAR_RAD, NEAR_RAD, glow, spread
from pelagos.sensors.camera.picture.pixel_order import Tiling, image_rows, pixels
from pelagos.sensors.camera.picture.surroundings import Surroundings


@pytest.mark.parametrize("width", [1.7, 2.5, 9.0, 20.0])
def test_a_point_is_spread_by_the_width_asked_for(width):
    """Mean over points at every place of a block: the kernel ends at three deviations, which takes 2.7 % of its
    variance."""
    size, images = (170, 150), 16
    tiling = Tiling(*size)
    where = pixels(tiling, images)
    u, v = 80 + where.image, 64 + (5 * where.image + 3) % 16
    lit = dr.select((where.column == u) & (where.row == v), 1.0, 0.0)
    light = jit.Array3f(lit, 2 * lit, 0)
    dr.eval(light)
    rows = np.array(image_rows(spread(light, width, where, tiling)[1], tiling, where, images)).reshape(16, 150, 170)
    assert rows.sum(axis=(1, 2)) == pytest.approx(np.full(16, 2.0), rel=0.01)
    k = np.arange(16)
    across = np.square(np.arange(170)[None] - (80 + k)[:, None]) * rows.sum(axis=1)
    down = np.square(np.arange(150)[None] - (64 + (5 * k + 3) % 16)[:, None]) * rows.sum(axis=2)
    for found in (across, down):
        assert found.sum(axis=1).mean() / 2.0 == pytest.approx(width**2, rel=0.04)


@pytest.mark.parametrize("pixels_wide", [48, 84, 240, 960])
def test_stripes_of_light_keep_their_contrast_at_any_number_of_pixels(pixels_wide):
    """A bell of deviation s leaves exp(-(2 pi f s)^2 / 2) of stripes of frequency f; a pixel itself, a little less."""
    tiling, wide = Tiling(pixels_wide, 32), 1.0  # [rad]
    where = pixels(tiling, 1)
    for stripes, deviation, near in ((4, NEAR_RAD, True), (2, FAR_RAD, False)):
        angle = (jit.Float(where.column) + 0.5) * (2 * math.pi * stripes / pixels_wide)
        light, dark = jit.Array3f(1 + dr.cos(angle)), dr.zeros(jit.Array3f, dr.width(where.ray))
        dr.eval(light, dark)
        seen = glow(*((light, dark) if near else (dark, light)), where, tiling, wide / pixels_wide)
        row = np.array(image_rows(seen[0], tiling, where, 1)).reshape(32, -1)[16]
        middle = row[pixels_wide // 4 : 3 * pixels_wide // 4]
        left = math.exp(-0.5 * (2 * math.pi * stripes * deviation / wide) ** 2)
        assert (middle.max() - middle.min()) / 2 == pytest.approx(left, rel=0.05)


def picture(**keys):
    config = CameraConfig(
        width_px=48, height_px=48, tone="linear", bits=16, exposure="manual", shutter_s=0.0005, iso=100, **keys
    )
    return Camera(config, context(water="1C", z=-9.0)).sense(looking_down(height=-5.0))


def test_white_balance_multiplies_the_noise_of_the_sensor_as_it_does_its_signal():
    plain, made = picture(), picture(white_balance="grey_world")
    truth = [m.truth[0].astype(float) for m in (plain, made)]
    noise = [(m.data[0].astype(float) - t) for m, t in zip((plain, made), truth, strict=True)]
    for channel in (0, 2):
        data = [m.data[0, ..., channel] for m in (plain, made)]
        whole = np.all([(d > 0) & (d < 65535) for d in data], axis=0)  # not cut off at black or white
        assert whole.mean() > 0.9
        gain = truth[1][..., channel].mean() / truth[0][..., channel].mean()
        assert abs(gain - 1) > 0.05
        # the same random numbers: only the rounding of 16 bits differs
        assert noise[1][whole, channel].std() / noise[0][whole, channel].std() == pytest.approx(gain, rel=0.02)


def test_raw_pictures_know_no_white_balance():
    raw = picture(mosaic="rggb")
    with pytest.warns(ValidityWarning, match="'white_tint' changes nothing without 'mosaic: none'"):
        made = picture(mosaic="rggb", white_balance="grey_world", white_temperature_k=4000.0, white_tint=0.3)
    assert np.array_equal(raw.data, made.data)
    assert np.array_equal(raw.truth, made.truth)
    assert raw.data.std() > 0


def test_copies_at_one_moment_share_the_maps_of_the_waves():
    surroundings = Surroundings(context(copies=5))
    times, moment = surroundings.arguments(looking_down(copies=5, tick=40), CameraConfig())[-1]
    assert np.array(times).tolist() == [40 * 5_000_000]
    assert np.array(moment).tolist() == [0] * 5
    two = replace(looking_down(copies=4), t_ns=jit.UInt64([300, 100, 300, 100]))
    times, moment = surroundings.arguments(two, CameraConfig())[-1]
    assert np.array(times).tolist() == [100, 300]
    assert np.array(moment).tolist() == [1, 0, 1, 0]


def test_times_of_a_picture_lie_in_memory_of_the_device():
    """NumPy's may lie anywhere, and a kernel that was compiled for the one is compiled anew for the other: seconds."""
    surroundings = Surroundings(context(copies=5))
    several = replace(looking_down(copies=4), t_ns=jit.UInt64([300, 100, 300, 100]))
    for motion in (*(looking_down(copies=5, tick=k) for k in range(12)), several):
        for values in surroundings.arguments(motion, CameraConfig())[-2:]:
            assert all(
                np.from_dlpack(v).ctypes.data % 32 == 0 for v in (values if isinstance(values, tuple) else [values])
            )


def test_another_sea_is_another_argument_of_the_same_kernel():
    """Heights and slopes of the ripples are no part of it; what comes out is what they give as numbers."""
    sun, t = jit.Array3f(0.3, 0.4, 0.866), jit.Float64([0.75])

    def recorded(measures: Any) -> tuple[Any, ...]:
        waves = waves_at(ripple(0.001), t_of(measures), jit.Array3f(0.3, 0.4, 0.866), 1, measures=measures)
        return waves.slope_x, waves.slope_y, waves.focus, waves.finer, waves.short, waves.long

    def t_of(measures: Any) -> Any:
        return 0.75 + 0 * jit.Float64(dr.gather(jit.Float, measures, 0))

    kernel = jit.freeze(recorded)
    for slope, finer, longer in ((0.003, 0.02, 0.004), (0.006, 0.03, 0.011)):
        sea = ripple(slope, finer=finer, longer=longer)
        found, plain = kernel(sea.measures()), waves_at(sea, t, sun, 1)
        expected = plain.slope_x, plain.slope_y, plain.focus, plain.finer, plain.short, plain.long
        for one, other in zip(found, expected, strict=True):
            assert np.array_equal(np.array(one), np.array(other))
        assert np.array(found[0]).std() == pytest.approx(np.sqrt(slope / 2), rel=0.5)
        assert np.array(found[4])[0] == pytest.approx(slope, rel=1e-5)


def test_light_under_shared_maps_is_that_under_maps_of_their_own():
    sun, sea, lane = jit.Array3f(0.3, 0.4, 0.866), ripple(0.004), dr.arange(jit.UInt32, 3)
    x, y, depth = jit.Float([0.7, -1.9, 3.3]), jit.Float([-0.4, 2.2, 1.1]), jit.Float([1.0, 2.5, 4.0])
    own = waves_at(sea, jit.Float64([2.0, 0.5, 2.0]), sun, 3)
    shared = waves_at(sea, jit.Float64([0.5, 2.0]), sun, 2, None, jit.UInt32([1, 0, 1]))
    found = [np.array(focusing(w, x, y, depth, sun, lane)) for w in (own, shared)]
    assert np.array_equal(*found)
    assert found[0].std() > 0.01


@pytest.mark.slow
def test_a_small_picture_is_a_large_one_seen_from_afar():
    """84 px against 672 px, binned eight by eight: within 3 % in the mean of each channel."""
    found = []
    for wide in (84, 672):
        config = CameraConfig(
            width_px=wide, height_px=wide, tone="linear", bits=16, exposure="manual", shutter_s=0.003, iso=100
        )
        truth = Camera(config, context(water="3C", z=-8.0)).sense(looking_down(height=-3.0)).truth[0]
        assert truth.max() < 65535
        found.append(truth.astype(float).mean(axis=(0, 1)))
    assert found[0] == pytest.approx(found[1], rel=0.03)

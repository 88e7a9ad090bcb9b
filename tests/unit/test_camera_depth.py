"""Noise of a depth camera and its failures, and depth behind a port."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from test_camera_geometry import SIZE, ahead, context, wall

from pelagos.sensors.camera.depth_camera import DepthCamera, DepthCameraConfig


def test_range_noise_grows_with_depth_and_each_pixel_has_its_own() -> None:
    """sqrt(0.02^2 + (0.01 z)^2); those that stay after a failure of every third are as many above as below."""
    for far in (1.5, 6.0):
        config = DepthCameraConfig(noise_m=0.02, noise_share=0.01, dropout=0.35, width_px=160, height_px=96)
        got = DepthCamera(config, context([wall(far, 60.0, 1, 1)])).sense(ahead())
        kept = np.isfinite(got.data[0])
        error = (got.data - got.truth)[0][kept]
        sigma = math.hypot(0.02, 0.01 * far)
        assert error.std() == pytest.approx(sigma, rel=4 / math.sqrt(2 * error.size))
        assert abs(error.mean()) < 4 * sigma / math.sqrt(error.size)
        assert len(np.unique(error)) > 0.9 * error.size  # single precision has not that many values of its own
        grid = np.where(kept, got.data - got.truth, 0.0)[0]
        along = [np.corrcoef(grid[: 96 - k].ravel(), grid[k:].ravel())[0, 1] for k in (1, 2)]
        assert np.abs(along).max() < 5 / math.sqrt(grid.size)


def test_what_is_nearer_than_its_noise_is_not_behind_the_camera() -> None:
    """Range noise of 1 m before a wall at 0.5 m: a third would be below 0, which is where measurements end."""
    got = DepthCamera(DepthCameraConfig(noise_m=1.0, **SIZE), context([wall(0.5, 30.0, 1, 1)])).sense(ahead())
    assert (got.data == 0).mean() == pytest.approx(0.3085, abs=0.04)
    assert got.data.min() == 0.0


@pytest.mark.parametrize("port", [
    {"type": "flat", "distance_m": 0.11, "thickness_m": 0.05},
    {"type": "dome", "radius_m": 0.4, "thickness_m": 0.03, "offset_m": (0.1, -0.05, 0.08)},
], ids=["flat", "dome"])  # fmt: skip
def test_depth_behind_a_port_counts_from_the_pupil(port: dict[str, Any]) -> None:
    """Of a wall square to the axis it is that of the wall, through whatever part of the window it is seen."""
    got = DepthCamera(DepthCameraConfig(port=port, **SIZE), context([wall(2.0, 60.0, 1, 1)])).sense(ahead())
    assert got.truth == pytest.approx(2.0, rel=1e-5)


def test_a_picture_comes_along_on_request() -> None:
    made = context([wall(2.0, 30.0, 1, 1)])
    assert DepthCamera(DepthCameraConfig(**SIZE), replace(made)).sense(ahead()).extras == {}

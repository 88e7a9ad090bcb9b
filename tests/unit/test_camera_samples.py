"""Samples of a pixel: steps of their sequence, and where they go through the lens."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import drjit as dr
import numpy as np
import pytest

from pelagos import jit
from pelagos.sensors.camera.picture import pixel_samples
from pelagos.sensors.camera.picture.camera_config import CameraConfig
from pelagos.sensors.camera.picture.pixel_samples import Sample, samples

PIXELS = 60


def drawn(count: int, environment: int = 3, tick: int = 11) -> list[dict[str, Any]]:
    """All samples of some pixels."""
    pixel, none = dr.arange(jit.UInt32, PIXELS), dr.zeros(jit.UInt32, PIXELS)
    config = CameraConfig(samples=count)
    frame: Any = SimpleNamespace(config=config, counter=lambda _: (pixel, none + environment, none + tick))
    where: Any = SimpleNamespace(row=pixel)
    return [
        {name: np.array(v) for name, v in vars(samples(dr.opaque(jit.UInt32, k), where, frame, (12, 34))).items()}
        for k in range(count)
    ]


def test_samples_step_on_by_powers_of_one_number_from_a_place_of_each_pixels_own() -> None:
    """In pixel, aperture (angle, square of radius) and each its own part of the exposure."""
    found = drawn(8)
    right, down = (np.array([s[k] for s in found]) + 0.5 for k in ("right", "down"))
    y, z = (np.array([s[k] for s in found]) for k in ("disc_y", "disc_z"))
    places = (right, down, np.arctan2(z, y) / (2 * math.pi), y**2 + z**2)
    root = max(np.roots([1, 0, 0, 0, 0, -1, -1]).real)  # of x^6 = x + 1, for five dimensions (Roberts 2018)
    for d, u in enumerate(places):
        step = root ** -(d + 1)
        off = (np.diff(u, axis=0) - step + 0.5) % 1.0 - 0.5
        assert np.abs(off).max() < 2e-4, d
        assert len({round(float(v), 4) for v in u[0] % 1.0}) > 0.95 * PIXELS  # each pixel begins elsewhere
    part = np.floor((np.array([s["moment"] for s in found]) + 0.5) * 8)
    assert np.array_equal(part, np.repeat(np.arange(8.0), PIXELS).reshape(8, PIXELS))
    begin = [v[0] for v in places] + [(found[0]["moment"] + 0.5) * 8]
    apart = np.corrcoef(begin) - np.eye(5)
    assert np.abs(apart).max() < 0.45  # no two places are the same
    for other in (drawn(8, environment=4), drawn(8, tick=12)):
        assert np.abs(other[0]["right"] - found[0]["right"]).min() > 0


def test_rays_from_all_over_the_aperture_meet_at_the_focal_distance() -> None:
    """From f / 2N aside, at x = 2.5 m, where the ray through the middle is."""
    config = CameraConfig(samples=4, aperture=1.4, focus_distance_m=2.5, sensor_width_mm=30.0)
    local = np.array([[0.8, 0.36, -0.48], [1.0, 0.0, 0.0], [0.6, -0.64, 0.48]]).T
    disc = np.array([[0.5, -0.9, 0.1], [-0.2, 0.3, 0.95]])
    sample: Any = Sample(jit.Float(0), jit.Float(0), jit.Float(disc[0]), jit.Float(disc[1]), jit.Float(0))
    start, out = (np.array(v) for v in pixel_samples._through_aperture(jit.Array3f(local), sample, config))
    start = np.broadcast_to(start, (3, 3))
    radius = 0.015 / math.tan(math.radians(35)) / 2.8
    assert start == pytest.approx(np.stack([[0, 0, 0], *(radius * disc)]), abs=1e-7)
    assert np.linalg.norm(out, axis=0) == pytest.approx(1)
    assert start + out * (2.5 / out[0]) == pytest.approx(local * (2.5 / local[0]), abs=1e-5)

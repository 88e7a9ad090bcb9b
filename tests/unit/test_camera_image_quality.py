"""PSNR, SSIM and colour bias on pictures whose answers are known."""

from __future__ import annotations

import numpy as np
import pytest

from pelagos.optics.image_quality import colour_ratio, psnr, ssim

PICTURE = np.random.default_rng(1).uniform(0, 255, (40, 50, 3))


def test_equal_pictures():
    assert psnr(PICTURE, PICTURE) == float("inf")
    assert ssim(PICTURE, PICTURE) == pytest.approx(1)


def test_constant_difference():
    """A shift of 5: 20 log10(255 / 5) dB; flat pictures differ in the luminance term alone."""
    assert psnr(PICTURE, PICTURE + 5) == pytest.approx(20 * np.log10(51))
    a, b = np.full((20, 20, 3), 100.0), np.full((20, 20, 3), 120.0)
    c1 = (0.01 * 255) ** 2
    assert ssim(a, b) == pytest.approx((2 * 100 * 120 + c1) / (100**2 + 120**2 + c1))


def test_inverted_structure_is_negative():
    assert ssim(PICTURE, 255 - PICTURE) < -0.5


def test_ratio_by_channel():
    assert colour_ratio(PICTURE * [1.0, 2.0, 0.5], PICTURE) == pytest.approx([1.0, 2.0, 0.5])

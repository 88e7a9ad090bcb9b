"""Measures of the difference of two pictures: PSNR, SSIM, bias of the mean colour. NumPy, `(height, width, 3)`.

SSIM: Z. Wang, A. C. Bovik, H. R. Sheikh and E. P. Simoncelli, IEEE Trans. Image Process. 13:600 (2004), doi
10.1109/TIP.2003.819861, with the constants of its Section III: a Gaussian window of 1.5 px, K1 = 0.01, K2 = 0.03.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import NDArray

_SIGMA: Final = 1.5  # [px]
_RADIUS: Final = 5  # [px]
_K1: Final = 0.01
_K2: Final = 0.03

Picture = NDArray[np.float64]


def psnr(a: Picture, b: Picture, *, peak: float = 255.0) -> float:
    """Peak over root mean square difference [dB]; infinite for equal pictures."""
    mean_square = float(np.mean(np.square(a - b)))
    return float("inf") if mean_square == 0 else float(10 * np.log10(peak**2 / mean_square))


def ssim(a: Picture, b: Picture, *, peak: float = 255.0) -> float:
    """Structural similarity, -1 .. 1, mean over the channels and over the places where the window fits."""
    c1, c2 = (_K1 * peak) ** 2, (_K2 * peak) ** 2
    mean_a, mean_b = _blurred(a), _blurred(b)
    var_a, var_b = _blurred(a * a) - mean_a**2, _blurred(b * b) - mean_b**2
    covariance = _blurred(a * b) - mean_a * mean_b
    same = (2 * mean_a * mean_b + c1) * (2 * covariance + c2)
    return float(np.mean(same / ((mean_a**2 + mean_b**2 + c1) * (var_a + var_b + c2))))


def colour_ratio(a: Picture, b: Picture) -> Picture:
    """Mean of `a` over that of `b`, by channel `(3,)`; of linear light, or it says little."""
    return np.asarray(a.mean(axis=(0, 1)) / b.mean(axis=(0, 1)))


def _blurred(picture: Picture) -> Picture:
    """Under the Gaussian window, without the border that it does not fit."""
    offset = np.arange(-_RADIUS, _RADIUS + 1)
    weight = np.exp(-0.5 * (offset / _SIGMA) ** 2)
    weight /= weight.sum()
    rows, columns = len(picture) - 2 * _RADIUS, picture.shape[1] - 2 * _RADIUS
    down = sum(w * picture[k : k + rows] for k, w in enumerate(weight))
    across = sum(w * np.asarray(down)[:, k : k + columns] for k, w in enumerate(weight))
    return np.asarray(across, dtype=np.float64)

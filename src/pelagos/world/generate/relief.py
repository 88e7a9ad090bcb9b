"""Ingredients of ground: random relief with a spectrum, ripples, dents and smooth steps, all on regular grids."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray


def fractal(
    shape: tuple[int, int], spacing: float, rng: np.random.Generator, *, slope: float, longest: float, shortest: float
) -> NDArray[np.float64]:
    """Gaussian relief `shape` with zero mean and unit root mean square, and a power-law spectrum.

    Args:
        shape: nodes.
        spacing: between nodes [m].
        rng: random numbers.
        slope: of the two-dimensional power spectrum, S(k) ~ k^-slope; 2 (rough) to 4 (smooth) are natural.
        longest, shortest: wavelengths between which there is power [m].
    """
    from scipy import fft

    # a patch larger than asked, cut out of the middle: the Fourier series would else repeat from edge to edge
    padded = tuple(_good_size(n + n // 4) for n in shape)
    kx = np.fft.fftfreq(padded[0], spacing).astype(np.float32)[:, None]
    ky = np.fft.rfftfreq(padded[1], spacing).astype(np.float32)[None, :]
    k2 = kx * kx + ky * ky
    band = (k2 >= longest**-2.0) & (k2 <= shortest**-2.0)
    waves = np.zeros(k2.shape, dtype=np.complex64)  # single precision: the relief is good to a millionth of itself
    noise = rng.standard_normal((int(band.sum()), 2), dtype=np.float32)
    noise *= (k2[band] ** np.float32(-slope / 4))[:, None]
    waves[band] = noise.view(np.complex64)[:, 0]
    field = fft.irfft2(waves, s=padded, overwrite_x=True, workers=2)[: shape[0], : shape[1]]
    field = field - field.mean(dtype=np.float64).astype(np.float32)
    field /= np.float32(max(float(np.sqrt((field**2).mean(dtype=np.float64))), 1e-30))
    return np.asarray(field, dtype=np.float64)


def _good_size(n: int) -> int:
    from scipy.fft import next_fast_len

    return int(next_fast_len(n, real=True))


def smoothstep(value: ArrayLike, low: float, high: float) -> NDArray[np.float64]:
    """0 below `low`, 1 above `high`, with level ends between."""
    t = np.clip((np.asarray(value, dtype=np.float64) - low) / (high - low), 0, 1)
    return t * t * (3 - 2 * t)


def dent(
    x: NDArray[np.float64], y: NDArray[np.float64], z: NDArray[np.float64], at: ArrayLike, radius: float, depth: float
) -> None:
    """Press a round hollow (or with negative `depth` a mound) of Gaussian shape into heights `z (nx, ny)`, in place.

    Args:
        x, y: node coordinates `(nx,)`, `(ny,)` [m].
        z: heights [m].
        at: middle (x, y) [m].
        radius: one standard deviation [m].
        depth: at the middle [m].
    """
    cx, cy = np.asarray(at, dtype=np.float64)
    i0, i1 = np.searchsorted(x, [cx - 3 * radius, cx + 3 * radius])
    j0, j1 = np.searchsorted(y, [cy - 3 * radius, cy + 3 * radius])
    r2 = (x[i0:i1, None] - cx) ** 2 + (y[None, j0:j1] - cy) ** 2
    z[i0:i1, j0:j1] -= depth * np.exp(-r2 / (2 * radius**2))


def ripples(
    x: NDArray[np.float64], y: NDArray[np.float64], *, wavelength: float, heading: float, wander: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Ripples `(nx, ny)` between -1 and 1 with sharp crests and broad troughs.

    Args:
        x, y: node coordinates [m].
        wavelength: crest to crest [m].
        heading: direction across the crests, from x towards y [rad].
        wander: phase that bends the crests `(nx, ny)` [rad].
    """
    along = x[:, None] * np.cos(heading) + y[None, :] * np.sin(heading)
    phase = 2 * np.pi * along / wavelength + wander
    shape: NDArray[np.float64] = (np.sin(phase) + 0.25 * np.sin(2 * phase + np.pi / 2)) / 1.25
    return shape

"""Waves in a flume: those that come and those that come back, told apart by gauges, and made again as components."""

from __future__ import annotations

from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.math.dispersion import wavenumber

Array = NDArray[np.float64]

DEPTH_M: Final = 1.0
SAMPLE_S: Final = 0.025
MODEL_M: Final = 7.0  # from the wave maker
GAUGES_M: Final = np.array([2.97, 4.915, 5.16, 5.455])  # found from the phases of five wave records, within 1 cm
_BAND: Final = (0.55, 1.8)  # of the wave's frequency
_WEAKEST: Final = 0.15  # singular values: gauges half a wave apart tell nothing of the sum


def wavenumbers(omega: Array) -> Array:
    """[1/m] in the flume."""
    return np.asarray(wavenumber(omega, DEPTH_M))


def about(t: Array, x: Array, omega: float) -> Array:
    """The part of x, sampled at even times t [s] from rest, that lies in the band about a frequency."""
    count = 2 * len(x)
    at = 2 * np.pi * np.fft.rfftfreq(count, float(t[1] - t[0]))
    return series(np.where(_in_band(at, omega), spectrum(x, count), 0), count)[: len(x)]


def spectrum(x: Array, count: int) -> NDArray[np.complex128]:
    """Amplitudes of exp(-i omega t) at the frequencies of `count` samples."""
    return np.conj(np.fft.rfft(np.concatenate([x - x[:40].mean(), np.zeros(count - len(x))]))) * 2 / count


def series(amplitudes: NDArray[np.complex128], count: int) -> Array:
    """The samples of amplitudes, the other way round."""
    return np.fft.irfft(np.conj(amplitudes) / 2 * count, count)


def separated(gauges: Array, omega: float) -> tuple[Array, Array]:
    """Samples at the model of the wave that comes and of that which goes back.

    Args:
        gauges: `(4, n)` elevations [m].
        omega: of the wave maker [rad/s].
    """
    count = 2 * gauges.shape[1]
    at = 2 * np.pi * np.fft.rfftfreq(count, SAMPLE_S)
    band = _in_band(at, omega)
    seen = np.stack([spectrum(g, count) for g in gauges])
    parts = np.zeros((2, len(at)), complex)
    k = wavenumbers(at[band])
    for i, number in zip(np.flatnonzero(band), k, strict=True):
        phase = 1j * number * (GAUGES_M - MODEL_M)
        parts[:, i] = np.linalg.lstsq(np.exp(np.stack([phase, -phase], axis=1)), seen[:, i], rcond=_WEAKEST)[0]
    n = gauges.shape[1]
    return series(parts[0], count)[:n], series(parts[1], count)[:n]


def synthesis(t: Array, elevation: Array, omega: float) -> list[dict[str, Any]]:
    """Components of a scenario's `waves`, towards north, whose sum at the origin is an elevation [m] at even times."""
    count = 2 * len(t)
    at = 2 * np.pi * np.fft.rfftfreq(count, float(t[1] - t[0]))
    found = np.conj(np.fft.rfft(np.concatenate([elevation, np.zeros(len(t))]))) * 2 / count
    chosen = _in_band(at, omega) & (np.abs(found) > 1e-7)
    return [
        {
            "type": "regular", "height_m": 2 * abs(a), "period_s": 2 * np.pi / w,
            "phase_deg": float(np.degrees(np.angle(a))), "towards_deg": 0.0,
        }
        for w, a in zip(at[chosen].tolist(), found[chosen].tolist(), strict=True)
    ]  # fmt: skip


def _in_band(at: Array, omega: float) -> NDArray[np.bool_]:
    return (at > _BAND[0] * omega) & (at < _BAND[1] * omega)

"""Speeds from pairs of pulses: the phase between two echoes of the same scatterers, and how far it can be trusted.

Two echoes of one place, a time T apart, are complex Gaussian with the coherence rho; their phase grows by 4 pi f v T/c.
The estimate is the phase of the sum of z1* z2 over the samples of the echo.
Sources: D. S. Zrnic, IEEE Trans. Aerosp. Electron. Syst. 13, 344 (1977), doi 10.1109/TAES.1977.308467 (its variance);
R. Lhermitte and R. Serafin, J. Atmos. Ocean. Technol. 1, 293 (1984) (pulse-to-pulse coherent sonar); B. H. Brumley,
R. G. Cabrera, K. L. Deines, E. A. Terray, IEEE J. Ocean. Eng. 16, 402 (1991), doi 10.1109/48.90905 (what takes
coherence from broadband pairs).
"""

from __future__ import annotations

import math
from typing import Any, Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

BEAM_SPREAD: Final = 0.25 / math.sqrt(math.log(2.0))
"""Rms angle of a two-way Gaussian beam about its axis, in one plane, over its one-way half-power width."""


def speed_per_radian(*, frequency_hz: float, sound_speed: Any, lag_s: float) -> Any:
    """Speed [m/s] that turns the phase by one radian, c/(4 pi f T); pi times as much is ambiguous."""
    return sound_speed / (4.0 * math.pi * frequency_hz * lag_s)


def speed_of_pair(iq: NDArray[np.complex64], *, frequency_hz: float, sound_speed: float, lag_s: float) -> Any:
    """Closing speed `(...,)` [m/s] of the echoes of pairs of pulses `(..., 2, bins)`, of all bins together.

    Speeds above c/(4 f T) are ambiguous.
    """
    product = (np.conj(iq[..., 0, :]) * iq[..., 1, :]).astype(np.complex128).sum(axis=-1)
    return np.angle(product) * speed_per_radian(frequency_hz=frequency_hz, sound_speed=sound_speed, lag_s=lag_s)


def pair_deviation(
    power: NDArray[np.float64], *, noise: float, coherence: ArrayLike, pulse: NDArray[np.floating], per_radian: float
) -> float:
    """Standard deviation [m/s] of `speed_of_pair`, where it is small against `per_radian`.

    Zrnic's (1977) variance of the phase for independent pairs of samples that are correlated with their neighbours:
    the sum over j, k of C11(j,k)^2 - C12(j,k)^2, over twice the square of the sum of C12(k,k), with C11 the covariance
    of one echo with noise, C12 that of both.

    Args:
        power: of the echo by range bin `(bins,)`.
        noise: power of the noise in each bin, in the same unit.
        coherence: rho of the echoes, of all bins or `(bins,)`.
        pulse: its amplitude by bin, of unit energy (see `point_spread`): neighbours hear the same scatterers.
        per_radian: see `speed_per_radian` [m/s].
    """
    rho = np.broadcast_to(np.asarray(coherence, dtype=np.float64), power.shape)
    kernel = pulse_correlation(pulse) ** 2
    both = (power * np.convolve(power, kernel, mode="same")).sum()
    coherent = (power * rho * np.convolve(power * rho, kernel, mode="same")).sum()
    spread = both - coherent + (2.0 * power * noise + noise**2).sum()
    return float(per_radian * math.sqrt(spread / 2.0) / (power * rho).sum())


def pulse_correlation(pulse: NDArray[np.floating]) -> NDArray[np.float64]:
    """Correlation of samples of the echo with their neighbours `(2 n - 1,)`, for a pulse of unit energy `(n,)`."""
    shape = np.asarray(pulse, dtype=np.float64)
    return np.convolve(shape, shape[::-1])

"""Effect of a multipath channel on a waveform, and the noise that comes with it. NumPy; times in double.

A path of delay tau whose length changes brings x(D t - tau), D the ratio of received to sent frequency: a waveform is
resampled, not just shifted. At complex baseband about a carrier f the same path turns by
exp(2 pi i f ((D - 1) t - tau)).

Sources: J. G. Proakis and M. Salehi, Digital Communications (5th ed., 2008), Sections 2.1 (baseband) and 13.1 (paths);
M. Stojanovic and J. Preisig, IEEE Commun. Mag. 47(1), 84 (2009), doi 10.1109/MCOM.2009.4752682.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.acoustics.noise import ambient_level

_TAPS: Final = 32  # of the interpolating filter
_BETA: Final = 9.0  # of its Kaiser window: 90 dB
_LOWEST_HZ: Final = 1.0  # below which the spectrum of noise is held

Complex = NDArray[np.complex128]


def impulse_response(
    delay: NDArray[np.float64], amplitude: Complex, *, carrier: float, sample_rate: float, start: float | None = None,
    taps: int | None = None,
) -> tuple[float, Complex]:  # fmt: skip
    """Taps of the complex baseband channel: each path a band-limited pulse between the samples.

    Args:
        delay, amplitude: of the paths [s], re 1 m.
        carrier, sample_rate: [Hz].
        start: time of the first tap [s]; half a filter before the first path where not given.
        taps: number of them; to half a filter behind the last path where not given.

    Returns:
        time of the first tap [s], and the taps.
    """
    if len(delay) == 0:
        return 0.0 if start is None else start, np.zeros(taps or 0, complex)
    first = float(delay.min()) - _TAPS / 2 / sample_rate if start is None else start
    count = int(np.ceil((float(delay.max()) - first) * sample_rate)) + _TAPS // 2 + 1 if taps is None else taps
    made = np.zeros(count, complex)
    for tau, a in zip(delay, amplitude * np.exp(-2j * np.pi * carrier * delay), strict=True):
        place = (tau - first) * sample_rate
        index = int(np.floor(place)) + np.arange(1 - _TAPS // 2, _TAPS // 2 + 1)
        inside = (index >= 0) & (index < count)
        made[index[inside]] += a * _kernel(place - index)[inside]
    return first, made


def received(
    waveform: Complex, delay: NDArray[np.float64], amplitude: Complex, doppler: NDArray[np.float64], *, carrier: float,
    sample_rate: float, start: float, count: int,
) -> Complex:  # fmt: skip
    """A baseband waveform as it arrives over several paths.

    Args:
        waveform: sent from t = 0 on.
        delay, amplitude, doppler: of the paths at t = 0; `doppler` is received over sent frequency.
        carrier, sample_rate: [Hz].
        start, count: time of the first sample received [s], and how many.
    """
    t = start + np.arange(count) / sample_rate
    total = np.zeros(count, complex)
    for tau, a, d in zip(delay, amplitude, doppler, strict=True):
        own_time = d * t - tau
        turn = np.exp(2j * np.pi * carrier * ((d - 1.0) * t - tau))
        total += a * turn * interpolated(waveform, own_time * sample_rate)
    return total


def interpolated(waveform: Complex, place: NDArray[np.float64]) -> Complex:
    """Values between the samples of a band-limited waveform, 0 outside; `place` in samples."""
    base = np.floor(place).astype(np.int64)
    value = np.zeros(place.shape, complex)
    wet = (base > -_TAPS) & (base < len(waveform) + _TAPS)
    base, place = base[wet], place[wet]
    part = np.zeros(base.shape, complex)
    for k in range(1 - _TAPS // 2, _TAPS // 2 + 1):
        index = base + k
        inside = (index >= 0) & (index < len(waveform))
        part += np.where(inside, waveform[np.clip(index, 0, len(waveform) - 1)], 0.0) * _kernel(place - index)
    value[wet] = part
    return value


def ambient_noise(
    count: int, sample_rate: float, *, wind_speed: float, shipping: float, rng: np.random.Generator, elements: int = 1
) -> NDArray[np.float64]:
    """Pressure of the sea's own noise `(elements, count)` [uPa]: Gaussian, with Wenz's spectrum up to half the rate.

    Args:
        count, sample_rate: samples, and how many a second [Hz].
        wind_speed: [m/s].
        shipping: 0 (none) to 1 (heavy).
        rng: draws them.
        elements: independent rows: elements half a wavelength and more apart.
    """
    density = ambient_density(count, sample_rate, wind_speed=wind_speed, shipping=shipping)
    return noise_of(density, count, sample_rate, rng=rng, elements=elements)


def ambient_density(count: int, sample_rate: float, *, wind_speed: float, shipping: float) -> NDArray[np.float64]:
    """Wenz's one-sided density [uPa^2/Hz] at the frequencies of a transform of `count` samples."""
    frequency = np.fft.rfftfreq(count, 1.0 / sample_rate)
    level = spectral_level(np.maximum(frequency, _LOWEST_HZ), wind_speed=wind_speed, shipping=shipping)
    return np.asarray(10.0 ** (level / 10.0))


def noise_of(
    density: NDArray[np.float64], count: int, sample_rate: float, *, rng: np.random.Generator, elements: int = 1
) -> NDArray[np.float64]:
    """Gaussian noise `(elements, count)` of a one-sided density, see `ambient_density`."""
    drawn = rng.standard_normal((elements, len(density))) + 1j * rng.standard_normal((elements, len(density)))
    spectrum = drawn * np.sqrt(density * sample_rate * count / 4.0)
    spectrum[:, 0] = 0.0
    return np.asarray(np.fft.irfft(spectrum, n=count, axis=1))


def spectral_level(frequency: ArrayLike, *, wind_speed: float, shipping: float) -> NDArray[np.float64]:
    """Wenz's total at frequencies [Hz]: dB re 1 uPa^2/Hz."""
    import drjit as dr

    from pelagos import jit

    f = jit.Float64(np.ascontiguousarray(np.atleast_1d(np.asarray(frequency, np.float64))))
    dr.eval(f)
    return np.asarray(np.array(ambient_level(f, jit.Float64(wind_speed), shipping)))


def delay_spread(delay: NDArray[np.float64], amplitude: Complex) -> float:
    """Root mean square spread of the delays, weighted with the power of each [s]."""
    power = np.abs(amplitude) ** 2
    if not power.sum() > 0:
        return 0.0
    mean = (power * delay).sum() / power.sum()
    return float(np.sqrt((power * (delay - mean) ** 2).sum() / power.sum()))


def _kernel(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """Windowed sinc."""
    inside = np.clip(1.0 - (2.0 * x / _TAPS) ** 2, 0.0, None)
    return np.asarray(np.sinc(x) * np.i0(_BETA * np.sqrt(inside)) / np.i0(_BETA) * (np.abs(x) <= _TAPS / 2))

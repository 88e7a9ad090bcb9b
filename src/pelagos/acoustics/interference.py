"""Other sonars' pulses in a receiver: how much of them its band holds, and what its matched filter makes of them.

Source: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010), Sections 2.3 (one-way loss) and 6.4 (matched
filters).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import lru_cache
from typing import Final

import numpy as np
from numpy.typing import NDArray

_LONGEST: Final = 21  # log2 of the samples of a correlation
_FEWEST: Final = 64.0  # samples of a burst
_SAMPLES: Final = 8.0  # in 1/bandwidth
_FAINT: Final = 1e-2  # of a response's peak: where it is cut off


def band_overlap(frequency: float, bandwidth: float, other_frequency: float, other_bandwidth: float) -> float:
    """Part of another pulse's energy, spread evenly over its band, that lies in the receiver's band; all [Hz]."""
    low = max(frequency - 0.5 * bandwidth, other_frequency - 0.5 * other_bandwidth)
    high = min(frequency + 0.5 * bandwidth, other_frequency + 0.5 * other_bandwidth)
    return max(high - low, 0.0) / other_bandwidth


@dataclass(frozen=True)
class Sent:
    """A pulse: `pulse` is "chirp" or "cw"; centre, width of the band [Hz], duration [s]."""

    frequency_hz: float
    bandwidth_hz: float
    pulse_s: float
    pulse: str = "chirp"


@dataclass(frozen=True)
class Filtered:
    """A pulse behind another one's matched filter.

    Attributes:
        signal: complex64 `(taps,)`, amplitude; 1 at the peak of the filter's own pulse.
        lead_s: time of the first sample after that at which the middle of the pulse arrives [s].
        step_s: between samples [s].
    """

    signal: NDArray[np.complex64]
    lead_s: float
    step_s: float


@lru_cache(maxsize=256)
def through_filter(own: Sent, other: Sent) -> Filtered:
    """Correlation of another sonar's pulse with a receiver's matched filter, which is Hann-shaded for chirps.

    Its own pulse is compressed to `pulse.response`; a chirp of another slope, band or length leaves a long, weak one,
    of the energy that lies in the filter's band (Lurton 2010, Section 6.4).
    """
    offset = other.frequency_hz - own.frequency_hz
    rate = max(2.5 * (abs(offset) + own.bandwidth_hz + other.bandwidth_hz), _FEWEST / min(own.pulse_s, other.pulse_s))
    span = 1.5 * (own.pulse_s + other.pulse_s) + 8.0 / own.bandwidth_hz
    count = 1 << min(math.ceil(math.log2(rate * span)), _LONGEST)
    frequency = np.fft.fftfreq(count, 1.0 / rate)
    replica = np.fft.fft(_waveform(own, count, rate, 0.0))
    band = np.abs(frequency) < 0.5 * own.bandwidth_hz
    shading = np.where(band, 1.0 + np.cos(2.0 * np.pi * frequency / own.bandwidth_hz), 0.0)
    weights = np.conj(replica) * (shading if own.pulse == "chirp" else 1.0)
    peak = float((weights * replica).real.mean())
    found = np.fft.fftshift(np.fft.ifft(weights * np.fft.fft(_waveform(other, count, rate, offset)))) / peak
    every = max(int(rate / (_SAMPLES * own.bandwidth_hz)), 1)
    loud = np.flatnonzero(np.abs(found) > _FAINT * np.abs(found).max())
    first, last = max(loud[0] - every, 0), min(loud[-1] + every, count - 1)
    signal = found[first : last + 1 : every].astype(np.complex64)
    return Filtered(signal, (first - count // 2) / rate, every / rate)


def _waveform(sent: Sent, count: int, rate: float, offset: float) -> NDArray[np.complex128]:
    """Samples about the middle of a pulse, at complex baseband, `offset` [Hz] off; the first one is its middle.

    Those at its ends count by their share in it.
    """
    t = np.fft.ifftshift((np.arange(count) - count // 2) / rate)
    slope = sent.bandwidth_hz / sent.pulse_s if sent.pulse == "chirp" else 0.0
    wave = np.exp(1j * np.pi * (slope * t**2 + 2.0 * offset * t))
    return np.asarray(np.clip(0.5 + (0.5 * sent.pulse_s - np.abs(t)) * rate, 0.0, 1.0) * wave)

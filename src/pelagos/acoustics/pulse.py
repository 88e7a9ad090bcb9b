"""Pulses after the matched filter: chirps, and tone bursts (CW)."""

from __future__ import annotations

import math
from typing import Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.beam_pattern import line
from pelagos.jit import Array


def range_resolution(sound_speed: float, bandwidth: float) -> float:
    """Width [m] of the compressed pulse, c/(2B); `bandwidth` B [Hz]. A CW pulse of duration T has B = 1/T."""
    return sound_speed / (2.0 * bandwidth)


def processing_gain_db(bandwidth: float, duration: float) -> float:
    """Gain [dB] of the matched filter, 10 log10(B T), at least 0."""
    return 10.0 * math.log10(max(bandwidth * duration, 1.0))


EQUIVALENT_WIDTH: Final = {"chirp": 1.5, "cw": 2.0 / 3.0}
"""Integral of a pulse's response, squared and 1 at its peak, over the range, in resolutions c/(2B): by Parseval's
theorem that of the squared weights 1 + cos(2 pi f/B) over the band; of a triangle 2/3."""

SHADING_LOSS_DB: Final = {"chirp": 10.0 * math.log10(1.5), "cw": 0.0}
"""What a filter loses against noise by its shading: the mean of the squared weights over the square of their mean."""


def point_spread(
    bin_width: float, resolution: float, *, pulse: str = "chirp", floor: float = 0.02
) -> NDArray[np.float32]:
    """Range response `(2 k + 1,)` of a Hann-shaded chirp or of a tone burst, sampled at the bins, unit power.

    The compressed pulse of a flat spectrum is sinc(x); shaded by a raised cosine it is the sum of three, with side
    lobes at -31.5 dB (F. J. Harris, Proc. IEEE 66, 51, 1978, doi 10.1109/PROC.1978.10837). A rectangular burst of the
    duration T comes out of its filter as a triangle that ends at +-c T/2 (N. Levanon and E. Mozeson, Radar Signals,
    2004, Section 3.2, at zero Doppler).

    Args:
        bin_width: [m].
        resolution: c/(2B) [m]; where it is well below the bin width the response is one bin.
        pulse: "chirp" or "cw".
        floor: amplitude below which the response is cut.
    """
    reach = math.ceil(2.5 * resolution / bin_width)
    x = np.arange(-reach, reach + 1) * bin_width / resolution
    if pulse == "cw":
        response = np.maximum(1.0 - np.abs(x), 0.0)
    else:
        response = np.sinc(x) + 0.5 * (np.sinc(x - 1.0) + np.sinc(x + 1.0))
    keep = np.flatnonzero(np.abs(response) >= floor)
    half = int(np.max(np.abs(keep - reach)))
    response = response[reach - half : reach + half + 1]
    return np.asarray(response / np.sqrt((response**2).sum()), dtype=np.float32)


def response(offset: Array, pulse: str) -> Array:
    """Amplitude of `point_spread`'s pulse, 1 at its peak, at an offset in resolutions c/(2B); a Dr.Jit array."""
    if pulse == "cw":
        return dr.maximum(1.0 - dr.abs(offset), 0.0)
    return line(offset, 1.0) + 0.5 * (line(offset - 1.0, 1.0) + line(offset + 1.0, 1.0))


def range_coupling(frequency_hz: float, bandwidth_hz: float, duration_s: float, pulse: str) -> float:
    """Range by which a chirp that sweeps upwards takes a closing target of 1 m/s for nearer, f T/B [s]; a burst: 0.

    Source: A. W. Rihaczek, Principles of High-Resolution Radar (1969), Section 6.2: ridge of the ambiguity function.
    """
    return frequency_hz * duration_s / bandwidth_hz if pulse == "chirp" else 0.0

"""How well a beam finds the bottom: errors of amplitude and of phase detection.

Source: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010), Sections 8.3.3-8.3.4, and Appl. Acoust. 64,
617 (2003), doi 10.1016/S0003-682X(03)00031-6.
"""

from __future__ import annotations

import math

import drjit as dr

from pelagos.jit import Array


def amplitude_error(spread: Array, resolution: Array, snr: Array) -> Array:
    """Standard deviation [m] of the range at the centre of gravity of a speckled echo envelope.

    An envelope of rms width w made of N = 1 + 2 sqrt(3) w/dr independent samples has its centre known to w/sqrt(N);
    noise spreads it further.

    Args:
        spread: rms range spread of the echo in the beam's footprint [m].
        resolution: dr, range resolution of the pulse [m].
        snr: power ratio.
    """
    width2 = spread * spread + resolution * resolution / 12.0
    count = 1.0 + 2.0 * math.sqrt(3.0) * spread / resolution
    return dr.sqrt(width2 / count * (1.0 + 1.0 / dr.maximum(snr, 1e-6)))


def phase_error(distance: Array, spread: Array, resolution: Array, snr: Array, *, baseline: float) -> Array:
    """Standard deviation [m] of the range at the zero of the phase difference of two half apertures.

    The phase of one sample errs by sqrt(1/snr + 1/20) [rad], the second term for the decorrelation of the baseline; the
    ramp across the footprint is fitted over N samples. A footprint of rms spread w and angular width b has the ramp
    2 pi a b / (2 sqrt(3) w), so that the error of range is that of phase over the ramp.

    Args:
        distance, spread, resolution, snr: as for `amplitude_error`.
        baseline: separation of the half apertures' centres times the beam width [wavelength rad].
    """
    count = 1.0 + 2.0 * math.sqrt(3.0) * spread / resolution
    phase = dr.sqrt((1.0 / dr.maximum(snr, 1e-6) + 0.05) / count)
    return phase * 2.0 * math.sqrt(3.0) * spread / (2.0 * math.pi * baseline) + resolution / math.sqrt(12.0)

"""Transmission loss of a wave, and the gain that undoes it.

Sources: X. Lurton, An Introduction to Underwater Acoustics (2nd ed., 2010), Sections 2.2, 2.3 and 8.2; R. J. Urick,
Principles of Underwater Sound (3rd ed., 1983), Chapters 5, 8 and 9.
"""

from __future__ import annotations

import drjit as dr

from pelagos.jit import Array

_LN10_10 = 0.2302585092994046  # ln(10)/10


def transmission_loss(distance: Array, absorption: Array, *, spreading: float = 20.0) -> Array:
    """One-way loss [dB] re 1 m: spreading log10(r) + a r; `distance` r [m], `absorption` a [dB/m].

    `spreading` is 20 for a sphere, 10 for a cylinder, 15 in between.
    """
    return spreading * log10(distance) + absorption * distance


def two_way_intensity(distance: Array, absorption: Array) -> Array:
    """Echo intensity factor of a point target re 1 m: r^-4 10^(-2 a r / 10); `absorption` a [dB/m]."""
    r2 = distance * distance
    return dr.exp(-2.0 * _LN10_10 * absorption * distance) / (r2 * r2)


def patch_intensity(distance: Array, absorption: Array) -> Array:
    """Echo intensity factor of a patch that fills a fixed solid angle re 1 m: r^-2 10^(-2 a r / 10)."""
    return dr.exp(-2.0 * _LN10_10 * absorption * distance) / (distance * distance)


def time_varied_gain(distance: Array, absorption: Array, *, spreading: float) -> Array:
    """Intensity gain that undoes spreading log10(r) + 2 a r; 40 keeps point targets level, 30 a bottom, 20 a volume."""
    return dr.exp(_LN10_10 * (spreading * log10(distance) + 2.0 * absorption * distance))


def doppler_two_way(frequency: Array, closing_speed: Array, sound_speed: Array) -> Array:
    """Frequency of an echo [Hz] from a target that closes at `closing_speed` v [m/s]: f (c + v)/(c - v).

    Source: special relativity does not enter; e.g. Lurton (2010), Eq. 2.32, here without the first-order expansion.
    """
    return frequency * (sound_speed + closing_speed) / (sound_speed - closing_speed)


def from_db(level: Array) -> Array:
    """10^(level/10)."""
    return dr.exp(_LN10_10 * level)


def to_db(ratio: Array) -> Array:
    """10 log10(ratio) of a power ratio."""
    return 10.0 * log10(ratio)


def log10(x: Array) -> Array:
    """Base-10 logarithm of a Dr.Jit array or number."""
    return dr.log2(x) * 0.30102999566398120

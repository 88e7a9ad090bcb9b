"""Noise that a receiver hears besides echoes.

Source: R. Coates, Underwater Acoustic Systems (1990), Section 6.3, fits to G. M. Wenz, J. Acoust. Soc. Am. 34, 1936
(1962), doi 10.1121/1.1909155. Levels are spectral: dB re 1 uPa^2/Hz.
"""

from __future__ import annotations

import dataclasses
import math
from typing import Final

import drjit as dr

from pelagos.acoustics.spreading import from_db, log10, to_db
from pelagos.jit import Array

_LEAST_RAIN: Final = 0.1  # [mm/h]
_RAIN_FLAT_HZ: Final = 1.0e4


@dataclasses.dataclass(frozen=True)
class NoiseLevels:
    """Spectral levels by origin [dB re 1 uPa^2/Hz], each a number or an array."""

    turbulence: Array
    shipping: Array
    wind: Array
    thermal: Array


def ambient(frequency: Array, wind_speed: Array, shipping: Array = 0.5) -> NoiseLevels:
    """Spectral levels of the four sources; `frequency` [Hz], `wind_speed` [m/s], `shipping` 0 (none) to 1 (heavy)."""
    f = frequency * 1e-3  # [kHz]
    return NoiseLevels(
        turbulence=17.0 - 30.0 * log10(f),
        shipping=40.0 + 20.0 * (shipping - 0.5) + 26.0 * log10(f) - 60.0 * log10(f + 0.03),
        wind=50.0 + 7.5 * dr.sqrt(wind_speed) + 20.0 * log10(f) - 40.0 * log10(f + 0.4),
        thermal=-15.0 + 20.0 * log10(f),
    )


def rain_level(frequency: Array, rain_mm_per_h: float) -> float:
    """Spectral level of rain on the sea [dB re 1 uPa^2/Hz]; none below 0.1 mm/h.

    At 5 kHz 42.4 + 15.4 log10(R): B. B. Ma, J. A. Nystuen and R.-C. Lien, J. Acoust. Soc. Am. 117, 3555 (2005), doi
    10.1121/1.1910283; as flat from 1 to 10 kHz as their spectra of heavy rain, and beyond falling with the square of
    the frequency (assumed).
    """
    if rain_mm_per_h < _LEAST_RAIN:
        return -math.inf
    beyond = max(float(frequency) / _RAIN_FLAT_HZ, 1.0)
    return 42.4 + 15.4 * math.log10(rain_mm_per_h) - 20.0 * math.log10(beyond)


def ambient_level(frequency: Array, wind_speed: Array, shipping: Array = 0.5, *, rain_mm_per_h: float = 0.0) -> Array:
    """Spectral level of all four sources and of rain together [dB re 1 uPa^2/Hz]."""
    n = ambient(frequency, wind_speed, shipping)
    power = from_db(n.turbulence) + from_db(n.shipping) + from_db(n.wind) + from_db(n.thermal)
    if rain_mm_per_h >= _LEAST_RAIN:
        power += from_db(rain_level(frequency, rain_mm_per_h))
    return to_db(power)


def band_level(spectral_level: float, bandwidth: float) -> float:
    """Level in a band [dB re 1 uPa]; `bandwidth` [Hz]."""
    return spectral_level + 10.0 * math.log10(bandwidth)


def directivity_index(horizontal_width: float, vertical_width: float) -> float:
    """Gain of a receiver against isotropic noise [dB], from its half-power widths [rad]: 10 log10(4 pi/(a b))."""
    return 10.0 * math.log10(4.0 * math.pi / (horizontal_width * vertical_width))

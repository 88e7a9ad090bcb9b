"""Noise that ships and propellers radiate: source levels as spectral densities, dB re 1 uPa^2/Hz at 1 m.

Sources: A. MacGillivray and C. de Jong, J. Mar. Sci. Eng. 9, 369 (2021), doi 10.3390/jmse9040369, Eqs. 1-3 (ships of
the AIS's classes, 20 Hz to 31.5 kHz; beyond, the spectrum goes on as it falls there, by 20 dB a decade, assumed); D.
Ross, Mechanics of Underwater Noise (1976), Section 8.6: cavitating propellers, some 60 dB a decade of speed and -20 dB
a decade of frequency.
"""

from __future__ import annotations

from typing import Final

import numpy as np
from numpy.typing import ArrayLike, NDArray

from pelagos.math.units import KNOT

SHIP_SPEEDS_KN: Final = {
    "fishing": 6.4, "tug": 3.7, "naval": 11.1, "recreational": 10.6, "government": 8.0, "cruise": 17.1,
    "passenger": 9.7, "bulker": 13.9, "containership": 18.0, "vehicle_carrier": 15.8, "tanker": 12.4, "dredger": 9.5,
    "other": 7.4,
}  # fmt: skip
"""Reference speed of each class of ships [kn]."""
SPEED_SLOPE_DB: Final = 60.0
"""Rise of a propeller's level with each decade of speed [dB]."""
FREQUENCY_SLOPE_DB: Final = 20.0
"""Fall of a propeller's spectral level with each decade of frequency [dB]."""

_LENGTH: Final = 91.44  # [m], of the ship that the reference spectrum is of: 300 ft
_LEVEL: Final = 191.0  # K of the spectrum [dB]
_PEAK: Final = 480.0  # f1 [Hz] at 1 kn
_SLOWEST: Final = 1e-3  # of the reference speed: 180 dB below it nothing is heard


def ship_level(frequency: float, speed: ArrayLike, *, length: float, ship_class: str) -> NDArray[np.float64]:
    """Spectral source level of a ship [dB re 1 uPa^2/Hz at 1 m], above 100 Hz.

    K - 20 log10 f1 - 10 log10((1 - f/f1)^2 + D^2) + 60 log10(V/Vc) + 20 log10(l/l0), with f1 = 480 Hz/(Vc/1 kn).

    Args:
        frequency: [Hz].
        speed: through the water [m/s], any shape.
        length: of the ship [m].
        ship_class: one of `SHIP_SPEEDS_KN`.
    """
    usual = SHIP_SPEEDS_KN[ship_class]
    peak = _PEAK / usual
    width = 4.0 if ship_class == "cruise" else 3.0
    shape = (1.0 - frequency / peak) ** 2 + width**2
    still = _LEVEL - 20.0 * np.log10(peak) - 10.0 * np.log10(shape) + 20.0 * np.log10(length / _LENGTH)
    return np.asarray(still + _by_speed(speed, usual * KNOT))


def propeller_level(
    frequency: float, speed: ArrayLike, *, level: float, at_frequency: float, at_speed: float
) -> NDArray[np.float64]:
    """Spectral source level of propellers [dB re 1 uPa^2/Hz at 1 m] that is known at one frequency and speed.

    Args:
        frequency: [Hz].
        speed: through the water [m/s], any shape.
        level: at `at_frequency` [Hz] and `at_speed` [m/s].
    """
    return np.asarray(level - FREQUENCY_SLOPE_DB * np.log10(frequency / at_frequency) + _by_speed(speed, at_speed))


def _by_speed(speed: ArrayLike, usual: float) -> NDArray[np.float64]:
    ratio = np.abs(np.asarray(speed, dtype=np.float64)) / usual
    return np.asarray(SPEED_SLOPE_DB * np.log10(np.maximum(ratio, _SLOWEST)))

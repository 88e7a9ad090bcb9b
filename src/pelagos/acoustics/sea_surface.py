"""The sea surface from below: scattering by its facets and by bubbles, and the loss of a bounce.

Source: Applied Physics Laboratory, University of Washington, "High-Frequency Ocean Environmental Acoustic Models
Handbook", APL-UW TR 9407 (1994), Section II. 10 to 100 kHz; bubbles after S. T. McDaniel, J. Acoust. Soc. Am. 94, 1905
(1993). Winds are 10 m above the surface, in fully developed seas.
"""

from __future__ import annotations

import math
import warnings
from typing import Final

import drjit as dr

from pelagos.acoustics.spreading import from_db
from pelagos.errors import ValidityWarning
from pelagos.jit import Array

FREQUENCY_RANGE_HZ: Final = (1.0e4, 1.0e5)

_FULL_WIND: Final = 6.0  # [m/s], from which the loss by bubbles follows a power of the wind
_MOST_LOSS_DB: Final = 15.0
_BREAKING: Final = 11.0  # [m/s], from which the bubbles' echo grows with a power of the wind
_STEEP: Final = 85.0  # [deg], grazing angle from which small-scale roughness is left out


def bubble_loss_db(sine: Array, frequency: float, wind_speed: float) -> Array:
    """Loss [dB] of one bounce at the surface by bubbles: 1.26e-3 U^1.57 f^0.85/sin(grazing), f in kHz.

    Below 6 m/s it falls with exp(1.2 (U - 6)). At most 15 dB.

    Args:
        sine: of the grazing angle.
        frequency: [Hz].
        wind_speed: U [m/s].
    """
    wind = max(wind_speed, _FULL_WIND)
    calm = math.exp(1.2 * (wind_speed - wind))
    loss = 1.26e-3 * wind**1.57 * (frequency * 1e-3) ** 0.85 * calm
    return dr.minimum(loss / dr.maximum(sine, 1e-3), _MOST_LOSS_DB)


def surface_backscatter(grazing: Array, frequency: float, wind_speed: float) -> Array:
    """Backscattering cross section per unit area and solid angle of the sea surface [1].

    Args:
        grazing: angle between ray and mean surface [rad], 0 to pi/2.
        frequency: [Hz], 10 to 100 kHz; a `ValidityWarning` outside.
        wind_speed: [m/s].
    """
    low, high = FREQUENCY_RANGE_HZ
    if not low <= frequency <= high:
        message = f"surface backscatter at {frequency:g} Hz: the model of TR 9407 covers {low:g} Hz to {high:g} Hz"
        warnings.warn(message, ValidityWarning, stacklevel=2)
    sine = dr.maximum(dr.sin(grazing), 1e-3)
    facets = surface_facets(sine, wind_speed)
    small = 1.3e-5 * wind_speed * (sine * sine / dr.maximum(1.0 - sine * sine, 1e-6)) ** 2
    small = dr.select(grazing < math.radians(_STEEP), small, 0.0)
    share = 1.0 / (1.0 + dr.exp(0.524 * (_facet_angle_deg(wind_speed) - grazing * (180.0 / math.pi))))
    rough = share * facets + (1.0 - share) * small
    return rough * from_db(-bubble_loss_db(sine, frequency, wind_speed)) + bubble_backscatter(
        sine, frequency, wind_speed
    )


def mean_square_slope(wind_speed: float) -> float:
    """Twice the variance of the surface's slope in one direction, s^2 = 4.6e-3 ln(2.1 U^2) [1]; U at least 1 m/s."""
    return 4.6e-3 * math.log(2.1 * max(wind_speed, 1.0) ** 2)


def surface_facets(sine: Array, wind_speed: float) -> Array:
    """Cross section [1] of the facets near the vertical: exp(-tan^2 g/s^2)/(4 pi s^2 cos^4 g), g the incidence."""
    s2 = mean_square_slope(wind_speed)
    squared = sine * sine
    return dr.exp(-(1.0 - squared) / (squared * s2)) / (4.0 * math.pi * s2 * squared * squared)


def bubble_backscatter(sine: Array, frequency: float, wind_speed: float) -> Array:
    """Cross section per unit area [1] of the bubbles below the surface, and of their mirror images in it."""
    khz = frequency * 1e-3
    density = 10.0 ** (-5.2577 + 0.4701 * min(wind_speed, _BREAKING)) * (khz / 25.0) ** 0.85
    density *= max(wind_speed / _BREAKING, 1.0) ** 3.5
    radiation, damping = 0.0136, 2.55e-2 * khz ** (1.0 / 3.0)
    b = density / sine
    paths = (1.0 + 8.0 * b * dr.exp(-2.0 * b) - dr.exp(-4.0 * b)) / (2.0 * b)
    return density * radiation / (4.0 * math.pi * damping) * paths


def _facet_angle_deg(wind_speed: float) -> float:
    """Grazing angle [deg] at which the facets' echo is 15 dB below that at the vertical, by bisection."""
    s2 = mean_square_slope(wind_speed)
    low, high = 0.0, 10.0  # tan^2 of the incidence
    for _ in range(60):
        middle = 0.5 * (low + high)
        fallen = 10.0 * math.log10((1.0 + middle) ** 2) - 10.0 / math.log(10.0) * middle / s2
        low, high = (middle, high) if fallen > -15.0 else (low, middle)
    return 90.0 - math.degrees(math.atan(math.sqrt(low)))

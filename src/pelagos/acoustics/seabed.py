"""Backscattering strength of a sea bed: the model of APL-UW TR 9407.

Source: Applied Physics Laboratory, University of Washington, "High-Frequency Ocean Environmental Acoustic Models
Handbook", APL-UW TR 9407 (1994), Section IV. 10 to 100 kHz. Its near-vertical (Kirchhoff) level as printed is 3.3 to
3.6 dB below its own table; the factor 2^(2 (1 - alpha)/alpha) that restores it is applied here.

Bottom parameters are ratios to the water: density rho, sound speed nu, loss delta; volume scattering sigma2; roughness
spectral strength w2 [cm^4] with spectral exponent 3.25.
"""

from __future__ import annotations

import math
import warnings
from dataclasses import dataclass
from typing import Final

import drjit as dr

from pelagos.acoustics.complex_pair import Pair, squared, times
from pelagos.acoustics.reflection import fluid_reflection, vertical_wavenumber
from pelagos.errors import ValidityWarning
from pelagos.jit import Array

FREQUENCY_RANGE_HZ: Final = (1.0e4, 1.0e5)

_GAMMA: Final = 3.25  # spectral exponent of the relief
_ALPHA: Final = _GAMMA / 2.0 - 1.0
_G = math.gamma
_C: Final = 2 * math.pi * _G(2 - _ALPHA) * 2 ** (-2 * _ALPHA) / (_ALPHA * (1 - _ALPHA) * _G(1 + _ALPHA))
_A: Final = (
    8 * _ALPHA**2 * _G(0.5 / _ALPHA + 0.5) / (_G(0.5) * _G(1 / _ALPHA) * _G(0.5 / _ALPHA))
) ** (2 * _ALPHA)  # fmt: skip
_B: Final = _A ** (0.5 - 0.5 / _ALPHA) * _G(1 / _ALPHA) / (2 * _ALPHA)
_LEVEL: Final = 2.0 ** (2 * (1 - _ALPHA) / _ALPHA)
_SLOPES: Final = ((0.295410, -1.224745), (1.181636, 0.0), (0.295410, 1.224745))  # Gauss-Hermite weights and nodes
_DEGREE: Final = math.pi / 180


@dataclass
class Bottom:
    """Parameters of a bottom, numbers or arrays (see the module's docstring); a Dr.Jit struct."""

    density_ratio: Array
    sound_speed_ratio: Array
    loss: Array
    volume_scatter: Array
    spectral_strength: Array


def backscatter(grazing: Array, frequency: float, bottom: Bottom, *, sound_speed: float = 1528.0) -> Array:
    """Backscattering cross section per unit area and solid angle [1]; 10 log10 of it is the strength S [dB].

    Args:
        grazing: angle between ray and bottom [rad], 0 to pi/2.
        frequency: [Hz], 10 to 100 kHz; a `ValidityWarning` outside.
        bottom: parameters, broadcast against `grazing`.
        sound_speed: of the water [m/s].
    """
    low, high = FREQUENCY_RANGE_HZ
    if not low <= frequency <= high:
        message = f"bottom backscatter at {frequency:g} Hz: the model of TR 9407 covers {low:g} Hz to {high:g} Hz"
        warnings.warn(message, ValidityWarning, stacklevel=2)
    k = 2.0 * math.pi * frequency / sound_speed / 100.0  # [1/cm], as in the report
    slope = rms_slope(bottom.spectral_strength, k)
    r90 = squared(_reflection(grazing * 0.0 + 1.0, bottom))
    perturbation = _over_slopes(lambda sine: _perturbation(sine, k, bottom), grazing, slope)
    volume = _over_slopes(lambda sine: _volume(sine, bottom), grazing, slope)
    shadow = _shadowing(grazing, slope)
    kirchhoff, q2 = _kirchhoff(grazing, k, bottom, r90)
    c4 = 1000.0 ** (1 / (1 + _ALPHA)) * (_A * q2) ** (1 / _ALPHA)
    steepness = (dr.cos(grazing) - (1.0 / c4 + 4.0) ** -0.25) / 0.0125
    moderate = _join(steepness, kirchhoff, perturbation * shadow)
    steep = _large_roughness(grazing, slope, bottom, r90)
    rough = _join((dr.atan(slope) / _DEGREE - 7.0) / 0.5, moderate, steep)
    return rough + volume * shadow


def rms_slope(spectral_strength: Array, k: float) -> Array:
    """Large-scale slope s [rad] of the composite model; wavenumber `k` [1/cm]."""
    s2 = (2 * math.pi * spectral_strength) ** (1 / _ALPHA) / (2 * (1 - _ALPHA))
    return dr.sqrt(s2 * (k * k / _ALPHA) ** ((1 - _ALPHA) / _ALPHA))


def _reflection(sine: Array, bottom: Bottom) -> Pair:
    return fluid_reflection(sine, bottom.density_ratio, bottom.sound_speed_ratio, bottom.loss)


def _kirchhoff(grazing: Array, k: float, bottom: Bottom, r90: Array) -> tuple[Array, Array]:
    """Cross section near the vertical, and q^2."""
    q = bottom.spectral_strength * _C * 2 ** (1 - 2 * _ALPHA) * k ** (2 * (1 - _ALPHA))
    sine, cosine = dr.sin(grazing), dr.maximum(dr.cos(grazing), 1e-12)
    spread = cosine ** (4 * _ALPHA) + _A * q * q * sine**4
    return _LEVEL * _B * q * r90 / (8 * math.pi * spread ** ((1 + _ALPHA) / (2 * _ALPHA))), q * q


def _perturbation(sine: Array, k: float, bottom: Bottom) -> Array:
    """Small-roughness cross section."""
    rho, nu, delta = bottom.density_ratio, bottom.sound_speed_ratio, bottom.loss
    cos2 = 1.0 - sine * sine
    kr, ki = 1.0 / nu, delta / nu
    p = vertical_wavenumber(sine, nu, delta)
    above = ((rho - 1.0) ** 2 * cos2 + rho * rho - (kr * kr - ki * ki), -2.0 * kr * ki)
    below = (rho * sine + p[0], p[1])
    y2 = squared(above) / squared(times(below, below))
    wave2 = 4.0 * k * k * cos2 + 0.01 * k * k
    return 4.0 * k**4 * sine**4 * y2 * bottom.spectral_strength * wave2 ** (-_GAMMA / 2)


def _volume(sine: Array, bottom: Bottom) -> Array:
    """Cross section of the sediment's inside."""
    nu, delta = bottom.sound_speed_ratio, bottom.loss
    p = vertical_wavenumber(sine, nu, delta)
    r = _reflection(sine, bottom)
    r2 = times(r, r)
    through = squared((1.0 - r2[0], -r2[1]))
    depth = nu * math.log(10.0) * squared(p) * dr.maximum(p[1], 1e-9)
    return 5.0 * delta * bottom.volume_scatter * through * sine * sine / depth


def _over_slopes(section: object, grazing: Array, slope: Array) -> Array:
    """Mean of a cross section over the large-scale slopes."""
    total = 0.0 * grazing
    for weight, node in _SLOPES:
        angle = dr.clip(grazing + node * slope, 1e-4, math.pi / 2)
        total = total + weight / math.sqrt(math.pi) * section(dr.sin(angle))  # type: ignore[operator]
    return total


def _shadowing(grazing: Array, slope: Array) -> Array:
    """Fraction of a Gaussian relief that the source sees."""
    t = dr.maximum(dr.tan(dr.minimum(grazing, 1.57)) / slope, 1e-4)
    q = (dr.exp(-t * t) / math.sqrt(math.pi) - t * (1.0 - dr.erf(t))) / (4.0 * t)
    q = dr.maximum(q, 1e-9)
    return dr.select(t > 2.0, 1.0, (1.0 - dr.exp(-2.0 * q)) / (2.0 * q))


def _large_roughness(grazing: Array, slope: Array, bottom: Bottom, r90: Array) -> Array:
    """Empirical cross section of rock and gravel; angles in degrees, as printed."""
    rho, nu = bottom.density_ratio, bottom.sound_speed_ratio
    theta = dr.maximum(grazing / _DEGREE, 0.1)
    theta_c = dr.select(nu < 1.001, 2.5613, dr.acos(dr.minimum(1.0 / nu, 1.0)) / _DEGREE)
    theta_s = slope / _DEGREE
    m = 0.7263 * slope ** (-1.0 / 3.0)
    c = 1.0 + 0.81 * theta_c**2 / theta**2
    side = 0.04682 * slope**1.25 * nu**3.25 * ((1.0 - 2.0 / rho) / nu**2 + 1.0) ** 2 / (1.0 + 3.54 * theta_s / theta_c)
    facets = 0.0260 * r90 / (slope**2 * c * (1.0 + (theta - 90.0) ** 2 / (2.6 * theta_s**2)) ** 1.9)
    return side * dr.sin(math.pi / c) ** m + facets


def _join(x: Array, small: Array, large: Array) -> Array:
    """A smooth change from `large` (x > 0) to `small` (x < 0)."""
    f = 1.0 / (1.0 + dr.exp(dr.clip(x, -40.0, 40.0)))
    return f * small + (1.0 - f) * large

"""Coherent echo of smooth solids: Kirchhoff's integral by the phase of the surface, near and far.

A surface that is smooth in wavelengths sends back what its stationary points send (curved sides), and what Fresnel's
integrals over its edges leave (flat sides). With r the distance to the surface, a flat side as large as many Fresnel
zones is a mirror, R/(2 r); a sphere of the radius a is R a/(2 r (r + a)); far away a plate of the area A is R A/(lambda
r^2), and a cylinder R L sqrt(a/(2 lambda))/r^2.

Sources: F. B. Jensen et al., Computational Ocean Acoustics (2nd ed., 2011), Section 1; R. J. Urick, Principles of
Underwater Sound (3rd ed., 1983), Table 9.1 (the limits); M. Abramowitz and I. A. Stegun, Handbook of Mathematical
Functions (1964), Eqs. 7.3.9, 7.3.10, 7.3.32, 7.3.33 (Fresnel integrals); J. A. Ogilvy, Theory of Wave Scattering from
Random Rough Surfaces (1991), Section 4.2 (coherent loss by roughness).
"""

from __future__ import annotations

import math
from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.acoustics.complex_pair import Pair
from pelagos.jit import Array

_NARROW: Final = 0.25  # difference of Fresnel arguments below which the integrand is a plane wave


def fresnel(x: Array) -> Pair:
    """Fresnel integrals C(x), S(x) of cos and sin(pi t^2/2), within 2e-3."""
    a = dr.abs(x)
    f = (1.0 + 0.926 * a) / (2.0 + 1.792 * a + 3.104 * a * a)
    g = 1.0 / (2.0 + 4.142 * a + 3.492 * a * a + 6.67 * a * a * a)
    s, c = dr.sincos(0.5 * math.pi * a * a)
    sign = dr.select(x < 0.0, -1.0, 1.0)
    return sign * (0.5 + f * s - g * c), sign * (0.5 - f * c - g * s)


def edge_factor(low: Array, high: Array, slope: Array, distance: Array, wavelength: Array) -> Pair:
    """Complex factor F of a flat side's extent on a mirror's echo, in one of its two directions.

    The way to a place x on the side is r + s x + (1 - s^2) x^2/(2 r), out and home. F is 1 where all Fresnel zones lie
    within the edges, and (high - low) sqrt(2/(lambda r)) where the side is much smaller than the first.

    Args:
        low, high: edges of the side, from the place that is at `distance` [m].
        slope: s, by which the way grows along the side there [1].
        distance: r [m].
        wavelength: [m].
    """
    bend = dr.maximum(1.0 - slope * slope, 1e-4)
    scale = 2.0 * dr.sqrt(bend / (wavelength * distance))
    shift = slope * distance / bend
    u1, u2 = scale * (low + shift), scale * (high + shift)
    (c1, s1), (c2, s2) = fresnel(u1), fresnel(u2)
    middle, width = 0.5 * (u1 + u2), u2 - u1
    # of a narrow side: a plane wave over it
    turn = dr.pi * 0.5 * middle * width
    small = dr.abs(turn) < 1e-3
    sinc = dr.select(small, 1.0, dr.sin(turn) / dr.select(small, 1.0, turn))
    sine, cosine = dr.sincos(0.5 * math.pi * middle * middle)
    narrow = dr.abs(width) < _NARROW
    scale_down = 1.0 / math.sqrt(2.0)
    return (
        scale_down * dr.select(narrow, width * sinc * cosine, c2 - c1),
        scale_down * dr.select(narrow, width * sinc * sine, s2 - s1),
    )


def roughness_loss(rms_height: Array, wavelength: Array, cosine: Array = 1.0) -> Array:
    """Part of the intensity that stays coherent on a surface of Gaussian roughness: exp(-(2 k s cos)^2)."""
    return dr.exp(-dr.square(4.0 * math.pi * rms_height * cosine / wavelength))


def flat_side(
    sides: tuple[Array, Array], offsets: tuple[Array, Array], height: Array, wavelength: Array
) -> tuple[Array, Array, Array]:
    """Amplitude over R [1/m] of a rectangle's echo at a sonar before it, its range [m], and how squarely it is met.

    Args:
        sides: half lengths of the rectangle [m].
        offsets: the sonar's place along both sides, from the rectangle's middle [m].
        height: of the sonar before the rectangle's plane [m]; behind it there is no echo.
        wavelength: [m].

    Returns:
        |amplitude| re 1 m over the reflection coefficient, range of the place on the rectangle nearest to the sonar,
        cosine of the incidence there.
    """
    feet = [dr.clip(offset, -half, half) for offset, half in zip(offsets, sides, strict=True)]
    away = [foot - offset for foot, offset in zip(feet, offsets, strict=True)]
    distance = dr.maximum(dr.sqrt(away[0] * away[0] + away[1] * away[1] + height * height), 1e-3)
    real, imaginary = jit.Float(1), jit.Float(0)
    spread = jit.Float(1)
    for foot, gone, half in zip(feet, away, sides, strict=True):
        slope = gone / distance
        a, b = edge_factor(-half - foot, half - foot, slope, distance, wavelength)
        real, imaginary = real * a - imaginary * b, real * b + imaginary * a
        spread *= dr.rsqrt(dr.maximum(1.0 - slope * slope, 1e-4))
    cosine = dr.maximum(height, 0.0) / distance
    size = dr.sqrt(real * real + imaginary * imaginary)
    return 0.5 * cosine * spread * size / distance, distance, cosine


def round_side(
    radius: Array, half_length: Array, along: Array, across: Array, wavelength: Array
) -> tuple[Array, Array, Array]:
    """The same of a cylinder's side.

    Args:
        radius: a [m].
        half_length: [m].
        along: the sonar's place along the axis, from the middle [m].
        across: its distance from the axis [m].
        wavelength: [m].
    """
    height = dr.maximum(across - radius, 1e-3)
    foot = dr.clip(along, -half_length, half_length)
    gone = foot - along
    distance = dr.sqrt(gone * gone + height * height)
    slope = gone / distance
    cosine = height / distance
    a, b = edge_factor(-half_length - foot, half_length - foot, slope, distance, wavelength)
    curved = dr.sqrt(radius / (distance + radius * cosine)) * dr.sqrt(cosine)
    bend = dr.rsqrt(dr.maximum(1.0 - slope * slope, 1e-4))
    return 0.5 * curved * bend * dr.sqrt(a * a + b * b) / distance, distance, cosine


def sphere_amplitude(form: Array, radius: Array, distance: Array) -> Array:
    """Amplitude re 1 m of a sphere's echo whose near side is at `distance` r: |f|/(r (r + a)); `form` |f| [m]."""
    return form / (distance * (distance + radius))

"""How strongly things send sound back.

`target strength` is of a whole object, 10 log10 of its backscattering cross section [m^2]; `cross section` per unit
area is of a surface patch, per solid angle [1].
Sources: R. J. Urick, Principles of Underwater Sound (3rd ed., 1983), Table 9.1; E. Thorsos and the Kirchhoff limit of
geometrical optics in F. G. Bass and I. M. Fuks, Wave Scattering from Statistically Rough Surfaces (1979), Chapter 7.
"""

from __future__ import annotations

import math

import drjit as dr

from pelagos.acoustics.spreading import from_db, to_db
from pelagos.jit import Array


def sphere(radius: Array) -> Array:
    """Target strength [dB] of a rigid sphere, k a >> 1: 20 log10(a/2)."""
    return to_db(radius * radius / 4.0)


def plate(area: Array, wavelength: Array) -> Array:
    """Target strength [dB] of a flat rigid plate at normal incidence: 20 log10(A/lambda); `area` [m^2]."""
    return to_db((area / wavelength) ** 2)


def corner(edge: Array, wavelength: Array) -> Array:
    """Target strength [dB] of a trihedral corner along its axis, effective area a^2/sqrt(3) for edges a [m].

    Source: E. F. Knott et al., Radar Cross Section (2nd ed., 2004), Table 6.1: sigma = 4 pi a^4/(3 lambda^2).
    """
    return to_db(edge**4 / (3.0 * wavelength**2))


def cylinder(radius: Array, length: Array, wavelength: Array) -> Array:
    """Target strength [dB] of a rigid cylinder at normal incidence: 10 log10(a L^2/(2 lambda))."""
    return to_db(radius * length * length / (2.0 * wavelength))


def lambert(sine: Array, mu_db: Array) -> Array:
    """Cross section mu sin^2 of a Lambert surface; `sine` of the grazing angle, `mu_db` 10 log10 mu.

    A surface that sends back all it receives has mu = 1/pi (-5 dB). Mackenzie's sea bed: -27 dB.
    Source: K. V. Mackenzie, J. Acoust. Soc. Am. 33, 1498 (1961), doi 10.1121/1.1908482.
    """
    return from_db(mu_db) * sine * sine


def facets(sine: Array, reflection_squared: Array, slope: float) -> Array:
    """Cross section of specular facets with Gaussian slopes: |R|^2/(8 pi s^2 sin^4) exp(-cot^2/(2 s^2)).

    Args:
        sine: sine of the grazing angle.
        reflection_squared: |R|^2 at normal incidence.
        slope: rms slope s of the facets in one direction [1].
    """
    s2 = dr.maximum(sine * sine, 1e-6)
    cot2 = (1.0 - s2) / s2
    return reflection_squared / (8.0 * math.pi * slope**2 * s2 * s2) * dr.exp(-cot2 / (2.0 * slope**2))

"""Target strengths of simple bodies.

`target strength` is of a whole object, 10 log10 of its backscattering cross section [m^2]; `cross section` per unit
area is of a surface patch, per solid angle [1].
Sources: R. J. Urick, Principles of Underwater Sound (3rd ed., 1983), Table 9.1; E. Thorsos and the Kirchhoff limit of
geometrical optics in F. G. Bass and I. M. Fuks, Wave Scattering from Statistically Rough Surfaces (1979), Chapter 7.
"""

from __future__ import annotations

import math

import drjit as dr
import numpy as np
from numpy.typing import NDArray

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


def corner_lobe(angle: NDArray[np.floating]) -> NDArray[np.float64]:
    """Cross section of a trihedral corner at angles from its axis [rad], over that along it: mean over all azimuths.

    About the axis it varies by less than 0.2 dB up to 20 deg, and 0.5 dB up to 25 deg. No echo comes back by three
    bounces where a direction sees fewer than all three plates.
    """
    turn = np.linspace(0.0, 2.0 * math.pi, 120, endpoint=False)
    tilt = np.asarray(angle, dtype=np.float64)[..., None]
    legs = [
        (np.cos(tilt) + math.sqrt(2.0) * np.sin(tilt) * np.cos(turn - 2.0 * math.pi * k / 3.0)) / math.sqrt(3.0)
        for k in range(3)
    ]
    return np.asarray((3.0 * corner_area(np.stack(legs, axis=-1)) ** 2).mean(axis=-1))


def corner_area(direction: NDArray[np.floating]) -> NDArray[np.float64]:
    """Effective area of a trihedral corner over the square of its edge, in directions `(..., 3)` along its legs.

    With the cosines l <= m <= n: 4 l m/(l + m + n) where l + m <= n, else l + m + n - 2/(l + m + n); the cross section
    is 4 pi A^2/lambda^2. Source: S. D. Robertson, Bell Syst. Tech. J. 26, 852 (1947).
    """
    low, middle, high = np.moveaxis(np.sort(np.asarray(direction, dtype=np.float64), axis=-1), -1, 0)
    total = np.maximum(low + middle + high, 1e-9)
    area = np.where(low + middle <= high, 4.0 * low * middle / total, total - 2.0 / total)
    return np.where(low > 0.0, area, 0.0)


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

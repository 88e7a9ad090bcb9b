"""Immersed share of a body, and the forces that fade with it. FRD.

Entry: the momentum that a wet part gave to the water, its share of the added mass times the velocity, is taken from
the body as the share grows (T. von Karman, "The impact on seaplane floats during landing", NACA TN 321, 1929), so that
(m + s m_a) v stays. What comes out of the water leaves its added mass behind: no force pulls it back (O. M. Faltinsen,
"Hydrodynamics of High-Speed Marine Vehicles", 2005, Section 8.2).
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos.hydro.algebra import Vector, dot, mul, total
from pelagos.jit import Array

# K. Minsaas, O. Faltinsen, B. Persson, "On the importance of added resistance, propeller immersion and propeller
# ventilation for large ships in a seaway", PRADS 1983: thrust by shaft depth over radius
_LOSS: Final = (0.675, 0.769, 1.258)  # assumed: as later works quote the paper, which could not be consulted itself
_DEEP: Final = 1.3


def ellipsoid_share(
    semi_axes: Vector, center: Vector, down: Vector, immersion: Array, sinking: Array
) -> tuple[Array, Array]:
    """Wet share of an ellipsoid's volume [-], exact at any attitude, and its rate [1/s]; see `emerged_ellipsoid`.

    Args:
        semi_axes: (3) [m].
        center: from the body's origin (3) [m].
        down: unit vector towards the centre of the earth, in body axes (3).
        immersion: depth of the origin below the surface [m].
        sinking: its rate [m/s].
    """
    stretched = [mul(a, d) for a, d in zip(semi_axes, down, strict=True)]
    inverse = dr.rcp(dr.sqrt(dot(stretched, stretched)))
    z = dr.clip(total(immersion, dot(center, down)) * inverse, -1.0, 1.0)
    return 0.5 + z * (0.75 - 0.25 * z * z), 0.75 * (1 - z * z) * inverse * sinking


def keel_share(
    semi_axes: Vector, center: Vector, down: Vector, immersion: Array, sinking: Array, fade: Array
) -> tuple[Array, Array]:
    """1 while the lowest point of a hull that floats is deeper than `fade` [m], 0 where it is out of the water.

    In between it is linear; the rate [1/s] beside it. Arguments as of `ellipsoid_share`, the box's half sizes.
    """
    stretched = [mul(a, d) for a, d in zip(semi_axes, down, strict=True)]
    depth = total(immersion, dot(center, down), dr.sqrt(dot(stretched, stretched)))
    share = dr.clip(depth / fade, 0.0, 1.0)
    return share, dr.select((share > 0) & (share < 1), sinking / fade, 0.0)


def propeller_share(depth: Array, radius: Array) -> Array:
    """Share of the thrust that a propeller keeps at a shaft depth [m]: disc out of the water, ventilation, Wagner.

    1 from 1.3 radii on, 0.325 with half the disc out of the water, 0 from half a radius above it on (Minsaas 1983).
    """
    a, b, power = _LOSS
    base = dr.maximum(1 - b * depth / radius, 0.0)
    lost = a * dr.exp(power * dr.log(dr.maximum(base, 1e-9)))
    return dr.select(depth < _DEEP * radius, dr.clip(1 - lost, 0.0, 1.0), 1.0)


def fin_share(depth: Array, half_span: Array) -> Array:
    """Share of a fin's area that is under water, its middle at a depth [m]."""
    return dr.clip(0.5 + 0.5 * depth / half_span, 0.0, 1.0)

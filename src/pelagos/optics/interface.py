"""The air-water interface: Snell's law, Fresnel's reflectance. Vectors are unit `Array3f` in the world frame NWU."""

from __future__ import annotations

import math

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.water import REFRACTIVE_INDEX


def fresnel(cosine: Array, eta: Array) -> Array:
    """Unpolarised reflectance.

    Args:
        cosine: of the angle of incidence, 0 .. 1.
        eta: index on the far side over index on the near side. Past the critical angle the result is 1.
    """
    sin2 = (1 - cosine * cosine) / (eta * eta)
    total = sin2 >= 1
    far = dr.sqrt(dr.maximum(1 - sin2, 0))
    s = (cosine - eta * far) / (cosine + eta * far)
    p = (eta * cosine - far) / (eta * cosine + far)
    return dr.select(total, 1, 0.5 * (s * s + p * p))


def refract(direction: Array, normal: Array, eta: Array) -> Array:
    """Direction of light behind the surface (Snell's law in vector form).

    Args:
        direction: of travel, towards the surface.
        normal: of the surface, against `direction`.
        eta: index on the near side over index on the far side. Past the critical angle the result grazes the surface.
    """
    cosine = -dr.dot(direction, normal)
    far = dr.sqrt(dr.maximum(1 - eta * eta * (1 - cosine * cosine), 0))
    return eta * direction + (eta * cosine - far) * normal


def reflect(direction: Array, normal: Array) -> Array:
    """Direction of travel after a mirror."""
    return direction - 2 * dr.dot(direction, normal) * normal


def sun_below_surface(towards_sun: Array) -> Array:
    """Unit vector in the water towards the sun, through a flat surface."""
    up = type(towards_sun)(0, 0, 1)
    return -refract(-towards_sun, up, 1 / REFRACTIVE_INDEX)


def critical_angle() -> float:
    """Half the width of Snell's window [rad]."""
    return math.asin(1 / REFRACTIVE_INDEX)


def surface_normal(slope: Array) -> Array:
    """Upward unit normal of a surface with slope (dh/dx, dh/dy)."""
    return dr.normalize(jit.Array3f(-slope[0], -slope[1], 1))

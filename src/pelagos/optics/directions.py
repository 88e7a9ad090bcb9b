"""Directions by chance: about an axis, and off a matt surface."""

from __future__ import annotations

import math

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


def about(axis: Array, cosine: Array, u: Array) -> Array:
    """The unit direction at an angle from `axis`, turned about it by u = 0 .. 1 of a full turn."""
    sine = dr.sqrt(dr.maximum(1 - cosine * cosine, 0))
    s, c = dr.sincos(2 * math.pi * u)
    side, other = _across(axis)
    return dr.normalize(sine * c * side + sine * s * other + cosine * axis)


def off_matt(normal: Array, u: Array, v: Array) -> Array:
    """A direction off a matt surface: density cos / pi."""
    return about(normal, dr.sqrt(1 - u), v)


def _across(n: Array) -> tuple[Array, Array]:
    """Two unit vectors across n (T. Duff et al., JCGT 6:1, 2017)."""
    sign = dr.select(n.z < 0, -1.0, 1.0)
    a = -1 / (sign + n.z)
    b = n.x * n.y * a
    return jit.Array3f(1 + sign * n.x * n.x * a, sign * b, -sign * n.x), jit.Array3f(b, sign + n.y * n.y * a, -n.y)

"""Angles and saturation."""

from __future__ import annotations

import math

import drjit as dr

from pelagos.jit import Array


def smallest_angle(angle: Array) -> Array:
    """The angle in [-pi, pi) [rad]."""
    return angle - 2 * math.pi * dr.floor((angle + math.pi) / (2 * math.pi))


def saturate(x: Array) -> Array:
    """x between -1 and 1."""
    return dr.clip(x, -1.0, 1.0)

"""Directions of a crossed pair of line arrays: one sends a fan, the other hears one across it, a little later.

A line array steered to the angle a from its broadside covers the cone d.l = sin a about its axis l. What a sounder
hears in one beam lies where the cone of the transmitter, as it stood when the pulse went out, meets that of the
receiver, as it stands when the echo comes back.

Source: J. R. Hughes Clarke, Multibeam echosounders, in Submarine Geomorphology (Springer, 2018), doi
10.1007/978-3-319-57852-1_3; J. Beaudoin, J. Hughes Clarke and J. Bartlett, Application of surface sound speed
measurements in post-processing for multi-sector multibeam echosounders, Int. Hydrogr. Rev. 5(3), 26-31 (2004).
"""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


def crossing(sender: Array, receiver: Array, sent: Array, heard: Array) -> Array:
    """Unit vector `Array3f` where both cones meet, on the side of receiver x sender (below, for a sender that points
    ahead and a receiver that points to the left).

    Args:
        sender, receiver: `Array3f`, unit vectors along the arrays, at any angle to one another but 0.
        sent, heard: sines of the steering angles from each array's broadside. Cones that do not meet touch.
    """
    g = dr.dot(sender, receiver)
    scale = 1.0 / dr.maximum(1.0 - g * g, 1e-6)
    a, b = (sent - g * heard) * scale, (heard - g * sent) * scale
    inside = dr.sqrt(dr.maximum(1.0 - (a * a + b * b + 2.0 * a * b * g), 0.0))
    return dr.normalize(sender * a + receiver * b + dr.normalize(dr.cross(receiver, sender)) * inside)


def turned(vector: Array, rotation: Array) -> Array:
    """A vector after a rotation by |rotation| [rad] about it (Rodrigues); `Array3f` both."""
    angle2 = dr.squared_norm(rotation)
    angle = dr.sqrt(angle2)
    small = angle2 < 1e-8
    safe = dr.select(small, 1.0, angle)
    s = dr.select(small, 1.0 - angle2 / 6.0, dr.sin(safe) / safe)
    c = dr.select(small, 0.5 - angle2 / 24.0, (1.0 - dr.cos(safe)) / (safe * safe))
    across = dr.cross(rotation, vector)
    return vector + across * s + dr.cross(rotation, across) * c


def aberration(velocity: Array, direction: Array, receiver: Array, speed: Array) -> Array:
    """Part of `heard` that the receiver's own way adds [1]: from where it has got to, the target lies 2 v/c aside.

    Args:
        velocity: of the sounder [m/s], `Array3f` as all vectors here.
        direction: from the place of transmission to the target.
        receiver: along its array.
        speed: of sound [m/s].
    """
    aside = velocity - direction * dr.dot(velocity, direction)
    return dr.dot(aside, receiver) * jit.Float(-2.0 / speed)

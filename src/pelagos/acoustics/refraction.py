"""Rays in water whose sound speed changes with depth: arcs of circles, layer by layer.

Sources: F. B. Jensen, W. A. Kuperman, M. B. Porter, H. Schmidt, Computational Ocean Acoustics (2nd ed., 2011),
Section 3.3.2, doi 10.1007/978-1-4419-8678-8; Snell's law cos(theta)/c = const.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import drjit as dr

from pelagos import jit
from pelagos.jit import Array


def arc_radius(sound_speed: float, gradient: float, angle: float) -> float:
    """Radius [m] of the ray in a linear gradient, c/(g cos theta); `gradient` g [1/s], `angle` theta [rad]."""
    return sound_speed / (abs(gradient) * math.cos(angle))


def bend(direction: Array, curvature: Array, distance: Array) -> Array:
    """The direction of a ray after `distance` [m] in a linear gradient.

    The elevation angle turns towards the slower water: d(theta)/ds = -cos(theta) c'/c; to first order in the distance,
    renormalised.

    Args:
        direction: `Array3f`, unit, z up.
        curvature: c'/c with c' = dc/dz, z up [1/m].
    """
    horizontal = dr.sqrt(direction.x * direction.x + direction.y * direction.y)
    angle = -curvature * horizontal * distance
    s, c = dr.sincos(angle)
    scale = dr.maximum(horizontal, 1e-9)
    up = horizontal * s + direction.z * c
    level = horizontal * c - direction.z * s
    return jit.Array3f(direction.x * level / scale, direction.y * level / scale, up)


@dataclass(frozen=True)
class Arrival:
    """Where a ray is: horizontal distance [m], depth [m], time [s], angle downwards [rad], length of its path [m]."""

    distance: float
    depth: float
    time: float
    angle: float
    length: float


def trace_layers(
    depths: Sequence[float], speeds: Sequence[float], *, source_depth: float, angle: float, distance: float
) -> Arrival:
    """Follow a ray through layers of linear sound speed to a horizontal distance; exact arcs in each layer.

    Args:
        depths: of the profile's points [m], positive down, increasing.
        speeds: sound speed at them [m/s].
        source_depth: [m].
        angle: at the source, positive down [rad].
        distance: horizontal [m].

    The ray turns where Snell's law says so; at the profile's ends it is reflected.
    """
    x, z, t, theta, s = 0.0, source_depth, 0.0, angle, 0.0
    index = _layer(depths, z, theta)
    for _ in range(1_000_000):
        z0, z1 = depths[index], depths[index + 1]
        g = (speeds[index + 1] - speeds[index]) / (z1 - z0)
        c = speeds[index] + g * (z - z0)
        step = _to_edge(z, theta, c, g, z0, z1)
        leg = _leg(theta, c, g, step, distance - x)
        x, z, t, theta, s = x + leg.distance, z + leg.depth, t + leg.time, leg.angle, s + leg.length
        if x >= distance - 1e-9 * max(distance, 1.0):
            return Arrival(x, z, t, theta, s)
        if theta > 0 and abs(z - z1) < 1e-6:
            index, z, theta = (index + 1, z1, theta) if index + 2 < len(depths) else (index, z1, -theta)
        elif theta < 0 and abs(z - z0) < 1e-6:
            index, z, theta = (index - 1, z0, theta) if index > 0 else (index, z0, -theta)
    raise AssertionError("a ray needs more than a million layers")


def _layer(depths: Sequence[float], z: float, theta: float) -> int:
    for i in range(len(depths) - 1):
        if depths[i] <= z < depths[i + 1] or (z == depths[i + 1] and theta <= 0):
            return i
    return len(depths) - 2


def _to_edge(z: float, theta: float, c: float, g: float, z0: float, z1: float) -> float:
    """Angle [rad] at which the ray leaves the layer, or at its turning point (0) inside of it."""
    edge = z1 if theta > 0 or (theta == 0 and g < 0) else z0
    cosine = math.cos(theta) * (c + g * (edge - z)) / c
    if cosine >= 1.0:
        return 0.0
    return math.copysign(math.acos(cosine), theta if theta != 0 else -g)


def _leg(theta: float, c: float, g: float, after: float, left: float) -> Arrival:
    """One arc from angle `theta` to `after`, cut where it has gone `left` [m] to the side; differences, not places."""
    if abs(g) < 1e-12:
        straight = left / math.cos(theta)
        return Arrival(left, left * math.tan(theta), straight / c, theta, straight)
    k = c / (g * math.cos(theta))  # signed radius: x = k (sin theta - sin after), z = k (cos after - cos theta)
    if after == 0.0:
        after = -1e-9 * math.copysign(1.0, theta)
    reach = k * (math.sin(theta) - math.sin(after))
    if reach > left:
        after = math.asin(math.sin(theta) - left / k)
        reach = left
    dz = k * (math.cos(after) - math.cos(theta))
    time = (math.asinh(math.tan(theta)) - math.asinh(math.tan(after))) / g
    return Arrival(reach, dz, time, after, k * (theta - after))

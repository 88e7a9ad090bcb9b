"""The arc of a circle that a ray of sound is where the sound speed changes linearly: its equations, for all tracers.

Exact rays between places (`layered_rays`) follow it by horizontal way, in double precision; rays of sonars
(`refraction`) by length, in single. Angles and heights have one sense: angles above the horizontal with heights that
grow upwards, or angles below it with depths. Every form stays exact where the gradient vanishes. Arguments are Dr.Jit
arrays of either precision, of one shape.

Source: F. B. Jensen, W. A. Kuperman, M. B. Porter, H. Schmidt, Computational Ocean Acoustics (2nd ed., 2011), Section
3.3.2, doi 10.1007/978-1-4419-8678-8; Snell's law cos(theta)/c = const.
"""

from __future__ import annotations

import drjit as dr

from pelagos.jit import Array


def snell_invariant(cosine: Array, speed: Array) -> Array:
    """Slowness cos(theta)/c [s/m] that a ray keeps through all levels; `speed` c where it is [m/s]."""
    return cosine / speed


def curvature(gradient: Array, slowness: Array) -> Array:
    """d(theta)/ds of an arc [rad/m], which is also d(sin theta)/dx: -g cos(theta)/c.

    Args:
        gradient: g = dc/dz [1/s].
        slowness: see `snell_invariant` [s/m].
    """
    return -gradient * slowness


def rotated(sine: Array, cosine: Array, turn: Array) -> tuple[Array, Array]:
    """Sine and cosine of an angle that has grown by `turn` [rad]."""
    s, c = dr.sincos(turn)
    return dr.fma(sine, c, cosine * s), dr.fma(cosine, c, -sine * s)


def turn_between(slowness: Array, change: Array, middle: Array) -> Array:
    """Turn [rad] over a `change` of sound speed [m/s], by Snell's law in whatever layers lie between.

    cos(theta1) - cos(theta0) is the slowness times the change, and -2 sin(middle) sin(turn/2); third order in the turn.

    Args:
        middle: sine of the mean of both angles.
    """
    half = -0.5 * slowness * change / middle
    return 2.0 * half * (1.0 + half * half * (1.0 / 6.0))


def chord_of(length: Array, turn: Array) -> Array:
    """Distance between both ends of an arc [m]: L sin(turn/2)/(turn/2), for turns below 1 rad (2e-5 of it there)."""
    x2 = 0.25 * turn * turn
    return length * (1.0 - x2 * (1.0 / 6.0) * (1.0 - x2 * 0.05))


def length_of(chord: Array, curve: Array) -> Array:
    """Length of an arc [m] of a chord [m] and a `curvature` [rad/m]: the inverse of `chord_of`."""
    y = 0.5 * chord * dr.abs(curve)
    y2 = y * y
    series = 1.0 + y2 * (1.0 / 6 + y2 * (3.0 / 40 + y2 * (15.0 / 336 + y2 * 105.0 / 3456)))
    safe = dr.clip(dr.select(y2 < 1e-4, 0.5, y), 0.0, 1.0)
    return chord * dr.select(y2 < 1e-4, series, dr.asin(safe) / safe)


def sine_after(sine: Array, curve: Array, way: Array) -> Array:
    """Sine of the angle after a horizontal way [m] that meets no turning back: linear in it."""
    return dr.clip(sine + curve * way, -1.0, 1.0)


def cosine_after(sines: tuple[Array, Array], cosine: Array, curve: Array, way: Array) -> Array:
    """Cosine of the angle after a horizontal way [m], from the sines at both ends and the cosine before: exact for rays
    that are nearly upright too, whose sine has lost it."""
    return dr.sqrt(dr.maximum(cosine * cosine - curve * way * (sines[0] + sines[1]), 0.0))


def rise_over(way: Array, sines: tuple[Array, Array], cosines: tuple[Array, Array]) -> Array:
    """Change of height [m] over a horizontal way [m], from sine and cosine of the angle at both ends: the chord points
    along the mean of both angles."""
    return way * (sines[0] + sines[1]) / dr.maximum(cosines[0] + cosines[1], 1e-300)


def duration(way: Array, cosines: tuple[Array, Array], curve: Array, slowness: Array) -> Array:
    """Travel time [s] over a horizontal way [m]: (atanh(sin theta1) - atanh(sin theta0))/|g|, without differences.

    1 - sin theta0 sin theta1 is half the sum of the squares of both cosines and of the change of the sine: so it stays
    exact for rays that are nearly upright.
    """
    bend = curve * way
    across = dr.maximum(0.5 * (dr.square(cosines[0]) + dr.square(cosines[1]) + bend * bend), 1e-300)
    return slowness * way / across * _atanh_ratio(bend / across)


def _atanh_ratio(u: Array) -> Array:
    """atanh(u)/u, also at 0."""
    u2 = u * u
    series = 1.0 + u2 * (1.0 / 3 + u2 * (1.0 / 5 + u2 * (1.0 / 7 + u2 / 9.0)))
    safe = dr.clip(dr.select(u2 < 1e-4, 0.5, u), -1.0 + 1e-16, 1.0 - 1e-16)
    return dr.select(u2 < 1e-4, series, 0.5 * dr.log((1.0 + safe) / (1.0 - safe)) / safe)

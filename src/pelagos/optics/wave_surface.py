"""Intersection of a line of sight with the sea surface: the ocean's waves on grids around each camera, met by marching.

The surface is that of the forces and of every other sensor, `Ocean.elevation`, linear between the nodes of the grids (a
few centimetres off near the camera). Beyond the grids it is the mean level.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.swell import REACH, Swell, elevation_at

_STEEP: Final = 0.45  # slope that waves do not exceed: how far a ray can go before it may meet them
_STEPS: Final = 80  # at most
_SHORTEST: Final = 0.2  # step [m]
_GROWTH: Final = 0.025  # shortest step over the way so far
_ROUNDS: Final = 4  # of regula falsi between the last two places
_ROOM: Final = 0.01  # [m], above the crests and below the troughs
_FAR: Final = 1e4  # [m]


def way_to_surface(swell: Swell, origin: Array, direction: Array, lane: Array) -> Array:
    """Way to the first place where a ray comes through the surface [m], `Float`; 1e4 where it does not.

    Args:
        swell: grids, three a lane.
        origin: `Array3f64` world NWU [m].
        direction: unit `Array3f`.
        lane: `UInt32`, row of `swell` of each ray.
    """
    x0 = jit.Float(origin.x - dr.gather(jit.Float64, swell.corner_x, lane))
    y0 = jit.Float(origin.y - dr.gather(jit.Float64, swell.corner_y, lane))
    z0 = jit.Float(origin.z)
    d = direction

    def over(t: Array) -> Array:
        """Height of the ray above the surface [m]."""
        return z0 + d.z * t - elevation_at(swell, x0 + d.x * t, y0 + d.y * t, lane)

    low, high, mean = (dr.gather(jit.Float, a, lane) for a in (swell.lowest, swell.highest, swell.mean))
    inverse = 1 / dr.select(dr.abs(d.z) < 1e-6, dr.select(d.z < 0, jit.Float(-1e-6), 1e-6), d.z)
    to_low, to_high = (low - _ROOM - z0) * inverse, (high + _ROOM - z0) * inverse
    first = dr.clip(dr.minimum(to_low, to_high), 0, 1.5 * REACH)
    last = dr.clip(dr.maximum(to_low, to_high), 0, 1.5 * REACH)
    start = over(first)
    above = start > 0
    closing = 1 / (dr.abs(d.z) + _STEEP * dr.sqrt(dr.maximum(1 - dr.square(d.z), 0)))

    def comes_through(k: Array, near: Array, gap: Array, far: Array, beyond: Array, found: Array) -> tuple[Array, ...]:
        step = dr.maximum(dr.abs(gap) * closing, _SHORTEST + _GROWTH * near)
        t = dr.minimum(near + step, last)
        height = over(t)
        comes = (height > 0) != above
        far, beyond = dr.select(comes, t, far), dr.select(comes, height, beyond)
        near, gap = dr.select(comes, near, t), dr.select(comes, gap, height)
        return k + 1, near, gap, far, beyond, found | comes

    state = (jit.UInt32(0), jit.Float(first), jit.Float(start), jit.Float(first), jit.Float(start), jit.Bool(False))
    state = dr.while_loop(
        state,
        lambda k, near, gap, far, beyond, found: (k < _STEPS) & ~found & (near < last),
        comes_through,
        mode="symbolic",
    )
    _, near, gap, far, beyond, found = state
    for _ in range(_ROUNDS):
        share = gap / dr.select(dr.abs(gap - beyond) < 1e-9, 1e-9, gap - beyond)
        t = near + (far - near) * dr.clip(share, 0.05, 0.95)
        height = over(t)
        same = (height > 0) == above
        near, gap = dr.select(same, t, near), dr.select(same, height, gap)
        far, beyond = dr.select(same, far, t), dr.select(same, beyond, height)
    met = near + (far - near) * dr.clip(gap / dr.select(dr.abs(gap - beyond) < 1e-9, 1e-9, gap - beyond), 0, 1)
    flat = (mean - z0) * inverse  # the level surface behind the waves
    behind = dr.select((flat > last) & (above == (d.z < 0)), flat, _FAR)
    return dr.minimum(dr.select(found, met, behind), _FAR)

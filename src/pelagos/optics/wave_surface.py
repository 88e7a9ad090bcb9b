"""Where a line of sight meets the sea surface: the ocean's waves on the grid around each camera, met by marching.

The surface is that of the forces and of every other sensor, `Ocean.elevation`, linear between the nodes of the grid (a
centimetre off in sea state 6). Beyond the grid it runs out to the mean level within some ten metres.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.caustics import NODE_STEP, NODES, Swell

_MARCH: Final = 14  # places along a ray at which it may have come through the surface
_ROUNDS: Final = 3  # of regula falsi between two of them
_FADE: Final = 10.0  # [m], in which the waves run out beyond the grid
_ROOM: Final = 0.01  # [m], above the crests and below the troughs
_FAR: Final = 1e4  # [m]


def elevation_at(swell: Swell, x: Array, y: Array, lane: Array) -> Array:
    """Height of the surface over z = 0 [m] at places x, y `Float` relative to the corner of the lane's grid [m]."""
    u, v = x * (1 / NODE_STEP), y * (1 / NODE_STEP)
    inside_u, inside_v = dr.clip(u, 0, NODES - 1.001), dr.clip(v, 0, NODES - 1.001)
    i, j = jit.UInt32(inside_u), jit.UInt32(inside_v)
    a, b = inside_u - jit.Float(i), inside_v - jit.Float(j)
    base = (lane * NODES + i) * NODES + j
    z00, z01, z10, z11 = (dr.gather(jit.Float, swell.elevation, base + k) for k in (0, 1, NODES, NODES + 1))
    height = dr.lerp(dr.lerp(z00, z01, b), dr.lerp(z10, z11, b), a)
    beyond = (dr.square(u - inside_u) + dr.square(v - inside_v)) * (NODE_STEP / _FADE) ** 2
    mean = dr.gather(jit.Float, swell.mean, lane)
    return dr.lerp(mean, height, dr.exp(-beyond))


def way_to_surface(swell: Swell, origin: Array, direction: Array, lane: Array) -> Array:
    """Way to the first place where a ray comes through the surface [m], `Float`; 1e4 where it does not.

    Args:
        swell: grids, one a lane.
        origin: `Array3f64` world NWU [m].
        direction: unit `Array3f`.
        lane: `UInt32`, row of `swell` of each ray.
    """
    x0 = jit.Float(origin.x - dr.gather(jit.Float64, swell.corner_x, lane))
    y0 = jit.Float(origin.y - dr.gather(jit.Float64, swell.corner_y, lane))
    z0 = jit.Float(origin.z)
    d = direction

    def over(t: Array) -> Array:
        """How far the ray is above the surface [m]."""
        return z0 + d.z * t - elevation_at(swell, x0 + d.x * t, y0 + d.y * t, lane)

    low, high, mean = (dr.gather(jit.Float, a, lane) for a in (swell.lowest, swell.highest, swell.mean))
    inverse = 1 / dr.select(dr.abs(d.z) < 1e-6, dr.select(d.z < 0, jit.Float(-1e-6), 1e-6), d.z)
    to_low, to_high = (low - _ROOM - z0) * inverse, (high + _ROOM - z0) * inverse
    span = (NODES - 1) * NODE_STEP + _FADE  # from anywhere inside to where only the mean level is left
    first = dr.clip(dr.minimum(to_low, to_high), 0, span)
    last = dr.clip(dr.maximum(to_low, to_high), 0, span)
    start = over(first)
    above = start > 0

    def comes_through(k: Array, near: Array, gap: Array, far: Array, beyond: Array, found: Array) -> tuple[Array, ...]:
        part = (jit.Float(k) + 1) * (1 / _MARCH)
        t = dr.lerp(first, last, part * part)  # closer steps near the camera
        height = over(t)
        comes = (height > 0) != above
        far, beyond = dr.select(comes, t, far), dr.select(comes, height, beyond)
        near, gap = dr.select(comes, near, t), dr.select(comes, gap, height)
        return k + 1, near, gap, far, beyond, found | comes

    state = (jit.UInt32(0), jit.Float(first), jit.Float(start), jit.Float(first), jit.Float(start), jit.Bool(False))
    state = dr.while_loop(
        state, lambda k, near, gap, far, beyond, found: (k < _MARCH) & ~found, comes_through, mode="symbolic"
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

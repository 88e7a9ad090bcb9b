"""The sea surface as sound meets it from below: waves and tide of the ocean, on a grid around each sonar."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.raycast.rays import Hits, Rays

if TYPE_CHECKING:
    from pelagos.ocean.ocean import Ocean

SEA_SURFACE_LABEL: Final = 0
SEA_SURFACE_INSTANCE: Final = 0xFFFF
_NODES: Final = 49  # of the grid, each way
_STEP: Final = 2.5  # [m], at most between them
_MARCH: Final = 12  # places along a ray at which it may have come through the surface
_ROUNDS: Final = 3  # of regula falsi between two of them
_DOWN: Final = math.sin(math.radians(-25.0))  # beams that all look lower than this see no waves


@jit.struct
class Sea:
    """The surface around each sonar, one grid a lane: a Dr.Jit struct.

    Attributes:
        elevation: `Float`, lanes by nodes by nodes, height over `level` [m]; y fastest.
        level: `Float`, height of the tide over the mean [m].
        highest: `Float`, largest absolute value of each lane's elevations [m].
        corner_x, corner_y: `Float64`, world, of each grid [m].
        step: distance of nodes [m].
        waves: whether there is a grid; else the surface is flat.
    """

    elevation: Array
    level: Array
    highest: Array
    corner_x: Array
    corner_y: Array
    step: float
    waves: bool

    @property
    def size_key(self) -> int:
        """Number of lanes."""
        return len(self.level)


def looks_up(directions: NDArray[np.floating[Any]]) -> bool:
    """Whether any of the unit vectors `(r, 3)`, in the body frame, rises above -25 deg."""
    return bool((directions[:, 2] > _DOWN).any())


def sea_around(ocean: Ocean, position: Array, t: Array, copy: Array | None = None, *, reach: float, waves: bool) -> Sea:
    """The surface at times `t` [s], out to `reach` [m] from each `position`; beyond the grid its mirror image goes on.

    `waves`: follow the ocean's waves; else only its tide. `copy`: of the fleet, in which each place is.
    """
    level = jit.Float64(0.0) if ocean.tide is None else ocean.tide.level(t)
    level = level + dr.zeros(jit.Float64, dr.width(position))
    if not waves or ocean.waves is None:
        zero = dr.zeros(jit.Float64, dr.width(position))
        return Sea(jit.Float(0), jit.Float(level), jit.Float(0), zero, zero, 1.0, False)
    step = min(2.0 * reach / (_NODES - 1), _STEP)
    half = 0.5 * (_NODES - 1) * step
    corner_x = dr.round((position.x - half) / step) * step
    corner_y = dr.round((position.y - half) / step) * step
    dr.eval(corner_x, corner_y, level)
    size = _NODES * _NODES
    node = dr.arange(jit.UInt32, dr.width(position) * size)
    lane = node // size
    x = dr.gather(jit.Float64, corner_x, lane) + jit.Float64(node % size // _NODES) * step
    y = dr.gather(jit.Float64, corner_y, lane) + jit.Float64(node % _NODES) * step
    when = dr.gather(jit.Float64, t, lane) if dr.width(t) > 1 else t
    sea = ocean.sea(dr.width(node), None if copy is None else dr.gather(jit.UInt32, copy, lane))
    assert sea is not None
    elevation = jit.Float(sea.elevation(x, y, when))
    dr.eval(elevation)
    highest = dr.block_reduce(dr.ReduceOp.Max, dr.abs(elevation), size)
    dr.eval(highest)
    return Sea(elevation, jit.Float(level), highest, corner_x, corner_y, step, True)


def with_sea_surface(hits: Hits, rays: Rays, row: Array, sea: Sea | None = None, lane: Array | None = None) -> Hits:
    """Let the sea surface end rays that reach it from below.

    Args:
        hits: what rays hit besides; changed in place.
        rays: see `Rays`.
        row: of the surface in the table of materials.
        sea, lane: the surface and each ray's grid in it; without, the mean surface.
    """
    up, depth = rays.direction.z, -jit.Float(rays.origin.z)
    if sea is not None and lane is not None:
        depth += dr.gather(jit.Float, sea.level, lane)
    down = jit.Array3f(0, 0, -1)
    furthest = dr.minimum(hits.t, rays.max_range)
    if sea is None or lane is None or not sea.waves:
        reach = depth / dr.maximum(up, 1e-6)
        meets = (up > 1e-6) & (depth > 0.0) & (reach < furthest)
    else:
        reach, meets, slope_x, slope_y = _meet_waves(sea, lane, rays, depth, furthest)
        scale = dr.rsqrt(1.0 + slope_x * slope_x + slope_y * slope_y)
        down = jit.Array3f(slope_x * scale, slope_y * scale, -scale)
        away = dr.dot(down, rays.direction) > 0.0  # met from behind, through a crest
        down = dr.select(away, -down, down)
    hits.t = dr.select(meets, reach, hits.t)
    hits.valid |= meets
    hits.position = dr.select(meets, rays.origin + jit.Array3f64(rays.direction) * jit.Float64(reach), hits.position)
    hits.normal = dr.select(meets, down, hits.normal)
    hits.shading_normal = dr.select(meets, down, hits.shading_normal)
    hits.label = dr.select(meets, SEA_SURFACE_LABEL, hits.label)
    hits.instance = dr.select(meets, SEA_SURFACE_INSTANCE, hits.instance)
    hits.material = dr.select(meets, row, hits.material)
    hits.velocity = dr.select(meets, 0.0, hits.velocity)
    return hits


def _meet_waves(sea: Sea, lane: Array, rays: Rays, depth: Array, furthest: Array) -> tuple[Array, Array, Array, Array]:
    """Way to the first place where a ray comes through the waves [m], whether it does, and the slopes there.

    Rays are followed in even steps between the heights of the lowest trough and the highest crest.
    """
    x0 = jit.Float(rays.origin.x - dr.gather(jit.Float64, sea.corner_x, lane))
    y0 = jit.Float(rays.origin.y - dr.gather(jit.Float64, sea.corner_y, lane))
    highest = dr.gather(jit.Float, sea.highest, lane)
    d = rays.direction

    def below(t: Array) -> Array:
        return depth - d.z * t + _elevation(sea, lane, x0 + d.x * t, y0 + d.y * t)[0]

    inverse = 1.0 / dr.select(dr.abs(d.z) < 1e-4, 1e-4, d.z)
    low, high = (depth - highest) * inverse, (depth + highest) * inverse
    first = dr.clip(dr.minimum(low, high), 0.0, furthest)
    last = dr.clip(dr.maximum(low, high), 0.0, furthest)
    step = (last - first) * (1.0 / _MARCH)
    near, gap = jit.Float(first), below(first)
    wet = gap > 0.0  # rays that begin in the air see no surface from below
    far, beyond, found = jit.Float(near), jit.Float(gap), jit.Bool(False)
    for k in range(1, _MARCH + 1):
        t = first + k * step
        height = below(t)
        comes = ~found & (height <= 0.0)
        far, beyond = dr.select(comes, t, far), dr.select(comes, height, beyond)
        found |= comes
        near, gap = dr.select(found, near, t), dr.select(found, gap, height)
    for _ in range(_ROUNDS):
        t = near + (far - near) * dr.clip(gap / dr.maximum(gap - beyond, 1e-9), 0.05, 0.95)
        height = below(t)
        wetter = height > 0.0
        near, gap = dr.select(wetter, t, near), dr.select(wetter, height, gap)
        far, beyond = dr.select(wetter, far, t), dr.select(wetter, beyond, height)
    reach = near + (far - near) * dr.clip(gap / dr.maximum(gap - beyond, 1e-9), 0.0, 1.0)
    _, slope_x, slope_y = _elevation(sea, lane, x0 + d.x * reach, y0 + d.y * reach)
    return reach, found & wet & (last > first), slope_x, slope_y


def _elevation(sea: Sea, lane: Array, x: Array, y: Array) -> tuple[Array, Array, Array]:
    """Height over the level [m] and its slopes at a place relative to the grid's corner [m], bilinear."""
    u, turn_u = _folded(x * (1.0 / sea.step))
    v, turn_v = _folded(y * (1.0 / sea.step))
    i, j = dr.minimum(jit.UInt32(u), _NODES - 2), dr.minimum(jit.UInt32(v), _NODES - 2)
    a, b = u - jit.Float(i), v - jit.Float(j)
    base = (lane * _NODES + i) * _NODES + j
    z00, z01, z10, z11 = (dr.gather(jit.Float, sea.elevation, base + k) for k in (0, 1, _NODES, _NODES + 1))
    low, high = dr.lerp(z00, z01, b), dr.lerp(z10, z11, b)
    slope_x = (high - low) * (1.0 / sea.step) * turn_u
    slope_y = dr.lerp(z01 - z00, z11 - z10, a) * (1.0 / sea.step) * turn_v
    return dr.lerp(low, high, a), slope_x, slope_y


def _folded(place: Array) -> tuple[Array, Array]:
    """A place in 0 .. nodes - 1, reflected at both ends as often as needed, and its direction there, 1 or -1."""
    span = _NODES - 1.0
    turns = place * (0.5 / span)
    whole = 2.0 * span * (turns - dr.floor(turns))
    back = whole > span
    return dr.clip(dr.select(back, 2.0 * span - whole, whole), 0.0, span), dr.select(back, jit.Float(-1), 1.0)

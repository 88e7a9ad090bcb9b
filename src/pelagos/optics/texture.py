"""Texture of materials close up: colour and bumps as pure functions of the place in the world; no pictures are
stored.

Built from value noise (K. Perlin's lattice noise with values instead of gradients) and its exact derivative. Detail
finer than a pixel fades out, so that nothing flickers far away.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from typing import Final

import drjit as dr
import numpy as np

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.water import Triple


@dataclass(frozen=True)
class Pattern:
    """Pattern of one kind of surface. Contrasts are shares of the albedo.

    Attributes:
        coarse: size of slow variation [m]; the material's own texture scale sets the fine detail.
        patch: contrast of slow variation of brightness.
        grain: contrast of fine variation and of specks.
        bump: steepness of the relief.
        stretch: factor on lengths along world z (wood grain, streaks).
        ripple: steepness of parallel ripples on level ground, one texture scale long.
        layer: share of the surface covered by a second colour (growth, rust, litter).
        layer_albedo: its linear colour.
        seams: darkness of seams in a square grid.
        seam_length: mesh of that grid [m].
        own_mean, layer_mean: shares of the material's and of the second colour in the mean albedo, by sampling.
        facing: mean cosine between the relief and the surface, likewise.
    """

    coarse: float = 0.5
    patch: float = 0.25
    grain: float = 0.15
    bump: float = 0.3
    stretch: float = 1.0
    ripple: float = 0.0
    layer: float = 0.0
    layer_albedo: Triple = (0.05, 0.06, 0.03)
    seams: float = 0.0
    seam_length: float = 2.5
    own_mean: float = 1.0
    layer_mean: float = 0.0
    facing: float = 1.0


_GROWTH: Final = (0.055, 0.06, 0.028)
_LITTER: Final = (0.13, 0.115, 0.08)
PATTERNS: Final[dict[str, Pattern]] = {  # looks, not measurements: all assumed
    "none": Pattern(patch=0.0, grain=0.0, bump=0.0),
    "grain": Pattern(
        0.8, patch=0.3, grain=0.3, bump=0.3, layer=0.2, layer_albedo=(0.08, 0.075, 0.05), own_mean=0.83,
        layer_mean=0.18, facing=0.99,
    ),
    "ripples": Pattern(
        0.9, patch=0.28, grain=0.3, bump=0.25, ripple=0.42, layer=0.2, layer_albedo=_LITTER, own_mean=0.87,
        layer_mean=0.13, facing=0.98,
    ),
    "pebbles": Pattern(
        0.5, patch=0.3, grain=0.7, bump=0.9, layer=0.3, layer_albedo=(0.12, 0.11, 0.10), own_mean=0.71,
        layer_mean=0.29, facing=0.91,
    ),
    "concrete": Pattern(
        0.6, patch=0.3, grain=0.25, bump=0.25, layer=0.42, layer_albedo=_GROWTH, seams=0.5, own_mean=0.56,
        layer_mean=0.42, facing=0.99,
    ),
    "rust": Pattern(
        0.3, patch=0.5, grain=0.35, bump=0.5, layer=0.5, layer_albedo=(0.045, 0.03, 0.02), own_mean=0.41,
        layer_mean=0.59, facing=0.96,
    ),
    "planks": Pattern(
        0.25, patch=0.45, grain=0.25, bump=0.5, stretch=6.0, layer=0.4, layer_albedo=_GROWTH, own_mean=0.59,
        layer_mean=0.42, facing=0.97,
    ),
    "bricks": Pattern(
        0.6, patch=0.4, grain=0.25, bump=0.3, layer=0.25, layer_albedo=_GROWTH, seams=0.6, seam_length=0.22,
        own_mean=0.71, layer_mean=0.18, facing=0.99,
    ),
    "growth": Pattern(
        0.4, patch=0.6, grain=0.5, bump=1.1, layer=0.45, layer_albedo=(0.16, 0.10, 0.05), own_mean=0.455,
        layer_mean=0.545, facing=0.86,
    ),
    "blades": Pattern(0.3, patch=0.4, grain=0.4, bump=0.7, stretch=4.0, facing=0.96),
}  # fmt: skip
"""By `Material.texture`."""


@jit.struct
class Looks:
    """Colour and pattern of each material, a Dr.Jit struct: albedos are `Array3f`, the others `Float`."""

    albedo: Array
    scale: Array
    coarse: Array
    patch: Array
    grain: Array
    bump: Array
    stretch: Array
    ripple: Array
    layer: Array
    layer_albedo: Array
    seams: Array
    seam_length: Array
    own_mean: Array
    layer_mean: Array
    facing: Array


def looks(albedo: Array, scale: Array, kinds: Sequence[str]) -> Looks:
    """Rows for materials.

    Args:
        albedo: `Array3f`, linear.
        scale: `Float`, texture scale [m].
        kinds: kind of texture of each, a key of `PATTERNS`.
    """
    rows = [PATTERNS[kind] for kind in kinds]
    columns = {f.name: [getattr(r, f.name) for r in rows] for f in fields(Pattern)}
    layer_albedo = np.array(columns.pop("layer_albedo"), dtype=np.float32).T
    table = Looks(
        albedo=jit.Array3f(albedo),
        scale=jit.Float(scale),
        layer_albedo=jit.Array3f(np.ascontiguousarray(layer_albedo)),
        **{name: jit.Float(np.array(values, dtype=np.float32)) for name, values in columns.items()},
    )
    jit.align(table)
    return table


def mean_albedo(table: Looks, material: Array, active: Array) -> Array:
    """Colour of materials from far away, `Array3f`."""

    def row(column: Array) -> Array:
        return dr.gather(type(column), column, material, active)

    return row(table.albedo) * row(table.own_mean) + row(table.layer_albedo) * row(table.layer_mean)


def mean_facing(table: Looks, material: Array, active: Array) -> Array:
    """Share of a beam's light that their relief leaves to materials, `Float`: facets face it less than the surface."""
    return dr.gather(jit.Float, table.facing, material, active)


def surface_look(
    table: Looks, material: Array, place: Array, normal: Array, footprint: Array, active: Array
) -> tuple[Array, Array]:
    """Colour and direction of a surface point.

    Args:
        table: rows of the materials.
        material: `UInt32` row of each point.
        place: `Array3f`, world position, or any frame that stays with the surface [m].
        normal: `Array3f`, unit.
        footprint: width of a pixel on the surface [m]; finer detail is left out.
        active: `Bool`, lanes that matter.

    Returns:
        Albedo `Array3f` (linear, 0 .. 1) and bumpy unit normal `Array3f`.
    """

    def row(column: Array) -> Array:
        return dr.gather(type(column), column, material, active)

    scale = dr.select(active, row(table.scale), 1)
    coarse = dr.select(active, row(table.coarse), 1)
    squeeze = dr.rcp(dr.select(active, row(table.stretch), 1))
    p = jit.Array3f(place.x, place.y, place.z * squeeze)
    slow, slow_d = value_noise(p * (0.33 / coarse))
    middle, middle_d = _turned_noise(p * (1.45 / coarse) + 17.3)
    fine, fine_d = _where_kept(footprint / scale, active, lambda: _turned_noise(p / scale + 5.1))
    speck, _ = _where_kept(footprint * 4.3 / scale, active, lambda: value_noise(p * (4.3 / scale) + 41.7))
    bright = (1 + row(table.patch) * (0.9 * slow + 0.5 * middle)) * (1 + row(table.grain) * (fine + 0.9 * speck))
    cover = row(table.layer)
    covered = _step(0.55 * slow + 0.45 * middle + 0.2 * fine + 0.08 * speck + (2 * cover - 1) * 0.62, 0.3)
    covered = dr.select(cover > 0, covered, 0)
    seam_length = dr.select(active, row(table.seam_length), 1)
    seam = row(table.seams) * _seams(place, seam_length, normal, footprint)
    ripple, crest = _ripples(place / scale, slow, middle, _keep(footprint * 2 / scale))
    level = dr.square(dr.clip(normal.z, 0, 1)) * row(table.ripple) * (1 - 0.7 * covered)
    albedo = dr.lerp(row(table.albedo), row(table.layer_albedo), covered) * dr.maximum(bright, 0.15)
    albedo = dr.clip(albedo * (1 - seam) * (1 + 0.35 * level * crest), 0.005, 0.95)
    relief = (0.16 * slow_d + 0.32 * middle_d + 0.26 * fine_d) * (row(table.bump) * (1 + 0.6 * covered))
    relief = jit.Array3f(relief.x + level * ripple.x, relief.y + level * ripple.y, relief.z * squeeze)
    along = relief - normal * dr.dot(normal, relief)
    return albedo, dr.normalize(normal - along)


def _ripples(p: Array, slow: Array, middle: Array, kept: Array) -> tuple[Array, Array]:
    """Slope and height (-1 .. 1) of sand ripples one unit long, steeper on one side, wavering."""
    s, c = dr.sincos(2 * math.pi * (0.94 * p.x + 0.34 * p.y) + 5.5 * slow + 2.2 * middle)
    kept = kept * dr.clip(0.55 + 0.9 * slow - 0.5 * middle, 0.08, 1)
    height = s + 0.56 * s * c
    rise = (c + 0.56 * (c * c - s * s)) * kept
    return jit.Array2f(0.94 * rise, 0.34 * rise), height * kept


def _seams(place: Array, length: Array, normal: Array, footprint: Array) -> Array:
    """1 on the dark lines of a square grid, on the faces that its planes cut."""
    half = 0.004 + 0.006 * length + 0.5 * footprint
    lines = jit.Float(0)
    for axis in range(3):
        u = place[axis] / length
        distance = dr.abs(u - dr.round(u)) * length
        line = dr.clip(1.5 - distance / half, 0, 1)
        lines = dr.maximum(lines, dr.select(dr.abs(normal[axis]) < 0.7, line, 0))
    return lines * dr.minimum((0.004 + 0.006 * length) / half * 2, 1)


def _keep(pixel: Array) -> Array:
    """1 where a pixel is much smaller than the detail (width 1), 0 where it is larger."""
    return dr.clip(1.6 - 1.2 * pixel, 0, 1)


def _where_kept(pixel: Array, active: Array, noise: Callable[[], tuple[Array, Array]]) -> tuple[Array, Array]:
    """Noise faded out by `_keep`, and not worked out where nothing of it is left."""
    kept = dr.select(active, _keep(pixel), 0)

    def faded(kept: Array) -> tuple[Array, Array]:
        value, gradient = noise()
        return value * kept, gradient * kept

    value, gradient = dr.if_stmt((kept,), kept > 0, faded, lambda _: (jit.Float(0), jit.Array3f(0)), mode="symbolic")
    return value, gradient


def _step(x: Array, width: float) -> Array:
    t = dr.clip(x / width + 0.5, 0, 1)
    return t * t * (3 - 2 * t)


def value_noise(p: Array) -> tuple[Array, Array]:
    """Smooth noise -1 .. 1 with mean 0 at `p` `Array3f`, one random value per unit cube's corner, and its gradient."""
    cell = dr.floor(p)
    f = p - cell
    w = f * f * f * (f * (f * 6 - 15) + 10)
    dw = 30 * f * f * (f * (f - 2) + 1)
    x, y, z = (jit.UInt32(jit.Int32(c)) for c in cell)
    hx, hy, hz = x * 0x8DA6B343, y * 0xD8163841, z * 0xCB1AB31F
    hx1, hy1, hz1 = hx + 0x8DA6B343, hy + 0xD8163841, hz + 0xCB1AB31F
    c000, c100 = hashed(hx ^ hy ^ hz), hashed(hx1 ^ hy ^ hz)
    c010, c110 = hashed(hx ^ hy1 ^ hz), hashed(hx1 ^ hy1 ^ hz)
    c001, c101 = hashed(hx ^ hy ^ hz1), hashed(hx1 ^ hy ^ hz1)
    c011, c111 = hashed(hx ^ hy1 ^ hz1), hashed(hx1 ^ hy1 ^ hz1)
    x00, x10, x01, x11 = (dr.lerp(a, b, w.x) for a, b in ((c000, c100), (c010, c110), (c001, c101), (c011, c111)))
    y0, y1 = dr.lerp(x00, x10, w.y), dr.lerp(x01, x11, w.y)
    dx0, dx1 = dr.lerp(c100 - c000, c110 - c010, w.y), dr.lerp(c101 - c001, c111 - c011, w.y)
    gradient = jit.Array3f(dr.lerp(dx0, dx1, w.z), dr.lerp(x10 - x00, x11 - x01, w.z), y1 - y0) * dw
    return dr.lerp(y0, y1, w.z), gradient


def _turned_noise(p: Array) -> tuple[Array, Array]:
    """`value_noise` on axes of its own, so that the cubes of two octaves do not line up."""
    x, y, z = p
    value, (gx, gy, gz) = value_noise(
        jit.Array3f(0.36 * x + 0.48 * y - 0.8 * z, 0.6 * y - 0.8 * x, 0.48 * x + 0.64 * y + 0.6 * z)
    )
    gradient = jit.Array3f(0.36 * gx - 0.8 * gy + 0.48 * gz, 0.48 * gx + 0.6 * gy + 0.64 * gz, -0.8 * gx + 0.6 * gz)
    return value, gradient


def hashed(h: Array) -> Array:
    """A 32-bit hash (finaliser of H. S. Warren's kind: multiply and fold) as a number -1 .. 1."""
    h = (h ^ (h >> 15)) * 0x2C1B3C6D
    h = (h ^ (h >> 12)) * 0x297A2D39
    h ^= h >> 15
    return jit.Float(jit.Int32(h)) * 2.0**-31

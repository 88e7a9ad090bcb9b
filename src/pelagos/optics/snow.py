"""Marine snow: pale flakes that hang in the water near the eye, each at its own place in the world.

A flake lives in a cube of water, if the cube's number says so. A ray looks into the cubes that it passes at a few
distances, each farther by the same factor; flakes beyond a few metres are too small to be seen one by one, and belong
to the water's scattering.
"""

from __future__ import annotations

from typing import Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.texture import hashed

CELL: Final = 0.2  # [m]
ALBEDO: Final = 0.5  # assumed
_NEAREST: Final = 0.25  # [m]
_FACTOR: Final = 1.35
_SHELLS: Final = 8  # out to 2 m
_RADIUS: Final = 0.0012  # [m], of the largest; assumed


def flakes(place: Array, direction: Array, reach: Array, per_m3: float, pixel_angle: float) -> tuple[Array, Array]:
    """Share of each pixel that a flake covers, and how far away it is [m].

    Args:
        place: of the camera, `Array3f`, world [m].
        direction: of the rays, `Array3f`.
        reach: length of the ray in water, `Float` [m].
        per_m3: flakes in a cubic metre.
        pixel_angle: angle between neighbouring pixels [rad].
    """
    cover, where = jit.Float(0), jit.Float(1)
    distance = _NEAREST
    for _ in range(_SHELLS):
        cell = dr.floor((place + direction * distance) / CELL)
        x, y, z = (jit.UInt32(jit.Int32(c)) for c in cell)
        seed = x * 0x8DA6B343 ^ y * 0xD8163841 ^ z * 0xCB1AB31F
        draws = [0.5 + 0.5 * hashed(seed + (k * 0x9E3779B9 & 0xFFFFFFFF)) for k in range(5)]
        centre = (cell + jit.Array3f(*draws[:3])) * CELL - place
        along = dr.dot(centre, direction)
        off = dr.norm(centre - along * direction)
        size = _RADIUS * (0.3 + 0.7 * draws[3])
        pixel = dr.maximum(along, 0.1) * pixel_angle
        seen = dr.clip((dr.maximum(size, 0.5 * pixel) - off) / pixel + 0.5, 0, 1)
        seen *= dr.minimum(1, dr.square(2 * size / pixel))
        seen = dr.select((along > 0.1) & (along < reach) & (draws[4] < per_m3 * CELL**3), seen, 0)
        where = dr.select(seen > cover, along, where)
        cover = dr.maximum(cover, seen)
        distance *= _FACTOR
    return cover, where

"""Shafts of light in a picture: followed along one line of sight in every square of pixels."""

from __future__ import annotations

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.light_shafts import shafts
from pelagos.sensors.camera.picture.camera_rays import Frame, ViewConfig
from pelagos.sensors.camera.picture.pixel_blocks import around, size, square_pixels, stratum
from pelagos.sensors.camera.picture.pixel_order import Pixels, Tiling
from pelagos.sensors.camera.picture.scenery import Scenery, by_ray


def shaft_squares(scenery: Scenery, frame: Frame[ViewConfig]) -> Array:
    """Values of `shafts` for each square of all images, `Array4f`, row by row; not worked out yet."""
    where, x, y = square_pixels(frame.tiling, frame.images)
    image = where.image
    rays = frame.rays(where, scenery.level)
    depth = dr.gather(jit.Float, scenery.depth, image)
    place = jit.Array2f(jit.Float(rays.origin.x), jit.Float(rays.origin.y))
    field = by_ray(scenery, image).field
    return shafts(scenery.waves, field, place, depth, rays.direction, image, stratum(x, y))


def mean_3x3(values: Array, tiling: Tiling) -> Array:
    """Means over three by three squares, repeating the edge; `Float`, four values side by side."""
    across, down = size(tiling)
    square = dr.arange(jit.UInt32, dr.width(values))
    packed = dr.ravel(values)
    first = square // (across * down) * (across * down)
    inner = square - first
    x, y = jit.Int32(inner % across), jit.Int32(inner // across)
    total = jit.Array4f(0)
    for a in (-1, 0, 1):
        for b in (-1, 0, 1):
            at = dr.clip(y + b, 0, down - 1) * across + dr.clip(x + a, 0, across - 1)
            total += dr.gather(jit.Array4f, packed, first + jit.UInt32(at))
    smooth = dr.ravel(total / 9)
    dr.eval(smooth)
    return smooth


def shafts_at(squares: Array, tiling: Tiling, where: Pixels) -> Array:
    """Between the squares, for every lane, `Array4f`; beyond the edge, that of the edge."""
    corners, right, down = around(tiling, where)
    p, q, r, s = (dr.gather(jit.Array4f, squares, c) for c in corners)
    return dr.lerp(dr.lerp(p, q, right), dr.lerp(r, s, right), down)

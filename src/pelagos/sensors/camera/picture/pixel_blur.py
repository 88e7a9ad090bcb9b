"""Blur that differs from pixel to pixel: the longest streak of each, the moving bodies that pass it while the shutter
is open, and the softening by the haze of the distance.

Found from the middle ray of each pixel, before the samples are taken.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.so3 import rotate
from pelagos.raycast.rays import Hits, Rays
from pelagos.sensors.camera.picture.camera_rays import Frame, view_intrinsics
from pelagos.sensors.camera.picture.pixel_order import TILE, Pixels, Tiling, smooth_tiles, tile_means
from pelagos.sensors.mount import sensor_angular_velocity, sensor_pose, sensor_velocity
from pelagos.sensors.sensor import Kinematics

if TYPE_CHECKING:
    from pelagos.sensors.camera.picture.camera_config import CameraConfig

_IDS: Final = 4096  # objects told apart by size; of two whose ids differ by a multiple, both count as larger
_REACH: Final = 2  # tiles beyond a moving body that its streaks may reach
_HAZE_WIDTH: Final = 1920  # [px], the width of picture for which the haze's radius is given
_SQUARE: Final = math.sqrt(3) / 2  # half the side of a square over the radius of the disc of the same variance


@jit.struct
class PixelBlur:
    """By lane, a Dr.Jit struct.

    Attributes:
        share: `Float`, of the exposure that motion is blurred over.
        drift: `Array3f`, velocity of the moving bodies around the pixel, world [m/s].
        haze: `Float`, half the side of the square that the distance is softened over [px].
    """

    share: Array
    drift: Array
    haze: Array


def pixel_blur(hits: Hits, rays: Rays, where: Pixels, frame: Frame[CameraConfig], exposure: Array) -> PixelBlur:
    """The blur of each pixel.

    Args:
        hits: of `rays`.
        rays: through the middle of each pixel.
        where: the pixels.
        frame: with limits and haze.
        exposure: time that the shutter is open, by image [s].
    """
    config, motion, tiling, images = frame.config, frame.motion, frame.tiling, frame.images
    moves = hits.valid & (dr.squared_norm(hits.velocity) > 0) & where.active
    if config.motion_blur_min_object > 0:
        moves &= _object_radius(hits, where, moves, images, config) >= config.motion_blur_min_object
    drift = velocity_around(hits.velocity, moves, where, tiling, images)
    share = jit.Float(1)
    if config.motion_blur_max < 1:
        seconds = dr.gather(jit.Float, exposure, where.image) * config.motion_blur
        speed = _pixels_a_second(hits, rays, where, motion, config)
        passing = velocity_around(jit.Array3f(speed), moves, where, tiling, images).x
        streak = dr.maximum(speed, passing) * seconds
        share = dr.minimum(config.motion_blur_max * config.width_px / dr.maximum(streak, 1e-6), 1)
    distance = dr.select(hits.valid, hits.t, config.max_range_m)
    far = 1 - dr.exp2(-distance / config.depth_blur_distance_m)
    radius = config.depth_blur_px * config.width_px / _HAZE_WIDTH
    return PixelBlur(share + dr.zeros(jit.Float, dr.width(where.ray)), drift, _SQUARE * radius * far)


def velocity_around(velocity: Array, moves: Array, where: Pixels, tiling: Tiling, images: int) -> Array:
    """Mean velocity of what moves in each pixel's tile and the next ones, `Array3f` world [m/s]; 0 where nothing does.

    Args:
        velocity: of what each pixel shows, world [m/s].
        moves: `Bool`, pixels that count.
        where: the pixels.
        tiling: their order.
        images: how many.
    """
    counted = [dr.select(moves, velocity, 0), jit.Array3f(dr.select(moves, jit.Float(1), 0))]
    speeds, shares = tile_means(counted, where.active)
    for _ in range(_REACH):
        speeds, shares = (smooth_tiles(v, tiling, images) for v in (speeds, shares))
    dr.eval(speeds, shares)
    tile = where.image * tiling.tiles + where.ray // (TILE * TILE)
    return dr.gather(jit.Array3f, speeds, tile) / dr.maximum(dr.gather(jit.Array3f, shares, tile), 1e-9)


def _object_radius(hits: Hits, where: Pixels, moves: Array, images: int, config: CameraConfig) -> Array:
    """Radius of the disc with as many pixels as show the same object, over the picture's width."""
    index = where.image * _IDS + hits.instance % _IDS
    counts = dr.zeros(jit.UInt32, images * _IDS)
    dr.scatter_add(counts, jit.UInt32(1), index, moves)
    dr.eval(counts)
    return dr.sqrt(jit.Float(dr.gather(jit.UInt32, counts, index, moves)) / math.pi) / config.width_px


def _pixels_a_second(hits: Hits, rays: Rays, where: Pixels, motion: Kinematics, config: CameraConfig) -> Array:
    """Speed at which the content of each pixel moves across the picture [px/s], as in its middle."""
    _, attitude = sensor_pose(motion, config)
    q = jit.Array4f(*(dr.gather(jit.Float, jit.Float(attitude[i]), where.image) for i in range(4)))

    def in_world(vector: Array) -> Array:
        return rotate(q, dr.gather(jit.Array3f, jit.Array3f(vector), where.image))

    relative = hits.velocity - in_world(sensor_velocity(motion, config))
    nearness = dr.select(hits.valid, dr.rcp(dr.maximum(hits.t, 1e-3)), 0)
    turning = relative * nearness - dr.cross(in_world(sensor_angular_velocity(motion, config)), rays.direction)
    across = turning - rays.direction * dr.dot(turning, rays.direction)
    return dr.norm(across) * view_intrinsics(config).fx

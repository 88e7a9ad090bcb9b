"""Automatic exposure that takes its time: how far it lags behind what the camera sees now.

A sensor keeps nothing from one reading to the next, so that readings do not depend on which of them were asked for.
What the meter saw before is seen again, with one ray a tile: the places where the vehicle was if it moved evenly.
"""

from __future__ import annotations

from dataclasses import replace
from typing import TYPE_CHECKING, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.optics.caustics import Ripple
from pelagos.optics.exposure import luminance
from pelagos.raycast.caster import Caster
from pelagos.sensors.camera.picture.camera_rays import Frame, pixel_angle
from pelagos.sensors.camera.picture.develop import meter_weight, zone_mean
from pelagos.sensors.camera.picture.pixel_order import TILE, Pixels, Tiling, inner_place
from pelagos.sensors.camera.picture.radiance import radiance_along
from pelagos.sensors.camera.picture.surroundings import Lit, light_sources, scenery_of
from pelagos.sensors.mount import pose_after

if TYPE_CHECKING:
    from pelagos.sensors.camera.picture.camera_config import CameraConfig

_MOMENTS: Final = 8  # at which the meter looks back
_STOPS: Final = 8.0  # that the exposure can be behind
_LONGEST: Final = 8.0  # [s] that it looks back at most
_INNER: Final = 95  # lane of a tile that meters for it: in its middle, column 7 and row 7


def moments_before(config: CameraConfig) -> tuple[Array, ...]:
    """The times of the frame at which the meter looks back, before 0 [s], first the oldest: arrays, so that a kernel
    serves them all."""
    step = _step(config)
    return tuple(dr.opaque(jit.Float64, -k * step) for k in range(_MOMENTS, 0, -1))


def _step(config: CameraConfig) -> float:
    """Time between two moments [s]."""
    up, down = config.exposure_speed_up_ev_per_s, config.exposure_speed_down_ev_per_s
    slowest = min(s for s in (up, down) if s is not None)
    return min(_STOPS / slowest, _LONGEST) / _MOMENTS


def exposure_lag(
    caster: Caster, light: Lit, ripples: Ripple, frame: Frame[CameraConfig], before: tuple[Array, ...]
) -> Array:
    """By how much the meter's luminance is behind that of the frame, by image [stops]; negative: it still sees less.

    `before`, see `moments_before`. The meter follows the logarithm of luminance at its speed up where the scene grows
    brighter, and at its speed down where it grows darker [stops/s].
    """
    config, tiling = frame.config, frame.tiling
    up, down = config.exposure_speed_up_ev_per_s, config.exposure_speed_down_ev_per_s
    step = _step(config)
    where = _tiles(tiling, frame.images)
    weight = dr.select(where.active, meter_weight(where, tiling, config), 0)
    seen = []
    for delay in (*before, None):
        moment = frame.motion if delay is None else pose_after(frame.motion, delay)
        scenery = scenery_of(caster.tables, light, ripples, moment, config, 0.0 if delay is None else delay)
        rays = replace(frame, motion=moment).rays(where, scenery.level)
        lamps = light_sources(config, moment, where.image)
        radiance, _ = radiance_along(caster, scenery, rays, where.image, lamps, pixel_angle(config))
        bright = luminance(radiance.sharp + radiance.near + radiance.far + radiance.veil)
        mean = zone_mean(bright * weight, weight, tiling)
        mean = dr.clip(mean, max(config.meter_min_cd_m2, 1e-6), config.meter_max_cd_m2)
        dr.eval(mean)
        seen.append(dr.log2(mean))
    follows = seen[0]
    for now in seen[1:]:
        change = now - follows
        change = change if up is None else dr.minimum(change, up * step)
        follows += change if down is None else dr.maximum(change, -down * step)
    lag = follows - seen[-1]
    dr.eval(lag)  # by itself: the picture's kernel serves all speeds
    return lag


def _tiles(tiling: Tiling, images: int) -> Pixels:
    """One pixel of each tile of `images` images."""
    lane = dr.arange(jit.UInt32, images * tiling.tiles)
    image, tile = lane // tiling.tiles, lane % tiling.tiles
    inner_column, inner_row = inner_place(_INNER)
    column, row = tile % tiling.across * TILE + inner_column, tile // tiling.across * TILE + inner_row
    ray = tile * (TILE * TILE) + _INNER
    return Pixels(image, ray, column, row, (column < tiling.width) & (row < tiling.height))

"""Rays of one pixel that differ: within the pixel, over the aperture, over the time that the shutter is open.

Each sample is one value of a low-discrepancy sequence (M. Roberts's R-sequence, a Kronecker sequence on the generalised
golden ratio), shifted by a random amount of each pixel (R. Cranley and T. N. L. Patterson 1976, doi 10.1137/0713071).
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Final

import drjit as dr

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import uniform32
from pelagos.math.so3 import integrate, rotate
from pelagos.raycast.rays import Rays
from pelagos.sensors.camera.picture.camera_rays import Frame, local_directions, starts_wet
from pelagos.sensors.camera.picture.pixel_order import Pixels
from pelagos.sensors.camera.picture.ray_change import RayChange
from pelagos.sensors.mount import sensor_angular_velocity, sensor_pose, sensor_velocity
from pelagos.sensors.noise import Key, words32

if TYPE_CHECKING:
    from pelagos.sensors.camera.picture.camera_config import CameraConfig
    from pelagos.sensors.camera.picture.pixel_blur import PixelBlur

ROOT: Final = 1.134724138401519  # of x^6 = x + 1: five dimensions (Roberts 2018)


@jit.struct
class Sample:
    """Place in pixel, aperture and exposure to which a ray belongs, a Dr.Jit struct of `Float`, one a lane.

    Attributes:
        right, down: in the pixel, -0.5 .. 0.5.
        disc_y, disc_z: on the unit aperture.
        moment: of the exposure, -0.5 .. 0.5.
    """

    right: Array
    down: Array
    disc_y: Array
    disc_z: Array
    moment: Array


def samples(number: Array, where: Pixels, frame: Frame[CameraConfig], key: Key) -> Sample:
    """Sample `number` of the configuration's for every lane."""
    count, blades, closed = frame.config.samples, frame.config.aperture_blades, frame.config.blades_closed
    words = words32(key, *frame.counter(where))
    shift = [uniform32(w) for w in words] + [uniform32(words[0] ^ (words[1] << 9) ^ (words[2] << 18))]
    u = []
    for d in range(5):
        value = shift[d] + (jit.Float(number) + 0.5) * ROOT ** -(d + 1)
        u.append(value - dr.floor(value))
    stratum = (jit.Float(number) + u[4]) / count - 0.5
    y, z = _polygon(u[2], u[3], blades, closed)
    return Sample(u[0] - 0.5, u[1] - 0.5, y, z, stratum)


def _polygon(u: Array, v: Array, blades: int, closed: float) -> tuple[Array, Array]:
    """A point of the unit disc (no blades, or `closed` = 0), or of the regular polygon with its area (`closed` = 1)."""
    angle, radius = 2 * math.pi * u, dr.sqrt(v)
    s, c = dr.sincos(angle)
    y, z = radius * c, radius * s
    if blades and closed > 0:
        wedge = 2 * math.pi / blades
        within = angle - wedge * (dr.floor(angle / wedge) + 0.5)
        # a wedge of the polygon has its edge at cos(half) / cos(angle): equal areas follow from the tangent
        half = math.tan(wedge / 2)
        within = dr.atan(half * within / (wedge / 2))
        scale = math.sqrt(wedge / (2 * half))  # same area as the disc
        angle = wedge * (dr.floor(angle / wedge) + 0.5) + within
        radius *= scale / dr.cos(within)
        s, c = dr.sincos(angle)
        y, z = dr.lerp(y, radius * c, closed), dr.lerp(z, radius * s, closed)
    return y, z


def sampled_rays(
    frame: Frame[CameraConfig],
    where: Pixels,
    sample: Sample | None,
    exposure: Array,
    *,
    blur: PixelBlur | None = None,
    level: Array | None = None,
    change: RayChange | None = None,
) -> Rays:
    """The rays of one sample, in the world.

    Args:
        frame: whose vehicle moves on evenly while the shutter is open.
        where: the pixels.
        sample: see `Sample`; None for the middle of pixel, aperture and exposure.
        exposure: time that the shutter is open, by image [s].
        blur: what differs from pixel to pixel; None for nothing.
        level: see `view_rays`.
        change: of the lens, from pixel to pixel; needed with a `sample`.
    """
    motion, config = frame.motion, frame.config
    rays = frame.rays(where, level)
    if sample is None and config.rolling_shutter_s == 0:
        return rays
    _, attitude = sensor_pose(motion, config)
    q = jit.Array4f(*(dr.gather(jit.Float, jit.Float(attitude[i]), where.image) for i in range(4)))
    velocity = dr.gather(jit.Array3f, jit.Array3f(sensor_velocity(motion, config)), where.image)
    spin = dr.gather(jit.Array3f, jit.Array3f(sensor_angular_velocity(motion, config)), where.image)
    moment = ((jit.Float(where.row) + 0.5) / config.height_px - 0.5) * config.rolling_shutter_s
    local = local_directions(frame.lens, where, rays.origin, level)
    start = jit.Array3f(0)
    if sample is not None:
        open_for = dr.gather(jit.Float, exposure, where.image) * config.motion_blur
        moment += sample.moment * (open_for if blur is None else open_for * blur.share)
        assert change is not None
        wide = 1.0 if blur is None else dr.sqrt(1 + dr.square(2 * blur.haze))
        right, down = wide * sample.right, wide * sample.down
        local = dr.normalize(local + _beside(frame.lens.dry, change, where, rays.origin, level, right, down))
        if change.start is not None:  # the place on the port moves along
            start = _across(change.start, where, right, down)
        if config.focus_distance_m is not None:
            aside, local = _through_aperture(local, sample, config)
            start += aside
    return Rays(
        origin=rays.origin + jit.Array3f64(rotate(q, start + velocity * moment)),
        direction=rotate(integrate(q, spin, moment), local),
        max_range=rays.max_range,
        copy=rays.copy,
        own=rays.own,
        drift=None if blur is None else blur.drift * moment,
    )


def _beside(
    dry: Array | None, change: RayChange, where: Pixels, origin: Array, level: Array | None, right: Array, down: Array
) -> Array:
    """By how much directions differ from those of the pixels' middles, `right` and `down` of them [px]."""
    wet = _across(change.direction, where, right, down)
    if dry is None or change.dry is None:
        return wet
    return dr.select(starts_wet(where, origin, level), wet, _across(change.dry, where, right, down))


def _across(change: list[Array], where: Pixels, right: Array, down: Array) -> Array:
    rightwards, downwards = (dr.gather(jit.Array3f, v, where.ray) for v in change)
    return rightwards * right + downwards * down


def _through_aperture(local: Array, sample: Sample, config: CameraConfig) -> tuple[Array, Array]:
    """A thin lens: rays from all over the aperture meet again at the focal distance."""
    radius = config.focal_length_m / (2 * config.aperture)
    start = jit.Array3f(0, sample.disc_y * radius, sample.disc_z * radius)
    distance = config.focus_distance_m / dr.maximum(local.x, 1e-3)
    return start, dr.normalize(local * distance - start)

"""From light at the pixels to a picture: glow, lens faults, exposure, noise, white balance, tone, bits.

Everything works on linear light until the very last step. White balance is a gain on what the sensor gave, and so on
its noise; the meter looks at the balanced picture.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any, Final

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32
from pelagos.optics.exposure import GREY, encode_srgb, luminance, metered, saturation_luminance, shoulder, to_bits
from pelagos.optics.film import FilmCurve, balance_gains, film
from pelagos.optics.image_noise import noisy_signal
from pelagos.sensors.camera.picture.camera_rays import Frame
from pelagos.sensors.camera.picture.glow import glow
from pelagos.sensors.camera.picture.pixel_order import (
    TILE,
    Pixels,
    Tiling,
    between_tiles,
    image_means,
    image_rows,
    pixel_values_at,
    smooth_tiles,
    tile_means,
    tile_sizes,
    tiles_at,
)
from pelagos.sensors.camera.picture.radiance import Radiance
from pelagos.sensors.noise import Key, words32

if TYPE_CHECKING:
    from pelagos.sensors.camera.picture.camera_config import CameraConfig

_SHORTEST: Final = 1e-5  # [s] exposure
_MOST_BALANCE: Final = 4.0
_BLOOM: Final = 0.04  # share of the light that a bloom of 1 spreads
_FLARE: Final = 0.02  # share of bright light that a flare of 1 shows in its first ghost
_GHOSTS: Final = ((-0.6, 1.0), (-1.3, 0.5), (0.45, 0.35))  # place of a ghost over that of its source, and strength
_METERINGS: Final = 4  # rounds of the meter: a glare on a fiftieth of the picture fades to a ninth in each
_CENTRE: Final = 0.35  # of half the width: where centre-weighted metering falls to a third
_CELLS: Final = {"rggb": (0, 1, 1, 2), "bggr": (2, 1, 1, 0), "grbg": (1, 0, 2, 1), "gbrg": (1, 2, 0, 1)}


def pixel_light(light: Radiance, where: Pixels, tiling: Tiling, pixel_angle: float) -> Array:
    """Light at the pixels, `Array3f`: the sharp image, what the water scattered into it from around, the veil."""
    direct = light.sharp + light.veil
    dr.eval(direct, light.near, light.far)  # once: sums over blocks follow, and would cast the rays again
    return direct + glow(light.near, light.far, where, tiling, pixel_angle)


def through_lens(
    light: Array, where: Pixels, tiling: Tiling, config: CameraConfig, vignette: Array, images: int
) -> Array:
    """Faults of a lens: lateral colour, bloom, ghosts of bright light, fall-off to the corners."""
    if config.chromatic_aberration > 0:
        light = _lateral_colour(light, where, tiling, config)
    if config.bloom > 0 or config.lens_flare > 0:
        coarse = smooth_tiles(tile_means([light], where.active)[0], tiling, images)
        if config.bloom > 0:
            wide = smooth_tiles(smooth_tiles(coarse, tiling, images), tiling, images)
            light = dr.lerp(light, between_tiles(wide, tiling, where), min(_BLOOM * config.bloom, 1.0))
        if config.lens_flare > 0:
            light += _ghosts(coarse, where, tiling) * (_FLARE * config.lens_flare)
    return light * dr.gather(jit.Float, vignette, where.ray)


def _lateral_colour(light: Array, where: Pixels, tiling: Tiling, config: CameraConfig) -> Array:
    """Red magnified and blue reduced by the same share at the picture's corner, from a radius outwards."""
    cx, cy = 0.5 * (tiling.width - 1), 0.5 * (tiling.height - 1)
    x, y = jit.Float(where.column) - cx, jit.Float(where.row) - cy
    radius = dr.sqrt(x * x + y * y) / (cx * cx + cy * cy) ** 0.5
    start = config.chromatic_aberration_start
    grow = config.chromatic_aberration * dr.clip((radius - start) / max(1 - start, 1e-3), 0, 1)
    shifted = [
        pixel_values_at(light[i], tiling, where.image, cx + x * (1 + sign * grow), cy + y * (1 + sign * grow))
        for i, sign in ((0, -1), (2, 1))
    ]
    return jit.Array3f(shifted[0], light[1], shifted[1])


def _ghosts(coarse: Array, where: Pixels, tiling: Tiling) -> Array:
    cx, cy = 0.5 * (tiling.width - 1), 0.5 * (tiling.height - 1)
    x, y = jit.Float(where.column) - cx, jit.Float(where.row) - cy
    total = jit.Array3f(0)
    for place, strength in _GHOSTS:
        total += strength * tiles_at(coarse, tiling, where.image, cx + x / place, cy + y / place)
    return total


def balance(light: Array, where: Pixels, tiling: Tiling, config: CameraConfig) -> Array:
    """Channel gains of the white balance, `Array3f` by lane; 1 for raw pictures."""
    gains = jit.Array3f(1)
    if config.mosaic != "none":
        return gains
    if config.white_balance == "grey_world":
        means = [dr.maximum(image_means(light[i], where.active, tiling), 1e-12) for i in range(3)]
        found = jit.Array3f(*(dr.clip(means[1] / m, 1 / _MOST_BALANCE, _MOST_BALANCE) for m in means))
        gains = dr.gather(jit.Array3f, found, where.image)
    if config.white_temperature_k != 6500 or config.white_tint != 0:
        gains *= jit.Array3f(*balance_gains(config.white_temperature_k, config.white_tint))
    return gains


def meter_weight(where: Pixels, tiling: Tiling, config: CameraConfig) -> Array:
    """Weight of each pixel in the meter's mean."""
    if config.metering == "average":
        return dr.full(jit.Float, 1.0, dr.width(where.column))
    x = (jit.Float(where.column) + 0.5) / tiling.width - 0.5
    y = (jit.Float(where.row) + 0.5) / tiling.height - 0.5
    return dr.exp(-(x * x + y * y) / (0.5 * _CENTRE) ** 2)


def zone_mean(bright: Array, weight: Array, tiling: Tiling) -> Array:
    """Means of a picture by a meter of zones, one a tile: mean luminance by image [cd/m^2].

    A zone counts at most as full as it would be in the picture, where the mean is middle grey: the sun, and its path
    on the water, do not turn the rest to night.

    Args:
        bright: luminance of each tile times its weight, summed over its pixels.
        weight: sums of the weights.
        tiling: of the pictures.
    """
    total = dr.block_sum(weight, tiling.tiles)
    mean = dr.block_sum(bright, tiling.tiles) / total
    image = dr.arange(jit.UInt32, dr.width(bright)) // tiling.tiles
    for _ in range(_METERINGS):
        full = dr.gather(jit.Float, mean, image) / GREY
        mean = dr.block_sum(dr.minimum(bright, full * weight), tiling.tiles) / total
    return mean


def exposure_of(
    light: Array, where: Pixels, tiling: Tiling, config: CameraConfig, images: int, lag: Array | None = None
) -> tuple[Array, Array]:
    """Exposure time [s] and ISO speed of each image; `lag`, see `exposure_lag`."""
    if config.exposure == "manual":
        return dr.full(jit.Float, config.shutter_s, images), dr.full(jit.Float, config.iso, images)
    weight = dr.select(where.active, meter_weight(where, tiling, config), 0)
    bright = dr.block_sum(luminance(light) * weight, TILE * TILE)
    weights = tile_sizes(tiling, images) if config.metering == "average" else dr.block_sum(weight, TILE * TILE)
    mean = dr.clip(zone_mean(bright, weights, tiling), config.meter_min_cd_m2, config.meter_max_cd_m2)
    if lag is not None:
        mean *= dr.exp2(lag)
    longest = min(config.shutter_s, 1 / config.rate_hz)
    return metered(
        mean,
        aperture=config.aperture,
        longest=longest,
        shortest=min(_SHORTEST, longest),
        iso=(config.iso, max(config.iso, config.iso_max)),
        compensation=config.compensation_ev,
    )


def develop_pictures(
    balanced: tuple[Array, Array], exposure: tuple[Array, Array], where: Pixels, frame: Frame[CameraConfig], key: Key,
    trace: Callable[[str, Array, str], None] | None,
) -> tuple[Array, Array]:  # fmt: skip
    """Pictures with and without noise, in the order of rows: see `unpack_pictures`.

    `balanced`: light and gains, see `balance`; `exposure`: shutter and ISO speed, see `exposure_of`.
    """
    (light, gains), (shutter, iso) = balanced, exposure
    config, images = frame.config, frame.images
    signal = light / dr.gather(jit.Float, saturation_luminance(config.aperture, shutter, iso), where.image)
    words = words32(key, *frame.counter(where))
    normal = jit.Array3f(*normal_pair32(words[0], words[1]), normal_pair32(words[2], words[3])[0])
    dark = dr.gather(jit.Float, shutter, where.image) * config.dark_current_e_per_s
    speed = dr.gather(jit.Float, iso, where.image)
    noisy = noisy_signal(
        signal, normal, iso=speed, full_well=config.full_well_e, read_noise=config.read_noise_e, dark=dark
    )
    if trace is not None:
        trace("light at the sensor", light, "cd/m^2")
        trace("signal", signal, "1 = full pixel")
        trace("signal with noise", noisy, "1 = full pixel")
    data, truth = (image_rows(_packed(s * gains, where, config), frame.tiling, where, images) for s in (noisy, signal))
    if config.mosaic == "none" and config.bits <= 8:
        dr.eval(data, truth)
        data, truth = _three_words(data), _three_words(truth)
    return data, truth


def unpack_pictures(packed: Array, config: CameraConfig, images: int) -> NDArray[Any]:
    """Values of `develop_pictures` as `(images, height, width, 3)`, of a mosaic `(images, height, width)`."""
    kind = np.uint8 if config.bits <= 8 else np.uint16
    shape = (images, config.height_px, config.width_px)
    values = np.array(packed)
    if config.mosaic != "none":
        return values.reshape(shape).astype(kind)
    if config.bits > 8:
        return np.ascontiguousarray(values.view(kind).reshape(*shape, 4)[..., :3])
    return values.view(kind)[: 3 * math.prod(shape)].reshape(*shape, 3)


def _three_words(pixels: Array) -> Array:
    """Pixels of three bytes, each in a word, as a row of bytes: four of them in three words."""
    count = dr.width(pixels)
    group = dr.arange(jit.UInt32, -(-count // 4))
    a, b, c, d = (dr.gather(jit.UInt32, pixels, 4 * group + k, 4 * group + k < count) for k in range(4))
    return dr.ravel(jit.Array3u(a | (b << 24), (b >> 8) | (c << 16), (c >> 16) | (d << 8)))


def _packed(signal: Array, where: Pixels, config: CameraConfig) -> Array:
    """Channels of `bits` side by side in one word; a mosaic has one channel."""
    values = [to_bits(tone_curve(signal[i], config), config.bits) for i in range(3)]
    if config.mosaic != "none":
        cell = (where.row % 2) * 2 + where.column % 2
        channels = _CELLS[config.mosaic]
        picked = values[channels[0]]
        for k in (1, 2, 3):
            picked = dr.select(cell == k, values[channels[k]], picked)
        return picked
    if config.bits <= 8:
        return values[0] | (values[1] << 8) | (values[2] << 16)
    wide = [jit.UInt64(v) for v in values]
    return wide[0] | (wide[1] << 16) | (wide[2] << 32)


def tone_curve(x: Array, config: CameraConfig) -> Array:
    """A full pixel's share to the display value 0 .. 1."""
    if config.tone == "linear":
        return dr.clip(x, 0, 1)
    if config.tone == "film":
        curve = FilmCurve(
            config.film_slope, config.film_toe, config.film_shoulder, config.film_black_clip, config.film_white_clip
        )
        return encode_srgb(film(x, curve))
    bent = shoulder(x, config.highlight_knee)
    return encode_srgb(bent) if config.tone == "srgb" else dr.power(dr.maximum(bent, 0), 1 / config.gamma)

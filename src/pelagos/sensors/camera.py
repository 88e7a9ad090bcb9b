"""A colour camera under and above water, in real time: 8-bit pictures with the noise of a real sensor.

Data and truth are `(m, height, width, 3)` uint8, red green blue, row 0 at the top; truth is the picture without noise.
Extras: `exposure_s` and `iso`, `(m,)`, as set or as the meter chose.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, ClassVar, Final, Literal

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos import jit
from pelagos.config.strict import Strict
from pelagos.jit import Array
from pelagos.math.philox import normal_pair32
from pelagos.math.so3 import from_euler, rotate
from pelagos.optics.caustics import ripple, swell_around, waves_at
from pelagos.optics.exposure import encode_srgb, luminance, metered, saturation_luminance, shoulder, to_bits
from pelagos.optics.image_noise import noisy_signal
from pelagos.optics.lamp import Beam, axis_intensity
from pelagos.optics.lens import Intrinsics, intrinsics, natural_vignette, pinhole_directions
from pelagos.optics.sunlight import daylight
from pelagos.optics.texture import looks
from pelagos.raycast.rays import Rays
from pelagos.sensors.mount import sensor_pose
from pelagos.sensors.noise import opaque_key, stream_key, words32
from pelagos.sensors.pixels import (
    Pixels,
    Tiling,
    between_tiles,
    image_means,
    image_rows,
    pixels,
    smooth_tiles,
    tile_means,
)
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.shading import Scenery, View, look
from pelagos.world.material import TEXTURES

Trace = Callable[[str, Array, str], None]


class LampConfig(Strict):
    """A lamp on the vehicle."""

    position_m: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Place in the body frame, forward-left-up of the vehicle's origin [m]."""
    orientation_deg: tuple[float, float, float] = (0.0, 0.0, 0.0)
    """Roll, pitch, yaw of the lamp's axis (its x) in the body frame [deg]; positive pitch shines down."""
    flux_lm: float = Field(default=1500.0, gt=0)
    """Luminous flux [lm]."""
    beam_angle_deg: float = Field(default=100.0, gt=1, le=170)
    """Full width of the cone [deg]; the light fades over its outer half."""
    color: tuple[float, float, float] = (1.0, 0.97, 0.92)
    """Colour: linear red, green, blue, relative to daylight."""


class CameraConfig(SensorConfig):
    """A colour camera."""

    type: Literal["camera"]
    """The sensor's kind."""
    rate_hz: float = Field(default=2.0, gt=0)
    """Frames per second [Hz]; must divide the tick rate."""
    width_px: int = Field(default=640, ge=16, le=8192)
    """Width of the picture [px]."""
    height_px: int = Field(default=480, ge=16, le=8192)
    """Height of the picture [px]."""
    horizontal_fov_deg: float = Field(default=70.0, gt=1, lt=175)
    """Field of view across the width, in the medium that the camera is in [deg]."""
    distortion: tuple[float, float, float, float, float] = (0.0, 0.0, 0.0, 0.0, 0.0)
    """Brown-Conrady coefficients k1, k2, p1, p2, k3 (the order of OpenCV)."""
    max_range_m: float = Field(default=60.0, gt=0)
    """How far to look for surfaces [m]; beyond is water, or sky."""
    exposure: Literal["auto", "manual"] = "auto"
    """Whether the frame meters itself, or `shutter_s` and `iso` hold."""
    compensation_ev: float = Field(default=0.0, ge=-10, le=10)
    """Correction of the automatic exposure [stops]; positive is brighter."""
    shutter_s: float = Field(default=0.01, gt=0, le=10)
    """Exposure time [s]; under automatic exposure the longest."""
    aperture: float = Field(default=2.8, ge=0.5, le=64)
    """f-number N; the light that arrives falls with N squared."""
    iso: float = Field(default=100.0, ge=1)
    """Speed; under automatic exposure the lowest. A full pixel at ISO 100 holds `full_well_e` electrons."""
    iso_max: float = Field(default=6400.0, ge=1)
    """Highest speed of the automatic exposure."""
    full_well_e: float = Field(default=10000.0, gt=0)
    """Electrons of a full pixel at ISO 100 [e-]."""
    read_noise_e: float = Field(default=4.0, ge=0)
    """Standard deviation of reading out a pixel [e-]."""
    dark_current_e_per_s: float = Field(default=5.0, ge=0)
    """Electrons without light [e-/s]."""
    vignette: float = Field(default=0.5, ge=0, le=4)
    """Fall-off to the corners: power of the natural cos^4 law; 0 is none, 1 a simple lens."""
    white_balance: Literal["daylight", "grey_world"] = "daylight"
    """`daylight` keeps the water's tint; `grey_world` scales red and blue to the mean green, at most 4 times."""
    highlight_knee: float = Field(default=0.7, gt=0, le=1)
    """Linear level from which highlights roll off towards white; 1 clips."""
    lamps: tuple[LampConfig, ...] = ()
    """Lamps that shine when this camera looks."""
    ripple: float = Field(default=0.004, ge=0, le=0.05)
    """Mean square slope of waves of 0.3 to 4 m that make caustics, on top of the ocean's waves."""


_SHORTEST: Final = 1e-5  # [s] exposure
_MOST_BALANCE: Final = 4.0


class Camera:
    """See `CameraConfig`."""

    TITLE: ClassVar[str] = "colour camera: water optics, caustics, lamps, exposure, sensor noise"
    Config: ClassVar[type[SensorConfig]] = CameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Image formation: D. Akkaynak and T. Treibitz, A Revised Underwater Image Formation Model, CVPR 2018",
        "Forward scattering: J. S. Jaffe, IEEE J. Oceanic Eng. 15:101 (1990)",
        "Inherent optical properties: see pelagos.optics.water",
        "Exposure: ISO 12232:2019; noise: EMVA Standard 1288, release 4.0",
    )

    def __init__(self, config: CameraConfig, context: SensorContext) -> None:
        self.config, self._context = config, context
        self._tiling = Tiling(config.width_px, config.height_px)
        directions = pixel_directions(config)
        vignette = natural_vignette(directions, config.vignette)
        self._directions = jit.Array3f(np.ascontiguousarray(self._tiling.arrange(directions).T))
        self._vignette = jit.Float(self._tiling.arrange(vignette))
        materials = context.world.material_tables()
        kinds = [TEXTURES[k] for k in np.array(materials.texture)]
        self._looks = looks(materials.albedo, materials.texture_scale, kinds)
        ocean = context.ocean
        self._water = ocean.water.arrays()
        self._light = daylight(float(ocean.sun_elevation[0]), -float(ocean.sun_azimuth[0])).arrays()
        self._key = opaque_key(stream_key(context.seed, context.path, "image"))
        self._own = jit.UInt32(context.own_body)
        dr.make_opaque(self._directions, self._vignette, self._own)
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One picture for every lane."""
        data, truth, shutter, iso = self._ping(*self._arguments(motion))
        return self._measurement(data, truth, shutter, iso)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        found: list[tuple[str, NDArray[Any], str]] = []

        def trace(name: str, values: Array, unit: str) -> None:
            found.append((name, np.array(values), unit))

        scene = self._context.scene
        self._make(scene.static, scene.moving, trace)(*self._arguments(motion))
        return found

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        ocean = self._context.ocean
        return (
            self._context.scene.tables, self._looks, self._water, self._light, self._directions, self._vignette, motion,
            self._own, self._key, ocean if ocean.waves is not None else None,
        )  # fmt: skip

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., Any]:
        config, tiling = self.config, self._tiling
        sea = ripple(config.ripple)

        def frame(tables: Any, looks: Any, water: Any, light: Any, directions: Array, vignette: Array,
                  motion: Kinematics, own: Array, key: Any, ocean: Any) -> tuple[Array, ...]:  # fmt: skip
            images = dr.width(motion.tick)
            t = jit.Float64(motion.t_ns) * 1e-9
            position, attitude = sensor_pose(motion, config)
            swell = None if ocean is None else swell_around(ocean.elevation, position, t, images)
            waves = waves_at(sea, t, light.towards_sun, images, swell)
            where = pixels(tiling, images)
            rays = camera_rays(where, position, attitude, directions, motion, own, config.max_range_m)
            lamps = [lamp_beam(lamp, config, motion, where.image) for lamp in config.lamps]
            scenery = Scenery(tables, looks, water, light, waves)
            view, hits = look(static, moving, scenery, rays, where.image, lamps, pixel_angle(config))
            if trace is not None:
                trace_view(trace, hits, view)
            dr.eval(view)  # once: sums over tiles follow, and would cast the rays again
            return develop(view, where, tiling, config, vignette, motion, key, trace)

        return frame

    def _measurement(self, data: Array, truth: Array, shutter: Array, iso: Array) -> Measurement:
        shape = (-1, self.config.height_px, self.config.width_px, 4)

        def picture(packed: Array) -> NDArray[np.uint8]:
            return np.ascontiguousarray(np.array(packed).view(np.uint8).reshape(shape)[..., :3])

        extras = {"exposure_s": np.array(shutter), "iso": np.array(iso)}
        return Measurement(data=picture(data), truth=picture(truth), extras=extras)


def pixel_directions(config: CameraConfig) -> NDArray[np.float64]:
    """`(height, width, 3)` unit directions of the pixels in the sensor frame (x forward, y left, z up)."""
    return pinhole_directions(camera_intrinsics(config), config.distortion)


def camera_intrinsics(config: CameraConfig) -> Intrinsics:
    """Focal length and principal point [px]."""
    return intrinsics(config.width_px, config.height_px, math.radians(config.horizontal_fov_deg))


def pixel_angle(config: CameraConfig) -> float:
    """Angle between neighbouring pixels in the middle of the picture [rad]."""
    return 1 / camera_intrinsics(config).fx


def camera_rays(
    where: Pixels, position: Array, attitude: Array, directions: Array, motion: Kinematics, own: Array, reach: float
) -> Rays:
    """Rays of all pixels: from the camera's place, along the lens's directions."""
    q = [dr.gather(jit.Float, jit.Float(attitude[i]), where.image) for i in range(4)]
    origin = dr.gather(jit.Array3f64, position, where.image)
    local = dr.gather(jit.Array3f, directions, where.ray)
    copy = dr.gather(jit.UInt32, motion.copy, where.image)
    return Rays(
        origin=origin,
        direction=rotate(jit.Array4f(*q), local),
        max_range=dr.select(where.active, jit.Float(reach), 0),
        copy=copy,
        own=dr.gather(jit.UInt32, own, copy),
    )


def lamp_beam(lamp: LampConfig, config: CameraConfig, motion: Kinematics, image: Array) -> Beam:
    """A lamp of the vehicle at the moments of the images, by ray."""
    attitude = jit.Array4f(*(jit.Float(motion.attitude[i]) for i in range(4)))
    offset = rotate(attitude, jit.Array3f(*(a - b for a, b in zip(lamp.position_m, config.position_m, strict=True))))
    w, x, y, z = from_euler(*(math.radians(a) for a in lamp.orientation_deg))
    axis = rotate(attitude, rotate(jit.Array4f(w, x, y, z), jit.Array3f(1, 0, 0)))
    half = math.radians(lamp.beam_angle_deg) / 2
    candela = axis_intensity(lamp.flux_lm, 2 * half)
    return Beam(
        position=dr.gather(jit.Array3f, offset, image),
        axis=dr.gather(jit.Array3f, axis, image),
        intensity=jit.Array3f(*(candela * c for c in lamp.color)),
        inner=jit.Float(math.cos(0.5 * half)),
        outer=jit.Float(math.cos(half)),
    )


def develop(
    view: View, where: Pixels, tiling: Tiling, config: CameraConfig, vignette: Array, motion: Kinematics, key: Any,
    trace: Trace | None,
) -> tuple[Array, Array, Array, Array]:  # fmt: skip
    """Light to pictures: glow, vignette, exposure, noise, tone. Gives packed data and truth, exposure [s], ISO."""
    images = dr.width(motion.tick)
    glow = smooth_tiles(tile_means(view.far, where.active), tiling, images) + tile_means(view.near, where.active)
    light = view.sharp + between_tiles(glow, tiling, where) + view.veil
    light *= dr.gather(jit.Float, vignette, where.ray)
    dr.eval(light)
    if config.white_balance == "grey_world":
        light *= dr.gather(jit.Array3f, _grey_world(light, where, tiling), where.image)
    if config.exposure == "auto":
        mean = image_means(luminance(light), where.active, tiling)
        shutter, iso = metered(
            mean, aperture=config.aperture, longest=config.shutter_s, shortest=_SHORTEST,
            iso=(config.iso, max(config.iso, config.iso_max)), compensation=config.compensation_ev,
        )  # fmt: skip
    else:
        shutter = dr.full(jit.Float, config.shutter_s, images)
        iso = dr.full(jit.Float, config.iso, images)
    signal = light / dr.gather(jit.Float, saturation_luminance(config.aperture, shutter, iso), where.image)
    speed = dr.gather(jit.Float, iso, where.image)
    dark = dr.gather(jit.Float, shutter, where.image) * config.dark_current_e_per_s
    index = where.row * tiling.width + where.column
    environment, tick = (dr.gather(jit.UInt32, v, where.image) for v in (motion.environment, motion.tick))
    words = words32(key, index, environment, tick)
    n0, n1 = normal_pair32(words[0], words[1])
    n2, _ = normal_pair32(words[2], words[3])
    noisy = noisy_signal(
        signal,
        jit.Array3f(n0, n1, n2),
        iso=speed,
        full_well=config.full_well_e,
        read_noise=config.read_noise_e,
        dark=dark,
    )
    if trace is not None:
        trace("light at the sensor", light, "cd/m^2")
        trace("signal", signal, "1 = full pixel")
        trace("signal with noise", noisy, "1 = full pixel")
    data, truth = (image_rows(_packed(s, config.highlight_knee), tiling, where, images) for s in (noisy, signal))
    return data, truth, shutter, iso


def _grey_world(light: Array, where: Pixels, tiling: Tiling) -> Array:
    means = [dr.maximum(image_means(light[i], where.active, tiling), 1e-12) for i in range(3)]
    return jit.Array3f(*(dr.clip(means[1] / m, 1 / _MOST_BALANCE, _MOST_BALANCE) for m in means))


def _packed(signal: Array, knee: float) -> Array:
    r, g, b = (to_bits(encode_srgb(shoulder(signal[i], knee)), 8) for i in range(3))
    return r | (g << 8) | (b << 16)


def trace_view(trace: Trace, hits: Any, view: View) -> None:
    """What `explain` shows of the light before the lens."""
    trace("slant range", dr.select(hits.valid, hits.t, dr.nan), "m")
    trace("material row", hits.material, "")
    trace("sharp light", view.sharp, "cd/m^2")
    trace("light scattered by a few degrees", view.near, "cd/m^2")
    trace("light scattered forward", view.far, "cd/m^2")
    trace("veiling light", view.veil, "cd/m^2")

"""A colour camera under and above water, in real time: pictures with the optics, exposure and noise of a real one.

Data and truth are `(m, height, width, 3)` uint8 (uint16 above 8 bits), red green blue, row 0 at the top; with a
`mosaic` `(m, height, width)`. Truth is the picture without noise. Extras: `exposure_s` and `iso`, `(m,)`, as set or
as the meter chose.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar

import drjit as dr
import numpy as np
from numpy.typing import NDArray

from pelagos import jit
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.optics.caustics import Ripple
from pelagos.optics.sight_line import SightLines
from pelagos.raycast.caster import Caster
from pelagos.raycast.rays import Hits
from pelagos.sensors.camera.picture.ambient_light import ambience, ambience_at
from pelagos.sensors.camera.picture.camera_config import CameraConfig, idle_keys
from pelagos.sensors.camera.picture.camera_rays import Frame, Imager, Lens, Trace, pixel_angle
from pelagos.sensors.camera.picture.develop import (
    balance,
    develop_pictures,
    exposure_of,
    pixel_light,
    through_lens,
    unpack_pictures,
)
from pelagos.sensors.camera.picture.exposure_lag import exposure_lag, moments_before
from pelagos.sensors.camera.picture.lamp_shadow import with_shadows
from pelagos.sensors.camera.picture.light_shafts import mean_3x3, shaft_squares, shafts_at
from pelagos.sensors.camera.picture.path_tracing import path_traced
from pelagos.sensors.camera.picture.pixel_blur import pixel_blur
from pelagos.sensors.camera.picture.pixel_order import Pixels, pixels
from pelagos.sensors.camera.picture.pixel_samples import Sample, sampled_rays, samples
from pelagos.sensors.camera.picture.radiance import Ambience, Radiance, radiance_along
from pelagos.sensors.camera.picture.ray_change import RayChange, ray_change
from pelagos.sensors.camera.picture.scenery import Scenery, in_rain
from pelagos.sensors.camera.picture.surroundings import Lit, Surroundings, light_sources, scenery_of
from pelagos.sensors.camera.picture.turbid_sight import sight_lines
from pelagos.sensors.noise import Key, opaque_key, stream_key
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class Camera:
    """See `CameraConfig`."""

    TITLE: ClassVar[str] = "colour camera: water optics, caustics, lamps, exposure, sensor noise"
    KERNELS: ClassVar[int] = 103
    CASTS: ClassVar[int] = 11
    Config: ClassVar[type[SensorConfig]] = CameraConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "Image formation: D. Akkaynak and T. Treibitz, CVPR 2018, doi 10.1109/CVPR.2018.00703",
        "Forward scattering: J. S. Jaffe, IEEE J. Oceanic Eng. 15:101 (1990), doi 10.1109/48.50695",
        "Water types: N. G. Jerlov, Marine Optics (1976); C. A. Williamson and R. C. Hollins, doi 10.1364/AO.470464; "
        "M. G. Solonenko and C. D. Mobley, doi 10.1364/AO.54.005392",
        "Daylight: W. J. Wiscombe, J. Atmos. Sci. 34:1408 (1977); J. T. O. Kirk 1984, doi 10.4319/lo.1984.29.2.0350",
        "Plankton and sediment: L. Prieur and S. Sathyendranath 1981; M. Babin et al., doi 10.4319/lo.2003.48.2.0843",
        "Fog and rain: WMO-No. 8; ITU-R P.1814 (2007); J. S. Marshall and W. McK. Palmer, J. Meteorol. 5:165 (1948)",
        "Exposure: ISO 12232:2019; noise: EMVA Standard 1288, release 4.0",
    )

    def __init__(self, config: CameraConfig, context: SensorContext) -> None:
        self.config = config
        if idle := idle_keys(config):
            warnings.warn(f"{context.path}: {idle}", ValidityWarning, stacklevel=3)
        self._view = Imager(config, context)
        self._vignette = self._view.vignette(config.vignette)
        self._surroundings = Surroundings(context)
        self._keys = tuple(opaque_key(stream_key(context.seed, context.path, k)) for k in ("image", "paths"))
        self._change = ray_change(config) if config.samples > 1 or config.renderer == "reference" else None
        self._before = moments_before(config) if config.adapts else None
        self._recorded = context.scene.compile(self._kernel)

    def sense(self, motion: Kinematics) -> Measurement:
        """One picture for every lane."""
        return self._measurement(*self._recorded(*self._arguments(motion)))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._kernel, self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return (
            *self._view.arguments(motion),
            self._surroundings.arguments(motion, self.config),
            self._vignette,
            self._change,
            self._before,
            self._keys,
        )

    def _kernel(
        self, caster: Caster, lens: Lens, motion: Kinematics, own: Array, light: Lit, vignette: Array,
        change: RayChange | None, before: tuple[Array, ...] | None, keys: tuple[Key, ...], *,
        trace: Trace | None = None,
    ) -> tuple[Array, ...]:  # fmt: skip
        config, tiling = self.config, self._view.tiling
        ripples = self._surroundings.ripple(config)
        frame = Frame(lens, motion, own, config, tiling)
        images = frame.images
        where = pixels(tiling, images)
        scenery = scenery_of(caster.tables, light, ripples, motion, config)
        lamps = light_sources(config, motion, where.image)

        angle = pixel_angle(config)
        if config.renderer == "realtime":
            lamps = with_shadows(lamps, caster, scenery, frame, where)
        around, lines = self._water_around(caster, scenery, ripples, frame, where)

        def light_of(sample: Sample, exposure: Array, number: Array) -> Radiance:
            rays = sampled_rays(frame, where, sample, exposure, blur=blur, level=scenery.level, change=change)
            if config.renderer == "realtime":
                return radiance_along(
                    caster, scenery, rays, where.image, lamps, angle, around,
                    config.marine_snow_per_m3, lines,
                )[0]  # fmt: skip
            counter = *frame.counter(where), number
            light = path_traced(caster, scenery, rays, where.image, lamps, angle, counter, keys[1])
            return Radiance(light, *(dr.zeros(jit.Array3f, dr.width(where.ray)) for _ in range(3)))

        blur = None
        centre = sampled_rays(frame, where, None, dr.zeros(jit.Float, images), level=scenery.level)
        seen, hits = radiance_along(
            caster, scenery, centre, where.image, lamps, angle, around, config.marine_snow_per_m3, lines
        )
        if trace is not None:
            dr.eval(seen, hits)
            trace_light(trace, hits, seen)
        picture = pixel_light(seen, where, tiling, angle)
        if config.samples > 1 or config.renderer == "reference":  # the middle meters for the others' motion blur
            dr.eval(picture)
            shutter, _ = exposure_of(picture, where, tiling, config, images)
            if config.samples > 1 and (caster.moving is not None or config.blurs_unevenly):
                blur = pixel_blur(hits, centre, where, frame, shutter)
                dr.eval(blur)
            seen = mean_light(light_of, shutter, where, frame, keys[0])
            picture = pixel_light(seen, where, tiling, angle)
        if scenery.air is not None and scenery.air.drops is not None:
            dr.eval(picture, hits)
            open_for = dr.gather(jit.Float, exposure_of(picture, where, tiling, config, images)[0], where.image)
            picture = in_rain(scenery, picture, centre, hits, where.image, open_for, angle)
        picture = through_lens(picture, where, tiling, config, vignette, images)
        dr.eval(picture)
        gains = balance(picture, where, tiling, config)
        lag = None if before is None else exposure_lag(caster, light, ripples, frame, before)
        exposure = exposure_of(picture * gains, where, tiling, config, images, lag)
        return *develop_pictures((picture, gains), exposure, where, frame, keys[0], trace), *exposure

    def _water_around(
        self, caster: Caster, scenery: Scenery, ripples: Ripple, frame: Frame[CameraConfig], where: Pixels
    ) -> tuple[Ambience, SightLines | None]:
        """Diffuse light and shafts around each ray, and lines of sight where the water differs from place to place."""
        tiling = frame.tiling
        squares = shaft_squares(scenery, frame) if ripples.mean_square_slope > 0 else None
        tiles = ambience(caster, scenery, frame, beside=squares)
        around = ambience_at(tiles, tiling, where)
        if squares is not None:
            around = replace(around, shafts=shafts_at(mean_3x3(squares, tiling), tiling, where))
        lines = sight_lines(scenery, frame, where, lambda at: ambience_at(tiles, tiling, at).rate)
        return around, lines

    def _measurement(self, data: Array, truth: Array, shutter: Array, iso: Array) -> Measurement:
        extras = {"exposure_s": np.array(shutter), "iso": np.array(iso)}
        data, truth = (unpack_pictures(packed, self.config, len(shutter)) for packed in (data, truth))
        return Measurement(data, truth, extras=extras)


def mean_light(
    light_of: Callable[[Sample, Array, Array], Radiance],
    exposure: Array,
    where: Pixels,
    frame: Frame[CameraConfig],
    key: Key,
) -> Radiance:
    """Mean over the samples of every pixel, in a loop on the device."""

    def add(number: Array, sharp: Array, near: Array, far: Array, veil: Array) -> tuple[Array, ...]:
        seen = light_of(samples(number, where, frame, key), exposure, number)
        return number + 1, sharp + seen.sharp, near + seen.near, far + seen.far, veil + seen.veil

    lanes, count = dr.width(where.ray), frame.config.samples
    start = (jit.UInt32(0), *(dr.zeros(jit.Array3f, lanes) for _ in range(4)))
    sums = dr.while_loop(start, lambda number, *_: number < count, add, mode="symbolic")[1:]
    return Radiance(*(s / count for s in sums))


def trace_light(trace: Trace, hits: Hits, seen: Radiance) -> None:
    """Light before the lens, as `explain` shows it."""
    trace("slant range", dr.select(hits.valid, hits.t, dr.nan), "m")
    trace("material row", hits.material, "")
    trace("sharp light", seen.sharp, "cd/m^2")
    trace("light scattered by a few degrees", seen.near, "cd/m^2")
    trace("light scattered forward", seen.far, "cd/m^2")
    trace("veiling light", seen.veil, "cd/m^2")

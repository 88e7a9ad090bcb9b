"""A colour camera under and above water, in real time: pictures with the optics, exposure and noise of a real one.

Data and truth are `(m, height, width, 3)` uint8 (uint16 above 8 bits), red green blue, row 0 at the top; with a
`mosaic` `(m, height, width)`. Truth is the picture without noise. Extras: `exposure_s` and `iso`, `(m,)`, as set or
as the meter chose.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable
from dataclasses import replace
from typing import Any, ClassVar, Literal, Self

import drjit as dr
import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.config.strict import refusal
from pelagos.errors import ValidityWarning
from pelagos.jit import Array
from pelagos.optics.caustics import Ripple
from pelagos.optics.lens import natural_vignette
from pelagos.optics.sight_line import SightLines
from pelagos.sensors.adaptation import exposure_lag
from pelagos.sensors.ambient import ambience, ambience_at
from pelagos.sensors.camera_keys import contradiction, idle_keys
from pelagos.sensors.camera_sampling import Sample, sampled_rays, samples
from pelagos.sensors.develop import balanced, developed, exposed, gathered, through_lens, unpacked
from pelagos.sensors.lamp_shade import shaded
from pelagos.sensors.murk import sight_lines
from pelagos.sensors.noise import opaque_key, stream_key
from pelagos.sensors.path_tracing import path_traced
from pelagos.sensors.pixel_blur import pixel_blur
from pelagos.sensors.pixels import Pixels, Tiling, pixels
from pelagos.sensors.ray_change import ray_change
from pelagos.sensors.scenery import Scenery, in_rain
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.shading import Ambience, Radiance, look
from pelagos.sensors.shaft_view import shaft_squares, shafts_at, smoothed
from pelagos.sensors.surroundings import LitViewConfig, Surroundings, light_sources, scenery_of
from pelagos.sensors.view import Lens, Trace, View, pixel_angle, pixel_rays


class CameraConfig(LitViewConfig):
    """A colour camera."""

    type: Literal["camera"] = "camera"
    """The sensor's kind."""
    renderer: Literal["realtime", "reference"] = "realtime"
    """`realtime`: direct light, analytic scattering. `reference`: path tracing, slow; grain falls with `samples`."""
    samples: int = Field(default=1, ge=1, le=65536)
    """Rays per pixel. One is sharp everywhere; more smooth edges, and show `motion_blur` and the depth of field."""
    exposure: Literal["auto", "manual"] = "auto"
    """Whether the frame meters itself, or `shutter_s` and `iso` hold."""
    metering: Literal["average", "centre"] = "average"
    """What the automatic exposure makes middle grey: the mean of the frame, or of its middle; no zone of 16 x 16 px
    counts as brighter than white, so that the sun in the picture leaves the rest visible."""
    compensation_ev: float = Field(default=0.0, ge=-15, le=15)
    """Correction of the automatic exposure [stops]; positive is brighter."""
    meter_min_cd_m2: float = Field(default=0.0, ge=0)
    """Least mean luminance that the meter believes [cd/m^2]; equal to the greatest, the exposure is fixed."""
    meter_max_cd_m2: float = Field(default=1e9, gt=0)
    """Greatest mean luminance that the meter believes [cd/m^2]."""
    exposure_speed_up_ev_per_s: float | None = Field(default=None, gt=0, le=100)
    """How fast the automatic exposure follows a scene that grows brighter [stops/s]; None: at once."""
    exposure_speed_down_ev_per_s: float | None = Field(default=None, gt=0, le=100)
    """How fast it follows a scene that grows darker [stops/s]; None: at once."""
    shutter_s: float = Field(default=0.01, gt=0, le=10)
    """Exposure time [s], at most the time between two frames; under automatic exposure the longest."""
    rolling_shutter_s: float = Field(default=0.0, ge=0, le=1)
    """Time from the first row's exposure to the last's [s]; 0 is a global shutter."""
    motion_blur: float = Field(default=1.0, ge=0, le=1)
    """Share of the exposure that motion is blurred over; needs several `samples`."""
    motion_blur_max: float = Field(default=1.0, ge=0, le=1)
    """Longest streak of motion blur [share of the picture's width]."""
    motion_blur_min_object: float = Field(default=0.0, ge=0, le=1)
    """Radius below which a moving body leaves no streak of its own [share of the picture's width]."""
    aperture: float = Field(default=2.8, ge=0.5, le=64)
    """f-number N; the light that arrives falls with N squared."""
    aperture_blades: int = Field(default=0, ge=0, le=16)
    """Blades of the diaphragm, the shape of blurred lights; 0 is round."""
    aperture_widest: float | None = Field(default=None, ge=0.5, le=64)
    """Lowest f-number of the lens, at which its blades leave a round opening; closed to the double they show fully.
    None: they show always.
    """
    focus_distance_m: float | None = Field(default=None, gt=0)
    """Distance that is in focus [m]; None for a lens that is sharp everywhere. Needs several `samples`."""
    depth_blur_px: float = Field(default=0.0, ge=0, le=64)
    """Radius by which haze softens what is infinitely far [px of a picture 1920 px wide]; needs several `samples`."""
    depth_blur_distance_m: float = Field(default=1000.0, gt=0)
    """Distance at which that softening is half [m]."""
    sensor_width_mm: float = Field(default=6.4, gt=0)
    """Width of the image sensor [mm]; with the field of view it makes the focal length."""
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
    """Fall-off to the corners: power of the natural law (cos^4; sin(a)/a of a fisheye); 0 is none, 1 a simple lens."""
    bloom: float = Field(default=0.0, ge=0, le=8)
    """Glow of bright light in the lens; 1 spreads 4 % of it."""
    lens_flare: float = Field(default=0.0, ge=0, le=16)
    """Strength of the ghosts that bright light leaves across the picture."""
    chromatic_aberration: float = Field(default=0.0, ge=0, le=0.05)
    """How much larger red is than green, and blue smaller, at the picture's corner."""
    chromatic_aberration_start: float = Field(default=0.0, ge=0, le=1)
    """Distance from the picture's middle where that begins; 1 is the corner."""
    white_balance: Literal["daylight", "grey_world"] = "daylight"
    """`daylight` keeps the water's tint; `grey_world` scales red and blue to the mean green, at most 4 times."""
    white_temperature_k: float = Field(default=6500.0, ge=1500, le=15000)
    """Colour temperature of light that looks white [K]; lower makes the picture bluer."""
    white_tint: float = Field(default=0.0, ge=-1, le=1)
    """Stops taken from green; negative is greener."""
    tone: Literal["srgb", "gamma", "film", "linear"] = "srgb"
    """Curve to display values: sRGB with soft highlights, a power `gamma`, a film's, or none."""
    gamma: float = Field(default=2.2, gt=0.1, le=10)
    """Exponent of `tone: gamma`."""
    highlight_knee: float = Field(default=0.7, gt=0, le=1)
    """Linear level from which highlights roll off towards white (`srgb`, `gamma`); 1 clips."""
    film_slope: float = Field(default=0.88, gt=0, le=2)
    """Steepness of the film's straight part."""
    film_toe: float = Field(default=0.55, ge=0, lt=1)
    """How much of the film's range its dark bend takes."""
    film_shoulder: float = Field(default=0.26, ge=0, lt=1)
    """How much of the film's range its bright bend takes."""
    film_black_clip: float = Field(default=0.0, ge=0, le=0.5)
    """How far the film's dark bend reaches below black."""
    film_white_clip: float = Field(default=0.04, ge=0, le=0.5)
    """How far the film's bright bend reaches above white."""
    bits: int = Field(default=8, ge=1, le=16)
    """Bits of a value; above 8 the arrays are uint16."""
    mosaic: Literal["none", "rggb", "bggr", "grbg", "gbrg"] = "none"
    """Raw pictures behind a colour filter array, one value a pixel."""

    marine_snow_per_m3: float = Field(default=0.0, ge=0, le=100)
    """Flakes of marine snow in a cubic metre; a hundred is a blizzard (realtime renderer)."""

    @model_validator(mode="after")
    def _keys_make_sense(self) -> Self:
        if wrong := contradiction(self):
            raise refusal(wrong)
        return self

    @property
    def adapts(self) -> bool:
        """The automatic exposure lags behind the scene."""
        speeds = (self.exposure_speed_up_ev_per_s, self.exposure_speed_down_ev_per_s)
        return self.exposure == "auto" and any(s is not None for s in speeds)

    @property
    def blurs_unevenly(self) -> bool:
        """Blur differs from pixel to pixel, even where nothing moves but the camera."""
        return self.motion_blur_max < 1 or self.depth_blur_px > 0

    @property
    def blades_closed(self) -> float:
        """How much the blades show, from 0 (a round opening) to 1 (a polygon)."""
        if self.aperture_widest is None:
            return 1.0
        return min(max(self.aperture / self.aperture_widest - 1, 0.0), 1.0)

    @property
    def focal_length_m(self) -> float:
        """Of the lens, from the field of view and the sensor's width [m]."""
        return 0.5e-3 * self.sensor_width_mm / math.tan(0.5 * math.radians(min(self.horizontal_fov_deg, 175.0)))


class Camera:
    """See `CameraConfig`."""

    TITLE: ClassVar[str] = "colour camera: water optics, caustics, lamps, exposure, sensor noise"
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
        self._view = View(config, context)
        _, directions = pixel_rays(config.model_copy(update={"port": None}))
        vignette = np.nan_to_num(natural_vignette(directions, config.vignette, fisheye=config.lens == "fisheye"))
        self._vignette = jit.Float(self._view.tiling.arrange(vignette))
        self._surroundings = Surroundings(context)
        self._keys = tuple(opaque_key(stream_key(context.seed, context.path, k)) for k in ("image", "paths"))
        jit.settle(self._vignette)
        self._change = ray_change(config) if config.samples > 1 or config.renderer == "reference" else None
        self._ping = context.scene.compile(self._make)

    def sense(self, motion: Kinematics) -> Measurement:
        """One picture for every lane."""
        return self._measurement(*self._ping(*self._arguments(motion)))

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """Intermediate arrays of one unfrozen frame: (name, values, unit)."""
        return self._view.explain(self._make, self._arguments(motion))

    def _arguments(self, motion: Kinematics) -> tuple[Any, ...]:
        return *self._view.arguments(motion), self._surroundings.arguments(), self._vignette, self._change, self._keys

    def _make(self, static: Any, moving: Any, trace: Trace | None = None) -> Callable[..., Any]:
        config, tiling = self.config, self._view.tiling
        sea = self._surroundings.ripple(config)

        def frame(
            tables: Any, lens: Any, motion: Kinematics, own: Array, light: Any, vignette: Array, change: Any, keys: Any
        ) -> tuple[Array, ...]:  # fmt: skip
            images = dr.width(motion.tick)
            where = pixels(tiling, images)
            scenery = scenery_of(tables, light, sea, motion, config)
            lamps = light_sources(config, motion, where.image)

            angle = pixel_angle(config)
            if config.renderer == "realtime":
                lamps = shaded(lamps, static, moving, scenery, lens, motion, own, config, tiling, where)
            around, lines = self._water_around(static, moving, scenery, sea, lens, motion, own, where)

            def light_of(sample: Sample, exposure: Array, number: Array) -> Radiance:
                rays = sampled_rays(lens, where, motion, own, config, sample, exposure, blur, scenery.level, change)
                if config.renderer == "realtime":
                    return look(
                        static, moving, scenery, rays, where.image, lamps, angle, around,
                        config.marine_snow_per_m3, lines,
                    )[0]  # fmt: skip
                counter = pixel_counter(where, tiling, motion, number)
                light = path_traced(static, moving, scenery, rays, where.image, lamps, angle, counter, keys[1])
                return Radiance(light, *(dr.zeros(jit.Array3f, dr.width(where.ray)) for _ in range(3)))

            blur = None
            centre = sampled_rays(
                lens, where, motion, own, config, None, dr.zeros(jit.Float, images), level=scenery.level
            )
            seen, hits = look(
                static, moving, scenery, centre, where.image, lamps, angle, around, config.marine_snow_per_m3, lines
            )
            if trace is not None:
                dr.eval(seen, hits)
                trace_light(trace, hits, seen)
            picture = gathered(seen, where, tiling, images)
            if config.samples > 1 or config.renderer == "reference":  # the middle meters for the others' motion blur
                dr.eval(picture)
                shutter, _ = exposed(picture, where, tiling, config, images)
                if config.samples > 1 and (moving is not None or config.blurs_unevenly):
                    blur = pixel_blur(hits, centre, where, tiling, motion, config, shutter)
                    dr.eval(blur)
                seen = mean_light(light_of, shutter, where, tiling, motion, keys[0], config)
                picture = gathered(seen, where, tiling, images)
            if scenery.air is not None and scenery.air.drops is not None:
                dr.eval(picture, hits)
                shutter, _ = exposed(picture, where, tiling, config, images)
                exposure = dr.gather(jit.Float, shutter, where.image)
                picture = in_rain(scenery, picture, centre, hits, where.image, exposure, angle)
            picture = through_lens(picture, where, tiling, config, vignette, images)
            dr.eval(picture)
            picture = balanced(picture, where, tiling, config)
            lag = None
            if config.adapts:
                lag = exposure_lag(static, moving, tables, light, sea, lens, motion, own, config, tiling)
            shutter, iso = exposed(picture, where, tiling, config, images, lag)
            data, truth = developed(picture, shutter, iso, where, tiling, config, motion, keys[0], trace)
            return data, truth, shutter, iso

        return frame

    def _water_around(
        self, static: Any, moving: Any, scenery: Scenery, sea: Ripple, lens: Lens, motion: Kinematics, own: Array,
        where: Pixels,
    ) -> tuple[Ambience, SightLines | None]:  # fmt: skip
        """Diffuse light and shafts around each ray, and lines of sight where the water differs from place to place."""
        config, tiling = self.config, self._view.tiling
        squares = shaft_squares(scenery, lens, motion, own, config, tiling) if sea.mean_square_slope > 0 else None
        tiles = ambience(static, moving, scenery, lens, motion, own, config, tiling, beside=squares)
        around = ambience_at(tiles, tiling, where)
        if squares is not None:
            around = replace(around, shafts=shafts_at(smoothed(squares, tiling), tiling, where))
        lines = sight_lines(
            scenery, lens, motion, own, config, tiling, where, lambda at: ambience_at(tiles, tiling, at).rate
        )
        return around, lines

    def _measurement(self, data: Array, truth: Array, shutter: Array, iso: Array) -> Measurement:
        extras = {"exposure_s": np.array(shutter), "iso": np.array(iso)}
        data, truth = (unpacked(packed, self.config, len(shutter)) for packed in (data, truth))
        return Measurement(data, truth, extras=extras)


def mean_light(
    light_of: Callable[[Sample, Array, Array], Radiance],
    exposure: Array,
    where: Pixels,
    tiling: Tiling,
    motion: Kinematics,
    key: Any,
    config: CameraConfig,
) -> Radiance:
    """Mean over the samples of every pixel, in a loop on the device."""

    def add(number: Array, sharp: Array, near: Array, far: Array, veil: Array) -> tuple[Array, ...]:
        sample = samples(
            config.samples, number, where, tiling, motion, key, config.aperture_blades, config.blades_closed
        )
        seen = light_of(sample, exposure, number)
        return number + 1, sharp + seen.sharp, near + seen.near, far + seen.far, veil + seen.veil

    lanes = dr.width(where.ray)
    start = (jit.UInt32(0), *(dr.zeros(jit.Array3f, lanes) for _ in range(4)))
    sums = dr.while_loop(start, lambda number, *_: number < config.samples, add, mode="symbolic")[1:]
    return Radiance(*(s / config.samples for s in sums))


def pixel_counter(
    where: Pixels, tiling: Tiling, motion: Kinematics, number: Array
) -> tuple[Array, Array, Array, Array]:
    """Of random numbers: pixel, environment, tick, sample."""
    environment, tick = (dr.gather(jit.UInt32, v, where.image) for v in (motion.environment, motion.tick))
    return where.row * tiling.width + where.column, environment, tick, number


def trace_light(trace: Trace, hits: Any, seen: Any) -> None:
    """What `explain` shows of the light before the lens."""
    trace("slant range", dr.select(hits.valid, hits.t, dr.nan), "m")
    trace("material row", hits.material, "")
    trace("sharp light", seen.sharp, "cd/m^2")
    trace("light scattered by a few degrees", seen.near, "cd/m^2")
    trace("light scattered forward", seen.far, "cd/m^2")
    trace("veiling light", seen.veil, "cd/m^2")

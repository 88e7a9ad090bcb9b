"""Configuration of a colour camera: its keys, which of them contradict one another, and which change nothing.

A key that is given and cannot show is most likely a mistake of whoever gave it: `gamma` where the tone curve is sRGB's.
"""

from __future__ import annotations

import math
from typing import Final, Literal, Self

from pydantic import Field, model_validator

from pelagos.config.strict import refusal
from pelagos.sensors.camera.picture.surroundings import LitViewConfig
from pelagos.sensors.idle_keys import Need, changed, idle, named


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
    """`daylight` keeps the water's tint; `grey_world` scales red and blue to the mean green, at most 4 times.
    As in a camera it multiplies the sensor's noise too; raw pictures (`mosaic`) have none."""
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
        """Share of the blades in the shape of the opening, from 0 (round) to 1 (a polygon)."""
        if self.aperture_widest is None:
            return 1.0
        return min(max(self.aperture / self.aperture_widest - 1, 0.0), 1.0)

    @property
    def focal_length_m(self) -> float:
        """Of the lens, from the field of view and the sensor's width [m]."""
        return 0.5e-3 * self.sensor_width_mm / math.tan(0.5 * math.radians(min(self.horizontal_fov_deg, 175.0)))


_METERED: Final = (
    "metering", "compensation_ev", "meter_min_cd_m2", "meter_max_cd_m2", "iso_max", "exposure_speed_up_ev_per_s",
    "exposure_speed_down_ev_per_s",
)  # fmt: skip
_FILM: Final = ("film_slope", "film_toe", "film_shoulder", "film_black_clip", "film_white_clip")
_OF_SAMPLES: Final = ("depth_blur_px", "motion_blur_max", "motion_blur_min_object")
"""Keys of blur that differs from pixel to pixel, which several samples show."""
_OF_A_SAMPLE: Final = ("focus_distance_m", "motion_blur")
"""Keys that the one sample of a path tracer shows already."""
NEEDS: Final = (
    Need(_METERED, "exposure", ("auto",)),
    Need(_FILM, "tone", ("film",)),
    Need(("gamma",), "tone", ("gamma",)),
    Need(("highlight_knee",), "tone", ("srgb", "gamma")),
    Need(("white_balance", "white_temperature_k", "white_tint"), "mosaic", ("none",)),
    Need(("marine_snow_per_m3",), "renderer", ("realtime",)),
    Need(("aperture_blades", "sensor_width_mm"), "focus_distance_m"),
    Need(("aperture_widest",), "aperture_blades"),
    Need(("depth_blur_distance_m",), "depth_blur_px"),
    Need(("chromatic_aberration_start",), "chromatic_aberration"),
)


def idle_keys(config: CameraConfig) -> str | None:
    """Keys that were changed and change nothing, with what they need; None where there are none."""
    if told := idle(config, NEEDS):
        return told
    if config.samples == 1 and (alone := changed(config, _OF_SAMPLES + _OF_A_SAMPLE * (config.renderer == "realtime"))):
        return f"{named(alone)} changes nothing without several 'samples', 16 say"
    return None


def contradiction(config: CameraConfig) -> str | None:
    """Contradiction in the keys of an exposure; None where all is well."""
    period, exposure, readout = 1 / config.rate_hz, config.shutter_s, config.rolling_shutter_s
    if config.exposure == "manual" and exposure > period * (1 + 1e-9):
        return f"'shutter_s' of {exposure:g} s is longer than the {period:.4g} s between two frames"
    if readout > period * (1 + 1e-9):
        return f"'rolling_shutter_s' of {readout:g} s is longer than the {period:.4g} s between two frames"
    if config.exposure == "auto" and config.iso > config.iso_max and "iso_max" in config.model_fields_set:
        return f"'iso' of {config.iso:g}, the lowest of the automatic exposure, is above 'iso_max', {config.iso_max:g}"
    if config.meter_min_cd_m2 > config.meter_max_cd_m2:
        return f"'meter_min_cd_m2', {config.meter_min_cd_m2:g}, is above 'meter_max_cd_m2', {config.meter_max_cd_m2:g}"
    if config.aperture_widest is not None and config.aperture < config.aperture_widest:
        return f"'aperture' of {config.aperture:g} is wider than 'aperture_widest', f/{config.aperture_widest:g}"
    return None

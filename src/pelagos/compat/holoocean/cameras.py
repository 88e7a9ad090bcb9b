"""HoloOcean's cameras."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, ClassVar, Final

import numpy as np

from pelagos.compat.holoocean.sensor import HoloOceanSensor
from pelagos.sensors.sensor import Reading

if TYPE_CHECKING:
    from pelagos.compat.holoocean.motion import AgentMotion

_SIZE: Final = frozenset({"CaptureWidth", "CaptureHeight"})
FAR_M: Final = 1000.0  # HoloOcean's depth ends here
_CAMERA: Final = _SIZE | frozenset(
    {
        "FovAngle", "TargetGamma", "ExposureMethod", "ExposureCompensation", "ShutterSpeed", "ISO", "Aperture",
        "Aperature", "FilmSlope", "FilmToe", "FilmShoulder", "FilmBlackClip", "FilmWhiteClip", "ExposureMinBrightness",
        "ExposureMaxBrightness", "LensFlareIntensity", "BloomIntensity", "WhiteTemp", "WhiteTint",
        "ChromAberrIntensity", "ChromAberrOffset", "DepthOfFieldMinFstop", "ExposureSpeedDown", "ExposureSpeedUp",
        "MotionBlurMaxDistortion", "MotionBlurIntensity", "MotionBlurMinObjectScreenSize", "MaxViewDistanceOverride",
        "FocalDistance", "DepthBlurAmount", "DepthBlurRadius", "BladeCount",
    }
)  # fmt: skip
_FILM: Final = {
    "FilmSlope": "film_slope", "FilmToe": "film_toe", "FilmShoulder": "film_shoulder",
    "FilmBlackClip": "film_black_clip", "FilmWhiteClip": "film_white_clip",
}  # fmt: skip
_SCALED: Final = {
    "FocalDistance": ("focus_distance_m", 0.01), "DepthBlurRadius": ("depth_blur_px", 1.0),
    "DepthBlurAmount": ("depth_blur_distance_m", 1000.0), "MotionBlurIntensity": ("motion_blur", 1.0),
    "MotionBlurMaxDistortion": ("motion_blur_max", 1.0), "MaxViewDistanceOverride": ("max_range_m", 0.01),
    "MotionBlurMinObjectScreenSize": ("motion_blur_min_object", 0.01), "DepthOfFieldMinFstop": ("aperture_widest", 1.0),
    "BladeCount": ("aperture_blades", 1), "ChromAberrIntensity": ("chromatic_aberration", 0.01),
}  # fmt: skip
"""Native keys, and how many of their units one of HoloOcean's is; 0 stands for the engine's own choice."""
_SPREAD: Final = frozenset({"FocalDistance", "DepthBlurRadius", "MotionBlurIntensity"})
_SAMPLES: Final = 8  # rays of a pixel where something is to be blurred
_METERED: Final = {"ExposureSpeedUp": "exposure_speed_up_ev_per_s", "ExposureSpeedDown": "exposure_speed_down_ev_per_s"}
_CD_PER_EV: Final = 0.125  # luminance of EV100 0 at the usual calibration K = 12.5 cd s/m^2
_PLAIN: Final = {
    "BloomIntensity": "bloom", "LensFlareIntensity": "lens_flare", "WhiteTemp": "white_temperature_k",
    "WhiteTint": "white_tint", "ChromAberrOffset": "chromatic_aberration_start",
}  # fmt: skip


class _View(HoloOceanSensor):
    """A picture of `CaptureWidth` x `CaptureHeight`."""

    keys = _SIZE
    usual: ClassVar[tuple[int, int]] = (256, 256)

    @property
    def width(self) -> int:
        """[px]"""
        return int(self.config.get("CaptureWidth", self.usual[0]))

    @property
    def height(self) -> int:
        """[px]"""
        return int(self.config.get("CaptureHeight", self.usual[1]))

    @property
    def fov(self) -> float:
        """Across the width [deg]."""
        return float(self.config.get("FovAngle", 90.0))

    @property
    def data_shape(self) -> Sequence[int]:
        return [self.height, self.width, 4]

    @property
    def dtype(self) -> Any:
        return np.uint8

    def view(self, kind: str) -> dict[str, Any]:
        """Keys of the native view."""
        lens = {} if self.fov < 170 else {"lens": "fisheye"}
        return {
            "type": kind, "width_px": self.width, "height_px": self.height, "horizontal_fov_deg": self.fov, **lens,
        }  # fmt: skip

    def picture(self, rgb: Any) -> Any:
        """`(H, W, 3)` red green blue as HoloOcean's blue green red alpha."""
        made = np.empty((*rgb.shape[:2], 4), dtype=np.uint8)
        made[..., :3], made[..., 3] = rgb[..., ::-1], 255
        return made


class RGBCamera(_View):
    """A colour picture, blue green red alpha, 90 deg wide."""

    sensor_type = "RGBCamera"
    keys = _SIZE | {"FovAngle"}

    def native(self) -> dict[str, Any] | None:
        return self.view("camera") | self.env.lamps_of(self.agent_name)

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        return self.picture(reading.data[0])


class CameraSensor(RGBCamera):
    """The same with a lens, a shutter and a film."""

    sensor_type = "CameraSensor"
    keys = _CAMERA

    def setup(self) -> None:
        if "Aperature" in self.config:
            self.env.advice.once("Aperature, as one of HoloOcean's pages spells it, is taken as Aperture")

    def native(self) -> dict[str, Any] | None:
        c = self.config
        made = super().native() or {}
        made |= {native: c[key] for key, native in _PLAIN.items() if key in c}
        made |= {native: c[key] * by for key, (native, by) in _SCALED.items() if c.get(key)}
        if any(c.get(key) for key in _SPREAD):
            made["samples"] = _SAMPLES
        film = {native: c[key] for key, native in _FILM.items() if key in c}
        if film:
            made |= {"tone": "film", **film}
        elif "TargetGamma" in c:
            made |= {"tone": "gamma", "gamma": float(c["TargetGamma"])}
        if "Aperture" in c or "Aperature" in c or "FocalDistance" in c:
            made["aperture"] = float(c.get("Aperture", c.get("Aperature", 4.0)))
        if "aperture_widest" in made:
            made["aperture_widest"] = min(made["aperture_widest"], made.setdefault("aperture", 4.0))
        return made | (self._manual() if c.get("ExposureMethod") == "AEM_Manual" else self._automatic())

    def _manual(self) -> dict[str, Any]:
        """Keys of a fixed exposure."""
        c = self.config
        f_stop = c.get("Aperture", c.get("Aperature", 4.0))
        shutter = 1 / float(c.get("ShutterSpeed", 60)) / 2.0 ** -float(c.get("ExposureCompensation", 0))
        return {
            "exposure": "manual", "iso": float(c.get("ISO", 100)), "aperture": float(f_stop), "shutter_s": shutter,
        }  # fmt: skip

    def _automatic(self) -> dict[str, Any]:
        """Keys of the automatic exposure."""
        c = self.config
        made = {native: float(c[key]) for key, native in _METERED.items() if key in c}
        for key, native in (("ExposureMinBrightness", "meter_min_cd_m2"), ("ExposureMaxBrightness", "meter_max_cd_m2")):
            if key in c:
                made[native] = _CD_PER_EV * 2.0 ** float(c[key])
        if "ExposureCompensation" in c:
            made["compensation_ev"] = float(c["ExposureCompensation"]) - 4.0  # 4 is HoloOcean's normal
        return made


class ViewportCapture(RGBCamera):
    """Spectator's picture: a camera where `move_viewport` put it, behind and above the agent until then."""

    sensor_type = "ViewportCapture"
    keys = _SIZE | {"Width", "Height"}
    usual = (1280, 720)

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        if self.env.viewport_shown is None or self.env.viewport_on:
            moved = self.env.viewport is not None
            self.env.viewport_shown = self.env.viewport_picture(self) if moved else super().value(motion, reading)
        return self.env.viewport_shown.copy()


class DepthCamera(_View):
    """Distance along the optical axis, as metres and as HoloOcean's 24-bit colours; there at every tick."""

    sensor_type = "DepthCamera"
    keys = _CAMERA
    always = True

    @property
    def data_shape(self) -> Sequence[int]:
        return [self.height, self.width, 4]

    def zero(self) -> Any:
        return {"image": np.zeros(self.data_shape, np.uint8), "depth": np.zeros((self.height, self.width))}

    def native(self) -> dict[str, Any] | None:
        return self.view("depth_camera") | {"max_range_m": FAR_M}

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        depth = np.minimum(np.where(np.isfinite(reading.data[0]), reading.data[0], FAR_M), FAR_M).astype(np.float64)
        code = np.round(depth / FAR_M * (2**24 - 1)).astype(np.uint32)
        image = np.empty((*depth.shape, 4), dtype=np.uint8)
        image[..., 2], image[..., 1], image[..., 0] = code & 255, (code >> 8) & 255, code >> 16
        image[..., 3] = 255
        return {"image": image, "depth": FAR_M * code.astype(np.float64) / (2**24 - 1)}


class SemanticSegmentationCamera(_View):
    """Colours of labels, red green blue in channels 2, 1, 0."""

    sensor_type = "SemanticSegmentationCamera"
    keys = _CAMERA

    def native(self) -> dict[str, Any] | None:
        return self.view("semantic_camera")

    def value(self, motion: AgentMotion, reading: Reading | None) -> Any:
        assert reading is not None
        return self.picture(reading.extras["palette"][reading.data[0]])

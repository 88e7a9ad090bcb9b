"""Which keys of a camera contradict one another, and which change nothing.

A key that is given and cannot show is most likely a mistake of whoever gave it: `gamma` where the tone curve is sRGB's.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Final

if TYPE_CHECKING:
    from pelagos.sensors.camera import CameraConfig


@dataclass(frozen=True)
class Need:
    """Keys that show only where another key has one of some values.

    Attributes:
        keys: those that need it.
        key: the other.
        values: under which they show.
    """

    keys: tuple[str, ...]
    key: str
    values: tuple[Any, ...]


_METERED: Final = (
    "metering", "compensation_ev", "meter_min_cd_m2", "meter_max_cd_m2", "iso_max", "exposure_speed_up_ev_per_s",
    "exposure_speed_down_ev_per_s",
)  # fmt: skip
_FILM: Final = ("film_slope", "film_toe", "film_shoulder", "film_black_clip", "film_white_clip")
NEEDS: Final = (
    Need(_METERED, "exposure", ("auto",)),
    Need(_FILM, "tone", ("film",)),
    Need(("gamma",), "tone", ("gamma",)),
    Need(("highlight_knee",), "tone", ("srgb", "gamma")),
    Need(("marine_snow_per_m3",), "renderer", ("realtime",)),
)


def idle_keys(config: CameraConfig) -> str | None:
    """Keys that were changed and change nothing, with what they need; None where there are none."""

    for need in NEEDS:
        if getattr(config, need.key) not in need.values and (idle := changed(config, need.keys)):
            return f"{named(idle)} changes nothing without '{need.key}: {' or '.join(need.values)}'"
    if config.samples == 1 and (idle := changed(config, ("focus_distance_m", "depth_blur_px"))):
        return f"{named(idle)} changes nothing without several 'samples', 16 say"
    return None


def contradiction(config: CameraConfig) -> str | None:
    """What cannot be about an exposure; None where all is well."""
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


def changed(config: CameraConfig, keys: Iterable[str]) -> list[str]:
    """Those that do not have their default."""
    return [k for k in keys if getattr(config, k) != type(config).model_fields[k].default]


def named(keys: list[str]) -> str:
    """Keys as messages name them."""
    return ", ".join(f"'{k}'" for k in keys)

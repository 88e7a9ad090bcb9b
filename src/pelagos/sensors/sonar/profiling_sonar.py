"""Profiling sonar: a thin fan that cuts a profile out of the world, as water-column data and as ranges."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.config.rate import Rate
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.ping_keys import ping_spec
from pelagos.sensors.sonar.keys.sector_keys import SectorConfig, element_tables, layout, warn_of_seed
from pelagos.sensors.sonar.ping.pinger import Pinger
from pelagos.sensors.sonar.ping.thin_fan_rays import slice_rays


class ProfilingSonarConfig(SectorConfig):
    """A multibeam profiler: 120 x 1 deg. Pitch it by 90 deg to look down."""

    type: Literal["profiling_sonar"] = "profiling_sonar"
    rate_hz: Rate = 5.0
    """Pings per second [Hz]."""
    beams: int = Field(default=240, ge=1, le=4096)
    """Beams across the sector."""
    bins: int = Field(default=750, ge=8, le=16384)
    """Range bins."""
    range_max_m: float = Field(default=75.0, gt=0, le=12000)
    """Far edge of the last bin [m]."""
    horizontal_aperture_deg: float = Field(default=120.0, gt=0, le=170)
    """Sector [deg], from the first beam's outer edge to the last one's."""
    vertical_beamwidth_deg: float = Field(default=1.0, gt=0, le=90)
    """Half-power width of the fan across it [deg], one way."""
    frequency_hz: float = Field(default=675e3, ge=200)
    """Centre frequency [Hz]."""
    rays_per_beam: int = Field(default=64, ge=4, le=4096)
    """Rays a beam, stratified across the beam both ways."""
    detection_db: float = Field(default=15.0, ge=0)
    """Level over the middle of a beam's samples at which a sample is an echo [dB]."""  # assumed


def fan_rays(config: ProfilingSonarConfig) -> dict[str, NDArray[Any]]:
    """The ray pattern in the sensor frame: x ahead, y left, z out of the fan (see `slice_rays`)."""
    sectors = np.full(config.beams, math.radians(config.horizontal_aperture_deg) / config.beams)
    width = math.radians(config.vertical_beamwidth_deg)
    return slice_rays(config.azimuths, sectors, rays=config.rays_per_beam, width=width, ways=2)


class ProfilingSonar:
    """A profiling sonar.

    data: `(m, beams, bins)` float32, water-column levels, as `ImagingSonar` gives them.
    truth: the same without noise and without interference of echoes.
    extras: `profile` `(m, beams)`, range of the strongest echo [m], NaN without one; `profile_truth`, that of the
        truth; and those of `ImagingSonar`.
    tables: `azimuth` `(beams,)` [rad], positive to the left; `range` `(bins,)` [m], middle of each bin.
    """

    TITLE: ClassVar[str] = "profiling sonar: a thin fan of beams with water-column data and ranges"
    KERNELS: ClassVar[int] = 27
    CASTS: ClassVar[int] = 1
    MAY_LACK: ClassVar[bool] = True
    Config: ClassVar[type[SensorConfig]] = ProfilingSonarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Chapters 5 and 8",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
    )

    def __init__(self, config: ProfilingSonarConfig, context: SensorContext) -> None:
        self.config = config
        warn_of_seed(config, context.path)
        self._spec = ping_spec(config, context)
        self._pinger = Pinger(self._spec, context, fan_rays(config), layout(config))
        self.tables = {"azimuth": config.azimuths.astype(np.float32), "range": config.ranges, **element_tables(config)}

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        data, mean, extras = self._pinger.ping(motion)
        truth = mean()
        for name, image in (("profile", data), ("profile_truth", truth)):
            extras[name] = strongest(self._spec.display.decibels(image), self.config.ranges, self.config.detection_db)
        return Measurement(data, truth, None, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._pinger.explain(motion)


def strongest(levels: NDArray[np.float32], ranges: NDArray[np.float32], margin: float) -> NDArray[np.float32]:
    """Range of the strongest sample of each beam `(m, beams)`; NaN where it is not `margin` over the median [dB]."""
    found = levels.max(axis=-1) > np.median(levels, axis=-1) + margin
    return np.where(found, ranges[levels.argmax(axis=-1)], np.float32(np.nan))

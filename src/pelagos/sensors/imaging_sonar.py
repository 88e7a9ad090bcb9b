"""Forward-looking imaging sonar: an intensity for every beam and range, as interference makes it."""

from __future__ import annotations

from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.sensors.pinger import Pinger
from pelagos.sensors.sector import SectorConfig, fan_rays, layout
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext


class ImagingSonarConfig(SectorConfig):
    """A multibeam forward-looking sonar. Defaults are of the 750 kHz class with 130 x 20 deg."""

    type: Literal["imaging_sonar"] = "imaging_sonar"
    rate_hz: float = Field(default=5.0, gt=0)
    """Pings per second [Hz]."""


class ImagingSonar:
    """A forward-looking imaging sonar.

    data: `(m, beams, bins)` float32, echo level after time-varied gain. In decibels it is the backscattering strength
        that a horizontal bottom filling the cell would have (with tvg_db 30); `scale` says how it is given.
    truth: the same without noise and without interference (the mean over all realisations of the roughness).
    extras: with `iq`, `iq` complex64 `(m, beams, bins)`, signal and noise before gain, re the source level at 1 m; with
        `labels`, `label` and `instance` `(m, beams, bins)` of the strongest echo, 0 for none.
    tables: `azimuth` `(beams,)` [rad], positive to the left; `range` `(bins,)` [m], middle of each bin.
    """

    TITLE: ClassVar[str] = "forward-looking multibeam imaging sonar: polar intensity images with coherent speckle"
    Config: ClassVar[type[SensorConfig]] = ImagingSonarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Chapters 3, 5 and 8",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
        "R. E. Francois and G. R. Garrison, J. Acoust. Soc. Am. 72, 1879 (1982), doi 10.1121/1.388673: absorption",
        "J. W. Goodman, Speckle Phenomena in Optics, 2nd ed. (2020): coherent sum",
        "G. M. Wenz, J. Acoust. Soc. Am. 34, 1936 (1962), doi 10.1121/1.1909155: ambient noise",
    )

    def __init__(self, config: ImagingSonarConfig, context: SensorContext) -> None:
        self.config = config
        self._pinger = Pinger(config, context, fan_rays(config), layout(config))
        self.tables = {"azimuth": config.azimuths.astype(np.float32), "range": config.ranges}

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        return self._pinger.measurement(motion, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._pinger.explain(motion)

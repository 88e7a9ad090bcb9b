"""Single-beam echo sounder: one cone, one echo trace a ping; pings side by side make an echogram."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.config.rate import Rate
from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.ping_keys import PingConfig, ping_spec
from pelagos.sensors.sonar.ping.aperture import round_aperture
from pelagos.sensors.sonar.ping.cone_rays import cone_rays
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.pinger import Pinger


class SinglebeamConfig(PingConfig):
    """A single-beam echo sounder that looks along -z of its frame. Defaults are of the 200 kHz class."""

    type: Literal["singlebeam"] = "singlebeam"
    rate_hz: Rate = 5.0
    """Pings per second [Hz]."""
    beamwidth_deg: float = Field(default=9.0, gt=0, le=60)
    """Half-power width of the cone [deg], one way."""
    frequency_hz: float = Field(default=200e3, ge=200)
    """Frequency [Hz]."""
    bandwidth_hz: float = Field(default=10e3, gt=0)
    """Bandwidth of the pulse [Hz]."""
    rays: int = Field(default=512, ge=8, le=65536)
    """Rays in the cone."""


class Singlebeam:
    """A single-beam echo sounder.

    data: `(m, bins)` float32, echo level after time-varied gain, in the unit that `scale` says. In decibels it is the
        backscattering strength of a surface that fills a cell of one beam width and one bin.
    truth: the same without noise and without interference of echoes.
    extras: with `iq`, `iq` complex64 `(m, bins)` before gain; with `labels`, `label` and `instance` `(m, bins)`.
    tables: `range` `(bins,)` [m], middle of each bin.
    """

    TITLE: ClassVar[str] = "single-beam echo sounder: one echo trace a ping"
    KERNELS: ClassVar[int] = 22
    CASTS: ClassVar[int] = 1
    Config: ClassVar[type[SensorConfig]] = SinglebeamConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Section 8.1",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
    )

    def __init__(self, config: SinglebeamConfig, context: SensorContext) -> None:
        self.config = config
        width = math.radians(config.beamwidth_deg)
        shape = Layout(
            1, width, width, width, np.zeros(1), aperture=round_aperture(np.array([[0.0, 0.0, -1.0]]), width)
        )
        self._pinger = Pinger(ping_spec(config, context), context, cone_rays(width, config.rays), shape)
        self.tables = {"range": config.ranges}

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        data, truth, extras = self._pinger.ping(motion)
        return Measurement(
            data[:, 0], promised(lambda: truth()[:, 0]), None, {k: v[:, 0] for k, v in extras.items()}, self.tables
        )

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._pinger.explain(motion)

"""Sidescan sonar: a thin fan to each side; pings side by side make the picture."""

from __future__ import annotations

import math
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.acoustics.beam_pattern import line_length, line_np, spread_over_beam
from pelagos.config.rate import Rate
from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.ping_keys import PingConfig, ping_spec
from pelagos.sensors.sonar.ping.aperture import Aperture
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.pinger import Pinger

_STEP: Final = 0.6180339887498949  # additive recurrence of the golden ratio: evenly spread along the track
_BELOW: Final = math.radians(5.0)  # how far each side's rays reach beyond straight down
_HORIZON: Final = math.radians(95.0)  # and up to above the horizon
_OVERHEAD: Final = math.radians(185.0)  # and, fewer of them, beyond straight up: the surface's own line in the picture
_THINNED: Final = 8  # times fewer a degree up there, about


class SidescanConfig(PingConfig):
    """A sidescan sonar with one transducer a side. Defaults are of the 450 kHz class on an AUV."""

    type: Literal["sidescan"] = "sidescan"
    rate_hz: Rate = 8.0
    """Pings per second [Hz]."""
    bins: int = Field(default=1024, ge=8, le=65536)
    """Range bins of each side."""
    range_min_m: float = Field(default=0.2, gt=0)
    """Near edge of the first bin [m]."""
    beamwidth_deg: float = Field(default=0.5, ge=0.01, le=20)
    """Half-power width along the track [deg], one way."""
    vertical_beamwidth_deg: float = Field(default=50.0, gt=0, le=90)
    """Half-power width across the track [deg], one way."""
    depression_deg: float = Field(default=30.0, ge=0, le=90)
    """Angle of the transducers' axes below the horizon [deg]."""
    frequency_hz: float = Field(default=450e3, ge=200)
    """Centre frequency [Hz]."""
    vertical_floor_db: float = Field(default=-15.0, le=0)
    """Response across the track where the ideal pattern has nulls and beyond, one way [dB]: real transducers fill them,
    and hear the bottom straight below."""  # assumed
    rays_per_side: int = Field(default=1024, ge=16, le=65536)
    """Rays of each side, stratified from below to the horizon."""


def side_rays(config: SidescanConfig) -> dict[str, NDArray[Any]]:
    """The ray pattern in the sensor frame, first the port side (+y), then starboard (see `Fan`).

    Strata of equal angle from 5 deg beyond straight down to 5 deg above the horizon; within the beam along the track
    the rays are spread by the two-way pattern, so that all have the same weight.
    """
    count = config.rays_per_side
    above = max(count // _THINNED, 8)
    edges = np.linspace(-_BELOW, _HORIZON, count + 1)  # angle from straight down
    edges = np.concatenate([edges, np.linspace(_HORIZON, _OVERHEAD, above + 1)[1:]])
    count += above
    low, high = np.tile(edges[:-1], 2), np.tile(edges[1:], 2)
    angle = 0.5 * (low + high)
    side = np.repeat([1.0, -1.0], count)
    width = math.radians(config.beamwidth_deg)
    length = line_length(width)
    ahead, along_track = spread_over_beam(length, (0.5 + _STEP * np.arange(2 * count)) % 1.0)
    vertical = line_length(math.radians(config.vertical_beamwidth_deg))
    off_axis = angle - (math.pi / 2 - math.radians(config.depression_deg))
    power = line_np(np.sin(off_axis), vertical) ** 2 * (np.abs(off_axis) < math.pi / 2)
    floor = 10.0 ** (config.vertical_floor_db / 10.0)
    shape = ((power + floor) / (1.0 + floor)) ** 2  # there and back
    sa, ca, sh, ch = np.sin(angle), np.cos(angle), np.sin(ahead), np.cos(ahead)
    return {
        "direction": np.stack([sh, side * ch * sa, -ch * ca], axis=-1),
        "along": np.stack([0 * sa, side * ca, sa], axis=-1),
        "aside": np.stack([-sh, side * (1 - ch) * sa, -(1 - ch) * ca], axis=-1),
        "lower": low - angle,
        "upper": high - angle,
        "across": np.full(2 * count, math.sqrt(2.0) * along_track),  # even spread with as many close pairs as a bell's
        "weight": (high - low) * along_track * shape,
        "beam": np.repeat([0, 1], count),
    }


def aperture(config: SidescanConfig) -> Aperture:
    """One transducer a side, both ways."""
    sine, cosine = (f(math.radians(config.depression_deg)) for f in (math.sin, math.cos))
    axis = np.array([[0.0, side * cosine, -sine] for side in (1.0, -1.0)])
    up = np.array([[0.0, side * sine, cosine] for side in (1.0, -1.0)])
    along, across = (line_length(math.radians(a)) for a in (config.beamwidth_deg, config.vertical_beamwidth_deg))
    return Aperture(axis, np.array([1.0, 0.0, 0.0]), up, along, across, floor=10.0 ** (config.vertical_floor_db / 10.0))


class Sidescan:
    """A sidescan sonar.

    data: `(m, 2, bins)` float32, port and starboard, echo level after time-varied gain over slant range, in the unit
        that `scale` says. In decibels it is the backscattering strength of a horizontal bottom that fills the cell.
    truth: the same without noise and without interference of echoes.
    extras: `altitude` `(m,)`, range of the first bottom return [m] (NaN without one), and `ground_range` `(m, bins)`,
        the distance from the track over a flat bottom at that altitude [m], NaN in the water column; with `iq` and
        `labels` as `ImagingSonar`.
    tables: `range` `(bins,)` slant range [m], middle of each bin.
    """

    TITLE: ClassVar[str] = "sidescan sonar: port and starboard traces"
    KERNELS: ClassVar[int] = 22
    CASTS: ClassVar[int] = 1
    Config: ClassVar[type[SensorConfig]] = SidescanConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "P. Blondel, The Handbook of Sidescan Sonar (2009), Chapter 2, doi 10.1007/978-3-540-49886-5",
        "X. Lurton, An Introduction to Underwater Acoustics, 2nd ed. (2010), Section 8.2",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
    )

    def __init__(self, config: SidescanConfig, context: SensorContext) -> None:
        self.config = config
        width = math.radians(config.beamwidth_deg)
        azimuths = np.array([math.pi / 2, -math.pi / 2])
        shape = Layout(2, width, width, math.radians(config.vertical_beamwidth_deg), azimuths, single_file=True,
                       aperture=aperture(config))  # fmt: skip
        self._spec = ping_spec(config, context)
        self._pinger = Pinger(self._spec, context, side_rays(config), shape)
        self.tables = {"range": config.ranges}

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        data, truth, extras = self._pinger.ping(motion)
        altitude = first_return(self._spec.display.decibels(data), self.config.ranges)
        squared = self.config.ranges[None, :] ** 2 - altitude[:, None] ** 2
        extras["altitude"] = altitude
        extras["ground_range"] = np.where(squared >= 0, np.sqrt(np.maximum(squared, 0.0)), np.float32(np.nan))
        return Measurement(data, promised(truth), None, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._pinger.explain(motion)


def first_return(levels: NDArray[np.float32], ranges: NDArray[np.float32]) -> NDArray[np.float32]:
    """Range `(m,)` where the mean of both sides over five bins first comes within 12 dB of its 90th percentile.

    `levels` `(m, 2, bins)` [dB]; NaN where the trace has no such step: its 90th percentile less than 6 dB over the
    median of the first tenth of the bins.
    """
    power = (10.0 ** (levels / 10.0)).mean(axis=1)
    power = np.stack([np.convolve(trace, np.full(5, 0.2), mode="same") for trace in power])
    reference = np.percentile(power, 90, axis=-1)
    quiet = np.median(power[:, : max(power.shape[1] // 10, 1)], axis=-1)
    loud = power > reference[:, None] / 10.0**1.2
    found = loud.any(axis=-1) & (reference > 4.0 * quiet)
    return np.where(found, ranges[loud.argmax(axis=-1)], np.float32(np.nan))

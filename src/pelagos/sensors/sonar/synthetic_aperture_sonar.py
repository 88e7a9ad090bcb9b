"""Synthetic aperture sonar: coherent raw pings along the track, to be focused afterwards."""

from __future__ import annotations

import math
import warnings
from typing import Any, ClassVar, Final, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.acoustics.beam_pattern import line_length, line_np
from pelagos.acoustics.pulse import range_resolution
from pelagos.config.rate import Rate
from pelagos.errors import ValidityWarning
from pelagos.math.constants import NOMINAL_SOUND_SPEED
from pelagos.sensors.lazy import promised
from pelagos.sensors.mount import sensor_pose, sensor_velocity
from pelagos.sensors.schedule import SLOWEST
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.ping_keys import PingConfig, ping_spec
from pelagos.sensors.sonar.ping.aperture import Aperture, one_beam
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.pinger import Pinger

_STEP: Final = 0.7548776662466927  # additive recurrences of the plastic number: evenly spread in two dimensions
_STEP2: Final = 0.5698402909980532


class SyntheticApertureSonarConfig(PingConfig):
    """A one-sided synthetic aperture sonar that looks along +y of its frame (roll 180 deg to look to starboard)."""

    type: Literal["synthetic_aperture_sonar"] = "synthetic_aperture_sonar"
    rate_hz: Rate = 10.0
    """Pings per second [Hz]; two successive pings should lie at most half an element apart (see `step_m`)."""
    bins: int = Field(default=1400, ge=8, le=65536)
    """Range bins; they should be no wider than c/2B, or the pulse is undersampled."""
    range_min_m: float = Field(default=5.0, gt=0)
    """Near edge of the first bin [m]."""
    range_max_m: float = Field(default=40.0, gt=0, le=12000)
    """Far edge of the last bin [m]."""
    frequency_hz: float = Field(default=120e3, ge=200)
    """Centre frequency [Hz]."""
    bandwidth_hz: float = Field(default=30e3, gt=0)
    """Bandwidth of the pulse [Hz]."""
    beamwidth_deg: float = Field(default=15.0, gt=0, le=60)
    """Half-power width of the element along the track [deg], one way."""
    vertical_beamwidth_deg: float = Field(default=40.0, gt=0, le=90)
    """Half-power width across the track [deg], one way."""
    depression_deg: float = Field(default=25.0, ge=0, le=90)
    """Angle of the axis below the horizon [deg]."""
    facet_m: float = Field(default=0.05, gt=0)
    """Edge of the lattice of scatterers [m]: about the resolution that is wanted along the track."""
    rays: int = Field(default=16384, ge=64, le=1_000_000)
    """Rays in the beam: enough to see most scatterers in every ping."""
    iq: bool = True
    """Always given: the complex signal is what this sonar is for."""

    @model_validator(mode="after")
    def _signal(self) -> Self:
        if not self.iq:
            raise ValueError("iq: false leaves nothing of a sonar that gives its complex signal; leave it out")
        if self.painted_noise is not None:
            raise ValueError("painted_noise is painted on levels, and this sonar gives its signal; leave it out")
        return self

    @property
    def step_m(self) -> float:
        """Farthest that two pings may lie apart along the track [m]: half the element's length, at 1500 m/s."""
        return 0.5 * line_length(math.radians(self.beamwidth_deg)) * NOMINAL_SOUND_SPEED / self.frequency_hz


def beam_rays(config: SyntheticApertureSonarConfig) -> dict[str, NDArray[Any]]:
    """Rays about +y: a grid of strata, in elevation as many as along the track, to the half-power edges times 1.1."""
    rows = max(int(math.sqrt(config.rays)), 8)
    columns = config.rays // rows
    vertical, along = math.radians(config.vertical_beamwidth_deg), math.radians(config.beamwidth_deg)
    depression = math.radians(config.depression_deg)
    row, column = (a.ravel() for a in np.meshgrid(np.arange(rows), np.arange(columns), indexing="ij"))
    lowest, highest = max(-1.1 * vertical - depression, -math.pi / 2 + 1e-3), 1.1 * vertical - depression
    offset = (0.5 + _STEP * column) % 1.0  # edges that were the same in all columns would show as rings
    low, high = (lowest + np.clip((row + i - 1 + offset) / (rows - 1), 0.0, 1.0) * (highest - lowest) for i in (0, 1))
    grid = np.linspace(lowest, highest, 8001)
    power = line_np(np.sin(grid + depression), line_length(vertical)) ** 4 * np.cos(grid) * (grid[1] - grid[0])
    share = np.concatenate([[0.0], np.cumsum(0.5 * (power[1:] + power[:-1]))])
    elevation = low + (0.5 + _STEP * column) % 1.0 * (high - low)
    step = 2.2 * along / columns
    azimuth = -1.1 * along + (column + (0.5 + _STEP2 * row) % 1.0) * step
    ce, se, ca, sa = np.cos(elevation), np.sin(elevation), np.cos(azimuth), np.sin(azimuth)
    return {
        "direction": np.stack([ce * sa, ce * ca, se], axis=-1),
        "along": np.stack([-se * sa, -se * ca, ce], axis=-1),
        "aside": np.zeros((len(row), 3)),
        "lower": low - elevation,
        "upper": high - elevation,
        "across": np.full(len(row), step),
        "weight": step
        * (np.interp(high, grid, share) - np.interp(low, grid, share))
        * line_np(sa, line_length(along)) ** 4,
        "beam": np.zeros(len(row), dtype=np.uint32),
    }


def aperture(config: SyntheticApertureSonarConfig) -> Aperture:
    """One element that looks along +y, tilted down, both ways."""
    sine, cosine = (f(math.radians(config.depression_deg)) for f in (math.sin, math.cos))
    along, across = (line_length(math.radians(a)) for a in (config.beamwidth_deg, config.vertical_beamwidth_deg))
    return Aperture(*one_beam([0.0, cosine, -sine], [1.0, 0.0, 0.0], [0.0, sine, cosine]), along, across)


class SyntheticApertureSonar:
    """A synthetic aperture sonar.

    data: `(m, bins)` complex64, baseband signal with noise, before gain, re the source level at 1 m. A scatterer at the
        distance r has the phase -4 pi f r/c.
    truth: `(m, bins)` float32, mean intensity after time-varied gain, in the unit that `scale` says.
    extras: `position` `(m, 3)`, of the sonar in the world [m], what a navigator would give the focusing.
    tables: `range` `(bins,)` [m], middle of each bin.
    """

    TITLE: ClassVar[str] = "synthetic aperture sonar: coherent raw data along the track"
    KERNELS: ClassVar[int] = 24
    CASTS: ClassVar[int] = 1
    Config: ClassVar[type[SensorConfig]] = SyntheticApertureSonarConfig
    SOURCES: ClassVar[tuple[str, ...]] = (
        "R. E. Hansen, Introduction to Synthetic Aperture Sonar, in Sonar Systems (2011), doi 10.5772/23122",
        "APL-UW TR 9407 (1994), Section IV: bottom backscatter",
    )

    def __init__(self, config: SyntheticApertureSonarConfig, context: SensorContext) -> None:
        self.config = config
        resolution = range_resolution(NOMINAL_SOUND_SPEED, config.bandwidth_hz)
        if config.bin_width_m > 1.01 * resolution:
            message = f"{context.path}: bins of {config.bin_width_m:.3g} m undersample the pulse, which resolves " + (
                f"{resolution:.3g} m at a bandwidth of {config.bandwidth_hz:g} Hz"
            )
            warnings.warn(message, ValidityWarning, stacklevel=3)
        along, vertical = math.radians(config.beamwidth_deg), math.radians(config.vertical_beamwidth_deg)
        shape = Layout(1, along, along, vertical, np.zeros(1), facet=config.facet_m, aperture=aperture(config))
        self._pinger = Pinger(ping_spec(config, context), context, beam_rays(config), shape)
        self.tables = {"range": config.ranges}
        self._path, self._sparse = context.path, False

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane.

        Warns (`ValidityWarning`), once, where pings lie too far apart along the track.
        """
        if not self._sparse:
            speed = float(np.abs(np.array(sensor_velocity(motion, self.config).x)).max())
            self._sparse = warn_of_sparse_pings(self.config, self._path, speed)
        _, truth, extras = self._pinger.ping(motion)
        position, _ = sensor_pose(motion, self.config)
        out = {k: v[:, 0] for k, v in extras.items() if k != "iq"} | {"position": np.array(position).T}
        return Measurement(extras["iq"][:, 0], promised(lambda: truth()[:, 0]), None, out, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._pinger.explain(motion)


def warn_of_sparse_pings(config: SyntheticApertureSonarConfig, path: str, speed: float) -> bool:
    """Whether an aperture built at `speed` [m/s] along the track is undersampled; warns of it.

    An element of the length D hears directions within +-lambda/(2 D) or so; between pings half of that, D/2, apart
    their two-way phases stay unambiguous (Hansen 2011, Section 2.3).
    """
    apart = speed / config.rate_hz
    if apart <= config.step_m * (1.0 + 1e-6):
        return False
    needed, fastest = speed / config.step_m, SLOWEST / (2.0 * config.range_max_m)
    rate = f" or ping at {needed:.3g} Hz" if needed <= fastest else ""
    message = (
        f"{path}: at {speed:.3g} m/s and {config.rate_hz:g} Hz pings lie {apart:.3g} m apart, more than half of the "
        f"element, {config.step_m:.3g} m: focused images show everything several times along the track; go at "
        f"{config.step_m * config.rate_hz:.3g} m/s or slower{rate} (a range of {config.range_max_m:g} m allows for "
        f"{fastest:.3g} Hz), or take a longer element (beamwidth_deg)"
    )
    warnings.warn(message, ValidityWarning, stacklevel=4)
    return True

"""Forward-looking imaging sonar: an intensity for every beam and range, as interference makes it."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any, ClassVar, Final, Literal

import numpy as np
from numpy.typing import NDArray
from pydantic import Field

from pelagos.acoustics.beam_pattern import line_length
from pelagos.acoustics.element_array import ElementLine, channel_factors, element_line
from pelagos.config.rate import Rate
from pelagos.sensors.lazy import promised
from pelagos.sensors.sensor import Kinematics, Measurement, SensorConfig, SensorContext
from pelagos.sensors.sonar.keys.ping_keys import ping_spec
from pelagos.sensors.sonar.keys.sector_keys import SectorConfig, element_tables, layout, warn_of_seed
from pelagos.sensors.sonar.ping.elevation_strata import strata
from pelagos.sensors.sonar.ping.pinger import Pinger

_BLOCK: Final = 16  # beams: the width of a vector
_STEP: Final = 0.7548776662466927  # additive recurrence of the plastic number: evenly spread in two dimensions
_STEP2: Final = 0.5698402909980532
_SENDS: Final = 1  # second part of the seed of a transmitter's errors


class ImagingSonarConfig(SectorConfig):
    """A multibeam forward-looking sonar. Defaults are of the 750 kHz class with 130 x 20 deg."""

    type: Literal["imaging_sonar"] = "imaging_sonar"
    rate_hz: Rate = 5.0
    """Pings per second [Hz]."""
    vertical_side_lobes: int = Field(default=1, ge=0, le=8)
    """Side lobes of the fan above and below its main lobe that rays are cast into (-26.5 dB there and back)."""
    transmit_gain_db: float = Field(default=0.0, ge=0, le=20)
    """Standard deviation of the gains of the transmitter's elements [dB], which lie half a wavelength apart across the
    fan; `channel_seed` draws them."""
    transmit_phase_deg: float = Field(default=0.0, ge=0, le=180)
    """Standard deviation of their phases [deg]."""
    transmit_dead_elements: float = Field(default=0.0, ge=0, le=0.9)
    """Share of them that are silent."""


def transmit_line(config: ImagingSonarConfig) -> ElementLine | None:
    """The elements across the fan that send, with their errors; None where they have none."""
    gain, phase = config.transmit_gain_db, math.radians(config.transmit_phase_deg)
    if max(gain, phase, config.transmit_dead_elements) == 0.0:
        return None
    line = element_line(line_length(math.radians(config.vertical_beamwidth_deg)), "uniform")
    seed = (config.channel_seed, _SENDS)
    factors = channel_factors(line.count, gain_db=gain, phase_rad=phase, dead=config.transmit_dead_elements, seed=seed)
    return replace(line, channels=factors)


def fan_rays(config: ImagingSonarConfig) -> dict[str, NDArray[Any]]:
    """The ray pattern in the sensor frame, `rays_per_beam` for each beam (see `Fan`).

    Elevation strata reach to the nulls of the vertical pattern beyond its chosen side lobes, and are thinner where the
    pattern is strong; each holds one ray. Neighbours in memory are neighbours in azimuth, whose patches are alike, by
    blocks of beams whose bins fit into a core's cache. Rays stand in the middle of their strata, whose edges move from
    beam to beam, and at low-discrepancy places across the beam's sector.
    """
    beams, rays = config.beams, config.rays_per_beam
    length = line_length(math.radians(config.vertical_beamwidth_deg))
    k, j = (a.ravel() for a in np.meshgrid(np.arange(rays), np.arange(beams), indexing="ij"))
    order = np.lexsort((j, k, j // _BLOCK))
    k, j = k[order], j[order]
    low, high, pattern = strata(
        length, config.vertical_side_lobes, rays, k, (0.5 + _STEP * j) % 1.0, transmit_line(config)
    )
    elevation = 0.5 * (low + high)
    width = math.radians(config.horizontal_aperture_deg) / beams
    azimuth = config.azimuths[j] + ((0.5 + _STEP * k + _STEP2 * j) % 1.0 - 0.5) * width
    ce, se, ca, sa = np.cos(elevation), np.sin(elevation), np.cos(azimuth), np.sin(azimuth)
    direction = np.stack([ce * ca, ce * sa, se], axis=-1)
    middle = config.azimuths[j]
    return {
        "direction": direction,
        "aside": np.stack([ce * np.cos(middle), ce * np.sin(middle), se], axis=-1) - direction,
        "along": np.stack([-se * ca, -se * sa, ce], axis=-1),
        "lower": low - elevation,
        "upper": high - elevation,
        "across": np.full(len(j), width),
        "weight": width * pattern,
        "beam": j,
    }


class ImagingSonar:
    """A forward-looking imaging sonar.

    data: `(m, beams, bins)` float32, echo level after time-varied gain. In decibels it is the backscattering strength
        that a horizontal bottom filling the cell would have (with tvg_db 30); `scale` says how it is given.
    truth: the same without noise and without interference (the mean over all realisations of the roughness).
    extras: with `iq`, `iq` complex64 `(m, beams, bins)`, signal and noise before gain, re the source level at 1 m; with
        `labels`, `label` and `instance` `(m, beams, bins)` of the strongest echo, 0 for none; with `elements`,
        `elements` complex64 `(m, elements, bins)`, what each element hears, before gain as `iq` is, and
        `steering_speed` `(m,)`, the sound speed that turns their phases into angles [m/s].
    tables: `azimuth` `(beams,)` [rad], positive to the left; `range` `(bins,)` [m], middle of each bin;
        with `elements` `element_position` `(elements, 3)` in the sensor frame [m], and `element_weights` `(elements,)`
        of the device's own beamformer, sum 1.
    """

    TITLE: ClassVar[str] = "forward-looking multibeam imaging sonar: polar intensity images with coherent speckle"
    KERNELS: ClassVar[int] = 22
    CASTS: ClassVar[int] = 1
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
        warn_of_seed(config, context.path)
        shape = layout(config)
        shape = replace(shape, aperture=replace(shape.aperture, transmit=transmit_line(config)))
        self._pinger = Pinger(ping_spec(config, context), context, fan_rays(config), shape)
        self.tables = {"azimuth": config.azimuths.astype(np.float32), "range": config.ranges, **element_tables(config)}

    def sense(self, motion: Kinematics) -> Measurement:
        """Ping on every lane."""
        data, truth, extras = self._pinger.ping(motion)
        return Measurement(data, promised(truth), None, extras, self.tables)

    def explain(self, motion: Kinematics) -> list[tuple[str, NDArray[Any], str]]:
        """One ping, not frozen, with its intermediate arrays: (name, values, unit)."""
        return self._pinger.explain(motion)

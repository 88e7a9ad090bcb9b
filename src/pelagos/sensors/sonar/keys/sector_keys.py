"""Sonars whose beams lie side by side in a sector: keys and beams of imaging and profiling sonars."""

from __future__ import annotations

import math
import warnings
from dataclasses import replace
from typing import Final, Literal, Self

import numpy as np
from numpy.typing import NDArray
from pydantic import Field, model_validator

from pelagos.acoustics.beam_pattern import equivalent_width, line_length, shaded_length, steering_matrix
from pelagos.acoustics.element_array import ElementLine, channel_factors, element_line
from pelagos.errors import ValidityWarning
from pelagos.sensors.idle_keys import changed, named
from pelagos.sensors.sonar.keys.conflicts import check_elements, check_spacing
from pelagos.sensors.sonar.keys.ping_keys import PingConfig
from pelagos.sensors.sonar.ping.aperture import Aperture
from pelagos.sensors.sonar.ping.elements import line_tables
from pelagos.sensors.sonar.ping.layout import Layout

_ERRORS: Final = ("_gain_db", "_phase_deg", "dead_elements")  # how keys of elements' errors end


class SectorConfig(PingConfig):
    """Keys of sonars whose beams lie side by side in the x-y plane of the sensor frame."""

    beams: int = Field(default=256, ge=1, le=4096)
    """Beams across the sector."""
    horizontal_aperture_deg: float = Field(default=130.0, gt=0, le=170)
    """Sector [deg], from the first beam's outer edge to the last one's."""
    vertical_beamwidth_deg: float = Field(default=20.0, gt=0, le=90)
    """Half-power width of the fan in elevation [deg], one way."""
    beamwidth_deg: float = Field(default=1.0, ge=0.01, le=20)
    """Half-power width of a receive beam at broadside [deg]."""
    shading: Literal["uniform", "light", "hamming", "hann"] = "light"
    """Weights of the receive array: side lobes at -13, -21, -43 and -31 dB."""
    side_lobe_beams: int = Field(default=8, ge=0, le=256)
    """Neighbours on each side whose echoes leak into a beam."""
    elements: bool = False
    """Also give the signal of each element of the receive array, for a beamformer of one's own."""
    channel_gain_db: float = Field(default=0.0, ge=0, le=20)
    """Standard deviation of the receive channels' gains [dB]. With this, `channel_phase_deg` or `dead_elements` the
    picture's beams are formed of the elements' signals, errors and all."""
    channel_phase_deg: float = Field(default=0.0, ge=0, le=180)
    """Standard deviation of the receive channels' phases [deg]."""
    dead_elements: float = Field(default=0.0, ge=0, le=0.9)
    """Share of the receive channels that are silent."""
    channel_seed: int = Field(default=0, ge=0, lt=2**32)
    """Which device it is: the draw of its channels' errors."""
    rays_per_beam: int = Field(default=96, ge=4, le=4096)
    """Rays a beam, stratified in elevation."""

    @model_validator(mode="after")
    def _dense(self) -> Self:
        check_spacing(self)
        check_elements(self)
        return self

    @property
    def faulty(self) -> bool:
        """Whether receive channels have errors."""
        return max(self.channel_gain_db, self.channel_phase_deg, self.dead_elements) > 0.0

    @property
    def azimuths(self) -> NDArray[np.float64]:
        """Beam directions `(beams,)` [rad], positive to the left, from left to right as an image's columns are."""
        sector = math.radians(self.horizontal_aperture_deg)
        return np.asarray(sector * (0.5 - (np.arange(self.beams) + 0.5) / self.beams))


def warn_of_seed(config: SectorConfig, path: str) -> None:
    """Warns (`ValidityWarning`) of a seed that draws no errors."""
    errors = [key for key in type(config).model_fields if key.endswith(_ERRORS)]
    if changed(config, ("channel_seed",)) and not changed(config, errors):
        message = f"{path}: 'channel_seed' changes nothing without one of {named(errors)}"
        warnings.warn(message, ValidityWarning, stacklevel=4)


def layout(config: SectorConfig) -> Layout:
    """Beams evenly spread over the sector, each with the side lobes of the receive array."""
    width = math.radians(config.beamwidth_deg)
    return Layout(
        beams=config.beams,
        sector=math.radians(config.horizontal_aperture_deg) / config.beams,
        horizontal_width=width,
        vertical_width=math.radians(config.vertical_beamwidth_deg),
        azimuths=config.azimuths,
        steering=steering_matrix(config.azimuths, width, config.shading, config.side_lobe_beams),
        equivalent=equivalent_width(config.azimuths, width, config.shading),
        aperture=aperture(config),
        elements=line_of(config) if config.elements or config.faulty else None,
        raw=config.elements,
    )


def line_of(config: SectorConfig) -> ElementLine:
    """The elements of the receive array, along y."""
    line = element_line(shaded_length(math.radians(config.beamwidth_deg), config.shading), config.shading)
    if not config.faulty:
        return line
    factors = channel_factors(
        line.count, gain_db=config.channel_gain_db, phase_rad=math.radians(config.channel_phase_deg),
        dead=config.dead_elements, seed=config.channel_seed,
    )  # fmt: skip
    return replace(line, channels=factors)


def element_tables(config: SectorConfig) -> dict[str, NDArray[np.float32]]:
    """Geometry of a reading's elements: `element_position` `(elements, 3)` in the sensor frame [m], `element_weights`
    `(elements,)` of the device's own beamformer, sum 1; nothing where none are given."""
    return line_tables(line_of(config), config.frequency_hz) if config.elements else {}


def aperture(config: SectorConfig) -> Aperture:
    """A line of receivers along y; transmitter and receivers as high as the fan is thin."""
    azimuth = config.azimuths
    axis = np.stack([np.cos(azimuth), np.sin(azimuth), 0.0 * azimuth], axis=-1)
    return Aperture(
        axis, np.array([0.0, 1.0, 0.0]), np.array([0.0, 0.0, 1.0]),
        shaded_length(math.radians(config.beamwidth_deg), config.shading),
        line_length(math.radians(config.vertical_beamwidth_deg)),
        shading=config.shading, steered=True,
    )  # fmt: skip

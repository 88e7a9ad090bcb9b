"""The water column of a multibeam: what each beam hears from the transducer on, side lobes and all."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Final

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.beam_pattern import equivalent_width, line_length, shaded_length, steering_matrix
from pelagos.acoustics.element_array import ElementLine, element_line
from pelagos.sensors.sonar.ping.aperture import Aperture
from pelagos.sensors.sonar.ping.layout import Layout
from pelagos.sensors.sonar.ping.thin_fan_rays import slice_rays

_RAYS: Final = 24  # of a beam: strata across its sector


@dataclass(frozen=True)
class Column:
    """Beams that look down.

    Attributes:
        angles: from straight down, positive to port `(beams,)` [rad].
        swath: angle between the outermost [rad].
        across, along: half-power widths across and along the track [rad].
        raw: give the signals of the array's elements too.
    """

    angles: NDArray[np.float64]
    swath: float
    across: float
    along: float
    raw: bool = False

    @property
    def line(self) -> ElementLine:
        """Elements of the receive array."""
        return element_line(shaded_length(self.across, "hamming"), "hamming")

    @property
    def sectors(self) -> NDArray[np.float64]:
        """Angle that belongs to each beam [rad]: half of the way to either neighbour."""
        if len(self.angles) == 1:
            return np.array([self.swath])
        return np.abs(np.gradient(self.angles))


def column_layout(column: Column) -> Layout:
    """The multibeam's beams, each with the side lobes of the receive array."""
    beams = len(column.angles)
    return Layout(
        beams=beams,
        sector=float(np.mean(column.sectors)),
        horizontal_width=column.across,
        vertical_width=column.along,
        azimuths=column.angles,
        steering=steering_matrix(column.angles, column.across, "hamming", beams - 1),
        hears_all=True,
        equivalent=equivalent_width(column.angles, column.across, "hamming"),
        aperture=aperture(column),
        elements=column.line if column.raw else None,
        raw=column.raw,
    )


def aperture(column: Column) -> Aperture:
    """A line of receivers along y, and one of transmitters along x."""
    axis = np.stack([0.0 * column.angles, np.sin(column.angles), -np.cos(column.angles)], axis=-1)
    side, up = np.array([0.0, 1.0, 0.0]), np.array([1.0, 0.0, 0.0])
    return Aperture(
        axis,
        side,
        up,
        shaded_length(column.across, "hamming"),
        line_length(column.along),
        shading="hamming",
        steered=True,
        ways=1,
    )


def column_rays(column: Column) -> dict[str, NDArray[Any]]:
    """Rays in the multibeam's frame: strata across each beam's sector, spread fore and aft over the transmit beam."""
    rays = slice_rays(column.angles, column.sectors, rays=_RAYS, width=column.along, ways=1)
    for name in ("direction", "along", "aside"):
        ahead, left, fore = rays[name].T
        rays[name] = np.stack([fore, left, -ahead], axis=-1)
    return rays

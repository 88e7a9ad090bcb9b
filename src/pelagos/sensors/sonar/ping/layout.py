"""Division of directions into beams."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from pelagos.acoustics.element_array import ElementLine
from pelagos.sensors.sonar.ping.aperture import Aperture


@dataclass(frozen=True)
class Layout:
    """Division of directions by a sonar.

    Attributes:
        beams: number of beams.
        sector: angle between neighbouring beams, or of the only one [rad]: with the bin width it is the cell that
            levels are calibrated to.
        horizontal_width, vertical_width: half-power widths of a receive beam [rad].
        steering: `(beams, 2 reach + 1)`, how beams hear their neighbours; None: not at all.
        azimuths: `(beams,)` [rad], positive to the left.
        facet: edge of the roughness lattice [m]; None: by beam and bin width.
        single_file: whether a beam's rays stand one behind another along their strata, and none beside another.
        equivalent: `(beams,)`, integral of each receive beam's power pattern over the angle [rad]; None: rays carry it,
            and a sector is heard as a whole.
        aperture: how beams hear any direction.
        elements: of the receive array, where beams are formed of their signals; None: they are not.
        raw: whether these signals are given.
        hears_all: every beam hears every sector, by its side lobes; `steering` is of the whole array.
    """

    beams: int
    sector: float
    horizontal_width: float
    vertical_width: float
    azimuths: NDArray[np.float64]
    aperture: Aperture
    steering: NDArray[np.float32] | None = None
    facet: float | None = None
    single_file: bool = False
    equivalent: NDArray[np.float64] | None = None
    hears_all: bool = False
    elements: ElementLine | None = None
    raw: bool = False

    @property
    def heard_parts(self) -> NDArray[np.float32]:
        """`(beams,)`, of a sector's energy how much a beam hears: beams may overlap, or leave something between."""
        if self.equivalent is None:
            return np.ones(self.beams, np.float32)
        return np.asarray(self.equivalent / self.sector, dtype=np.float32)

"""First-order force of the waves that a floating hull scatters, as a panel method has it at every frequency.

Without it a hull feels the acceleration of the water times its added mass, which is right for waves that are longer
than it is. The pressure of the undisturbed wave is no part of it: that is taken on the hull as it lies in the actual
surface. Zero speed. O. M. Faltinsen, Sea Loads on Ships and Offshore Structures (1990), Sections 3.2 and 3.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from pelagos.jit import Array
from pelagos.ocean.waves import Waves
from pelagos.vehicles.heading_table import HeadingTable, checked_table, met
from pelagos.vehicles.part import PartConfig, Positive

_Rows = tuple[tuple[tuple[float, float, float, float, float, float], ...], ...]
_EVEN = (1, 0, 1, 0, 1, 0)  # in waves from the other side: surge, heave and pitch are the same, the rest turns over


class DiffractionConfig(PartConfig):
    """Diffraction force of regular waves of amplitude 1 m over the water's density, zero speed, both sides alike.

    FRD, about the origin at the waterline. Where cos(theta) is the elevation at the origin, theta falling with time,
    the force is real times cos(theta) less imaginary times sin(theta): m^3/s^2, and m^4/s^2 for moments.
    """

    omega_radps: tuple[Positive, ...] = Field(min_length=2)
    """Frequencies, increasing [rad/s]; beyond the last the force is that of the last."""
    heading_deg: tuple[float, ...] = Field(min_length=2)
    """Direction that the wave travels towards, from the bow over starboard, evenly from 0 to 180 [deg]; 180: a head
    sea."""
    real: _Rows
    """`(frequencies, headings, 6)`."""
    imaginary: _Rows
    """`(frequencies, headings, 6)`."""

    @model_validator(mode="after")
    def _shapes(self) -> Self:
        for name in ("real", "imaginary"):
            checked_table(self.omega_radps, self.heading_deg, getattr(self, name), columns=6, name=name)
        return self


@dataclass(frozen=True)
class Diffraction:
    """Coefficients, compiled: real parts (6), then imaginary ones (6), over the density."""

    rows: HeadingTable

    def push(
        self, waves: Waves, table: Array, place: tuple[Array, Array], heading: tuple[Array, Array], t: Array
    ) -> list[Array]:
        """Wrench (6) along the heading, level, over the density.

        Args:
            waves: the sea.
            table: of `rows`, on the device.
            place: x and y of the hull's origin, world NWU [m].
            heading: cosine and sine of the compass heading.
            t: time [s].
        """
        nothing = 0 * (place[0] + place[1] + t + heading[0])

        def add(i: Array, *sums: Array) -> tuple[Array, ...]:
            wave = met(waves, i, place, heading, t)
            parts = self.rows.at(table, wave.omega, wave.direction)
            real, imaginary = [*parts[0], *parts[1]], [*parts[2], *parts[3]]
            force = [r * wave.cos - m * wave.sin for r, m in zip(real, imaginary, strict=True)]
            force = [f if even else wave.side * f for f, even in zip(force, _EVEN, strict=True)]
            return i + 1, *(a + b for a, b in zip(sums, force, strict=True))

        return list(waves._loop(add, *([nothing] * 6)))


def compile_diffraction(config: DiffractionConfig) -> Diffraction:
    """On an even grid of frequencies that starts with nothing at zero."""
    values = np.concatenate([np.array(config.real), np.array(config.imaginary)], axis=-1)
    return Diffraction(HeadingTable.even(config.omega_radps, values))

"""First-order force of the waves that a floating hull scatters, as a panel method has it at every frequency.

Without it a hull feels the acceleration of the water times its added mass, which is right for waves that are longer
than it is. The pressure of the undisturbed wave is no part of it: that is taken on the hull as it lies in the actual
surface. At one speed ahead or at several, between which it is linear. O. M. Faltinsen, Sea Loads on Ships and Offshore
Structures (1990), Sections 3.2 and 3.5.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import drjit as dr
import numpy as np
from pydantic import Field, model_validator

from pelagos import jit
from pelagos.jit import Array
from pelagos.ocean.waves import Waves
from pelagos.vehicles.heading_table import Component, HeadingTable, checked_table, met
from pelagos.vehicles.part import NonNegative, PartConfig, Positive

_Rows = tuple[tuple[tuple[float, float, float, float, float, float], ...], ...]
_Tables = _Rows | tuple[_Rows, ...]
_EVEN = (1, 0, 1, 0, 1, 0)  # in waves from the other side: surge, heave and pitch are the same, the rest turns over


class DiffractionConfig(PartConfig):
    """Diffraction force of regular waves of amplitude 1 m over the water's density, both sides alike.

    FRD, about the origin at the waterline. Where cos(theta) is the elevation at the origin, theta falling with time,
    the force is real times cos(theta) less imaginary times sin(theta): m^3/s^2, and m^4/s^2 for moments.
    """

    omega_radps: tuple[Positive, ...] = Field(min_length=2)
    """Frequencies of the waves as one who stands sees them, increasing [rad/s]; beyond the last the force is that of
    the last, and below the first it falls with frequency to nothing. At speed that is too coarse for pitch: there the
    first should belong to the longest waves that are met."""
    heading_deg: tuple[float, ...] = Field(min_length=2)
    """Direction that the wave travels towards, from the bow over starboard, evenly from 0 to 180 [deg]; 180: a head
    sea."""
    real: _Tables
    """`(frequencies, headings, 6)`; with `speed_mps` one such table for each speed."""
    imaginary: _Tables
    """The same shape."""
    speed_mps: tuple[NonNegative, ...] = ()
    """Speeds ahead, evenly from 0 [m/s]; beyond the last, and astern, the force is that of the nearest. Without, the
    force is that of zero speed."""

    @model_validator(mode="after")
    def _shapes(self) -> Self:
        speeds = self.speed_mps
        if speeds and (len(speeds) < 2 or not np.allclose(speeds, np.linspace(0, speeds[-1], len(speeds)), rtol=1e-4)):
            raise ValueError(f"speed_mps must go evenly from 0, two speeds or more, not {', '.join(map(str, speeds))}")
        for name in ("real", "imaginary"):
            tables = getattr(self, name)
            if speeds and len(tables) != len(speeds):
                raise ValueError(f"{name} must have {len(speeds)} tables, one for each of speed_mps, not {len(tables)}")
            for table in tables if speeds else [tables]:
                checked_table(self.omega_radps, self.heading_deg, table, columns=6, name=name)
        return self


@dataclass(frozen=True)
class Diffraction:
    """Coefficients, compiled: real parts (6), then imaginary ones (6), over the density.

    Attributes:
        rows: a layer for each speed.
        fastest: the last speed [m/s]; 0 where there is one table for all.
    """

    rows: HeadingTable
    fastest: float = 0.0

    def push(
        self,
        waves: Waves,
        table: Array,
        place: tuple[Array, Array],
        heading: tuple[Array, Array],
        t: Array,
        *,
        speed: Array | None = None,
    ) -> list[Array]:
        """Wrench (6) along the heading, level, over the density.

        Args:
            waves: the sea.
            table: of `rows`, on the device.
            place: x and y of the hull's origin, world NWU [m].
            heading: cosine and sine of the compass heading.
            t: time [s].
            speed: ahead [m/s]; for tables that depend on it.
        """
        nothing = 0 * (place[0] + place[1] + t + heading[0])

        def add(i: Array, *sums: Array) -> tuple[Array, ...]:
            wave = met(waves, i, place, heading, t)
            parts = self._at(table, wave, speed)
            real, imaginary = [*parts[0], *parts[1]], [*parts[2], *parts[3]]
            force = [r * wave.cos - m * wave.sin for r, m in zip(real, imaginary, strict=True)]
            force = [f if even else wave.side * f for f, even in zip(force, _EVEN, strict=True)]
            return i + 1, *(a + b for a, b in zip(sums, force, strict=True))

        return list(waves._loop(add, *([nothing] * 6)))

    def _at(self, table: Array, wave: Component, speed: Array | None) -> list[Array]:
        """Parts (4 `Array3f64`) at a speed."""
        if self.rows.layers == 1:
            return self.rows.at(table, wave.omega, wave.direction)
        last = self.rows.layers - 1
        assert speed is not None
        v = dr.clip(speed, 0.0, self.fastest) * (last / self.fastest)
        layer = dr.minimum(jit.UInt32(v), last - 1)
        q = v - jit.Float64(layer)
        low, high = (self.rows.at(table, wave.omega, wave.direction, one) for one in (layer, layer + 1))
        return [(1 - q) * a + q * b for a, b in zip(low, high, strict=True)]


def compile_diffraction(config: DiffractionConfig) -> Diffraction:
    """On an even grid of frequencies that starts with nothing at zero."""
    if config.speed_mps:
        parts = np.concatenate(
            [np.array(config.real), np.array(config.imaginary)], axis=-1
        )  # (speeds, w, headings, 12)
        values = np.concatenate(list(parts), axis=-1)
        return Diffraction(
            HeadingTable.even(config.omega_radps, values, layers=len(config.speed_mps)), config.speed_mps[-1]
        )
    values = np.concatenate([np.array(config.real), np.array(config.imaginary)], axis=-1)
    return Diffraction(HeadingTable.even(config.omega_radps, values))

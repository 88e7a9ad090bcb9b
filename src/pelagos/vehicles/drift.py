"""Mean wave drift of a floating hull: forces of second order that push it along, slowly varying with groups.

A regular wave of amplitude a pushes with a^2 D, D from a panel method's far field; waves of several frequencies push
with D at each pair's mean, J. N. Newman, "Second-order, slowly-varying forces on vessels in irregular waves", Proc.
Int. Symp. on the Dynamics of Marine Vehicles, London 1974, p. 182. Zero speed: what the hull's own speed changes in D
(wave drift damping) is not part of it. The pressure on the hull as it moves (`seakeeping.py`) is itself a part of what
pushes it, so the coefficients may say which (`DriftConfig.own`).
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Self

import numpy as np
from pydantic import Field, model_validator

from pelagos.hydro.wave_load import newman_drift
from pelagos.jit import Array
from pelagos.ocean.waves import Waves
from pelagos.vehicles.heading_table import HeadingTable, checked_table, met
from pelagos.vehicles.part import PartConfig, Positive


class DriftConfig(PartConfig):
    """Mean force of regular waves of amplitude 1 m over the water's density, zero speed, hulls the same on both sides.

    FRD, about the origin. Newtons over the square of the amplitude and over the density: m^2/s^2.
    """

    omega_radps: tuple[Positive, ...] = Field(min_length=2)
    """Frequencies, increasing [rad/s]; beyond the last the force is that of the last."""
    heading_deg: tuple[float, ...] = Field(min_length=2)
    """Direction that the wave travels towards, from the bow over starboard, evenly from 0 to 180 [deg]; 180: a head
    sea."""
    force: tuple[tuple[tuple[float, float, float], ...], ...]
    """`(frequencies, headings, 3)`: surge and sway [m^2/s^2], yaw [m^3/s^2]."""
    own: tuple[tuple[tuple[float, float, float], ...], ...] = ()
    """What the pressure on the moving hull, as this simulator has it, pushes by itself; the same shape. It is taken
    off, so that both together are `force` (`scripts/drift.py` measures it)."""

    @model_validator(mode="after")
    def _shapes(self) -> Self:
        checked_table(self.omega_radps, self.heading_deg, self.force, columns=3, name="force")
        if self.own:
            checked_table(self.omega_radps, self.heading_deg, self.own, columns=3, name="own")
        return self


@dataclass(frozen=True)
class Drift:
    """Coefficients, compiled: surge, sway and yaw over the density."""

    rows: HeadingTable

    def push(
        self, waves: Waves, table: Array, x: Array, y: Array, heading: tuple[Array, Array], t: Array
    ) -> list[Array]:
        """Surge, sway and yaw along the heading, over the density.

        Args:
            waves: the sea.
            table: of `rows`, on the device.
            x, y: of the hull's origin, world NWU [m].
            heading: cosine and sine of the compass heading.
            t: time [s].
        """
        nothing = 0 * (x + y + t + heading[0])

        def add(i: Array, *sums: Array) -> tuple[Array, ...]:
            wave = met(waves, i, (x, y), heading, t)
            (force,) = self.rows.at(table, wave.omega, wave.direction)
            s, c, side = wave.sin, wave.cos, wave.side
            each = (force[0], side * force[1], side * force[2])
            terms = [c, s, *(v for d in each for v in (d * c, d * s))]
            return i + 1, *(a + b for a, b in zip(sums, terms, strict=True))

        c, s, *weighted = waves._loop(add, *([nothing] * 8))
        return [newman_drift((c, s), (weighted[2 * k], weighted[2 * k + 1])) for k in range(3)]


def compile_drift(config: DriftConfig) -> Drift:
    """On an even grid of frequencies that starts with nothing at zero."""
    rest = np.array(config.force) - (np.array(config.own) if config.own else 0.0)
    return Drift(HeadingTable.even(config.omega_radps, rest))
